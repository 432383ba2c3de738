//! What the distances look like: noise or not, and how it compares with the curvature of the shape.

use crate::shape::ActiveShape;
use crate::target::{Feet, Samples};

/// What is known about the distances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    /// Their number.
    pub(crate) count: f64,
    /// Root mean square of distance times curvature.
    pub(crate) bend: f64,
    /// Whether the shape is a surface, whose score is estimated from random vectors.
    pub(crate) surface: bool,
}

impl Noise {
    pub(crate) fn of<const D: usize>(feet: &Feet<D>, weights: &[f64]) -> Self {
        let (mut count, mut square, mut surface) = (0, 0.0, false);
        for (frame, weight) in feet.frames.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
            // Each sample tells as many distances as there are directions across the shape.
            count += D.saturating_sub(frame.tangent_dimension).max(1);
            surface |= frame.tangent_dimension > 1;
            square += weight * (frame.curvatures.amax() * frame.distance).powi(2).min(1.0);
        }
        Self { count: count as f64, bend: square.sqrt(), surface }
    }
}

/// Mean squared difference of the residuals of neighbours on a curve as a share of the mean square of all: 2 for noise, near
/// 0 where the shape systematically misses the data ([Ne41]). Always 2 on surfaces, whose points have no order.
pub(crate) fn disagreement<const D: usize, S: ActiveShape<D>>(
    shape: &S,
    samples: &Samples<'_, D>,
    feet: &Feet<D>,
    weights: &[f64],
) -> f64 {
    let used = (0..weights.len()).filter(|&i| weights[i] > 0.0);
    let mut order: Vec<(usize, [f64; 2], usize)> = used
        .map(|i| {
            let parameter = samples.parameter(feet, i);
            (shape.cell(parameter), parameter, i)
        })
        .collect();
    if order.iter().any(|o| o.1[1] != 0.0) {
        return 2.0;
    }
    order.sort_by(|a, b| a.0.cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])).then(a.2.cmp(&b.2)));
    let residual = |i: usize| feet.frames[i].normal() * feet.frames[i].distance;
    let squares: f64 = order.iter().map(|o| residual(o.2).norm_squared()).sum();
    let changes: f64 = order.windows(2).map(|p| (residual(p[1].2) - residual(p[0].2)).norm_squared()).sum();
    if squares > 0.0 { changes / squares } else { 0.0 }
}
