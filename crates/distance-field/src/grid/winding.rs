//! Inside or outside: outlines in the plane, and triangles in space with holes and flips.

use super::sight::side;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::PI;

/// Closed polygons in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    polygons: Vec<Vec<Vector2<f64>>>,
}

impl Outline {
    /// Each list of vertices is closed from its last one to its first one.
    #[must_use]
    pub fn new(polygons: Vec<Vec<Vector2<f64>>>) -> Self {
        Self { polygons }
    }

    /// Whether a point is surrounded an odd number of times, decided by exact signs.
    #[must_use]
    pub fn holds(&self, p: &Vector2<f64>) -> bool {
        let mut is_inside = false;
        for polygon in &self.polygons {
            let mut a = polygon.last();
            for b in polygon {
                if let Some(a) = a.replace(b)
                    && (a.y > p.y) != (b.y > p.y)
                {
                    is_inside ^= (side(a, b, p) > 0.0) == (b.y > a.y);
                }
            }
        }
        is_inside
    }
}

/// Triangles of a leaf of the hierarchy.
const LEAF: usize = 8;
/// A cluster is seen as a dipole from this many times its radius on.
const FAR: f64 = 2.5;
/// Most triangles on which the winding number is looked at.
const LOOKS: usize = 1 << 16;
/// Distance of such a look from a triangle, in roots of twice its area.
const NEAR: f64 = 1e-6;

/// The generalised winding number of triangles (Jacobson et al. 2013), with dipoles for clusters far off (Barill et al. 2018): about 1
/// inside, 0 outside, also of meshes with holes, flips and self-intersections.
#[derive(Clone, Debug)]
pub struct Winding {
    triangles: Vec<[Vector3<f64>; 3]>,
    nodes: Vec<Cluster>,
}

#[derive(Clone, Copy, Debug)]
struct Cluster {
    centre: Vector3<f64>,
    radius: f64,
    /// Sum of half the cross products of the edges.
    area: Vector3<f64>,
    first: usize,
    last: usize,
    /// The two halves; 0 for a leaf, since the root is no half.
    halves: [usize; 2],
}

impl Winding {
    /// Prepares triangles; those with a vertex that is not finite do not count.
    #[must_use]
    pub fn new(mut triangles: Vec<[Vector3<f64>; 3]>) -> Self {
        triangles.retain(|corners| corners.iter().all(|p| p.iter().all(|c| c.is_finite())));
        let mut out = Self { triangles, nodes: Vec::new() };
        if !out.triangles.is_empty() {
            out.split(0, out.triangles.len());
        }
        out
    }

    fn split(&mut self, first: usize, last: usize) -> usize {
        let part = &mut self.triangles[first..last];
        let middle = |corners: &[Vector3<f64>; 3]| (corners[0] + corners[1] + corners[2]) / 3.0;
        let area =
            |corners: &[Vector3<f64>; 3]| (corners[1] - corners[0]).cross(&(corners[2] - corners[0])) * 0.5;
        let total: f64 = part.iter().map(|corners| area(corners).norm()).sum();
        let centre = if total > 0.0 {
            part.iter().map(|corners| middle(corners) * area(corners).norm()).sum::<Vector3<f64>>() / total
        } else {
            part.iter().map(middle).sum::<Vector3<f64>>() / part.len() as f64
        };
        let radius = part.iter().flatten().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let sum = part.iter().map(area).sum();
        let node = self.nodes.len();
        if last - first > LEAF {
            let low = part.iter().map(middle).fold(Vector3::repeat(f64::INFINITY), |low, p| low.inf(&p));
            let high =
                part.iter().map(middle).fold(Vector3::repeat(f64::NEG_INFINITY), |high, p| high.sup(&p));
            let axis = (high - low).imax();
            let half = part.len() / 2;
            part.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        }
        self.nodes.push(Cluster { centre, radius, area: sum, first, last, halves: [0; 2] });
        if last - first > LEAF {
            let half = first + (last - first) / 2;
            let halves = [self.split(first, half), self.split(half, last)];
            self.nodes[node].halves = halves;
        }
        node
    }

