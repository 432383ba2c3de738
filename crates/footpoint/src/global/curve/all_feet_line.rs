//! All local minima of the squared distance along a curve piece or an edge of a patch.
//!
//! The squared distance is a quotient `F = A / W` of polynomials in Bernstein form (`W = 1` without weights). With
//! the level `c = F(p)` of a place `p` and `G = A − c W`, the derivative of `F` at `p` is that of `G`, divided by
//! `W`, and where it vanishes so are the second derivatives. `G` is linear in `c`: what its coefficients show at the
//! lowest and the highest level that `F` takes on an interval or box holds for all levels between.

use crate::global::arithmetic::bernstein::basis_rows;
use crate::global::arithmetic::lanes::{Lanes, Row, dot};
use crate::global::proof::line::{Segment, halve};
use crate::global::tree::Bounds;

/// Halvings after which an interval is left as it is.
const MAX_DEPTH: u32 = 48;

/// Boxes that each piece within reach adds to the budget.
const BOXES_PER_PIECE: u32 = 64;

/// Places from which the distance may grow on all sides, collected over all pieces, and what is left undecided.
#[derive(Clone, Debug)]
pub(crate) struct Harvest<F, const D: usize> {
    /// Ends of local iterations. They need not be minima, but every minimum is among them.
    pub(crate) feet: Vec<F>,
    /// Boxes on which the distance is the same as far as can be told: the end of an iteration from there, and the
    /// bounding box of the part of the shape.
    pub(crate) flats: Vec<(F, Bounds<D>)>,
    /// Whether the budget or the depth ended before everything was decided.
    pub(crate) unresolved: bool,
    pub(crate) boxes: u32,
    max_boxes: u32,
}

impl<F, const D: usize> Harvest<F, D> {
    pub(crate) fn new(max_boxes: u32) -> Self {
        Self { feet: Vec::new(), flats: Vec::new(), unresolved: false, boxes: 0, max_boxes }
    }

    /// Accounts for one more piece.
    pub(crate) fn enter_piece(&mut self) {
        self.max_boxes = self.max_boxes.saturating_add(BOXES_PER_PIECE);
    }

    /// Accounts for one more box; false when that is too many.
    pub(crate) fn enter_box(&mut self) -> bool {
        if self.boxes >= self.max_boxes || self.flats.len() >= MAX_FLATS {
            self.unresolved = true;
            return false;
        }
        self.boxes += 1;
        true
    }
}

/// Boxes of equal distance after which a search ends: the query is a centre or on an axis.
const MAX_FLATS: usize = 128;

/// Which minima are wanted, and how well coefficients can be told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Level {
    /// Squared distance from which the levels are counted.
    pub(crate) base: f64,
    /// Largest squared distance that is wanted, less `base`.
    pub(crate) limit_sq: f64,
    /// Rounding errors of the coefficients.
    pub(crate) noise: f64,
    /// Relative difference below which squared distances are the same.
    pub(crate) flat: f64,
    pub(crate) min_weight_sq: f64,
    /// Parts of the shape smaller than this are points.
    pub(crate) apart: f64,
    /// Flat parts larger than this are continua.
    pub(crate) wide: f64,
}

/// Share of the size of the model within which minima are not told apart.
pub(crate) const APART: f64 = 1e-7;

/// Share of the size of the model beyond which places of the same distance are a continuum.
const WIDE: f64 = 1e-3;

/// The levels of `F` on a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    /// Those that matter: from the lowest one up to the limit.
    pub(crate) levels: [f64; 2],
    /// Whether the distance on the box is the same up to the tolerance for ties.
    flat: bool,
    /// Whether it is the same up to rounding errors.
    same: bool,
}

impl Level {
    /// Thresholds for forms whose coefficients are at most `scale`, and come from sums of terms of that size.
    pub(crate) fn new(
        limit_sq: f64,
        base: f64,
        scale: f64,
        weight_sq: [f64; 2],
        tie: f64,
        size: f64,
    ) -> Self {
        // Levels above the largest distance do not occur.
        let limit_sq = (limit_sq - base).min(2.0 * scale / weight_sq[0]);
        let noise = 4.0 * f64::EPSILON * (scale + limit_sq.abs() * weight_sq[1]);
        Self {
            base,
            limit_sq,
            noise,
            flat: 4.0 * tie,
            min_weight_sq: weight_sq[0],
            apart: APART * size,
            wide: WIDE * size,
        }
    }

