//! The lowest of the places on curves that a certificate cannot tell apart: [`polish`](crate::global::surface::polish) for curves.

use crate::global::curve::piece::PieceSet;
use crate::global::curve::scratch::{CurveFoot, CurveScratch};
use crate::global::surface::polish::{BESIDE, MAX_STEPS, ROUNDS, SADDLE, STRIDE, TIE_STEPS, WORTH, is_lower};
use nalgebra::SVector;

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// Replaces the footpoint by the lowest of the places that the proof met; the others become rivals.
    #[inline(always)]
    pub(crate) fn polish(&self, x: &SVector<f64, D>, best: &mut CurveFoot, scratch: &mut CurveScratch<K>) {
        if best.piece == usize::MAX {
            return;
        }
        let budget = best.steps.saturating_add(TIE_STEPS);
        for next in 0..scratch.ties.len() {
            if best.steps >= budget {
                break;
            }
            let (piece, place) = scratch.ties[next];
            let beside = |foot: &CurveFoot| foot.piece == piece && (foot.local - place).abs() <= BESIDE;
            if beside(best) || scratch.rivals.iter().any(beside) {
                continue;
            }
            let before = *best;
            let found = self.take(x, piece, place, best);
            scratch.rivals.push(if best.distance_sq < before.distance_sq { before } else { found });
        }
        for _ in 0..ROUNDS {
            let before = best.distance_sq;
            if !self.leave(x, best) || best.distance_sq >= before * (1.0 - WORTH) {
                break;
            }
        }
    }

    /// Tries to go on from a place that may be a maximum; false where there is no need to.
    #[inline(always)]
    fn leave(&self, x: &SVector<f64, D>, best: &mut CurveFoot) -> bool {
        let piece = &self.pieces[best.piece];
        let jet = self.jet(piece, best.local);
        let r = jet.point - (x - piece.centre);
        let (slope, speed_sq) = (jet.d1.dot(&r), jet.d1.norm_squared());
        let bend = speed_sq + jet.d2.dot(&r);
        let blocked = (best.local <= 0.0 && slope > 0.0 && piece.neighbours[0].is_none())
            || (best.local >= 1.0 && slope < 0.0 && piece.neighbours[1].is_none());
        if blocked || bend.is_nan() || bend > SADDLE * speed_sq {
            return false;
        }
        let start = *best;
        for step in [STRIDE, -STRIDE] {
            let (index, place) = self.walk(start.piece, start.local, step);
            self.take(x, index, place, best);
        }
        true
    }

    /// Goes downhill from a place, and stays there if that is lower; returns where it led.
    #[inline(always)]
    fn take(&self, x: &SVector<f64, D>, index: usize, place: f64, best: &mut CurveFoot) -> CurveFoot {
        let found = self.descend(x, index, place, MAX_STEPS);
        let steps = best.steps + found.steps;
        if is_lower(found.distance_sq, best.distance_sq, self.size) && (found.settled || !best.settled) {
            *best = found;
        }
        best.steps = steps;
        found
    }
}