    /// The winding number about a point.
    #[must_use]
    pub fn number(&self, x: &Vector3<f64>) -> f64 {
        let mut stack = Vec::with_capacity(64);
        stack.extend((!self.nodes.is_empty()).then_some(0));
        let mut sum = 0.0;
        while let Some(node) = stack.pop() {
            let cluster = &self.nodes[node];
            let offset = cluster.centre - x;
            let distance = offset.norm();
            if distance > FAR * cluster.radius {
                sum += cluster.area.dot(&offset) / distance.powi(3);
            } else if cluster.halves != [0; 2] {
                stack.extend(cluster.halves);
            } else {
                let part = &self.triangles[cluster.first..cluster.last];
                sum += part.iter().map(|corners| solid_angle(corners, x)).sum::<f64>();
            }
        }
        sum / (4.0 * PI)
    }

    /// The winding number on the triangles themselves, half way between its values on their two sides: `(mean, area)` of at most 65,536
    /// of them.
    pub(super) fn on_triangles(&self) -> Vec<(f64, f64)> {
        let step = self.triangles.len().div_ceil(LOOKS).max(1);
        let look = |[a, b, c]: &[Vector3<f64>; 3]| {
            let normal = (b - a).cross(&(c - a));
            let size = normal.norm();
            let offset = normal * (NEAR / size.sqrt());
            let middle = (a + b + c) / 3.0;
            let mean = 0.5 * (self.number(&(middle + offset)) + self.number(&(middle - offset)));
            (size > 0.0 && mean.is_finite()).then_some((mean, 0.5 * size))
        };
        self.triangles.iter().step_by(step).filter_map(look).collect()
    }
}

/// The solid angle under which a triangle is seen, with its sign (Van Oosterom & Strackee 1983).
fn solid_angle(corners: &[Vector3<f64>; 3], x: &Vector3<f64>) -> f64 {
    let [a, b, c] = corners.map(|p| p - x);
    let (u, v, w) = (a.norm(), b.norm(), c.norm());
    let above = a.dot(&b.cross(&c));
    let below = u * v * w + a.dot(&b) * w + b.dot(&c) * u + c.dot(&a) * v;
    2.0 * above.atan2(below)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sphere of radius 1 in triangles, from a subdivided octahedron.
    fn sphere() -> Vec<[Vector3<f64>; 3]> {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let mut faces = Vec::new();
        for (sx, sy, sz) in (0..8).map(|k| (1 - 2 * (k & 1), 1 - (k & 2), 1 - (k & 4) / 2)) {
            let corners = [x * f64::from(sx), y * f64::from(sy), z * f64::from(sz)];
            let outward = sx * sy * sz > 0;
            faces.push(if outward { corners } else { [corners[0], corners[2], corners[1]] });
        }
        for _ in 0..4 {
            faces = faces
                .iter()
                .flat_map(|&[a, b, c]| {
                    let [d, e, f] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
                    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
                })
                .collect();
        }
        faces
    }

    #[test]
    fn one_inside_and_none_outside() {
        let winding = Winding::new(sphere());
        for k in 0..200 {
            let t = f64::from(k);
            let direction = Vector3::new((1.3 * t).sin(), (2.1 * t).cos(), (0.7 * t).sin()).normalize();
            let radius = 3.0 * (t * 0.618_034).fract();
            if (radius - 1.0).abs() > 0.02 {
                let found = winding.number(&(direction * radius));
                let right = if radius < 1.0 { 1.0 } else { 0.0 };
                assert!((found - right).abs() < 0.02, "{radius}: {found}");
            }
        }
    }

    #[test]
    fn a_hole_changes_little_far_from_it() {
        let faces: Vec<_> = sphere().into_iter().filter(|corners| corners[0].z < 0.9).collect();
        let winding = Winding::new(faces);
        assert!(winding.number(&Vector3::new(0.0, 0.0, -0.5)) > 0.9);
        assert!(winding.number(&Vector3::new(0.0, 0.0, -1.5)) < 0.1);
    }

    #[test]
    fn outlines_with_holes() {
        let square = |r: f64| [[-r, -r], [r, -r], [r, r], [-r, r]].map(Vector2::from).to_vec();
        let outline = Outline::new(vec![square(2.0), square(1.0)]);
        assert!(!outline.holds(&Vector2::zeros()) && outline.holds(&Vector2::new(1.5, 0.0)));
        assert!(!outline.holds(&Vector2::new(2.5, 0.3)));
    }
}
