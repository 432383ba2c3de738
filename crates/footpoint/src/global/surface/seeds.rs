//! Starts of local iterations when there is no proof: dips of the squared distance on a grid.

use crate::global::arithmetic::lanes::{Row, WIDTH, row_min, widen, zero_row};
use crate::global::curve::piece::PieceSet;
use crate::global::curve::scratch::CurveFoot;
use crate::global::curve::search::MAX_STEPS;
use crate::global::gap::Gap;
use crate::global::surface::foot::Foot;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::sampling::Dip;
use crate::global::surface::scratch::{Candidate, Scratch};
use nalgebra::{SVector, Vector3};

/// Pieces that are sampled for one query at most.
const MAX_SAMPLED: usize = 32;
/// Local iterations that are started from samples of one query at most.
const MAX_SEEDS: usize = 16;
/// A quadratic function falls at most an eighth of its second difference below the lowest sample; mixed terms may double it.
const SHARE: f64 = 0.25;

/// Sample `l` of a line; beyond its ends the samples are mirrored.
#[inline(always)]
fn mirrored<const K: usize>(line: &Row<K>, l: isize) -> f64 {
    let last = (WIDTH * K - 1).cast_signed();
    let l = if l < 0 {
        1
    } else if l > last {
        last - 1
    } else {
        l
    }
    .unsigned_abs();
    line[l / WIDTH].0[l % WIDTH]
}

impl<const K: usize> PatchSet<K> {
    /// Samples the patches that may hold a nearer point, and follows the distance from the deepest dips.
    #[inline(always)]
    pub(in crate::global) fn second_seeds(
        &self,
        x: &Vector3<f64>,
        best: &mut Foot,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) {
        let limit_sq = gap.limit_sq(best.distance_sq);
        let mut sampled = 0;
        scratch.dips.clear();
        for next in 0..scratch.candidates.len() {
            let Candidate { patch: index, box_sq, .. } = scratch.candidates[next];
            if box_sq >= limit_sq || sampled >= MAX_SAMPLED {
                continue;
            }
            let patch = &self.patches[index];
            let m = patch.rows();
            if scratch.rows.len() < m {
                scratch.rows.resize(m, zero_row());
            }
            let rows = &mut scratch.rows[..m];
            self.form(patch, &(x - patch.centre), limit_sq, rows);
            let (mut low, mut high) = (rows[0], rows[0]);
            for row in &rows[1..] {
                widen(&mut low, &mut high, row);
            }
            if row_min(&low) >= 0.0 {
                continue;
            }
            sampled += 1;
            self.sampling.sample(rows, &mut scratch.grid);
            let dips = &mut scratch.dips;
            note_dips(&scratch.grid, |place, floor| {
                let floor_sq = limit_sq + floor / patch.min_weight_sq;
                dips.push(Dip { floor_sq, patch: index, place });
            });
        }
        // Equal ones stay in the order in which they were found.
        scratch.dips.sort_by(|a, b| a.floor_sq.total_cmp(&b.floor_sq));
        let mut seeds = 0;
        for dip in &scratch.dips {
            let reach = [2 * self.patches[dip.patch].degrees()[0] + 2, WIDTH * K - 1].map(|n| 0.6 / n as f64);
            let known = best.settled
                && best.patch == dip.patch
                && (0..2).all(|d| (best.local[d] - dip.place[d]).abs() <= reach[d]);
            if !known && dip.floor_sq < best.distance_sq && seeds < MAX_SEEDS {
                seeds += 1;
                self.improve(x, &Candidate { patch: dip.patch, place: dip.place, ..Candidate::NONE }, best);
            }
        }
    }
}

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// Samples the pieces that may hold a nearer point, and follows the distance from every dip that may lead there.
    #[inline(always)]
    pub(in crate::global) fn second_seeds(
        &self,
        x: &SVector<f64, D>,
        best: &mut CurveFoot,
        gap: &Gap,
        candidates: &[(usize, f64)],
    ) {
        let (mut sampled, mut seeds) = (0, 0);
        for &(index, box_sq) in candidates {
            let limit_sq = gap.limit_sq(best.distance_sq);
            if box_sq >= limit_sq || sampled >= MAX_SAMPLED {
                continue;
            }
            let piece = &self.pieces[index];
            let row = self.form(piece, &(x - piece.centre), limit_sq);
            if row_min(&row) >= 0.0 {
                continue;
            }
            sampled += 1;
            let line = self.sampling.sample_row(&row);
            let last = WIDTH * K - 1;
            for l in 0..=last {
                let [left, value, right] = [-1, 0, 1].map(|k| mirrored(&line, l.cast_signed() + k));
                let dip = value <= left && value <= right && value < SHARE * (left + right - 2.0 * value);
                let place = l as f64 / last as f64;
                let known =
                    best.settled && best.piece == index && (best.local - place).abs() <= 1.0 / last as f64;
                if dip && !known && seeds < MAX_SEEDS {
                    seeds += 1;
                    let found = self.descend(x, index, place, MAX_STEPS);
                    let steps = best.steps + found.steps;
                    if found.distance_sq < best.distance_sq {
                        *best = found;
                    }
                    best.steps = steps;
                }
            }
        }
    }
}

