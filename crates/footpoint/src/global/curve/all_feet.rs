//! All local minima of the distance from a set of curve pieces.

use crate::global::arithmetic::lanes::{row_max, row_min};
use crate::global::curve::all_feet_line::{Harvest, Level, Line, Spot};
use crate::global::curve::piece::{PieceSet, bounds, extent};
use crate::global::curve::scratch::CurveFoot;
use crate::global::gap::Gap;
use crate::global::tree::{Bounds, Content, Visit};
use nalgebra::SVector;

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// Candidates for all local minima whose squared distance is at most `limit_sq`.
    pub(crate) fn minima(&self, x: &SVector<f64, D>, limit_sq: f64, gap: &Gap) -> Harvest<CurveFoot, D> {
        let mut harvest = Harvest::new(gap.max_boxes);
        let mut visits = vec![Visit::root()];
        let query: [f64; D] = (*x).into();
        while let Some(visit) = visits.pop() {
            match visit.content() {
                Content::Node(node) => self.tree.expand(node, &query, limit_sq, &mut visits),
                Content::Item(index) => {
                    harvest.enter_piece();
                    self.piece_minima(x, index, limit_sq, gap, &mut harvest);
                }
            }
        }
        harvest
    }

    fn piece_minima(
        &self,
        x: &SVector<f64, D>,
        index: usize,
        limit_sq: f64,
        gap: &Gap,
        harvest: &mut Harvest<CurveFoot, D>,
    ) {
        let piece = &self.pieces[index];
        let y = x - piece.centre;
        let squared = self.form(piece, &y, 0.0);
        let scale =
            row_max(&squared).abs().max(row_min(&squared).abs()) + y.norm_squared() * piece.max_weight_sq;
        let weights = [piece.min_weight_sq, piece.max_weight_sq];
        let level = Level::new(limit_sq, 0.0, scale, weights, gap.tie, self.size);
        let weight = self.weight_form(piece);
        let line = Line { squared: &squared, weight, degree: Self::DEGREE, ends: [true; 2] };
        let extent = |range| extent(&[self.arc_bounds(index, range)]);
        let spots = line.minima(&level, &extent, &mut || harvest.enter_box());
        for spot in spots {
            match spot {
                Spot::Minimum(s) => harvest.feet.push(self.descend(x, index, s, 50)),
                Spot::Flat([a, b]) => {
                    let foot = self.descend(x, index, 0.5 * (a + b), 50);
                    harvest.flats.push((foot, self.arc_bounds(index, [a, b])));
                }
                Spot::Unresolved => harvest.unresolved = true,
            }
        }
    }

    /// Box around points sampled between two local parameters.
    fn arc_bounds(&self, index: usize, [a, b]: [f64; 2]) -> Bounds<D> {
        let piece = &self.pieces[index];
        let sample = |k: u32| {
            let s = f64::from(k) / 4.0;
            self.jet(piece, (1.0 - s) * a + s * b).point + piece.centre
        };
        bounds(&[0, 1, 2, 3, 4].map(sample))
    }
}