    /// The levels on a box, or `None` when all are above the limit.
    #[inline(always)]
    pub(crate) fn range(
        &self,
        squared: impl Iterator<Item = f64>,
        weight: Option<impl Iterator<Item = f64>>,
    ) -> Option<Range> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut above = f64::INFINITY;
        match weight {
            Some(weight) => {
                for (a, w) in squared.zip(weight) {
                    low = low.min(a / w);
                    high = high.max(a / w);
                    above = above.min(a - self.limit_sq * w);
                }
            }
            None => {
                for a in squared {
                    low = low.min(a);
                    high = high.max(a);
                }
                above = low - self.limit_sq;
            }
        }
        if above > self.noise {
            return None;
        }
        let error = 8.0 * self.noise / self.min_weight_sq;
        let top = (high + error).min(self.limit_sq);
        Some(Range {
            levels: [(low - error).max(-self.base).min(top), top],
            flat: high - low <= self.flat * (self.base + high) + error,
            same: high - low <= error,
        })
    }

    /// Whether a part of the shape in which the distance has this range belongs to a continuum.
    pub(crate) fn is_continuum(&self, range: &Range, extent: f64) -> bool {
        range.same || (range.flat && extent > self.wide)
    }

    /// Differences of second order hold up to four rounding errors.
    pub(crate) fn slack(&self) -> f64 {
        4.0 * self.noise
    }
}

/// What was found on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Spot {
    /// If there is a minimum in an interval around this parameter, then it is here.
    Minimum(f64),
    /// The distance stays the same between these parameters.
    Flat([f64; 2]),
    /// An interval was not decided.
    Unresolved,
}

/// The polynomials of one line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a, const K: usize> {
    pub(crate) squared: &'a Row<K>,
    pub(crate) weight: Option<&'a Row<K>>,
    pub(crate) degree: usize,
    /// Whether a minimum at the lower and upper end counts, though the distance may decrease beyond.
    pub(crate) ends: [bool; 2],
}

impl<const K: usize> Line<'_, K> {
    /// Finds all local minima up to the limit; `extent` is the size of the part of the shape over an interval.
    pub(crate) fn minima(
        &self,
        level: &Level,
        extent: &impl Fn([f64; 2]) -> f64,
        enter: &mut impl FnMut() -> bool,
    ) -> Vec<Spot> {
        let mut spots = Vec::new();
        let n = self.degree;
        let mut stack = vec![(Segment::unit(self.squared), self.weight.map(Segment::unit))];
        while let Some((squared, weight)) = stack.pop() {
            if !enter() {
                spots.push(Spot::Unresolved);
                break;
            }
            let a = &squared.coefficients.as_flattened()[..=n];
            let w = weight.as_ref().map(|w| &w.coefficients.as_flattened()[..=n]);
            let Some(range) = level.range(a.iter().copied(), w.map(|w| w.iter().copied())) else { continue };
            let (start, end) = (squared.start, squared.start + squared.length);
            let [first, second] = differences(a, w, range.levels);
            let slack = level.slack();
            let mut at_ends = |wanted: [bool; 2]| {
                if wanted[0] && start == 0.0 && self.ends[0] {
                    spots.push(Spot::Minimum(0.0));
                }
                if wanted[1] && end == 1.0 && self.ends[1] {
                    spots.push(Spot::Minimum(1.0));
                }
            };
            if first[0] > slack || first[1] < -slack {
                let rising = first[0] > slack;
                at_ends([rising, !rising]);
            } else if second[1] < -slack {
                at_ends([true; 2]);
            } else if second[0] > slack {
                let place = bisect(&squared, weight.as_ref(), n);
                spots.push(Spot::Minimum(start + place * squared.length));
            } else {
                let extent = extent([start, end]);
                if extent <= level.apart {
                    spots.push(Spot::Minimum(0.5 * (start + end)));
                } else if level.is_continuum(&range, extent) {
                    spots.push(Spot::Flat([start, end]));
                } else if squared.depth >= MAX_DEPTH {
                    spots.push(Spot::Unresolved);
                } else {
                    let (low, high) = halve(&squared, n);
                    let parts = weight.map(|w| halve(&w, n));
                    stack.push((high, parts.map(|p| p.1)));
                    stack.push((low, parts.map(|p| p.0)));
                }
            }
        }
        spots
    }
}

