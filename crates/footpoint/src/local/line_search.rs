//! Steps shortened until the distance does not grow.

use super::axis::{Axis, Cell};

/// Halvings tried before a direction is given up: more than a double has digits.
const MAX_TRIALS: usize = 60;

/// Share of the step below which a break of the second derivative is no candidate for its end.
const SMALLEST_CUT: f64 = 1e-3;

/// Share of the decrease promised by the gradient that a step must keep.
///
/// A quarter allows steps up to 1.5 times the best one, so that what is left of the error at least halves.
/// Without such a rule first order steps near the stability limit swing for thousands of iterations, each
/// a little nearer.
const SUFFICIENT: f64 = 0.25;

/// The largest acceptable distance after a step: `promise = ⟨w, displacement⟩` is how much `½d²` would
/// decrease along the tangent. Rounding must not make a step fail.
pub(crate) fn largest_distance(distance: f64, promise: f64, noise: f64) -> f64 {
    (distance * distance - 2.0 * SUFFICIENT * promise.max(0.0)).max(0.0).sqrt() + 0.5 * noise
}

/// The longest acceptable step from `from` towards `from + delta`.
///
/// The full step, cut at the ends of the cell, is tried first. Where it fails, the second derivative
/// that it relied on may have been that of the near side only: the first break on the way is tried, then
/// halves. `None` when nothing is accepted before the step vanishes in rounding.
pub(crate) fn search<T>(
    axis: &Axis,
    cell: &Cell,
    from: f64,
    delta: f64,
    mut evaluate: impl FnMut(f64) -> T,
    accept: impl Fn(&T) -> bool,
) -> Option<T> {
    let half_turn = if axis.wraps { 0.5 * axis.domain.length() } else { f64::INFINITY };
    let mut to = cell.clamp(from + delta.clamp(-half_turn, half_turn));
    let mut cut = axis.curvature_break_between(from, to);
    for _ in 0..MAX_TRIALS {
        if to == from || to.is_nan() {
            return None;
        }
        let candidate = evaluate(to);
        if accept(&candidate) {
            return Some(candidate);
        }
        let half = from + 0.5 * (to - from);
        to = match cut.take() {
            Some(at) if (at - from).abs() > SMALLEST_CUT * (to - from).abs() => at,
            _ => half,
        };
    }
    None
}
