//! Best-first search for the nearest point of a set of curve pieces, and its certificate.

use crate::global::arithmetic::lanes::{Row, WIDTH, row_max, row_min};
use crate::global::arithmetic::simd::vectorized;
use crate::global::curve::piece::PieceSet;
use crate::global::curve::scratch::{CurveFoot, CurveScratch};
use crate::global::gap::Gap;
use crate::global::proof::line::{LineProof, Segment, prove_line};
use crate::global::surface::descend::{FLATTEST, SLOPE_NOISE_SQ};
use crate::global::tree::{Content, Visit};
use nalgebra::SVector;

/// A local step shorter than this, in units of the piece, is the last one.
const LAST_STEP: f64 = 1e-7;
/// Limit of the local iterations that start inside a search.
pub(in crate::global) const MAX_STEPS: u32 = 40;

/// Limit of the local iteration that finishes a footpoint which has not settled.
const PATIENT_STEPS: u32 = 400;

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// Follows the distance downhill, across smooth borders of pieces, until the steps vanish.
    pub(crate) fn descend(&self, x: &SVector<f64, D>, piece: usize, local: f64, max_steps: u32) -> CurveFoot {
        vectorized(
            #[inline(always)]
            || self.descend_inline(x, piece, local, max_steps),
        )
    }

    #[inline(always)]
    pub(crate) fn descend_inline(
        &self,
        x: &SVector<f64, D>,
        piece: usize,
        local: f64,
        max_steps: u32,
    ) -> CurveFoot {
        let mut best = CurveFoot { piece, local, ..CurveFoot::NONE };
        let (mut index, mut at) = (piece, local);
        let (mut steps, mut taken, mut shrink) = (0, 0.0f64, 1.0);
        loop {
            let piece = &self.pieces[index];
            let jet = self.jet(piece, at);
            let r = jet.point - (x - piece.centre);
            let distance_sq = r.norm_squared();
            steps += 1;
            if distance_sq > best.distance_sq * (1.0 + 1e-14) || !distance_sq.is_finite() {
                if steps >= max_steps || shrink < 1e-4 || taken.abs() * shrink < LAST_STEP {
                    best.settled = steps < max_steps;
                    break;
                }
                shrink *= 0.5;
                (index, at) = self.walk(best.piece, best.local, taken * shrink);
                continue;
            }
            best = CurveFoot { piece: index, local: at, distance_sq, steps, settled: false };
            shrink = 1.0;
            let (slope, speed_sq) = (jet.d1.dot(&r), jet.d1.norm_squared());
            let bend = speed_sq + jet.d2.dot(&r);
            let noise_sq = SLOPE_NOISE_SQ * (distance_sq + self.size * self.size) * speed_sq;
            if slope * slope <= noise_sq {
                // Nothing but rounding errors is left of the slope.
                best.settled = true;
                break;
            }
            let curvature = if bend.abs() > FLATTEST * speed_sq { bend.abs() } else { speed_sq };
            let step = if curvature > 0.0 { -slope / curvature } else { 0.0 };
            if !step.is_finite() {
                break;
            }
            let (next, target) = self.walk(index, at, step.clamp(-1.5, 1.5));
            let stays = next == index && target == at;
            if step.abs() < LAST_STEP || stays || steps >= max_steps {
                let distance_sq = self.distance_sq(x, next, target);
                if distance_sq <= best.distance_sq {
                    (best.piece, best.local, best.distance_sq) = (next, target, distance_sq);
                }
                best.settled = step.abs() < LAST_STEP || stays;
                break;
            }
            taken = step.clamp(-1.5, 1.5);
            (index, at) = (next, target);
        }
        best.steps = steps;
        best
    }

    /// The place reached by a local step: across smooth borders into other pieces, stopped at the others.
    #[inline(always)]
    pub(crate) fn walk(&self, mut index: usize, from: f64, step: f64) -> (usize, f64) {
        let mut to = from + step;
        for _ in 0..3 {
            if (0.0..=1.0).contains(&to) {
                break;
            }
            let end = usize::from(to > 1.0);
            let Some(other) = self.pieces[index].neighbours[end] else { break };
            let beyond = if end == 0 { -to } else { to - 1.0 };
            let scaled = beyond * self.pieces[index].interval.length() / self.pieces[other].interval.length();
            to = if end == 0 { 1.0 - scaled } else { scaled };
            index = other;
        }
        (index, to.clamp(0.0, 1.0))
    }

    /// The nearest point, and the squared distance below which the curves have none (0 when not asked for).
    #[inline(always)]
    pub(crate) fn search(
        &self,
        x: &SVector<f64, D>,
        prove: bool,
        gap: &Gap,
        scratch: &mut CurveScratch<K>,
    ) -> (CurveFoot, f64) {
        let mut best = CurveFoot::NONE;
        let mut limit_sq = gap.limit_sq(best.distance_sq);
        scratch.candidates.clear();
        scratch.ties.clear();
        scratch.rivals.clear();
        scratch.visits.clear();
        scratch.visits.push(Visit::root());
        let query: [f64; D] = (*x).into();
        while let Some(visit) = scratch.visits.pop() {
            let reach_sq = gap.reach_sq(best.distance_sq);
            if visit.distance_sq > reach_sq {
                continue;
            }
            let index = match visit.content() {
                Content::Node(node) => {
                    self.tree.expand(node, &query, reach_sq, &mut scratch.visits);
                    continue;
                }
                Content::Item(index) => index,
            };
            let piece = &self.pieces[index];
            let known = if limit_sq.is_finite() { limit_sq } else { 0.0 };
            let row = self.form(piece, &(x - piece.centre), known);
            let min = row_min(&row);
            if min >= 0.0 && known > 0.0 {
                if min <= 1e-6 * row_max(&row) && scratch.ties.len() < 16 {
                    scratch.ties.push((index, argmin(&row)));
                }
                continue;
            }
            scratch.candidates.push((index, visit.distance_sq));
            let place = argmin(&row);
            if !(index == best.piece && best.settled) && self.distance_sq(x, index, place) < best.distance_sq
            {
                let found = self.descend(x, index, place, MAX_STEPS);
                let steps = best.steps + found.steps;
                if found.distance_sq < best.distance_sq {
                    best = found;
                    limit_sq = gap.limit_sq(best.distance_sq);
                }
                best.steps = steps;
            }
            if limit_sq == 0.0 {
                // On the model, as far as the allowed gap can tell.
                self.settle(x, &mut best);
                return (best, 0.0);
            }
        }
        if !best.settled && best.piece != usize::MAX {
            // A start that needed more steps than a start is given.
            let found = self.descend(x, best.piece, best.local, MAX_STEPS);
            let steps = best.steps + found.steps;
            if found.distance_sq <= best.distance_sq {
                best = found;
            }
            best.steps = steps;
        }
        if !prove {
            self.second_seeds(x, &mut best, gap, &scratch.candidates);
            self.settle(x, &mut best);
            return (best, 0.0);
        }
        let mut bound_sq = limit_sq;
        for next in 0..scratch.candidates.len() {
            let (index, box_sq) = scratch.candidates[next];
            if box_sq < gap.limit_sq(best.distance_sq) {
                bound_sq = bound_sq.min(self.prove(x, index, &mut best, gap, scratch));
            } else if box_sq <= gap.reach_sq(best.distance_sq) && scratch.ties.len() < 16 {
                // Not nearer, but perhaps as near.
                let row = self.form(&self.pieces[index], &(x - self.pieces[index].centre), 0.0);
                scratch.ties.push((index, argmin(&row)));
            }
        }
        if bound_sq < gap.open_sq(best.distance_sq) {
            // Not proven: at least as good as without a proof.
            self.second_seeds(x, &mut best, gap, &scratch.candidates);
        }
        bound_sq = bound_sq.min(gap.limit_sq(best.distance_sq));
        self.settle(x, &mut best);
        self.polish(x, &mut best, scratch);
        (best, bound_sq.min(best.distance_sq))
    }

    /// Goes on where the steps ran out: near centres of curvature the convergence is only linear.
    #[inline(always)]
    fn settle(&self, x: &SVector<f64, D>, best: &mut CurveFoot) {
        if !best.settled && best.piece != usize::MAX {
            let found = self.descend(x, best.piece, best.local, PATIENT_STEPS);
            if found.distance_sq <= best.distance_sq {
                *best = CurveFoot { steps: best.steps + found.steps, ..found };
            }
        }
    }

    /// Shows that no point of the piece is nearer than the limit, improving `best` where one is.
    #[inline(always)]
    fn prove(
        &self,
        x: &SVector<f64, D>,
        index: usize,
        best: &mut CurveFoot,
        gap: &Gap,
        scratch: &mut CurveScratch<K>,
    ) -> f64 {
        let piece = &self.pieces[index];
        let y = x - piece.centre;
        loop {
            let limit_sq = gap.limit_sq(best.distance_sq);
            let row = self.form(piece, &y, limit_sq);
            let scale = row_max(&row).abs().max(row_min(&row).abs());
            let noise = 4.0 * f64::EPSILON * (scale + y.norm_squared() * piece.max_weight_sq);
            let tie = (best.distance_sq * (1.0 + 4.0 * gap.tie) - limit_sq) * piece.max_weight_sq;
            let mut improved = None;
            // Negative values of which nothing comes are rounding errors at the known minimum.
            let mut examine = |s: f64| {
                let found = self.descend(x, index, s, MAX_STEPS);
                if found.distance_sq < best.distance_sq * (1.0 - 1e-13) {
                    improved = Some(found);
                    return false;
                }
                true
            };
            let ties = &mut scratch.ties;
            let best_place = (best.piece, best.local);
            let proof = prove_line(
                Segment::unit(&row),
                Self::DEGREE,
                noise,
                tie,
                &mut scratch.segments,
                &mut |s, [low, high]| {
                    let known = index == best_place.0 && (low..=high).contains(&best_place.1);
                    if !known && ties.len() < 16 {
                        ties.push((index, s));
                    }
                },
                &mut examine,
            );
            if let Some(found) = improved {
                let steps = best.steps + found.steps;
                *best = CurveFoot { steps, ..found };
                continue;
            }
            return match proof {
                LineProof::Unresolved(min) => (limit_sq + min / piece.min_weight_sq).max(0.0),
                LineProof::Holds | LineProof::Below(_) => (limit_sq - noise / piece.min_weight_sq).max(0.0),
            };
        }
    }
}

/// Place of the smallest coefficient.
#[inline(always)]
fn argmin<const K: usize>(row: &Row<K>) -> f64 {
    let mut best = (f64::INFINITY, 0);
    for j in 0..WIDTH * K {
        let value = row[j / WIDTH].0[j % WIDTH];
        if value < best.0 {
            best = (value, j);
        }
    }
    best.1 as f64 / (WIDTH * K - 1) as f64
}
