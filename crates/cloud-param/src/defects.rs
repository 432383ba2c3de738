//! Self-loops and crossovers: what a base curve or surface must not have.

use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineSurface, ParametricSurface, SurfaceJet};

/// Number of places where a closed polygon crosses itself.
#[must_use]
pub fn self_loops(polygon: &[Vector2<f64>]) -> usize {
    let n = polygon.len();
    let edge = |i: usize| (polygon[i], polygon[(i + 1) % n]);
    // Edges by their left ends; each is compared with those that begin before it ends.
    let mut order: Vec<usize> = (0..n).collect();
    let left = |i: usize| edge(i).0.x.min(edge(i).1.x);
    order.sort_by(|&i, &j| left(i).total_cmp(&left(j)));
    let mut found = 0;
    for (k, &i) in order.iter().enumerate() {
        let (a, b) = edge(i);
        let right = a.x.max(b.x);
        for &j in order[k + 1..].iter().take_while(|&&j| left(j) <= right) {
            if (i + 1) % n != j && (j + 1) % n != i && cross(a, b, edge(j).0, edge(j).1) {
                found += 1;
            }
        }
    }
    found
}

/// Whether two segments cross in their interiors.
fn cross(a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>, d: Vector2<f64>) -> bool {
    let side = |p: Vector2<f64>, q: Vector2<f64>, r: Vector2<f64>| (q - p).perp(&(r - p));
    let (low, high) = (a.y.min(b.y), a.y.max(b.y));
    c.y.max(d.y) >= low
        && c.y.min(d.y) <= high
        && side(a, b, c) * side(a, b, d) < 0.0
        && side(c, d, a) * side(c, d, b) < 0.0
}

/// How often an edge over which the normal turns by more than a right angle is halved to tell a ridge from a fold.
const HALVINGS: usize = 4;
/// Cosine of the angle that a normal in a pleat makes at least with those on both sides of it.
const REVERSED: f64 = -0.7;
/// How far off these are at most, in cells.
const PLEAT: usize = 3;

/// A surface at the corners of a grid of cells, two for each knot span in both directions.
struct Corners<'a> {
    surface: &'a BsplineSurface,
    /// Ends and middles of the spans.
    parameters: [Vec<f64>; 2],
    cells: [usize; 2],
    closed: [bool; 2],
    jets: Vec<Vec<SurfaceJet>>,
    /// Length below which a normal has no direction, squared: at a pole.
    negligible: f64,
}

impl<'a> Corners<'a> {
    fn new(surface: &'a BsplineSurface) -> Self {
        let knots = [surface.knots_u(), surface.knots_v()];
        let parameters = knots.map(|knots| {
            let spans = knots.spans().map(|span| knots.span_interval(span));
            let halves = spans.flat_map(|span| [span.start(), span.midpoint()]);
            halves.chain([knots.domain().end()]).collect::<Vec<f64>>()
        });
        let cells = [parameters[0].len() - 1, parameters[1].len() - 1];
        let closed = knots.map(|k| k.is_periodic());
        let mut corners = Self { surface, parameters, cells, closed, jets: Vec::new(), negligible: 0.0 };
        corners.jets = crate::parallel::map(cells[1] + 1, |j| {
            let along = (0..=cells[0]).map(|i| corners.parameter([i, j]));
            along.map(|[u, v]| surface.jet(u, v)).collect()
        });
        let squares = corners.jets.iter().flatten().map(|jet| jet.normal_direction().norm_squared());
        corners.negligible = 1e-12 * squares.fold(0.0, f64::max);
        corners
    }

    fn parameter(&self, corner: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.parameters[k][corner[k]])
    }

    fn normal(&self, [i, j]: [usize; 2]) -> Vector3<f64> {
        self.jets[j][i].normal_direction()
    }

    /// Whether the sheet goes back for a short way here: the normal is the opposite of what it is on both sides.
    fn is_pleat(&self, corner: [usize; 2]) -> bool {
        let here = self.normal(corner);
        let beside = |direction: usize, step: isize| {
            let count = self.cells[direction] as isize;
            let moved = corner[direction] as isize + step;
            let moved = if self.closed[direction] { moved.rem_euclid(count) } else { moved };
            let mut other = corner;
            other[direction] = usize::try_from(moved).ok().filter(|&k| k <= self.cells[direction])?;
            let normal = self.normal(other);
            let reversed = normal.dot(&here) < REVERSED * normal.norm() * here.norm() - self.negligible;
            reversed.then_some(normal)
        };
        (0..2).any(|direction| {
            let side = |sign: isize| (1..=PLEAT as isize).find_map(|k| beside(direction, sign * k));
            side(-1).zip(side(1)).is_some_and(|(before, after)| before.dot(&after) > 0.0)
        })
    }

    /// Whether the normal jumps to the other side somewhere along an edge.
    fn jumps(&self, edge: [[usize; 2]; 2]) -> bool {
        self.flips(edge.map(|corner| (self.parameter(corner), self.normal(corner))), HALVINGS)
    }

    /// Whether the normal turns by more than a right angle between two places, and still does so in a half, and so on.
    fn flips(&self, [a, b]: [([f64; 2], Vector3<f64>); 2], halvings: usize) -> bool {
        if a.1.dot(&b.1) >= -self.negligible || halvings == 0 {
            return a.1.dot(&b.1) < -self.negligible;
        }
        let middle = [0, 1].map(|k| 0.5 * (a.0[k] + b.0[k]));
        let middle = (middle, self.surface.jet(middle[0], middle[1]).normal_direction());
        self.flips([a, middle], halvings - 1) || self.flips([middle, b], halvings - 1)
    }

    /// The folded cells, row by row.
    fn folded(&self) -> Vec<[usize; 2]> {
        let row = |j: usize| {
            let cells = (0..self.cells[0]).map(|i| [i, j]);
            cells.filter(|&cell| self.is_folded(cell)).collect::<Vec<_>>()
        };
        crate::parallel::map(self.cells[1], row).concat()
    }

    fn is_folded(&self, [i, j]: [usize; 2]) -> bool {
        let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
        corners.iter().any(|&corner| self.is_pleat(corner))
            || (0..4).any(|k| self.jumps([corners[k], corners[(k + 1) % 4]]))
    }
}