/// Ranges of the first and second differences of `a − c w` for all levels `c`.
fn differences(a: &[f64], w: Option<&[f64]>, levels: [f64; 2]) -> [[f64; 2]; 2] {
    let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for c in levels {
        let value = |j: usize| a[j] - w.map_or(0.0, |w| c * w[j]);
        for j in 0..a.len() - 1 {
            let first = value(j + 1) - value(j);
            ranges[0] = [ranges[0][0].min(first), ranges[0][1].max(first)];
            if j > 0 {
                let second = value(j - 1) - 2.0 * value(j) + value(j + 1);
                ranges[1] = [ranges[1][0].min(second), ranges[1][1].max(second)];
            }
        }
    }
    ranges
}

/// Where the derivative of `a / w` changes its sign, or the end at which it is lower if it does not.
fn bisect<const K: usize>(squared: &Segment<K>, weight: Option<&Segment<K>>, n: usize) -> f64 {
    let rows = |segment: &Segment<K>| segment.coefficients.map(Lanes);
    let (a, w) = (rows(squared), weight.map(rows));
    let slope = |s: f64| {
        let basis = basis_rows::<K>(n, s);
        let slope = dot(&a, &basis[1]);
        w.map_or(slope, |w| slope * dot(&w, &basis[0]) - dot(&a, &basis[0]) * dot(&w, &basis[1]))
    };
    let (mut low, mut high) = (0.0, 1.0);
    if slope(low) >= 0.0 {
        return low;
    }
    if slope(high) <= 0.0 {
        return high;
    }
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if slope(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::global::arithmetic::lanes::WIDTH;

    fn minima(a: &[f64], w: Option<&[f64]>, limit_sq: f64) -> Vec<Spot> {
        let row = |c: &[f64]| {
            let mut row = [0.0; WIDTH];
            row[..c.len()].copy_from_slice(c);
            [Lanes(row)]
        };
        let (squared, weight) = (row(a), w.map(row));
        let line = Line { squared: &squared, weight: weight.as_ref(), degree: a.len() - 1, ends: [true; 2] };
        let level = Level::new(limit_sq, 0.0, 10.0, [1.0, 1.0], 1e-9, 1.0);
        line.minima(&level, &|[a, b]| b - a, &mut || true)
    }

    #[test]
    fn minima_of_a_wave() {
        // Inner minima on both sides of a hump, none at the ends.
        let spots = minima(&[2.0, -0.9, 4.0, -0.9, 2.0], None, 9.0);
        let [Spot::Minimum(a), Spot::Minimum(b)] = spots[..] else { panic!("{spots:?}") };
        assert!((a + b - 1.0).abs() < 1e-12 && a > 0.1 && a < 0.4, "{a} {b}");
    }

    #[test]
    fn ends_and_limits() {
        // s (1 − s) has its minima at the ends.
        assert_eq!(minima(&[0.0, 0.5, 0.0], None, 1.0), [Spot::Minimum(0.0), Spot::Minimum(1.0)]);
        assert!(minima(&[2.0, 2.5, 1.0], None, 1.5).contains(&Spot::Minimum(1.0)));
        assert_eq!(minima(&[2.0, 2.5, 1.0], None, 0.5), []);
    }

    #[test]
    fn constant_quotients_are_flat() {
        let w = [1.0, 1.3, 1.0];
        let a = w.map(|w| 2.0 * w);
        assert_eq!(minima(&a, Some(&w), 4.0), [Spot::Flat([0.0, 1.0])]);
    }
}
