//! Lines of sight among polygons, decided by exact signs.

use nalgebra::Vector2;
use robust::{Coord, orient2d};
use std::cmp::Ordering;

/// On which side of the line from `a` to `b` a point lies: positive on the left; the sign is exact.
pub(super) fn side(a: &Vector2<f64>, b: &Vector2<f64>, p: &Vector2<f64>) -> f64 {
    let at = |p: &Vector2<f64>| Coord { x: p.x, y: p.y };
    orient2d(at(a), at(b), at(p))
}

/// A simple polygon, counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polygon {
    pub(super) vertices: Vec<Vector2<f64>>,
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Polygon {
    /// The polygon with these vertices in either order; repeated ones count once. `None` for less than three, or without area.
    pub(super) fn new(vertices: &[Vector2<f64>]) -> Option<Self> {
        let mut vertices = vertices.to_vec();
        vertices.dedup();
        while vertices.len() > 1 && vertices.first() == vertices.last() {
            vertices.pop();
        }
        if vertices.len() < 3 {
            return None;
        }
        // The side of the polygon at its lowest vertex, of the lowest ones the leftmost, is that of its interior.
        let count = vertices.len();
        let before = |a: &Vector2<f64>, b: &Vector2<f64>| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x));
        let lowest = (0..count).min_by(|&i, &j| before(&vertices[i], &vertices[j])).unwrap_or(0);
        let turn =
            side(&vertices[(lowest + count - 1) % count], &vertices[lowest], &vertices[(lowest + 1) % count]);
        match turn.partial_cmp(&0.0) {
            Some(Ordering::Less) => vertices.reverse(),
            Some(Ordering::Greater) => {}
            _ => return None,
        }
        let low = vertices.iter().fold(vertices[0], |low, p| low.inf(p));
        let high = vertices.iter().fold(vertices[0], |high, p| high.sup(p));
        Some(Self { vertices, low, high })
    }

    fn edges(&self) -> impl Iterator<Item = (&Vector2<f64>, &Vector2<f64>)> {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next)
    }

    /// The vertices at which a shortest way can bend: those where the polygon is convex.
    pub(super) fn corners(&self) -> impl Iterator<Item = Vector2<f64>> {
        let count = self.vertices.len();
        (0..count)
            .filter(move |&i| {
                let (before, after) =
                    (&self.vertices[(i + count - 1) % count], &self.vertices[(i + 1) % count]);
                side(before, &self.vertices[i], after) > 0.0
            })
            .map(|i| self.vertices[i])
    }

    /// Whether a point lies inside, not on the boundary.
    pub(super) fn holds(&self, p: &Vector2<f64>) -> bool {
        if p.x <= self.low.x || p.x >= self.high.x || p.y <= self.low.y || p.y >= self.high.y {
            return false;
        }
        let mut is_inside = false;
        for (a, b) in self.edges() {
            if is_on(a, b, p) {
                return false;
            }
            if (a.y > p.y) != (b.y > p.y) {
                let left = side(a, b, p) > 0.0;
                // A crossing of the ray to the right: the edge passes to the right of the point.
                is_inside ^= left == (b.y > a.y);
            }
        }
        is_inside
    }

    /// Whether the segment between two points that are not inside passes through the inside. Along the boundary is not through.
    pub(super) fn blocks(&self, p: &Vector2<f64>, q: &Vector2<f64>) -> bool {
        let (low, high) = (p.inf(q), p.sup(q));
        if high.x < self.low.x || low.x > self.high.x || high.y < self.low.y || low.y > self.high.y {
            return false;
        }
        let count = self.vertices.len();
        let mut of_a = side(p, q, &self.vertices[0]);
        for i in 0..count {
            let (a, b) = (&self.vertices[i], &self.vertices[(i + 1) % count]);
            let of_b = side(p, q, b);
            if of_a == 0.0 && is_between(p, q, a) {
                // The segment meets a vertex: it must not leave it into the inside, in either sense.
                let before = &self.vertices[(i + count - 1) % count];
                if is_into(before, a, b, p) || is_into(before, a, b, q) {
                    return true;
                }
            }
            if (of_a > 0.0 && of_b < 0.0) || (of_a < 0.0 && of_b > 0.0) {
                let (of_p, of_q) = (side(a, b, p), side(a, b, q));
                if (of_p > 0.0 && of_q < 0.0) || (of_p < 0.0 && of_q > 0.0) {
                    return true;
                }
                // An end on the edge: the other one must not lie on the inner side.
                if (of_p == 0.0 && of_q > 0.0) || (of_q == 0.0 && of_p > 0.0) {
                    return true;
                }
            }
            of_a = of_b;
        }
        false
    }
}

