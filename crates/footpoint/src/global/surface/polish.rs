//! The lowest of the places that a certificate cannot tell apart.
//!
//! A proof ends when nothing is nearer by more than the allowed gap. The footpoint is better than that: other minima
//! within the gap are compared, and saddles, maxima along a valley and poles are left downhill.

use crate::global::surface::foot::Foot;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::scratch::Scratch;
use nalgebra::Vector3;

/// Limit of the local iterations.
pub(in crate::global) const MAX_STEPS: u32 = 40;

/// Steps of all local iterations from places that may be ties, after which the rest is not looked at: next to axes
/// there are many such places, and the iterations are slow.
pub(in crate::global) const TIE_STEPS: u32 = 80;

/// Places nearer than this, in local parameters, lead to the same minimum.
pub(in crate::global) const BESIDE: f64 = 1e-6;

/// `1 − d κ` below this may be a saddle.
pub(in crate::global) const SADDLE: f64 = 1e-8;

/// Step that leaves a saddle, in local parameters.
pub(in crate::global) const STRIDE: f64 = 0.35;

/// How often a saddle is left.
pub(in crate::global) const ROUNDS: usize = 4;

/// Relative decrease of the squared distance that is more than a rounding error.
pub(in crate::global) const WORTH: f64 = 1e-14;

/// Lines through a pole, per patch, of which the one that falls most is followed.
const LINES: usize = 8;

/// Distance from a pole, as a share of the size of the model, within which places are the pole.
const AT_POLE: f64 = 1e-9;

impl<const K: usize> PatchSet<K> {
    /// Replaces the footpoint by the lowest of the places that the proof met; the others become rivals.
    #[inline(always)]
    pub(crate) fn polish(&self, x: &Vector3<f64>, best: &mut Foot, scratch: &mut Scratch<K>) {
        if best.patch == usize::MAX {
            return;
        }
        let budget = best.steps.saturating_add(TIE_STEPS);
        for next in 0..scratch.ties.len() {
            if best.steps >= budget {
                break;
            }
            let (patch, place) = scratch.ties[next];
            let beside = |foot: &Foot| {
                foot.patch == patch && (0..2).all(|d| (foot.local[d] - place[d]).abs() <= BESIDE)
            };
            if beside(best) || scratch.rivals.iter().any(beside) {
                continue;
            }
            let before = *best;
            let found = self.take(x, patch, place, best);
            scratch.rivals.push(if best.distance_sq < before.distance_sq { before } else { found });
        }
        for _ in 0..ROUNDS {
            let before = best.distance_sq;
            if !self.leave(x, best) || best.distance_sq >= before * (1.0 - WORTH) {
                break;
            }
        }
    }

    /// Tries to go on from a place that may not be a minimum; false where there is no need to.
    #[inline(always)]
    fn leave(&self, x: &Vector3<f64>, best: &mut Foot) -> bool {
        let patch = &self.patches[best.patch];
        let jet = self.jet(patch, best.local[0], best.local[1]);
        let r = jet.point - (x - patch.centre);
        let metric = [jet.du.norm_squared(), jet.du.dot(&jet.dv), jet.dv.norm_squared()];
        let hessian = [metric[0] + jet.duu.dot(&r), metric[1] + jet.duv.dot(&r), metric[2] + jet.dvv.dot(&r)];
        let gradient = [jet.du.dot(&r), jet.dv.dot(&r)];
        let cells = &self.cells[patch.shape()];
        let still_sq = AT_POLE * AT_POLE * self.size * self.size;
        let mut free = [true; 2];
        for d in 0..2 {
            let end = usize::from(best.local[d] > 0.5);
            let gap = (best.local[d] - end as f64).abs();
            if cells.collapsed[d][end]
                && cells.at_end(patch.cell(), d, end)
                && gap * gap * metric[2 * d] <= still_sq
            {
                return self.leave_pole(x, best, d, end);
            }
            let outwards = if end == 0 { gradient[d] } else { -gradient[d] };
            free[d] = gap > 0.0 || outwards <= 0.0 || cells.across(patch.cell(), d, end).is_some();
        }
        let (ratio, direction) = match free {
            [true, true] => flattest(&metric, &hessian),
            [true, false] => (hessian[0] / metric[0], [1.0, 0.0]),
            [false, true] => (hessian[2] / metric[2], [0.0, 1.0]),
            [false, false] => return false,
        };
        let length = direction[0].abs().max(direction[1].abs());
        if !(ratio <= SADDLE && length > 0.0 && length.is_finite()) {
            return false;
        }
        let (start, step) = (*best, direction.map(|c| STRIDE * c / length));
        for step in [step, step.map(|c| -c)] {
            let (index, place) = self.walk(start.patch, start.local, step);
            self.take(x, index, place, best);
        }
        true
    }

