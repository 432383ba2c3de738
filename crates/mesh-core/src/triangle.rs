//! The closest point of one triangle.

use nalgebra::{Point3, Vector3};

use crate::bvh::{larger, smaller};

/// The part of a triangle on which a point lies. Corners are 0, 1, 2; edge `i` joins the corners `i` and `i + 1` (mod 3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Feature {
    /// The interior.
    Face,
    /// The interior of an edge.
    Edge(u8),
    /// A corner.
    Vertex(u8),
}

/// Closest point of one triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TriangleFoot {
    pub(crate) point: Point3<f64>,
    pub(crate) barycentric: [f64; 3],
    pub(crate) feature: Feature,
    pub(crate) distance_sq: f64,
}

/// Squared sine of the thinnest angle for which the barycentric coordinates of the projection are trusted alone.
const WELL_SHAPED_SQ: f64 = 1e-8;

/// Corners `a`, `b`, `c` of a triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle(pub(crate) [Point3<f64>; 3]);

impl Triangle {
    /// (b − a) × (c − a): along the normal, its length twice the area.
    pub(crate) fn area_vector(&self) -> Vector3<f64> {
        let [a, b, c] = self.0;
        (b - a).cross(&(c - a))
    }

    /// Unit normal, or zero for a triangle without area.
    pub(crate) fn unit_normal(&self) -> Vector3<f64> {
        self.area_vector().try_normalize(0.0).unwrap_or_else(Vector3::zeros)
    }

    /// Interior angle at a corner in radians, 0 where an adjacent edge has no length.
    pub(crate) fn angle(&self, corner: usize) -> f64 {
        let origin = self.0[corner];
        let first = self.0[(corner + 1) % 3] - origin;
        let second = self.0[(corner + 2) % 3] - origin;
        first.cross(&second).norm().atan2(first.dot(&second))
    }

    /// The closest point to `x`.
    ///
    /// The foot on the plane counts where its barycentric coordinates are positive. Otherwise the closest point
    /// lies on one of the edges that have `x` on their outer side. Triangles so thin that rounding decides those
    /// signs are answered by the best of all candidates, so a triangle without area acts as the segment it is.
    pub(crate) fn closest(&self, x: &Point3<f64>) -> TriangleFoot {
        let [a, b, c] = self.0;
        let (ab, ac, ax) = (b - a, c - a, x - a);
        let normal = ab.cross(&ac);
        let (area_sq, longest_sq) =
            (normal.norm_squared(), ab.norm_squared().max(ac.norm_squared()).max((c - b).norm_squared()));
        let of_c = ab.cross(&ax).dot(&normal) / area_sq;
        let of_b = ax.cross(&ac).dot(&normal) / area_sq;
        let barycentric = [1.0 - of_b - of_c, of_b, of_c];
        let well_shaped = area_sq > WELL_SHAPED_SQ * longest_sq * longest_sq;

        let inside = barycentric.iter().all(|&weight| weight > 0.0);
        let mut best = None;
        if inside {
            let foot = foot(x, a + ab * of_b + ac * of_c, barycentric, Feature::Face);
            if well_shaped {
                return foot;
            }
            best = Some(foot);
        }
        for edge in [0u8, 1, 2] {
            // Opposite of edge i lies the corner i + 2, whose weight is negative beyond the edge.
            if well_shaped && barycentric[usize::from(edge + 2) % 3] > 0.0 {
                continue;
            }
            let candidate = self.closest_on_edge(x, edge);
            if best.is_none_or(|best: TriangleFoot| candidate.distance_sq < best.distance_sq) {
                best = Some(candidate);
            }
        }
        // At least one barycentric coordinate is not positive here, hence at least one edge was tried.
        best.unwrap_or_else(|| self.closest_on_edge(x, 0))
    }

    /// The squared distance of the closest point to `x`, with the same bits as that of [`Triangle::closest`].
    #[inline]
    pub(crate) fn distance_sq(&self, x: &Point3<f64>) -> f64 {
        let [a, b, c] = self.0;
        let (ab, ac, ax) = (b - a, c - a, x - a);
        let normal = ab.cross(&ac);
        let area_sq = normal.norm_squared();
        let longest_sq = larger(larger(ab.norm_squared(), ac.norm_squared()), (c - b).norm_squared());
        if area_sq <= WELL_SHAPED_SQ * longest_sq * longest_sq || area_sq.is_nan() {
            return self.closest(x).distance_sq;
        }
        let of_c = ab.cross(&ax).dot(&normal) / area_sq;
        let of_b = ax.cross(&ac).dot(&normal) / area_sq;
        let of_a = 1.0 - of_b - of_c;
        if of_a > 0.0 && of_b > 0.0 && of_c > 0.0 {
            return (x - (a + ab * of_b + ac * of_c)).norm_squared();
        }
        let to_edge = |start: Point3<f64>, end: Point3<f64>| {
            let along = end - start;
            let t = (x - start).dot(&along) / along.norm_squared();
            let point = if t > 0.0 && t < 1.0 {
                start + along * t
            } else if t >= 1.0 {
                end
            } else {
                start
            };
            (x - point).norm_squared()
        };
        // Opposite of an edge lies the corner whose weight is not positive beyond it.
        let mut least = f64::INFINITY;
        for (weight, start, end) in [(of_c, a, b), (of_a, b, c), (of_b, c, a)] {
            if weight <= 0.0 {
                least = least.min(to_edge(start, end));
            }
        }
        if least < f64::INFINITY { least } else { self.closest(x).distance_sq }
    }

