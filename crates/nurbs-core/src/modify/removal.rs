//! Knot removal within a tolerance.

use super::removal_step::{Step, Unrolled};
use super::rows::{ControlRows, along, check_tolerance};
use crate::{BsplineCurve, BsplineSurface, Direction, Error};

/// What a knot removal did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Removal {
    /// How many knots were removed.
    pub removed: usize,
    /// Bound of the distance between the shapes before and after, at equal parameters (a length).
    pub error: f64,
}

impl std::fmt::Display for Removal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} knots removed, error at most {:e}", self.removed, self.error)
    }
}

fn remove(
    mut rows: ControlRows,
    t: f64,
    times: usize,
    tolerance: f64,
) -> Result<(ControlRows, Removal), Error> {
    check_tolerance(tolerance)?;
    let domain = rows.knots.domain();
    let mut report = Removal::default();
    while report.removed < times {
        let unrolled = Unrolled::new(&rows);
        let wanted = if rows.knots.is_periodic() { domain.wrap(t) } else { t };
        let is_it = |&(i, _): &(isize, usize)| t.is_finite() && unrolled.value(i) == wanted;
        let found = unrolled.removable().into_iter().find(is_it);
        let Some((index, multiplicity)) = found else {
            if report.removed == 0 {
                return Err(Error::argument(format!(
                    "{t} is not a knot that can be removed: inner knots of [{}, {}] can, of a periodic \
                     vector all but the last one at its start",
                    domain.start(),
                    domain.end()
                )));
            }
            break;
        };
        let step = unrolled.step(index, multiplicity);
        if report.error + step.error > tolerance {
            break;
        }
        rows = unrolled.apply(&step)?;
        report.error += step.error;
        report.removed += 1;
    }
    Ok((rows, report))
}

/// Errors spent on each knot interval, and the costs of removals that are already known.
struct Ledger {
    spent: Vec<f64>,
    /// At the index of a knot: the error of its removal, where the change begins relative to it.
    known: Vec<Option<(f64, isize)>>,
}

impl Ledger {
    fn new(intervals: usize) -> Self {
        Self { spent: vec![0.0; intervals], known: vec![None; intervals] }
    }

    /// The ledger after the removal of knot `r`, whose two intervals become one.
    fn without(&self, unrolled: &Unrolled, r: isize, periodic: bool, reach: isize) -> Self {
        let intervals = self.spent.len().cast_signed();
        let mut out = Self::new(self.spent.len() - 1);
        let window = if periodic { r - intervals + 1..r + 1 } else { 0..intervals };
        for i in window {
            let moved = if i < r { i } else { i - 1 };
            let slot = if periodic { moved.rem_euclid(intervals - 1) } else { moved }.cast_unsigned();
            let old = unrolled.slot(i);
            out.spent[slot] = out.spent[slot].max(self.spent[old]);
            let far = if periodic { (r - i).min(i + intervals - r) } else { (i - r).abs() };
            if far > reach {
                out.known[slot] = self.known[old];
            }
        }
        out
    }
}

/// Removes the knot that costs least as long as the errors on no interval add up to more than the
/// tolerance ([PT97, A9.8]).
fn remove_all(mut rows: ControlRows, tolerance: f64) -> Result<(ControlRows, Removal), Error> {
    check_tolerance(tolerance)?;
    let p = rows.knots.degree().cast_signed();
    let periodic = rows.knots.is_periodic();
    let intervals = if periodic { rows.knots.distinct_count() } else { rows.knots.as_slice().len() - 1 };
    let mut ledger = Ledger::new(intervals);
    let mut removed = 0;
    loop {
        let unrolled = Unrolled::new(&rows);
        let mut best: Option<(f64, isize, usize)> = None;
        for (index, multiplicity) in unrolled.removable() {
            let slot = unrolled.slot(index);
            let (error, offset) = match ledger.known[slot] {
                Some(known) => known,
                None => {
                    let step = unrolled.step(index, multiplicity);
                    let known = (step.error, step.support[0] - index);
                    ledger.known[slot] = Some(known);
                    known
                }
            };
            let start = index + offset;
            let spent = (start..=start + p).map(|i| ledger.spent[unrolled.slot(i)]).fold(0.0, f64::max);
            if error + spent <= tolerance && best.is_none_or(|b| error < b.0) {
                best = Some((error, index, multiplicity));
            }
        }
        let Some((error, index, multiplicity)) = best else {
            return Ok((rows, Removal { removed, error: ledger.spent.into_iter().fold(0.0, f64::max) }));
        };
        let step: Step = unrolled.step(index, multiplicity);
        for i in step.support[0]..step.support[1] {
            ledger.spent[unrolled.slot(i)] += error;
        }
        ledger = ledger.without(&unrolled, index, periodic, 2 * p + 2);
        rows = unrolled.apply(&step)?;
        removed += 1;
    }
}

impl<const D: usize> BsplineCurve<D> {
    /// Removes the inner knot `t` up to `times` times, as long as the curve moves by no more than
    /// `tolerance` (a length) in all ([PT97, A5.8]).
    ///
    /// Rounding costs some 1e-15 of the size of the curve, so a tolerance of 0 removes nothing. Of a
    /// periodic curve the last knot at the seam stays.
    ///
    /// # Errors
    /// When `t` is no such knot, or the tolerance is negative or NaN.
    pub fn remove_knot(&self, t: f64, times: usize, tolerance: f64) -> Result<(Self, Removal), Error> {
        let (rows, report) = remove(ControlRows::from_curve(self), t, times, tolerance)?;
        Ok((rows.into_curve()?, report))
    }

    /// Removes as many inner knots as possible so that the curve moves by no more than `tolerance` (a
    /// length): data reduction ([PT97, A9.8]).
    ///
    /// # Errors
    /// When the tolerance is negative or NaN.
    pub fn remove_all_within(&self, tolerance: f64) -> Result<(Self, Removal), Error> {
        let (rows, report) = remove_all(ControlRows::from_curve(self), tolerance)?;
        Ok((rows.into_curve()?, report))
    }
}

impl BsplineSurface {
    /// Removes the inner knot `t` of a direction up to `times` times; see [`BsplineCurve::remove_knot`].
    ///
    /// # Errors
    /// As [`BsplineCurve::remove_knot`].
    pub fn remove_knot(
        &self,
        direction: Direction,
        t: f64,
        times: usize,
        tolerance: f64,
    ) -> Result<(Self, Removal), Error> {
        let mut report = Removal::default();
        let surface = along(self, direction, |rows| {
            let (rows, done) = remove(rows, t, times, tolerance)?;
            report = done;
            Ok(rows)
        })?;
        Ok((surface, report))
    }

    /// Removes as many inner knots of a direction as possible; see [`BsplineCurve::remove_all_within`].
    ///
    /// # Errors
    /// As [`BsplineCurve::remove_all_within`].
    pub fn remove_all_within(&self, direction: Direction, tolerance: f64) -> Result<(Self, Removal), Error> {
        let mut report = Removal::default();
        let surface = along(self, direction, |rows| {
            let (rows, done) = remove_all(rows, tolerance)?;
            report = done;
            Ok(rows)
        })?;
        Ok((surface, report))
    }
}
