//! Starts of local iterations when there is no proof: dips of the squared distance on a grid.

use super::bernstein::basis_rows;
use super::descend::Foot;
use super::gap::Gap;
use super::lanes::{Row, WIDTH, add_scaled, row_min, widen, zero_row};
use super::patch::PatchSet;
use super::piece::PieceSet;
use super::products::part_of_row;
use super::scratch::{Candidate, Scratch};
use super::search_curve::{CurveFoot, MAX_STEPS};
use nalgebra::{SVector, Vector3};

/// Pieces that are sampled for one query at most.
const MAX_SAMPLED: usize = 32;
/// Local iterations that are started from samples of one query at most.
const MAX_SEEDS: usize = 16;
/// A quadratic function falls at most an eighth of its second difference below the lowest sample; mixed terms may double it.
const SHARE: f64 = 0.25;

/// Values of the Bernstein polynomials at the places where forms are sampled.
#[derive(Clone, Debug)]
pub(crate) struct Sampling<const K: usize> {
    /// By the degree of the form in `u`, for degrees that occur: polynomial by polynomial, for each of the lines.
    across: Vec<Vec<f64>>,
    /// Row `j`: what coefficient `j` contributes to the `8 K` samples of a line.
    along: Vec<Row<K>>,
}

impl<const K: usize> Default for Sampling<K> {
    fn default() -> Self {
        let n = WIDTH * K - 1;
        let mut along = vec![zero_row::<K>(); n + 1];
        for l in 0..=n {
            let [values, ..] = basis_rows::<K>(n, l as f64 / n as f64);
            for (j, row) in along.iter_mut().enumerate() {
                row[l / WIDTH].0[l % WIDTH] = values[j / WIDTH].0[j % WIDTH];
            }
        }
        Self { across: Vec::new(), along }
    }
}

impl<const K: usize> Sampling<K> {
    /// Prepares forms of `degree` in `u`: `degree + 3` lines.
    pub(super) fn prepare(&mut self, degree: usize) {
        if self.across.len() <= degree {
            self.across.resize(degree + 1, Vec::new());
        }
        if self.across[degree].is_empty() {
            let lines = degree + 3;
            self.across[degree] = (0..lines)
                .flat_map(|i| {
                    let [values, ..] = basis_rows::<K>(degree, i as f64 / (lines - 1) as f64);
                    (0..=degree).map(move |j| values[j / WIDTH].0[j % WIDTH])
                })
                .collect();
        }
    }

    /// The samples of a form, line by line; its degree must have been prepared.
    #[inline(always)]
    fn sample(&self, rows: &[Row<K>], grid: &mut Vec<Row<K>>) {
        grid.clear();
        for shares in self.across[rows.len() - 1].chunks(rows.len()) {
            let mut line = zero_row::<K>();
            for (row, share) in rows.iter().zip(shares) {
                add_scaled(&mut line, row, *share);
            }
            grid.push(part_of_row(&line, &self.along));
        }
    }

    /// The samples of a form of one variable.
    #[inline(always)]
    fn sample_row(&self, row: &Row<K>) -> Row<K> {
        part_of_row(row, &self.along)
    }
}

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

/// A start of a local iteration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dip {
    /// Estimate of the squared distance that may be found.
    floor_sq: f64,
    patch: usize,
    place: [f64; 2],
}

impl<const K: usize> PatchSet<K> {
    /// Samples the patches that may hold a nearer point, and follows the distance from the deepest dips.
    #[inline(always)]
    pub(super) fn second_seeds(
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
    pub(super) fn second_seeds(
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
    use crate::global::lanes::Lanes;

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
