//! What keeps a fit from folding: the base surface, where the fit would fold.

use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface};

/// Places in each direction of a cell at which the base surface is taken.
const PLACES: usize = 4;
/// How much an anchored cell counts at first, in cells with data, and by what factor more each time it folds again.
const FIRST: f64 = 0.05;
const MORE: f64 = 4.0;

/// For each cell (product of knot spans) how much the base surface counts there besides the data.
#[derive(Clone, Debug)]
pub(super) struct Anchors {
    /// Ends of the spans in u and v.
    ends: [Vec<f64>; 2],
    closed: bool,
    strength: Vec<f64>,
}

/// Points of the base surface with the parameters they have there, and how much each counts.
#[derive(Clone, Debug, Default)]
pub(super) struct AnchorPoints {
    pub(super) parameters: Vec<[f64; 2]>,
    pub(super) points: Vec<Vector3<f64>>,
    pub(super) weights: Vec<f64>,
}

impl Anchors {
    /// None yet; `closed` says whether u is.
    pub(super) fn none(ends: [Vec<f64>; 2], closed: bool) -> Self {
        let cells = (ends[0].len() - 1) * (ends[1].len() - 1);
        Self { ends, closed, strength: vec![0.0; cells] }
    }

    /// Makes the base count more in the given cells and their neighbours.
    pub(super) fn strengthen(&mut self, folded: &[[usize; 2]]) {
        let [m, n] = [self.ends[0].len() - 1, self.ends[1].len() - 1];
        let mut touched = vec![false; m * n];
        for &[i, j] in folded {
            for k in 0..9 {
                let (a, b) = (i + k / 3, j + k % 3);
                let a = if self.closed { (a + m - 1) % m } else { a.wrapping_sub(1) };
                let b = b.wrapping_sub(1);
                if a < m && b < n {
                    touched[a * n + b] = true;
                }
            }
        }
        for (strength, _) in self.strength.iter_mut().zip(touched).filter(|(_, t)| *t) {
            *strength = (*strength * MORE).max(FIRST);
        }
    }

    /// The points of the base in the cells that are held; `per_cell` is the weight of the data in a cell, on average.
    pub(super) fn points(&self, base: &BsplineSurface, per_cell: f64) -> AnchorPoints {
        let n = self.ends[1].len() - 1;
        let mut found = AnchorPoints::default();
        for (cell, &strength) in self.strength.iter().enumerate().filter(|(_, s)| **s > 0.0) {
            let at = |direction: usize, span: usize, k: usize| {
                let ends = &self.ends[direction];
                ends[span] + (ends[span + 1] - ends[span]) * (k as f64 + 0.5) / PLACES as f64
            };
            for k in 0..PLACES * PLACES {
                let [u, v] = [at(0, cell / n, k / PLACES), at(1, cell % n, k % PLACES)];
                found.parameters.push([u, v]);
                found.points.push(base.point(u, v));
                found.weights.push(strength * per_cell / (PLACES * PLACES) as f64);
            }
        }
        found
    }
}
