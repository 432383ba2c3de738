//! Where a surface folds back on itself.

use super::fold_bounds;
use crate::parallel;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface, SurfaceJet};

/// Cells of a surface, and those in which it folds.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Folds {
    /// Number of cells (products of knot spans).
    pub cells: usize,
    /// The folded ones, by the index of their span in u and in v, in ascending order.
    pub folded: Vec<[usize; 2]>,
    /// Parts of a span in each direction down to which folds were looked for: one that is smaller than a part may be missed.
    pub parts_per_span: usize,
}

impl Folds {
    /// Looks for cells in which the surface folds over, so that parameter lines cross.
    ///
    /// A cell is free of folds where bounds on its normals, the Bernstein coefficients of `s_u × s_v`, show that they are on one side, in
    /// parts down to 1/32 of a span. It is folded where the normals of such a part differ by more than a right angle, or where the
    /// normal at a knot or half way between two is reversed against what it is close by on both sides: a pleat. Ridges and thin
    /// edges, over which it turns once by however much, are no folds, nor are poles, where it has no direction.
    /// Surfaces with weights are looked at along the lines of a grid only, two in each span.
    #[must_use]
    pub fn of(surface: &BsplineSurface) -> Self {
        let mut found = Self::on_grid(surface);
        if surface.weights().is_none() {
            found.folded.extend(fold_bounds::folded(surface));
            found.folded.sort_unstable();
            found.folded.dedup();
            found.parts_per_span = fold_bounds::PARTS;
        }
        found
    }

    /// The same from normals along the lines of a grid only, which has the ends and the middles of the knot spans: for looking often.
    pub(crate) fn on_grid(surface: &BsplineSurface) -> Self {
        let corners = Corners::new(surface);
        let mut folded: Vec<[usize; 2]> =
            corners.folded().into_iter().map(|cell| cell.map(|k| k / 2)).collect();
        folded.sort_unstable();
        folded.dedup();
        Self { cells: corners.cells.map(|n| n / 2).iter().product(), folded, parts_per_span: 2 }
    }

    /// Number of folded cells.
    #[must_use]
    pub fn count(&self) -> usize {
        self.folded.len()
    }
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
        corners.jets = parallel::tasks(cells[1] + 1, |j| {
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
            // Around a closed surface of few cells a quarter at most: further off its normal is reversed on both sides anyway.
            let quarter = (self.cells[direction].saturating_sub(1) / 4).max(1);
            let most = if self.closed[direction] { PLEAT.min(quarter) } else { PLEAT } as isize;
            let side = |sign: isize| (1..=most).find_map(|k| beside(direction, sign * k));
            side(-1)
                .zip(side(1))
                .is_some_and(|(before, after)| before.dot(&after) > 0.5 * before.norm() * after.norm())
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
        parallel::tasks(self.cells[1], row).concat()
    }

    fn is_folded(&self, [i, j]: [usize; 2]) -> bool {
        let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
        corners.iter().any(|&corner| self.is_pleat(corner))
            || (0..4).any(|k| self.jumps([corners[k], corners[(k + 1) % 4]]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nurbs_core::KnotVector;
    use std::f64::consts::TAU;

    /// A sheet over `z = height(v)`, with places `across(v)`.
    fn sheet(across: &dyn Fn(f64) -> f64, height: &dyn Fn(f64) -> f64) -> BsplineSurface {
        let (m, n) = (6, 61);
        let at = |k: usize| {
            let v = (k % n) as f64 / (n - 1) as f64;
            Vector3::new((k / n) as f64, across(v), height(v))
        };
        let points: Vec<_> = (0..m * n).map(at).collect();
        let [u, v] =
            [m, n].map(|count| (0..count).map(|k| k as f64 / (count - 1) as f64).collect::<Vec<_>>());
        let knots = [KnotVector::averaged(3, &u).unwrap(), KnotVector::averaged(3, &v).unwrap()];
        BsplineSurface::interpolate_grid_at(knots, [&u, &v], &points).unwrap()
    }

    #[test]
    fn ridges_are_no_folds() {
        // Flanks that rise by 2 to 1: normals of neighbouring flanks are 127 degrees apart.
        let ridges = |v: f64| 2.0 * (10.0 * v - (10.0 * v).round()).abs();
        assert_eq!(Folds::of(&sheet(&|v| 10.0 * v, &ridges)).count(), 0);
        // A sheet around a thin edge.
        let edge = |v: f64| (v - 0.5).hypot(0.01);
        assert_eq!(Folds::of(&sheet(&|v| 0.02 * (v - 0.5).atan(), &edge)).count(), 0);
        // The sheet runs back for a while, flat or in three layers.
        let back = |v: f64| v + 0.025 * (10.0 * TAU * v).sin();
        assert!(Folds::of(&sheet(&back, &|_| 0.0)).count() > 0);
        assert!(Folds::of(&sheet(&back, &|v| 0.01 * (10.0 * TAU * v).cos())).count() > 0);
    }
}