/// Whether a point of the line through `p` and `q` lies between them, ends included.
fn is_between(p: &Vector2<f64>, q: &Vector2<f64>, a: &Vector2<f64>) -> bool {
    let (low, high) = (p.inf(q), p.sup(q));
    (0..2).all(|k| low[k] <= a[k] && a[k] <= high[k])
}

/// Whether a point lies on a segment.
fn is_on(a: &Vector2<f64>, b: &Vector2<f64>, p: &Vector2<f64>) -> bool {
    is_between(a, b, p) && side(a, b, p) == 0.0
}

/// Whether the way from the vertex `v` towards `t` begins inside of the polygon, which comes from `u` and goes on to `w`.
fn is_into(u: &Vector2<f64>, v: &Vector2<f64>, w: &Vector2<f64>, t: &Vector2<f64>) -> bool {
    if t == v {
        return false;
    }
    let (before, after) = (side(u, v, t) > 0.0, side(v, w, t) > 0.0);
    match side(u, v, w).partial_cmp(&0.0) {
        Some(Ordering::Greater) => before && after,
        Some(Ordering::Less) => before || after,
        _ => before,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(points: &[[f64; 2]]) -> Polygon {
        Polygon::new(&points.iter().map(|p| Vector2::from(*p)).collect::<Vec<_>>()).unwrap()
    }

    fn l_shape() -> Polygon {
        polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]])
    }

    #[test]
    fn points_inside_outside_and_on_the_boundary() {
        let shape = l_shape();
        let reversed = Polygon::new(&shape.vertices.iter().rev().copied().collect::<Vec<_>>()).unwrap();
        for (p, inside) in [
            ([0.5, 0.5], true),
            ([3.9, 0.5], true),
            ([2.0, 2.0], false),
            ([1.0, 2.0], false),
            ([1.0, 1.0], false),
            ([0.0, 4.0], false),
            ([0.5, 1.0], true),
            ([-1.0, 1.0], false),
        ] {
            let p = Vector2::from(p);
            assert_eq!((shape.holds(&p), reversed.holds(&p)), (inside, inside), "{p}");
        }
    }

    #[test]
    fn sight_along_the_boundary_is_free() {
        let shape = l_shape();
        for (p, q, blocked) in [
            ([-1.0, 2.0], [5.0, 2.0], true),
            ([0.0, -1.0], [0.0, 5.0], false),
            ([1.0, 0.0], [1.0, 5.0], true),
            ([1.0, 1.0], [1.0, 5.0], false),
            ([4.0, 1.0], [1.0, 4.0], false),
            ([2.0, 1.0], [1.0, 2.0], false),
            ([2.0, 1.0], [2.0, 0.0], true),
            ([2.0, 1.0], [2.0, 3.0], false),
            ([1.0, 1.0], [0.0, 0.0], true),
            ([1.0, 1.0], [3.0, 3.0], false),
            ([-1.0, 1.0], [1.0, -1.0], false),
            ([-1.0, 5.0], [5.0, -1.0], true),
            ([0.0, 1.0], [4.0, 1.0], true),
            ([1.0, 1.0], [4.0, 1.0], false),
            ([5.0, 0.0], [-1.0, 0.0], false),
        ] {
            let (p, q) = (Vector2::from(p), Vector2::from(q));
            assert_eq!((shape.blocks(&p, &q), shape.blocks(&q, &p)), (blocked, blocked), "{p} {q}");
        }
    }

    #[test]
    fn corners_are_where_it_is_convex() {
        assert_eq!(l_shape().corners().count(), 5);
        assert!(Polygon::new(&[Vector2::zeros(), Vector2::x(), Vector2::x() * 2.0]).is_none());
    }
}
