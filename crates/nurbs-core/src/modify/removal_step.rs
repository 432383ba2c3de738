//! Removal of one copy of a knot, with a bound of what it changes.

use super::periodic::Cycle;
use super::rows::ControlRows;
use crate::{Error, KnotVector};

/// Access to knots and rows by any index, wrapped when periodic.
pub(super) struct Unrolled<'a> {
    rows: &'a ControlRows,
    cycle: Option<Cycle>,
}

/// What the removal of a knot would do.
pub(super) struct Step {
    /// Index of the knot removed, the last of its copies.
    index: isize,
    multiplicity: usize,
    /// The rows `index − p … index − multiplicity − 1` after the removal.
    solved: Vec<f64>,
    /// First and last knot of the interval where the shape changes.
    pub(super) support: [isize; 2],
    /// Bound of the distance between the shapes before and after, at equal parameters.
    pub(super) error: f64,
}

impl<'a> Unrolled<'a> {
    pub(super) fn new(rows: &'a ControlRows) -> Self {
        Self { rows, cycle: rows.knots.is_periodic().then(|| Cycle::of(&rows.knots)) }
    }

    /// Number of rows that are not repetitions.
    pub(super) fn distinct(&self) -> usize {
        self.rows.knots.distinct_count()
    }

    /// Index of row, or of knot interval, `i` among those that are not repetitions.
    pub(super) fn slot(&self, i: isize) -> usize {
        match self.cycle {
            Some(_) => i.rem_euclid(self.distinct().cast_signed()).cast_unsigned(),
            None => i.cast_unsigned(),
        }
    }

    fn knot(&self, i: isize) -> f64 {
        match &self.cycle {
            Some(cycle) => cycle.at(self.rows.knots.degree(), i),
            None => self.rows.knots.as_slice()[i.cast_unsigned()],
        }
    }

    /// The knot `index` of [`removable`](Self::removable), brought into the domain.
    pub(super) fn value(&self, index: isize) -> f64 {
        let t = self.knot(index);
        if self.cycle.is_some() { self.rows.knots.domain().wrap(t) } else { t }
    }

    fn row(&self, i: isize) -> &[f64] {
        self.rows.row(self.slot(i))
    }

    /// Index of the last copy and multiplicity of every knot that may go, in order.
    ///
    /// The knot that carries the seam of a periodic vector stays when it is the only copy.
    pub(super) fn removable(&self) -> Vec<(isize, usize)> {
        let p = self.rows.knots.degree();
        match &self.cycle {
            None => {
                let domain = self.rows.knots.domain();
                let mut end = self.rows.knots.as_slice().partition_point(|&t| t <= domain.start());
                let inner = self.rows.knots.distinct_knots().into_iter();
                inner
                    .filter(|m| m.0 > domain.start() && m.0 < domain.end())
                    .map(|(_, m)| {
                        end += m;
                        (end.cast_signed() - 1, m)
                    })
                    .collect()
            }
            Some(cycle) => {
                let m = cycle.values.len();
                if m <= p {
                    return Vec::new();
                }
                let mut end = p.cast_signed() - cycle.seam.cast_signed();
                let mut out = Vec::new();
                for (k, (_, count)) in cycle.multiplicities().into_iter().enumerate() {
                    end += count.cast_signed();
                    if k == 0 && count == 1 {
                        continue;
                    }
                    // The last copy at the start is knot p: take the one a period later.
                    let index = if end - 1 == p.cast_signed() { end - 1 + m.cast_signed() } else { end - 1 };
                    out.push((index, count));
                }
                out
            }
        }
    }

