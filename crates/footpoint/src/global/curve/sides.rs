//! The sides of a place on a curve: [`sides`](crate::global::surface::sides) for curves, whose pieces may meet in a kink.

use crate::global::arithmetic::simd::vectorized;
use crate::global::curve::piece::PieceSet;
use crate::global::curve::scratch::CurveFoot;
use crate::global::surface::sides::{ROUNDS, WORTH};
use crate::tolerance::{ORTHOGONAL, ORTHOGONAL_FLOOR};
use nalgebra::SVector;

/// Where a walk ended.
pub(crate) struct CurveWalk {
    pub(crate) foot: CurveFoot,
    /// Whether the distance falls on the other side of the foot, which the limit on steps kept the walk from taking.
    pub(crate) falls_beyond: bool,
}

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// Follows the distance downhill from a place, across smooth joints and kinks.
    #[inline(always)]
    pub(crate) fn follow(&self, x: &SVector<f64, D>, place: (usize, f64), max_steps: u32) -> CurveWalk {
        vectorized(
            #[inline(always)]
            || {
                let (piece, local) = self.steeper_side(x, place).unwrap_or(place);
                let mut foot = self.descend_inline(x, piece, local, max_steps);
                for _ in 0..ROUNDS {
                    let Some((piece, local)) = self.steeper_side(x, (foot.piece, foot.local)) else {
                        return CurveWalk { foot, falls_beyond: false };
                    };
                    if foot.steps >= max_steps {
                        break;
                    }
                    let mut found = self.descend(x, piece, local, max_steps - foot.steps);
                    found.steps += foot.steps;
                    if found.distance_sq >= foot.distance_sq * (1.0 - WORTH) {
                        // The fall was one of rounding errors.
                        foot.steps = found.steps;
                        return CurveWalk { foot, falls_beyond: false };
                    }
                    foot = found;
                }
                CurveWalk { foot, falls_beyond: true }
            },
        )
    }

    /// The piece across the lower (`end` 0) or upper (`end` 1) end of a piece, whether the curve goes on smoothly or not.
    pub(crate) fn beyond(&self, index: usize, end: usize) -> Option<usize> {
        let piece = &self.pieces[index];
        match (piece.ends[end], end) {
            (false, 0) => Some(index - 1),
            (false, _) => Some(index + 1),
            (true, _) if !piece.closed => None,
            (true, 0) => self.locate(piece.shape, f64::INFINITY).map(|p| p.0),
            (true, _) => self.locate(piece.shape, f64::NEG_INFINITY).map(|p| p.0),
        }
    }

    /// The other side of a place, if it is a kink and the distance falls more there.
    #[inline(always)]
    fn steeper_side(&self, x: &SVector<f64, D>, (index, local): (usize, f64)) -> Option<(usize, f64)> {
        if local > 0.0 && local < 1.0 {
            return None;
        }
        let end = usize::from(local > 0.5);
        if self.pieces[index].neighbours[end].is_some() {
            return None;
        }
        let other = (self.beyond(index, end)?, 1.0 - end as f64);
        let point = |(index, local): (usize, f64)| {
            let piece = &self.pieces[index];
            self.jet(piece, local).point + piece.centre
        };
        // Across a gap the curve is not the same point.
        let here = point((index, local));
        if (point(other) - here).norm() > 1e-9 * self.size {
            return None;
        }
        let noise = (ORTHOGONAL * (here - x).norm()).max(ORTHOGONAL_FLOOR * self.size);
        let beyond = self.fall(x, other);
        (beyond > noise && beyond > self.fall(x, (index, local))).then_some(other)
    }

    /// How fast the distance to `x` falls, per length, from an end into its piece, times the distance.
    fn fall(&self, x: &SVector<f64, D>, (index, local): (usize, f64)) -> f64 {
        let piece = &self.pieces[index];
        let jet = self.jet(piece, local);
        let slope = jet.d1.dot(&(jet.point - (x - piece.centre)));
        let speed = jet.d1.norm();
        if speed > 0.0 { (if local > 0.5 { slope } else { -slope } / speed).max(0.0) } else { 0.0 }
    }
}
