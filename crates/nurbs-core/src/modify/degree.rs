//! Degree elevation and reduction.

use super::knot_map::KnotMap;
use super::refine::on_knots;
use super::rows::{ControlRows, along, check_tolerance};
use crate::fit::project;
use crate::{BsplineCurve, BsplineSurface, Direction, Error, KnotVector, MAX_DEGREE};

pub(super) fn elevate(rows: &ControlRows, by: usize) -> Result<ControlRows, Error> {
    let degree = rows.knots.degree().saturating_add(by);
    if degree > MAX_DEGREE {
        return Err(Error::Degree { degree });
    }
    let mut rows = rows.clone();
    for _ in 0..by {
        rows = KnotMap::elevating(&rows.knots)?.apply(&rows);
    }
    Ok(rows)
}

/// The knots on which the reduced shape lives: multiplicities lowered by `by`, at least 1.
fn reduced_knots(knots: &KnotVector, by: usize) -> Result<KnotVector, Error> {
    let p = knots.degree();
    let Some(q) = p.checked_sub(by).filter(|&q| q > 0) else {
        return Err(Error::argument(format!("degree {p} cannot be reduced by {by}: at least 1 must remain")));
    };
    let lower = |(t, m): (f64, usize)| std::iter::repeat_n(t, m.saturating_sub(by).max(1));
    if knots.is_periodic() {
        let mut cycle = super::periodic::Cycle::of(knots);
        let multiplicities = cycle.multiplicities();
        cycle.values = multiplicities.iter().copied().flat_map(lower).collect();
        let at_seam = multiplicities[0].1.saturating_sub(by).max(1);
        cycle.seam = cycle.seam.min(at_seam - 1);
        return cycle.vector(q);
    }
    let domain = knots.domain();
    let inner = knots.distinct_knots().into_iter().filter(|m| m.0 > domain.start() && m.0 < domain.end());
    let ends = |t| std::iter::repeat_n(t, q + 1);
    KnotVector::new(q, ends(domain.start()).chain(inner.flat_map(lower)).chain(ends(domain.end())).collect())
}

fn reduce(rows: &ControlRows, by: usize, tolerance: f64) -> Result<(ControlRows, f64), Error> {
    check_tolerance(tolerance)?;
    if by == 0 {
        return Ok((rows.clone(), 0.0));
    }
    let target = reduced_knots(&rows.knots, by)?;
    let reduced = project(rows, target)?;
    // Back to a common spline space, where control points bound the difference.
    let raised = elevate(&reduced, by)?;
    let original = on_knots(rows, raised.knots.clone())?;
    let error = super::removal_step::distance_bound(&raised, &original);
    if error.is_nan() || error > tolerance {
        return Err(Error::argument(format!(
            "reducing the degree by {by} changes the shape by up to {error:e}, more than the tolerance {tolerance:e}"
        )));
    }
    Ok((reduced, error))
}

impl<const D: usize> BsplineCurve<D> {
    /// The same curve written with the degree `degree + by` ([PT97, sec. 5.5], by blossoming).
    ///
    /// Its continuity stays: all multiplicities are raised by `by`.
    ///
    /// # Errors
    /// [`Error::Degree`] above [`MAX_DEGREE`].
    pub fn elevated(&self, by: usize) -> Result<Self, Error> {
        elevate(&ControlRows::from_curve(self), by)?.into_curve()
    }

    /// The curve of degree `degree − by` that is nearest in the least squares sense (of homogeneous
    /// coordinates) with the same ends, and a bound of its distance to this one.
    ///
    /// Multiplicities of inner knots fall by `by`, but not below 1. A curve that was
    /// [elevated](Self::elevated) comes back exactly. The bound holds at equal parameters. A floating
    /// curve is clamped.
    ///
    /// # Errors
    /// [`Error::Argument`] when the bound exceeds `tolerance` (a length) or no degree would remain.
    pub fn reduced(&self, by: usize, tolerance: f64) -> Result<(Self, f64), Error> {
        let (rows, error) = reduce(&ControlRows::from_curve(self), by, tolerance)?;
        Ok((rows.into_curve()?, error))
    }
}

impl BsplineSurface {
    /// The same surface with a higher degree in a direction ([PT97, A5.10], by blossoming).
    ///
    /// # Errors
    /// [`Error::Degree`] above [`MAX_DEGREE`].
    pub fn elevated(&self, direction: Direction, by: usize) -> Result<Self, Error> {
        along(self, direction, |rows| elevate(&rows, by))
    }

    /// The nearest surface of lower degree in a direction, with a bound of its distance;
    /// see [`BsplineCurve::reduced`].
    ///
    /// # Errors
    /// As [`BsplineCurve::reduced`].
    pub fn reduced(&self, direction: Direction, by: usize, tolerance: f64) -> Result<(Self, f64), Error> {
        let mut bound = 0.0;
        let surface = along(self, direction, |rows| {
            let (rows, error) = reduce(&rows, by, tolerance)?;
            bound = error;
            Ok(rows)
        })?;
        Ok((surface, bound))
    }
}
