//! Lower bounds on whole patches: the proof that no point is nearer than the footpoint.
//!
//! On a patch the polynomial `G = w² (|S − x|² − limit²)` must be shown to be nonnegative. Each box of the
//! parameter domain is dropped as soon as one of these holds, and is halved otherwise:
//! - all Bernstein coefficients are nonnegative;
//! - `G` is monotone in one parameter: its minimum lies on an edge (shared with another box, or a polynomial of
//!   one variable on the border of the patch);
//! - `G` is strictly convex: its only minimum is found by Newton's method;
//! - the polynomials of one parameter that `G` consists of are strictly convex, and so are their minima (see
//!   [`valley`](crate::global::proof::valley)).
//!
//! Where the footpoint is close, or next to a pole, boxes are not cut in the middle but around it.

use crate::global::arithmetic::lanes::{Row, WIDTH, row_min, widen, zero_row};
use crate::global::arithmetic::simd::vectorized;
use crate::global::gap::Gap;
use crate::global::proof::box_tests::{Bends, argmin, bends, edge, evaluate, sag_direction};
use crate::global::proof::line::{LineProof, Segment, prove_line};
use crate::global::proof::region::Region;
use crate::global::proof::valley::{is_promising_u, is_promising_v, transpose, valley};
use crate::global::surface::foot::Foot;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::scratch::Scratch;
use nalgebra::Vector3;

/// Halvings, in both directions together, after which a box is left as it is.
const MAX_DEPTH: u32 = 80;

/// Boxes that are examined in this way before the rest is left to the control nets (see [`hulls`](crate::global::proof::hulls)), by the length of the
/// rows.
const QUICK: [u32; 3] = [32, 24, 1];

/// What each of them costs, in units of [`max_boxes`](crate::ProjectionOptions::max_boxes).
const COST: [u32; 4] = [16, 40, 80, 150];

/// Improvement of the squared distance below which a place counts as the same minimum.
pub(in crate::global) const IMPROVEMENT: f64 = 1e-13;

/// Rounding errors, as a share of the allowed gap, that do not matter.
const HARMLESS: f64 = 0.25;

/// What one box of a patch says.
pub(in crate::global) enum Verdict {
    Dropped,
    /// `G` is negative at this place of the box.
    Below([f64; 2]),
    /// To be halved in this direction.
    Undecided(usize, f64),
}

/// Thresholds of one query on one box.
pub(in crate::global) struct Levels {
    /// Size of the rounding errors.
    pub(in crate::global) noise: f64,
    /// What coefficients must reach for the box to be dropped: `−noise`, but `+noise` where so close to the model
    /// that the rounding errors of the whole patch would hide the answer.
    pub(in crate::global) floor: f64,
    /// Values up to this may be ties.
    pub(in crate::global) tie: f64,
}

impl<const K: usize> PatchSet<K> {
    /// Shows that no point of the patch is nearer than the limit that `gap` sets for `best`, improving `best` where
    /// one is.
    ///
    /// Returns the largest squared distance for which this was shown.
    pub(crate) fn prove(
        &self,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) -> f64 {
        vectorized(
            #[inline(always)]
            || self.prove_inline(x, index, best, gap, scratch),
        )
    }

