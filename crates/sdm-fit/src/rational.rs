//! What the fits of rational curves and surfaces have in common: the control of their steps and the bounds on weights.

use crate::Error;
use nurbs_core::KnotVector;
use sdm_core::StepLimits;

/// Control of the steps; dampings are shares of the mean of the diagonal. The cost has to fall.
pub(crate) const LIMITS: StepLimits = StepLimits {
    decrease: 1e-4,
    shortest: 1e-6,
    first: 1e-3,
    least: 1e-12,
    last: 1e6,
    drops: false,
    slack: 0.0,
};
/// Share of the cost by which the last step lowers it at most.
pub(crate) const SMALL_DECREASE: f64 = 1e-9;
/// Largest change of the logarithm of a weight in a step.
pub(crate) const LARGEST_CHANGE: f64 = 0.7;
/// Largest logarithm of a weight.
pub(crate) const LARGEST_LOGARITHM: f64 = 6.0;

/// Knots of degree 2 whose pieces are joined without derivatives, so that each can be any arc of a conic.
pub(crate) fn conic_knots(arcs: usize, closed: bool) -> Result<KnotVector, Error> {
    let at = |k: isize| k as f64 / arcs as f64;
    let last = arcs.cast_signed();
    Ok(if closed {
        // Period 1; the domain starts with the second of two equal knots.
        let knots = (-1..=last + 1).flat_map(|k| [at(k), at(k)]).collect::<Vec<_>>();
        KnotVector::periodic(2, knots[1..].to_vec())?
    } else {
        let mut knots = vec![0.0];
        knots.extend((0..=last).flat_map(|k| [at(k), at(k)]));
        knots.push(1.0);
        KnotVector::new(2, knots)?
    })
}
