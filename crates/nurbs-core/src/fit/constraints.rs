//! End conditions as fixed control points.

use crate::{Error, KnotVector, MAX_DEGREE, basis};
use nalgebra::SVector;
use std::collections::BTreeMap;

/// Fixes the control points that follow from the point and derivatives given at the ends of a clamped
/// curve: the `d`-th derivative at an end involves the outermost `d + 1` control points only
/// ([PT97, sec. 9.4.2]).
pub(crate) fn fix_ends<const D: usize>(
    knots: &KnotVector,
    start: &[SVector<f64, D>],
    end: &[SVector<f64, D>],
    fixed: &mut BTreeMap<usize, Vec<f64>>,
) -> Result<(), Error> {
    if start.is_empty() && end.is_empty() {
        return Ok(());
    }
    let (p, n) = (knots.degree(), knots.basis_count());
    if knots.is_periodic() || !knots.is_clamped() {
        return Err(Error::argument("ends can be fixed on clamped knots only"));
    }
    if start.len() > p + 1 || end.len() > p + 1 || start.len() + end.len() > n {
        return Err(Error::argument(format!(
            "{} and {} end conditions are too many for degree {p} and {n} control points",
            start.len(),
            end.len()
        )));
    }
    let domain = knots.domain();
    for (values, t, at_end) in [(start, domain.start(), false), (end, domain.end(), true)] {
        let span = knots.span(t);
        let mut rows = vec![[0.0; MAX_DEGREE + 1]; values.len().max(1)];
        basis::derivatives(knots, span, t, values.len().max(1) - 1, &mut rows);
        let mut known: Vec<SVector<f64, D>> = Vec::new();
        for (d, value) in values.iter().enumerate() {
            if value.iter().any(|x| !x.is_finite()) {
                return Err(Error::argument(format!(
                    "end condition {d} has a coordinate that is not finite"
                )));
            }
            // Counted from the end of the curve.
            let weight = |k: usize| if at_end { rows[d][p - k] } else { rows[d][k] };
            let rest = known.iter().enumerate().fold(*value, |sum, (k, point)| sum - point * weight(k));
            let point = rest / weight(d);
            fixed.insert(if at_end { n - 1 - d } else { d }, point.iter().copied().collect());
            known.push(point);
        }
    }
    Ok(())
}

/// A regularization factor must be a finite number that is not negative.
pub(crate) fn check_factor(factor: f64) -> Result<(), Error> {
    if factor.is_finite() && factor >= 0.0 {
        Ok(())
    } else {
        Err(Error::argument(format!("the regularization {factor} must be finite and not negative")))
    }
}