    #[inline(always)]
    fn prove_inline(
        &self,
        x: &Vector3<f64>,
        index: usize,
        best: &mut Foot,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) -> f64 {
        let patch = &self.patches[index];
        let y = x - patch.centre;
        let m = patch.rows();
        if self.is_tiled(index) {
            let limit_sq = gap.limit_sq(best.distance_sq);
            let floor = self.prove_divided(x, index, best, gap, scratch);
            return limit_sq.min(floor * floor);
        }
        let mut boxes = 0u32;
        let quick = QUICK[K.min(QUICK.len()) - 1];
        let cost = COST[K.min(COST.len()) - 1];
        'restart: loop {
            let limit_sq = gap.limit_sq(best.distance_sq);
            scratch.regions.clear();
            scratch.rows.resize(m, zero_row());
            self.form(patch, &y, limit_sq, &mut scratch.rows[..m]);
            let noise = self.noise(patch, &y, &Region::UNIT);
            scratch.regions.push(Region { noise, ..Region::UNIT });
            let tie = (best.distance_sq * (1.0 + 4.0 * gap.tie) - limit_sq) * patch.max_weight_sq;
            // Rounding errors up to this do not matter.
            let harmless = HARMLESS * (best.distance_sq - limit_sq) * patch.min_weight_sq;
            let way = self.way_from_pole(patch, &y, best);
            let mut unresolved = 0.0f64;
            while let Some(region) = scratch.regions.pop() {
                if boxes >= quick || scratch.boxes_left < cost {
                    scratch.regions.push(region);
                    break;
                }
                boxes += 1;
                scratch.boxes_left -= cost;
                let first = scratch.regions.len() * m;
                let mut rows = std::mem::take(&mut scratch.current);
                rows.clear();
                rows.extend_from_slice(&scratch.rows[first..first + m]);
                let noise = region.noise;
                let close = noise > harmless;
                if !close {
                    unresolved = unresolved.min(-noise);
                }
                let levels = Levels { noise, floor: if close { noise } else { -noise }, tie };
                let focus = (best.patch == index).then_some(best.local);
                match self.judge(&rows, &region, focus, &levels, index, scratch) {
                    Verdict::Dropped => {}
                    Verdict::Below(place) => {
                        let found = self.descend(x, index, place, 30);
                        best.steps += found.steps;
                        if found.distance_sq < best.distance_sq * (1.0 - IMPROVEMENT) {
                            *best = Foot { steps: best.steps, ..found };
                            scratch.current = rows;
                            continue 'restart;
                        }
                        // A minimum that is not lower than the known one but for rounding.
                    }
                    Verdict::Undecided(_, min) if region.depth >= MAX_DEPTH => {
                        unresolved = unresolved.min(min);
                    }
                    Verdict::Undecided(direction, _) => {
                        if close && region.depth == 0 {
                            // Before the fine arithmetic: is there something nearer where the form is lowest?
                            let found = self.descend(x, index, region.place(argmin(&rows)), 30);
                            best.steps += found.steps;
                            if found.distance_sq < best.distance_sq * (1.0 - IMPROVEMENT) {
                                *best = Foot { steps: best.steps, ..found };
                                scratch.current = rows;
                                continue 'restart;
                            }
                        }
                        let (direction, at) = match self.cut_at_pole(patch, &region, way) {
                            Some(cut) => cut,
                            None if close && best.patch == index => {
                                (direction, self.cut_close(&region, direction, best, patch))
                            }
                            None => (direction, 0.5),
                        };
                        scratch.rows.resize(first + 2 * m, zero_row());
                        let both = &mut scratch.rows[first..];
                        self.split_rows(&rows, direction, at, &mut scratch.splitting, both);
                        for (part, rows) in region.split(direction, at).into_iter().zip(both.chunks_mut(m)) {
                            let mut noise = self.noise(patch, &y, &part).min(noise);
                            if noise > harmless {
                                noise = self.fine_form(patch, &y, &part, limit_sq, &mut scratch.net, rows);
                            }
                            scratch.regions.push(Region { noise, ..part });
                        }
                    }
                }
                scratch.current = rows;
            }
            let shown_sq = (limit_sq + unresolved / patch.min_weight_sq).max(0.0);
            if scratch.regions.is_empty() {
                return shown_sq;
            }
            let floor = self.prove_by_hulls(x, index, best, gap, scratch);
            return shown_sq.min(floor * floor);
        }
    }

    #[inline(always)]
    pub(in crate::global) fn judge(
        &self,
        rows: &[Row<K>],
        region: &Region,
        focus: Option<[f64; 2]>,
        levels: &Levels,
        index: usize,
        scratch: &mut Scratch<K>,
    ) -> Verdict {
        let (mut low, mut high) = (rows[0], rows[0]);
        for row in &rows[1..] {
            widen(&mut low, &mut high, row);
        }
        let min = row_min(&low);
        if min >= levels.floor {
            if min <= levels.tie {
                scratch.note_tie(index, region.place(argmin(rows)));
            }
            return Verdict::Dropped;
        }
        let bends = bends(rows);
        if let Some(verdict) = self.monotone(rows, region, &bends, levels, index, scratch) {
            return verdict;
        }
        let m = rows.len() as f64 - 1.0;
        let n = Self::DEGREE as f64;
        // Differences of second order hold up to four rounding errors.
        let slack = 4.0 * levels.noise;
        let a = m * (m - 1.0) * (bends.duu[0] - slack);
        let b = n * (n - 1.0) * (bends.dvv[0] - slack);
        let c = m * n * (bends.duv[1].abs().max(bends.duv[0].abs()) + slack);
        let inside = focus.map(|f| region.local(f));
        if a > 0.0 && b > 0.0 && a * b > c * c {
            let strength = 0.5 * (a + b) - (0.25 * (a - b) * (a - b) + c * c).sqrt();
            let start = inside.unwrap_or_else(|| argmin(rows));
            return self.minimize(rows, region, start, strength, levels, index, scratch);
        }
        let [s, t] = inside.unwrap_or_else(|| argmin(rows));
        if a > 0.0
            && is_promising_u(rows, min)
            && let Some(found) = valley(rows, WIDTH * K, s, slack)
            && found.bound >= levels.floor
        {
            return self.drop_valley(
                region,
                found.bound,
                [[found.ends[0], 0.0], [found.ends[1], 1.0]],
                levels,
                index,
                scratch,
            );
        }
        if b > 0.0 && is_promising_v(rows, min) {
            transpose(rows, &mut scratch.transposed);
            if let Some(found) = valley(&scratch.transposed, rows.len(), t, slack)
                && found.bound >= levels.floor
            {
                return self.drop_valley(
                    region,
                    found.bound,
                    [[0.0, found.ends[0]], [1.0, found.ends[1]]],
                    levels,
                    index,
                    scratch,
                );
            }
        }
        Verdict::Undecided(sag_direction(rows), min)
    }

    /// A box whose valley, from one place to another, is high enough.
    #[inline(always)]
    fn drop_valley(
        &self,
        region: &Region,
        bound: f64,
        ends: [[f64; 2]; 2],
        levels: &Levels,
        index: usize,
        scratch: &mut Scratch<K>,
    ) -> Verdict {
        if bound <= levels.tie {
            for end in ends {
                scratch.note_tie(index, region.place(end));
            }
        }
        Verdict::Dropped
    }

    /// Boxes on which `G` is monotone in a parameter.
    #[inline(always)]
    fn monotone(
        &self,
        rows: &[Row<K>],
        region: &Region,
        bends: &Bends,
        levels: &Levels,
        index: usize,
        scratch: &mut Scratch<K>,
    ) -> Option<Verdict> {
        for (d, range) in [bends.du, bends.dv].into_iter().enumerate() {
            // Flat but for rounding errors, as next to a collapsed edge: one line stands for all.
            let flat = range[0] >= -levels.noise && range[1] <= levels.noise;
            // Strictly monotone towards another box of the same patch: that one holds the common edge too.
            if (range[0] > levels.noise && !region.at_border(d, 0))
                || (range[1] < -levels.noise && !region.at_border(d, 1))
            {
                return Some(Verdict::Dropped);
            }
            // Monotone towards the border of the patch: what happens there decides.
            let rising = flat || (range[0] >= levels.floor && region.at_border(d, 0));
            let falling = range[1] <= -levels.floor && region.at_border(d, 1);
            if !rising && !falling {
                continue;
            }
            let end = usize::from(!rising);
            let (edge, n) = edge(rows, d, end);
            let place = |s: f64| {
                let mut at = [s; 2];
                at[d] = end as f64;
                region.place(at)
            };
            // The minimum on the edge may be missed by what a slope of the size of the noise adds up to.
            let noise = if levels.floor < 0.0 { levels.noise * 2.0 * (WIDTH * K) as f64 } else { 0.0 };
            let mut ties = [None; 4];
            let mut count = 0;
            let mut note = |s: f64, _: [f64; 2]| {
                if count < ties.len() {
                    ties[count] = Some(s);
                    count += 1;
                }
            };
            let mut stack = std::mem::take(&mut scratch.segments);
            let proof =
                prove_line(Segment::unit(&edge), n, noise, levels.tie, &mut stack, &mut note, &mut |_| false);
            scratch.segments = stack;
            for s in ties.into_iter().flatten() {
                scratch.note_tie(index, place(s));
            }
            return Some(match proof {
                LineProof::Holds => Verdict::Dropped,
                LineProof::Below(s) => Verdict::Below(place(s)),
                LineProof::Unresolved(min) => Verdict::Undecided(1 - d, min),
            });
        }
        None
    }

    /// Minimum of a strictly convex box.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the box, its thresholds and where to start")]
    fn minimize(
        &self,
        rows: &[Row<K>],
        region: &Region,
        start: [f64; 2],
        strength: f64,
        levels: &Levels,
        index: usize,
        scratch: &mut Scratch<K>,
    ) -> Verdict {
        let mut at = start;
        for _ in 0..30 {
            let (value, mut g, h) = evaluate(rows, at);
            if value < -levels.noise {
                return Verdict::Below(region.place(at));
            }
            let mut free = [true; 2];
            for d in 0..2 {
                free[d] = !((at[d] <= 0.0 && g[d] > 0.0) || (at[d] >= 1.0 && g[d] < 0.0));
                if !free[d] {
                    g[d] = 0.0;
                }
            }
            let slope_sq = g[0] * g[0] + g[1] * g[1];
            let settled = value - 0.5 * slope_sq / strength >= -levels.noise;
            // Where the minimum may be a tie it is wanted exactly.
            if settled && value > 4.0 * levels.tie {
                return Verdict::Dropped;
            }
            let det = h[0] * h[2] - h[1] * h[1];
            let step = match free {
                [true, true] => [(h[1] * g[1] - h[2] * g[0]) / det, (h[1] * g[0] - h[0] * g[1]) / det],
                [true, false] => [-g[0] / h[0], 0.0],
                [false, true] => [0.0, -g[1] / h[2]],
                [false, false] => [0.0; 2],
            };
            let next = [0, 1].map(|d| (at[d] + step[d]).clamp(0.0, 1.0));
            let moved = (next[0] - at[0]).abs().max((next[1] - at[1]).abs());
            if moved < 1e-9 && settled {
                if value <= levels.tie {
                    scratch.note_tie(index, region.place(at));
                }
                return Verdict::Dropped;
            }
            if moved == 0.0 {
                return Verdict::Dropped;
            }
            at = next;
        }
        // Newton's method with bounds may cycle between them; smaller boxes will not.
        Verdict::Undecided(sag_direction(rows), -0.0)
    }
}
