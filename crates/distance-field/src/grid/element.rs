//! Points, segments and triangles as sources of a distance, and the nodes next to them.

use super::Lattice;
use nalgebra::SVector;

/// A source with a distance in closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Element<const D: usize> {
    /// A point.
    Point(SVector<f64, D>),
    /// The segment between two points.
    Segment([SVector<f64, D>; 2]),
    /// The triangle of three points.
    Triangle([SVector<f64, D>; 3]),
}

impl<const D: usize> Element<D> {
    /// The point of the element nearest to `x`.
    #[must_use]
    pub fn nearest(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        match self {
            Self::Point(p) => *p,
            Self::Segment([a, b]) => on_segment(x, a, b),
            Self::Triangle(corners) => on_triangle(x, corners),
        }
    }

    /// The distance of `x`.
    #[must_use]
    pub fn distance(&self, x: &SVector<f64, D>) -> f64 {
        (x - self.nearest(x)).norm()
    }

    /// Whether all its numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.corners().iter().all(|p| p.iter().all(|c| c.is_finite()))
    }

    pub(super) fn corners(&self) -> &[SVector<f64, D>] {
        match self {
            Self::Point(p) => std::slice::from_ref(p),
            Self::Segment(ends) => ends,
            Self::Triangle(corners) => corners,
        }
    }
}

fn on_segment<const D: usize>(
    x: &SVector<f64, D>,
    a: &SVector<f64, D>,
    b: &SVector<f64, D>,
) -> SVector<f64, D> {
    let along = b - a;
    let squared = along.norm_squared();
    let share = if squared > 0.0 { ((x - a).dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    // From the nearer end, so that the far one is hit exactly.
    if share < 0.5 { a + along * share } else { b - along * (1.0 - share) }
}

fn on_triangle<const D: usize>(x: &SVector<f64, D>, [a, b, c]: &[SVector<f64, D>; 3]) -> SVector<f64, D> {
    let (u, v, d) = (b - a, c - a, x - a);
    let (uu, uv, vv, ud, vd) = (u.dot(&u), u.dot(&v), v.dot(&v), u.dot(&d), v.dot(&d));
    let determinant = uu * vv - uv * uv;
    if determinant > 1e-14 * uu * vv {
        let (s, t) = ((vv * ud - uv * vd) / determinant, (uu * vd - uv * ud) / determinant);
        if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
            return a + u * s + v * t;
        }
    }
    let feet = [on_segment(x, a, b), on_segment(x, b, c), on_segment(x, c, a)];
    let far = |p: &SVector<f64, D>| (x - p).norm_squared();
    let nearer = |p: SVector<f64, D>, q: SVector<f64, D>| if far(&q) < far(&p) { q } else { p };
    nearer(nearer(feet[0], feet[1]), feet[2])
}

/// A node whose distance is known from the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seed {
    /// The node.
    pub node: usize,
    /// Its distance.
    pub distance: f64,
    /// The source that has it.
    pub element: u32,
}

/// The nodes within `margin` of the elements, each with its nearest one, in the order of the nodes.
///
/// Where no node is that near to an element, the nodes around its nearest point count, as far as they are in the box.
#[must_use]
pub fn seeds<const D: usize>(lattice: &Lattice<D>, elements: &[Element<D>], margin: f64) -> Vec<Seed> {
    // One entry for each node: elements far smaller than the margin would come to many for each.
    let mut found: Vec<(f64, u32)> = vec![(f64::INFINITY, 0); lattice.len()];
    for (element, index) in elements.iter().zip(0u32..) {
        let corners = element.corners();
        let low = corners.iter().fold(corners[0], |low, p| low.inf(p));
        let high = corners.iter().fold(corners[0], |high, p| high.sup(p));
        let Some(range) = lattice.range(&low, &high, margin) else { continue };
        lattice.visit(&range, |node| {
            let distance = element.distance(&lattice.point(node));
            if distance <= margin && distance < found[node].0 {
                found[node] = (distance, index);
            }
        });
    }
    let is_near = |(_, (distance, _)): &(usize, (f64, u32))| distance.is_finite();
    let near = found.into_iter().enumerate().filter(is_near);
    near.map(|(node, (distance, element))| Seed { node, distance, element }).collect()
}

/// The seeds of a shape that lies outside of the box: the nodes of its faces, each with its nearest element.
#[must_use]
pub fn seeds_on_faces<const D: usize>(lattice: &Lattice<D>, elements: &[Element<D>]) -> Vec<Seed> {
    let counts = lattice.counts();
    let on_face = |node: &usize| {
        let indices = lattice.indices(*node);
        (0..D).any(|k| indices[k] == 0 || indices[k] == counts[k] - 1)
    };
    let nearest = |node: usize| {
        let x = lattice.point(node);
        let mut best = Seed { node, distance: f64::INFINITY, element: 0 };
        for (element, index) in elements.iter().zip(0u32..) {
            let distance = element.distance(&x);
            if distance < best.distance {
                best = Seed { node, distance, element: index };
            }
        }
        best
    };
    (0..lattice.len()).filter(on_face).map(nearest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    #[test]
    fn nearest_points_of_a_triangle() {
        let corners = [Vector3::zeros(), Vector3::x(), Vector3::y()];
        let triangle = Element::Triangle(corners);
        for (x, right) in [
            ([0.25, 0.25, 1.0], [0.25, 0.25, 0.0]),
            ([-1.0, -1.0, 0.5], [0.0, 0.0, 0.0]),
            ([1.0, 1.0, 0.0], [0.5, 0.5, 0.0]),
            ([0.5, -2.0, 0.0], [0.5, 0.0, 0.0]),
            ([3.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ] {
            assert!((triangle.nearest(&Vector3::from(x)) - Vector3::from(right)).norm() < 1e-15);
        }
        // Without area the edges decide.
        let flat = Element::Triangle([Vector3::zeros(), Vector3::x(), Vector3::x() * 2.0]);
        assert_eq!(flat.distance(&Vector3::new(1.5, 2.0, 0.0)), 2.0);
    }

    #[test]
    fn seeds_have_the_nearest_element() {
        let lattice = Lattice::new(Vector2::zeros(), Vector2::new(4.0, 4.0), [5, 5]).unwrap();
        let elements = [
            Element::Point(Vector2::new(1.0, 1.0)),
            Element::Segment([Vector2::new(1.0, 2.0), Vector2::new(3.0, 2.0)]),
        ];
        let found = seeds(&lattice, &elements, 1.0);
        assert_eq!(found.len(), 13);
        let at = |node: usize| found.iter().find(|seed| seed.node == node).unwrap();
        assert_eq!((at(6).distance, at(6).element), (0.0, 0));
        assert_eq!((at(11).distance, at(11).element), (1.0, 0));
        assert_eq!((at(12).distance, at(12).element), (0.0, 1));
    }
}
