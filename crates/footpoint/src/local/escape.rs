//! Leaving points that satisfy the first order conditions without being minima.

/// How often the trial step of an escape is halved; beyond, the gain would drown in rounding.
pub(crate) const ESCAPE_TRIALS: i32 = 24;

/// Whether one distance is below another by more than rounding, and by enough to be worth a step.
pub(crate) fn is_lower(candidate: f64, reference: f64, noise: f64) -> bool {
    candidate < reference - noise - 1e-13 * reference
}