    /// Solves for the rows without the knot `index` of the given multiplicity.
    ///
    /// Inserting the knot again gives `p − s + 1` equations for `p − s` rows ([PT97, eq. (5.28)]). They
    /// are solved from both sides; the one equation where the sides meet is violated by a residual,
    /// and the shape changes by that residual times one basis function. The meeting place is chosen
    /// where the residual is least.
    pub(super) fn step(&self, index: isize, multiplicity: usize) -> Step {
        let (p, s) = (self.rows.knots.degree().cast_signed(), multiplicity.cast_signed());
        let w = self.rows.width;
        let u = self.knot(index);
        let (first, last) = (index - p, index - s);
        let alpha = |i: isize| {
            let (left, right) = (self.knot(i), self.knot(i + p + 1));
            (u - left) / (right - left)
        };
        let count = (last - first).cast_unsigned();
        // From the left: rows first − 1 (given), first … last − 1.
        let mut left = self.row(first - 1).to_vec();
        for i in first..last {
            let a = alpha(i);
            let start = left.len() - w;
            for (c, d) in self.row(i).iter().enumerate() {
                left.push((d - (1.0 - a) * left[start + c]) / a);
            }
        }
        // From the right: rows first … last − 1, last (given), stored in this order.
        let mut right = vec![0.0; (count + 1) * w];
        right[count * w..].copy_from_slice(self.row(last + 1));
        for i in (first + 1..=last).rev() {
            let a = alpha(i);
            let at = (i - first).cast_unsigned() * w;
            for (c, d) in self.row(i).iter().enumerate() {
                right[at - w + c] = (d - a * right[at + c]) / (1.0 - a);
            }
        }
        let mut best: Option<(usize, f64)> = None;
        let (centre, radius) = self.bounds(self.around(first, last));
        for k in 0..=count {
            let i = first + k.cast_signed();
            let a = alpha(i);
            let residual: Vec<f64> = self
                .row(i)
                .iter()
                .enumerate()
                .map(|(c, d)| d - a * right[k * w + c] - (1.0 - a) * left[k * w + c])
                .collect();
            let error = deviation(self.rows, &residual, &centre, radius);
            if best.is_none_or(|(_, least)| error < least) {
                best = Some((k, error));
            }
        }
        let (k, error) = best.unwrap_or((0, f64::INFINITY));
        let mut solved = left[w..(k + 1) * w].to_vec();
        solved.extend_from_slice(&right[k * w..count * w]);
        let at = first + k.cast_signed();
        let error = if self.rows.rational {
            let d = self.rows.point - 1;
            let weights = |data: &[f64]| data.chunks_exact(d + 1).map(|h| h[d]).fold(f64::INFINITY, f64::min);
            // Distances are numerators over the weight function after the removal.
            let near = self.around(first, last).map(|i| weights(self.row(i)));
            let least = near.fold(weights(&solved), f64::min);
            if least > 0.0 { error / least } else { f64::INFINITY }
        } else {
            error
        };
        Step { index, multiplicity, solved, support: [at, at + p + 1], error }
    }

    /// The rows that the functions `first … last` share a span with.
    fn around(&self, first: isize, last: isize) -> impl Iterator<Item = isize> + use<> {
        let (p, count) = (self.rows.knots.degree().cast_signed(), self.rows.count().cast_signed());
        let periodic = self.cycle.is_some();
        (first - p..=last + p).filter(move |i| periodic || (0..count).contains(i))
    }

    fn bounds(&self, rows: impl Iterator<Item = isize>) -> (Vec<f64>, f64) {
        if !self.rows.rational {
            return (Vec::new(), 0.0);
        }
        self.rows.bounds(rows.map(|i| self.slot(i)))
    }

    /// The rows without the knot.
    pub(super) fn apply(&self, step: &Step) -> Result<ControlRows, Error> {
        let p = self.rows.knots.degree();
        let (first, last) = (step.index - p.cast_signed(), step.index - step.multiplicity.cast_signed());
        let w = self.rows.width;
        let new_row = |i: isize| {
            if i < first {
                self.row(i)
            } else if i < last {
                let at = (i - first).cast_unsigned() * w;
                &step.solved[at..at + w]
            } else {
                self.row(i + 1)
            }
        };
        let mut data = Vec::with_capacity(self.rows.data.len());
        let Some(cycle) = &self.cycle else {
            (0..self.rows.count().cast_signed() - 1).for_each(|i| data.extend_from_slice(new_row(i)));
            let mut knots = self.rows.knots.as_slice().to_vec();
            knots.remove(step.index.cast_unsigned());
            return Ok(self.rows.with(KnotVector::new(p, knots)?, data));
        };
        let m = cycle.values.len().cast_signed();
        data.resize((self.rows.count() - 1) * w, 0.0);
        for i in first - 1..first + m - 2 {
            let at = i.rem_euclid(m - 1).cast_unsigned() * w;
            data[at..at + w].copy_from_slice(new_row(i));
        }
        let (head, tail) = data.split_at_mut((m - 1).cast_unsigned() * w);
        tail.copy_from_slice(&head[..p * w]);
        let u = self.knot(step.index);
        let domain = cycle.domain;
        let mut values = cycle.values.clone();
        if let Some(gone) = values.iter().position(|&t| t == domain.wrap(u)) {
            values.remove(gone);
        }
        let at_seam = u == domain.start() || u == domain.end();
        let below = step.index >= p.cast_signed() + m;
        let seam = if at_seam && below { cycle.seam - 1 } else { cycle.seam };
        let knots = Cycle { values, seam, domain }.vector(p)?;
        Ok(self.rows.with(knots, data))
    }
}

/// Largest length, over the points of a row, of the numerator that a change `delta` of homogeneous
/// coordinates leaves: `|δ_wp − c δ_w|` for every point `c` of the ball around the shape.
pub(super) fn deviation(rows: &ControlRows, delta: &[f64], centre: &[f64], radius: f64) -> f64 {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let points = delta.chunks_exact(rows.point);
    points
        .map(|h| {
            if rows.rational {
                let (w, x) = (h[rows.point - 1], &h[..rows.point - 1]);
                norm(&mut x.iter().zip(centre).map(|(x, c)| x - c * w)) + radius * w.abs()
            } else {
                norm(&mut h.iter().copied())
            }
        })
        .fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { f64::max(a, b) })
}