    /// Follows the parameter line that falls most.
    fn leave_pole(&self, x: &Vector3<f64>, best: &mut Foot, d: usize, end: usize) -> bool {
        let patch = &self.patches[best.patch];
        let cells = &self.cells[patch.shape()];
        let mut steepest = (0.0, usize::MAX, [0.0; 2]);
        for other in 0..cells.counts[1 - d] {
            let mut cell = [other; 2];
            cell[d] = patch.cell()[d];
            let index = cells.patch(cell);
            let patch = &self.patches[index];
            for k in 0..LINES {
                let mut place = [k as f64 / LINES as f64; 2];
                place[d] = end as f64;
                let jet = self.jet(patch, place[0], place[1]);
                let r = jet.point - (x - patch.centre);
                let (tangent, second) = if d == 0 { (jet.du, jet.duu) } else { (jet.dv, jet.dvv) };
                let inward = if end == 0 { tangent } else { -tangent };
                let (slope, speed_sq) = (inward.dot(&r), inward.norm_squared());
                let fall = slope / speed_sq.sqrt();
                if fall < steepest.0 {
                    let bend = (speed_sq + second.dot(&r)).max(1e-3 * speed_sq);
                    let way = (-slope / bend).min(0.5);
                    place[d] = if end == 0 { way } else { 1.0 - way };
                    steepest = (fall, index, place);
                }
            }
        }
        let (_, index, place) = steepest;
        if index == usize::MAX {
            return false;
        }
        self.take(x, index, place, best);
        true
    }

    /// Goes downhill from a place, and stays there if that is lower; returns where it led.
    #[inline(always)]
    fn take(&self, x: &Vector3<f64>, index: usize, place: [f64; 2], best: &mut Foot) -> Foot {
        let found = self.descend(x, index, place, MAX_STEPS);
        let steps = best.steps + found.steps;
        if is_lower(found.distance_sq, best.distance_sq, self.size) && (found.settled || !best.settled) {
            *best = found;
        }
        best.steps = steps;
        found
    }
}

/// Whether a squared distance is lower by more than the rounding errors of places on a model of this size.
#[inline(always)]
pub(in crate::global) fn is_lower(candidate_sq: f64, best_sq: f64, size: f64) -> bool {
    candidate_sq < best_sq * (1.0 - WORTH) - 4.0 * f64::EPSILON * size * best_sq.sqrt()
}

/// Smallest eigenvalue of the Hessian with respect to the metric, `1 − d κ`, and its unit direction.
pub(crate) fn flattest(g: &[f64; 3], h: &[f64; 3]) -> (f64, [f64; 2]) {
    // Roots of det(H − λ G).
    let a = g[0] * g[2] - g[1] * g[1];
    let b = h[0] * g[2] + h[2] * g[0] - 2.0 * h[1] * g[1];
    let c = h[0] * h[2] - h[1] * h[1];
    let root = (0.5 * b - (0.25 * b * b - a * c).max(0.0).sqrt()) / a;
    let rows = [[h[0] - root * g[0], h[1] - root * g[1]], [h[1] - root * g[1], h[2] - root * g[2]]];
    let weight = |r: &[f64; 2]| r[0].abs() / g[0].sqrt() + r[1].abs() / g[2].sqrt();
    let row = if weight(&rows[0]) >= weight(&rows[1]) { rows[0] } else { rows[1] };
    let mut direction = [-row[1], row[0]];
    if direction == [0.0; 2] {
        direction = [1.0, 0.0];
    }
    let length = (g[0] * direction[0] * direction[0]
        + 2.0 * g[1] * direction[0] * direction[1]
        + g[2] * direction[1] * direction[1])
        .sqrt();
    (root, direction.map(|c| c / length))
}
