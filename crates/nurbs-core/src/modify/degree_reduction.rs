//! Degree reduction.

use super::degree::elevate;
use super::refine::on_knots;
use super::removal_step::deviation;
use super::rows::{ControlRows, along, check_tolerance};
use crate::fit::project;
use crate::{BsplineCurve, BsplineSurface, Direction, Error, KnotVector};

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
    let error = distance_bound(&raised, &original);
    if error.is_nan() || error > tolerance {
        return Err(Error::argument(format!(
            "reducing the degree by {by} changes the shape by up to {error:e}, more than the tolerance {tolerance:e}"
        )));
    }
    Ok((reduced, error))
}

impl<const D: usize> BsplineCurve<D> {
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

/// Bound of the distance of two shapes on the same knots at equal parameters.
fn distance_bound(a: &ControlRows, b: &ControlRows) -> f64 {
    let (centre, radius) = b.bounds(0..b.count());
    let delta: Vec<f64> = a.data.iter().zip(&b.data).map(|(x, y)| x - y).collect();
    let error = deviation(a, &delta, &centre, radius);
    if !a.rational {
        return error;
    }
    let least = a.data.chunks_exact(a.point).map(|h| h[a.point - 1]).fold(f64::INFINITY, f64::min);
    if least > 0.0 { error / least } else { f64::INFINITY }
}
