//! Best-first search for the nearest point of a set of patches, and its certificate.

use crate::global::arithmetic::lanes::{row_max, row_min, zero_row};
use crate::global::gap::Gap;
use crate::global::proof::box_tests::argmin;
use crate::global::proof::region::Region;
use crate::global::surface::foot::Foot;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::scratch::{Candidate, Scratch};
use crate::global::tree::{Content, Visit};
use nalgebra::Vector3;

/// Limit of the local iterations that start inside a search.
const MAX_STEPS: u32 = 40;

/// Limit of the local iteration that finishes a footpoint which has not settled.
const PATIENT_STEPS: u32 = 400;

/// What a search without a proof costs at most, in units of [`max_boxes`](crate::ProjectionOptions::max_boxes), by the length of the rows.
const RESERVE: [u32; 4] = [1200, 2700, 7500, 15_000];

/// Footpoint and what is proven about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) foot: Foot,
    /// Squared distance below which the model has no point.
    pub(crate) bound_sq: f64,
}

impl<const K: usize> PatchSet<K> {
    /// The nearest point; `prove` asks for the certificate.
    #[inline(always)]
    pub(crate) fn search(&self, x: &Vector3<f64>, prove: bool, gap: &Gap, scratch: &mut Scratch<K>) -> Found {
        let mut best = Foot::NONE;
        let mut limit_sq = gap.limit_sq(best.distance_sq);
        scratch.candidates.clear();
        scratch.ties.clear();
        scratch.rivals.clear();
        scratch.boxes_left = gap.max_boxes - if prove { Self::reserve(gap.max_boxes) } else { 0 };
        scratch.visits.clear();
        scratch.visits.push(Visit::root());
        let query = [x.x, x.y, x.z];
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
            let mut candidate = Candidate {
                patch: index,
                box_sq: visit.distance_sq,
                place: best.local,
                sample_sq: best.distance_sq,
            };
            if index == best.patch && best.settled {
                scratch.candidates.push(candidate);
                continue;
            }
            let place = if prove && self.is_tiled(index) {
                self.promising_tile(x, index, reach_sq.sqrt())
            } else {
                self.promising(x, index, limit_sq, scratch)
            };
            if let Some(place) = place {
                candidate.place = place;
                candidate.sample_sq = self.distance_sq(x, index, place);
                scratch.candidates.push(candidate);
                if candidate.sample_sq < best.distance_sq {
                    self.improve(x, &candidate, &mut best);
                    limit_sq = gap.limit_sq(best.distance_sq);
                }
            }
            if limit_sq == 0.0 {
                // On the model, as far as the allowed gap can tell.
                self.settle(x, &mut best);
                return Found { foot: best, bound_sq: 0.0 };
            }
        }
        if !best.settled && best.patch != usize::MAX {
            // A start that needed more steps than a start is given.
            self.improve(
                x,
                &Candidate { patch: best.patch, place: best.local, ..Candidate::NONE },
                &mut best,
            );
        }
        if !prove {
            self.second_seeds(x, &mut best, gap, scratch);
            self.search_poles(x, &mut best, gap, scratch);
            self.settle(x, &mut best);
            return Found { foot: best, bound_sq: 0.0 };
        }
        let mut bound_sq = limit_sq;
        let mut next = 0;
        while next < scratch.candidates.len() {
            let candidate = scratch.candidates[next];
            next += 1;
            if candidate.box_sq < gap.limit_sq(best.distance_sq) {
                bound_sq = bound_sq.min(self.prove(x, candidate.patch, &mut best, gap, scratch));
            } else if candidate.box_sq <= gap.reach_sq(best.distance_sq) {
                // Not nearer, but perhaps as near.
                scratch.note_tie(candidate.patch, candidate.place);
            }
        }
        bound_sq = bound_sq.min(gap.limit_sq(best.distance_sq));
        self.settle(x, &mut best);
        self.polish(x, &mut best, scratch);
        Found { foot: best, bound_sq: bound_sq.min(best.distance_sq) }
    }

    /// Work that is kept for the search without a proof that follows an open one.
    fn reserve(max_boxes: u32) -> u32 {
        RESERVE[K.min(RESERVE.len()) - 1].min(max_boxes / 4)
    }

    /// Where a proof has not ended, the foot becomes at least as near as without a proof.
    #[inline(never)]
    pub(crate) fn improve_open(
        &self,
        x: &Vector3<f64>,
        found: &mut Found,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) {
        if found.bound_sq >= gap.open_sq(found.foot.distance_sq) {
            return;
        }
        let (ties, rivals) = (std::mem::take(&mut scratch.ties), std::mem::take(&mut scratch.rivals));
        let fast = self.search(x, false, gap, scratch).foot;
        if fast.distance_sq < found.foot.distance_sq {
            let steps = fast.steps.saturating_add(found.foot.steps);
            found.foot = Foot { steps, ..fast };
        } else {
            (scratch.ties, scratch.rivals) = (ties, rivals);
        }
    }

    /// Patches with a collapsed edge are searched as for a proof: next to a pole, where all parameter lines meet, no
    /// sample leads to the foot.
    #[inline(always)]
    fn search_poles(&self, x: &Vector3<f64>, best: &mut Foot, gap: &Gap, scratch: &mut Scratch<K>) {
        let mut next = 0;
        while next < scratch.candidates.len() {
            let candidate = scratch.candidates[next];
            next += 1;
            if self.patches[candidate.patch].pole.is_some()
                && candidate.box_sq < gap.limit_sq(best.distance_sq)
            {
                self.prove(x, candidate.patch, best, gap, scratch);
            }
        }
    }

    /// Follows the distance downhill from a candidate.
    #[inline(always)]
    pub(in crate::global) fn improve(&self, x: &Vector3<f64>, candidate: &Candidate, best: &mut Foot) {
        let found = self.descend(x, candidate.patch, candidate.place, MAX_STEPS);
        let steps = best.steps + found.steps;
        if found.distance_sq < best.distance_sq || (found.settled && found.distance_sq == best.distance_sq) {
            *best = found;
        }
        best.steps = steps;
    }

    /// Goes on where the steps ran out: near centres of curvature the convergence is only linear.
    #[inline(always)]
    fn settle(&self, x: &Vector3<f64>, best: &mut Foot) {
        if !best.settled && best.patch != usize::MAX {
            let found = self.descend(x, best.patch, best.local, PATIENT_STEPS);
            if found.distance_sq <= best.distance_sq {
                *best = Foot { steps: best.steps + found.steps, ..found };
            }
        }
    }

    /// The most likely place of a point of the patch nearer than the limit, or `None` if there cannot be one.
    #[inline(always)]
    fn promising(
        &self,
        x: &Vector3<f64>,
        index: usize,
        limit_sq: f64,
        scratch: &mut Scratch<K>,
    ) -> Option<[f64; 2]> {
        let patch = &self.patches[index];
        let m = patch.rows();
        if scratch.rows.len() < m {
            scratch.rows.resize(m, zero_row());
        }
        let y = x - patch.centre;
        let limit_sq = if limit_sq.is_finite() { limit_sq } else { 0.0 };
        let rows = &mut scratch.rows[..m];
        self.form(patch, &y, limit_sq, rows);
        let (mut low, mut high) = (rows[0], rows[0]);
        for row in &rows[1..] {
            crate::global::arithmetic::lanes::widen(&mut low, &mut high, row);
        }
        let min = row_min(&low);
        // What is above zero by less than the rounding errors is left to the proof.
        if min >= 0.0 && limit_sq > 0.0 && min >= self.noise(patch, &y, &Region::UNIT) {
            // Nearly as near as the footpoint: perhaps a second one.
            if min <= 1e-6 * row_max(&high) {
                let place = argmin(rows);
                scratch.note_tie(index, place);
            }
            return None;
        }
        Some(argmin(rows))
    }
}