    /// The squared distance of the box around the triangle, which is no larger than that of the triangle.
    pub(crate) fn box_distance_sq(&self, x: &Point3<f64>) -> f64 {
        let [a, b, c] = &self.0;
        let mut sum = 0.0;
        for axis in 0..3 {
            let low = smaller(smaller(a[axis], b[axis]), c[axis]);
            let high = larger(larger(a[axis], b[axis]), c[axis]);
            let outside = larger(larger(low - x[axis], x[axis] - high), 0.0);
            sum += outside * outside;
        }
        sum
    }

    fn closest_on_edge(&self, x: &Point3<f64>, edge: u8) -> TriangleFoot {
        let (from, to) = (usize::from(edge), usize::from(edge + 1) % 3);
        let start = self.0[from];
        let along = self.0[to] - start;
        let t = (x - start).dot(&along) / along.norm_squared();
        let mut barycentric = [0.0; 3];
        // An edge without length gives NaN and counts as its start.
        let (point, feature) = if t > 0.0 && t < 1.0 {
            barycentric[from] = 1.0 - t;
            barycentric[to] = t;
            (start + along * t, Feature::Edge(edge))
        } else if t >= 1.0 {
            barycentric[to] = 1.0;
            (self.0[to], Feature::Vertex((edge + 1) % 3))
        } else {
            barycentric[from] = 1.0;
            (start, Feature::Vertex(edge))
        };
        foot(x, point, barycentric, feature)
    }
}

fn foot(x: &Point3<f64>, point: Point3<f64>, barycentric: [f64; 3], feature: Feature) -> TriangleFoot {
    TriangleFoot { point, barycentric, feature, distance_sq: (x - point).norm_squared() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64, z: f64) -> Point3<f64> {
        Point3::new(x, y, z)
    }

    #[test]
    fn tells_features_apart() {
        let triangle = Triangle([point(0.0, 0.0, 0.0), point(2.0, 0.0, 0.0), point(0.0, 2.0, 0.0)]);
        for (x, feature, distance) in [
            (point(0.5, 0.5, 3.0), Feature::Face, 3.0),
            (point(1.0, -2.0, 0.0), Feature::Edge(0), 2.0),
            (point(2.0, 2.0, 0.0), Feature::Edge(1), f64::sqrt(2.0)),
            (point(-3.0, 1.0, 4.0), Feature::Edge(2), 5.0),
            (point(-3.0, -4.0, 0.0), Feature::Vertex(0), 5.0),
            (point(5.0, -1.0, 0.0), Feature::Vertex(1), f64::sqrt(10.0)),
            (point(-1.0, 5.0, 0.0), Feature::Vertex(2), f64::sqrt(10.0)),
        ] {
            let foot = triangle.closest(&x);
            assert_eq!(foot.feature, feature, "{x}");
            assert!((foot.distance_sq.sqrt() - distance).abs() < 1e-15, "{x}");
        }
    }

    #[test]
    fn an_obtuse_corner_does_not_mislead() {
        let triangle = Triangle([point(0.0, 0.0, 0.0), point(1.0, 0.0, 0.0), point(-3.0, 1.0, 0.0)]);
        let foot = triangle.closest(&point(-1.0, -0.2, 0.0));
        let dense = (0..=100_000u32)
            .flat_map(|i| {
                let t = f64::from(i) / 1e5;
                [point(t, 0.0, 0.0), point(-3.0 * t, t, 0.0), point(1.0 - 4.0 * t, t, 0.0)]
            })
            .map(|q| (q - point(-1.0, -0.2, 0.0)).norm())
            .fold(f64::INFINITY, f64::min);
        assert!((foot.distance_sq.sqrt() - dense).abs() < 1e-8);
    }

    #[test]
    fn degenerate_triangles_are_segments_and_points() {
        let segment = Triangle([point(0.0, 0.0, 0.0), point(1.0, 0.0, 0.0), point(3.0, 0.0, 0.0)]);
        assert_eq!(segment.closest(&point(2.0, 1.0, 0.0)).point, point(2.0, 0.0, 0.0));
        let dot = Triangle([point(1.0, 1.0, 1.0); 3]);
        let foot = dot.closest(&point(1.0, 1.0, 3.0));
        assert_eq!((foot.distance_sq, foot.point), (4.0, point(1.0, 1.0, 1.0)));
        assert_eq!(dot.unit_normal(), Vector3::zeros());
    }

    #[test]
    fn the_distance_alone_has_the_same_bits() {
        let number = |k: u32| (f64::from(k) * 0.754_877_666_2).fract() * 4.0 - 2.0;
        let shapes = [
            [point(0.0, 0.0, 0.0), point(2.0, 0.1, 0.3), point(0.4, 1.0, -0.2)],
            [point(0.0, 0.0, 0.0), point(1.0, 0.0, 0.0), point(-3.0, 1.0, 0.0)],
            [point(0.0, 0.0, 0.0), point(1.0, 0.0, 0.0), point(0.5, 1e-9, 0.0)],
            [point(0.0, 0.0, 0.0), point(1.0, 0.0, 0.0), point(3.0, 0.0, 0.0)],
            [point(1.0, 1.0, 1.0); 3],
        ];
        for (k, shape) in (0u32..2000).flat_map(|k| shapes.iter().map(move |shape| (k, shape))) {
            let triangle = Triangle(*shape);
            let x = point(number(3 * k), number(3 * k + 1), number(3 * k + 2));
            let whole = triangle.closest(&x).distance_sq;
            assert_eq!(triangle.distance_sq(&x).to_bits(), whole.to_bits(), "{x} {shape:?}");
        }
    }
}