/// The products of knot spans, by their numbers in u and v, in which a surface folds; see [`SurfaceDefects::crossovers`].
pub(crate) fn folded_spans(surface: &BsplineSurface) -> Vec<[usize; 2]> {
    let mut spans: Vec<[usize; 2]> =
        Corners::new(surface).folded().into_iter().map(|cell| cell.map(|k| k / 2)).collect();
    spans.sort_unstable();
    spans.dedup();
    spans
}

/// What is wrong with a surface that should be a deformed cylinder, sphere or plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SurfaceDefects {
    /// Number of places where curves `v = const` cross themselves, seen along the axis; 0 where there is none.
    pub self_loops: usize,
    /// Number of cells of a grid on the surface, two for each knot span in both directions, in which the surface folds over and
    /// parameter lines cross: the normal jumps to the other side along an edge, or it is reversed at a corner against what it
    /// is close by on both sides. Ridges and thin edges, over which it turns once, are none.
    pub crossovers: usize,
}

impl SurfaceDefects {
    /// Examines a surface; self-loops are looked for along `axis`, if `u` is closed and one is given.
    #[must_use]
    pub fn of(surface: &BsplineSurface, axis: Option<&[Vector3<f64>; 3]>) -> Self {
        let corners = Corners::new(surface);
        let [n_u, n_v] = corners.cells;
        let mut found = Self { self_loops: 0, crossovers: corners.folded().len() };
        if let (Some([a, b, _]), true) = (axis, corners.closed[0]) {
            let loops = crate::parallel::map(n_v + 1, |j| {
                let polygon: Vec<Vector2<f64>> = corners.jets[j][..n_u]
                    .iter()
                    .map(|jet| Vector2::new(jet.point.dot(a), jet.point.dot(b)))
                    .collect();
                self_loops(&polygon)
            });
            found.self_loops = loops.iter().sum();
        }
        found
    }

    /// Whether nothing is wrong.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn counts_crossings() {
        let figure = |f: &dyn Fn(f64) -> Vector2<f64>| -> Vec<Vector2<f64>> {
            (0..101).map(|i| f(TAU * f64::from(i) / 101.0)).collect()
        };
        assert_eq!(self_loops(&figure(&|t| Vector2::new(t.cos(), t.sin()))), 0);
        assert_eq!(self_loops(&figure(&|t| Vector2::new((t + 0.01).sin(), (2.0 * t + 0.02).sin()))), 1);
        // A circle with three small loops.
        assert!(self_loops(&figure(&|t| Vector2::new(t.cos(), t.sin()) * (1.0 - 1.6 * (3.0 * t).cos()))) > 0);
        assert_eq!(self_loops(&[]), 0);
    }

    /// A sheet over `z = height(v)`, with places `across(v)`.
    fn sheet(across: &dyn Fn(f64) -> f64, height: &dyn Fn(f64) -> f64) -> BsplineSurface {
        let (m, n) = (6, 61);
        let at = |k: usize| {
            let v = (k % n) as f64 / (n - 1) as f64;
            Vector3::new((k / n) as f64, across(v), height(v))
        };
        let points: Vec<_> = (0..m * n).map(at).collect();
        crate::SampleGrid { size: [m, n], points, closed: false }.surface().unwrap()
    }

    #[test]
    fn ridges_are_no_folds() {
        // Flanks that rise by 2 to 1: normals of neighbouring flanks are 127 degrees apart.
        let ridges = |v: f64| 2.0 * (10.0 * v - (10.0 * v).round()).abs();
        assert_eq!(SurfaceDefects::of(&sheet(&|v| 10.0 * v, &ridges), None).crossovers, 0);
        // A sheet around a thin edge.
        let edge = |v: f64| (v - 0.5).hypot(0.01);
        assert_eq!(SurfaceDefects::of(&sheet(&|v| 0.02 * (v - 0.5).atan(), &edge), None).crossovers, 0);
        // The sheet runs back for a while, flat or in three layers.
        let back = |v: f64| v + 0.025 * (10.0 * TAU * v).sin();
        assert!(SurfaceDefects::of(&sheet(&back, &|_| 0.0), None).crossovers > 0);
        assert!(SurfaceDefects::of(&sheet(&back, &|v| 0.01 * (10.0 * TAU * v).cos()), None).crossovers > 0);
    }
}
