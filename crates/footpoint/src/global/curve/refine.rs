//! The last digits of a footpoint on a curve: [`refine`](crate::global::surface::refine) for curves.

use crate::global::arithmetic::bernstein::basis_jet;
use crate::global::curve::piece::{Piece, PieceSet};
use crate::global::curve::scratch::CurveFoot;
use crate::global::surface::refine::{MAX_STEPS, Noise};
use nalgebra::SVector;
use nurbs_core::MAX_DEGREE;

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// A place at which the slope is smaller, next to one at which a descent has come to rest.
    #[cold]
    pub(crate) fn refine(&self, x: &SVector<f64, D>, foot: &CurveFoot) -> CurveFoot {
        let mut best = *foot;
        let mut violation = self.slope(x, &best).0.abs();
        for _ in 0..MAX_STEPS {
            let limit_sq = self.noise_at(&self.pieces[best.piece], best.local).same_sq(best.distance_sq);
            let (slope, bend, speed) = self.slope(x, &best);
            let step = -slope / (bend * speed);
            if !(bend > 0.0 && step.is_finite()) {
                break;
            }
            let (piece, local) = self.walk(best.piece, best.local, step.clamp(-0.5, 0.5));
            let distance_sq = self.distance_sq(x, piece, local);
            let next = CurveFoot { piece, local, distance_sq, steps: best.steps + 1, settled: true };
            let left = self.slope(x, &next).0.abs();
            let better = distance_sq <= limit_sq && left < violation;
            if !better {
                break;
            }
            (best, violation) = (next, left);
        }
        best
    }

    /// Component of the connecting line along the curve, `1 − d κ`, and the speed.
    fn slope(&self, x: &SVector<f64, D>, foot: &CurveFoot) -> (f64, f64, f64) {
        let piece = &self.pieces[foot.piece];
        let jet = self.jet(piece, foot.local);
        let r = jet.point - (x - piece.centre);
        let speed = jet.d1.norm();
        (jet.d1.dot(&r) / speed, 1.0 + jet.d2.dot(&r) / (speed * speed), speed)
    }

    /// The rounding errors at a place.
    pub(crate) fn noise_at(&self, piece: &Piece<D>, s: f64) -> Noise {
        let p = piece.degree;
        let mut basis = [[0.0; 3]; MAX_DEGREE + 1];
        basis_jet(p, s, &mut basis[..=p]);
        let weighted = self.points(piece).iter().zip(&basis);
        let (w, length) = weighted.fold((0.0, 0.0f64), |(w, length), ((point, weight), b)| {
            (w + weight * b[0], length.max(point.norm() / weight))
        });
        let ratio = if piece.rational { piece.max_weight_sq.sqrt() / w } else { 1.0 };
        Noise::new(p, false, length, ratio)
    }

    /// Whether the slope at a place is as small as its rounding error.
    #[cold]
    pub(crate) fn is_level(&self, x: &SVector<f64, D>, foot: &CurveFoot) -> bool {
        let (slope, _, speed) = self.slope(x, foot);
        let noise = self.noise_at(&self.pieces[foot.piece], foot.local);
        slope.abs() <= noise.along(foot.distance_sq.sqrt(), speed)
    }
}
