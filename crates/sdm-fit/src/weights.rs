//! What each sample counts in a step.

use crate::target::{Feet, Samples};
use distance_field::{Kernel, Spread};
use sdm_core::{Robust, trim_limit};

/// Share of the largest distance below which a kernel has no scale.
const NO_SPREAD: f64 = 1e-12;

/// The weights of the samples, with the sum 1 (or all 0).
pub(crate) fn weights<const D: usize>(samples: &Samples<'_, D>, feet: &Feet<D>, robust: Robust) -> Vec<f64> {
    let mut out: Vec<f64> = (0..samples.len()).map(|i| samples.weight(i, feet)).collect();
    weigh(&mut out, &|i| feet.distance(i), robust);
    let total: f64 = out.iter().sum();
    if total > 0.0 {
        out.iter_mut().for_each(|w| *w /= total);
    }
    out
}

/// Weighs down what is far away.
pub(crate) fn weigh(out: &mut [f64], distance: &dyn Fn(usize) -> f64, robust: Robust) {
    let distances = || (0..out.len()).filter(|&i| out[i] > 0.0).map(distance).collect::<Vec<_>>();
    match robust {
        Robust::None => {}
        Robust::Kernel { kernel, abs_scale } => {
            let scale = abs_scale.unwrap_or_else(|| {
                let mut distances = distances();
                let largest = distances.iter().copied().fold(0.0, f64::max);
                let sigma = Spread::of(&mut distances, Kernel::Tukey.tuning()).sigma;
                kernel.tuning() * sigma.max(NO_SPREAD * largest)
            });
            if scale > 0.0 {
                for (i, weight) in out.iter_mut().enumerate().filter(|(_, w)| **w > 0.0) {
                    *weight *= kernel.weight((distance(i) / scale).powi(2));
                }
            }
        }
        Robust::Trimmed { outliers } => {
            let limit = trim_limit(&mut distances(), outliers);
            for (i, weight) in out.iter_mut().enumerate() {
                if *weight > 0.0 && distance(i) > limit {
                    *weight = 0.0;
                }
            }
        }
    }
}

/// `Σ w d²`, the largest distance of a sample that counts, and which one that is.
pub(crate) fn measure<const D: usize>(feet: &Feet<D>, weights: &[f64]) -> (f64, f64, usize) {
    let (mut sum, mut largest, mut index) = (0.0, 0.0, 0);
    for (i, weight) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
        let distance = feet.distance(i);
        sum += weight * distance * distance;
        if distance > largest {
            (largest, index) = (distance, i);
        }
    }
    (sum, largest, index)
}