/// Tells of samples that are not above their neighbours, and below which there may be zeros: the place where a parabola
/// through the neighbours has its bottom, and how deep the form may be there.
#[inline(always)]
fn note_dips<const K: usize>(grid: &[Row<K>], mut note: impl FnMut([f64; 2], f64)) {
    let last = grid.len() - 1;
    for (i, line) in grid.iter().enumerate() {
        let below = &grid[if i == 0 { 1 } else { i - 1 }];
        let above = &grid[if i == last { last - 1 } else { i + 1 }];
        for l in 0..WIDTH * K {
            let at = |row: &Row<K>| row[l / WIDTH].0[l % WIDTH];
            let (value, down, up) = (at(line), at(below), at(above));
            if value > down || value > up {
                continue;
            }
            let [left, right] = [-1, 1].map(|k| mirrored(line, l.cast_signed() + k));
            let bends = [down + up - 2.0 * value, left + right - 2.0 * value];
            let floor = value - SHARE * (bends[0] + bends[1]);
            if value <= left && value <= right && floor < 0.0 {
                let place =
                    [bottom(i, last, down - up, bends[0]), bottom(l, WIDTH * K - 1, left - right, bends[1])];
                note(place, floor);
            }
        }
    }
}

/// Where, between 0 and 1, a parabola has its bottom around sample `i` of `0..=last`; a little inside at the ends.
#[inline(always)]
fn bottom(i: usize, last: usize, fall: f64, bend: f64) -> f64 {
    let offset = if i == 0 {
        0.25
    } else if i == last {
        -0.25
    } else if bend > 0.0 {
        (0.5 * fall / bend).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    (i as f64 + offset) / last as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::global::arithmetic::lanes::Lanes;
    use crate::global::surface::sampling::Sampling;

    #[test]
    fn samples_are_values() {
        let mut sampling = Sampling::<1>::default();
        sampling.prepare(2);
        // s² t in degrees 2 and 7: coefficients (0, 0, 1) and j / 7.
        let t = [Lanes(std::array::from_fn(|j| j as f64 / 7.0))];
        let rows = [zero_row::<1>(), zero_row::<1>(), t];
        let mut grid = Vec::new();
        sampling.sample(&rows, &mut grid);
        assert_eq!(grid.len(), 5);
        for (i, line) in grid.iter().enumerate() {
            for l in 0..WIDTH {
                let s = i as f64 / 4.0;
                assert!((line[0].0[l] - s * s * l as f64 / 7.0).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn every_dip_is_found() {
        // Two valleys, at (1, 2) and at the border (3, 7), and a third one that is too high.
        let mut grid = vec![[Lanes([10.0; WIDTH])]; 5];
        grid[1][0].0[2] = -1.0;
        grid[3][0].0[7] = 4.0;
        grid[3][0].0[4] = 9.9;
        let mut places = Vec::new();
        note_dips(&grid, |place, floor| places.push((place, floor)));
        assert_eq!(places.len(), 2, "{places:?}");
        assert_eq!(places[0], ([0.25, 2.0 / 7.0], -1.0 - SHARE * 44.0));
        assert_eq!(places[1], ([0.75, 6.75 / 7.0], 4.0 - SHARE * 24.0));
    }
}
