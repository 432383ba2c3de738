//! Linear maps from the control points on one knot vector to those on a finer one.
//!
//! Knot insertion, trimming, clamping and degree elevation all ask for the same spline on other knots.
//! A new control point is the polar form (blossom) of a polynomial piece at the new knots inside its
//! support; evaluated in the order of the Oslo algorithm every weight is a convex one, so that
//! nothing is lost to rounding (Cohen, Lyche and Riesenfeld 1980; [PT97, sec. 5.3 and 5.5] by blossoming).

use super::periodic::Cycle;
use super::rows::ControlRows;
use crate::{Error, KnotVector, MAX_DEGREE, basis};

/// New control points as combinations of `width` consecutive old ones.
pub(crate) struct KnotMap {
    to: KnotVector,
    width: usize,
    /// Index of the first old control point of each new one; may leave the range where the weight is 0.
    first: Vec<isize>,
    weights: Vec<f64>,
    /// Old control points repeat after this many.
    modulus: Option<usize>,
}

impl KnotMap {
    /// The map to `to`, of the same degree, whose knots contain those of `from` on the domain of `to`.
    pub(crate) fn refining(from: &KnotVector, to: KnotVector) -> Result<Self, Error> {
        let p = from.degree();
        let source = Source::new(from)?;
        let mut map = Self::empty(&source, to);
        for i in 0..map.new_rows() {
            let t = map.to.as_slice();
            let row = source.polar(t[i], &t[i + 1..=i + p]);
            map.push(row);
        }
        Ok(map)
    }

    /// The map to one degree more, on `from.elevated(1)`.
    ///
    /// The polar form of the raised polynomial is the mean of those that leave out one argument
    /// ([PT97, eq. (5.36)] by blossoming).
    pub(crate) fn elevating(from: &KnotVector) -> Result<Self, Error> {
        let to = from.elevated(1)?;
        let q = to.degree();
        let source = Source::new(from)?;
        let mut map = Self::empty(&source, to);
        for i in 0..map.new_rows() {
            let t = map.to.as_slice();
            let (start, arguments) = (t[i], &t[i + 1..=i + q]);
            let mut mean = ([0.0; MAX_DEGREE + 1], 0);
            let mut rest = vec![0.0; q - 1];
            let mut left_out = 0;
            for run in arguments.chunk_by(|a, b| a == b) {
                rest[..left_out].copy_from_slice(&arguments[..left_out]);
                rest[left_out..].copy_from_slice(&arguments[left_out + 1..]);
                let (row, first) = source.polar(start, &rest);
                for (sum, value) in mean.0.iter_mut().zip(row) {
                    *sum += value * run.len() as f64;
                }
                mean.1 = first;
                left_out += run.len();
            }
            mean.0.iter_mut().for_each(|value| *value /= q as f64);
            map.push(mean);
        }
        Ok(map)
    }

    fn empty(source: &Source, to: KnotVector) -> Self {
        let width = source.degree + 1;
        Self { to, width, first: Vec::new(), weights: Vec::new(), modulus: source.modulus }
    }

    /// Rows to compute; the others of a periodic vector are repetitions.
    fn new_rows(&self) -> usize {
        self.to.distinct_count()
    }

    fn push(&mut self, (weights, first): (basis::BasisRow, isize)) {
        self.first.push(first);
        self.weights.extend_from_slice(&weights[..self.width]);
    }

    /// The rows on the new knots.
    pub(crate) fn apply(self, rows: &ControlRows) -> ControlRows {
        let w = rows.width;
        let mut data = Vec::with_capacity(self.to.basis_count() * w);
        let mut sum = vec![0.0; w];
        for (first, weights) in self.first.iter().zip(self.weights.chunks_exact(self.width)) {
            sum.fill(0.0);
            for (j, &weight) in weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                let index = first + j.cast_signed();
                let index = match self.modulus {
                    Some(m) => index.rem_euclid(m.cast_signed()).cast_unsigned(),
                    // Outside there is only rounding of a weight that is zero.
                    None if index < 0 || index.cast_unsigned() >= rows.count() => continue,
                    None => index.cast_unsigned(),
                };
                for (s, value) in sum.iter_mut().zip(rows.row(index)) {
                    *s += weight * value;
                }
            }
            data.extend_from_slice(&sum);
        }
        let repeated = (self.to.basis_count() - self.first.len()) * w;
        data.extend_from_within(..repeated);
        rows.with(self.to, data)
    }
}

/// The old vector, continued beyond its ends so that every span has neighbours; a periodic one to the
/// end of its second period.
struct Source {
    knots: KnotVector,
    degree: usize,
    /// Knots put in front.
    lead: usize,
    modulus: Option<usize>,
}

impl Source {
    fn new(from: &KnotVector) -> Result<Self, Error> {
        let p = from.degree();
        let all = from.as_slice();
        if from.is_periodic() {
            let cycle = Cycle::of(from);
            let m = cycle.values.len();
            let last = (all.len() + m + p).cast_signed();
            let mut knots: Vec<f64> = (-p.cast_signed()..last).map(|i| cycle.at(p, i)).collect();
            // Adding periods may leave copies of a knot apart by a rounding error, in the wrong order.
            for i in 1..knots.len() {
                knots[i] = knots[i].max(knots[i - 1]);
            }
            let knots = KnotVector::new(p, knots)?;
            return Ok(Self { knots, degree: p, lead: p, modulus: Some(m) });
        }
        let clamped_start = all[0] == all[p];
        let lead = if clamped_start { 0 } else { p };
        let step = from.domain().length();
        let phantom = (1..=lead).rev().map(|i| all[0] - i as f64 * step);
        let knots = KnotVector::new(p, phantom.chain(all.iter().copied()).collect())?;
        Ok(Self { knots, degree: p, lead, modulus: None })
    }

    /// Weights of the polar form at increasing `arguments` on the piece that starts at or before
    /// `start`, and the old index of the first weight.
    fn polar(&self, start: f64, arguments: &[f64]) -> (basis::BasisRow, isize) {
        let p = self.degree;
        let all = self.knots.as_slice();
        let span = (all.partition_point(|&t| t <= start).max(1) - 1).clamp(p, self.knots.basis_count() - 1);
        // Oslo order: the narrowest interval meets the argument next to the start.
        let mut reversed = [0.0; MAX_DEGREE];
        for (slot, t) in reversed.iter_mut().zip(arguments.iter().rev()) {
            *slot = *t;
        }
        let mut row = [0.0; MAX_DEGREE + 1];
        basis::polar_weights(&self.knots, span, &reversed[..p], &mut row);
        (row, span.cast_signed() - (p + self.lead).cast_signed())
    }
}
