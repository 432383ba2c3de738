//! Clouds that lie in one plane.

use crate::neighbourhood::plane_deviation;
use nalgebra::{Matrix3, Vector3};

/// Thickness as a share of the width below which points lie in a plane, whatever their noise is.
const THIN: f64 = 1e-6;
/// Thickness in units of what points deviate from planes through their neighbours up to which it is all noise.
const NOISE: f64 = 2.0;
/// Thickness as a share of the width above which points do not lie in a plane.
const THICK: f64 = 0.02;

/// Whether points lie in one plane, but for their noise: nothing tells their motions in that plane apart when they are laid on other
/// such points.
///
/// Points that are not finite do not take part; fewer than four always lie in a plane.
#[must_use]
pub fn is_flat(points: &[Vector3<f64>]) -> bool {
    let finite: Vec<Vector3<f64>> =
        points.iter().copied().filter(|x| x.iter().all(|c| c.is_finite())).collect();
    let count = finite.len().max(1) as f64;
    let mean = finite.iter().sum::<Vector3<f64>>() / count;
    let spread = finite.iter().fold(Matrix3::zeros(), |sum, x| sum + (x - mean) * (x - mean).transpose());
    let mut widths: Vec<f64> =
        spread.symmetric_eigenvalues().iter().map(|value| (value.max(0.0) / count).sqrt()).collect();
    widths.sort_by(f64::total_cmp);
    let (thickness, width) = (widths[0], widths[2]);
    finite.len() < 4
        || thickness <= THIN * width
        || thickness <= THICK * width
            && plane_deviation(&finite).is_some_and(|deviation| thickness <= NOISE * deviation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::start::random::Random;

    #[test]
    fn planes_with_noise_are_flat_and_waves_are_not() {
        let mut random = Random::new(3);
        let turn = crate::rotation::exponential::<3>(&Vector3::new(0.4, -1.0, 0.3)).0;
        for (waves, noise, flat) in
            [(0.0, 0.0, true), (0.0, 1e-3, true), (0.0, 1e-9, true), (0.02, 1e-3, false), (0.1, 0.0, false)]
        {
            let points: Vec<_> = (0..2000)
                .map(|_| {
                    let (x, y) = (4.0 * random.unit(), 3.0 * random.unit());
                    let z = waves * (2.0 * x).sin() * (2.0 * y).cos() + noise * (random.unit() - 0.5);
                    turn * Vector3::new(x + 1e3, y, z)
                })
                .collect();
            assert_eq!(is_flat(&points), flat, "{waves} {noise}");
        }
    }
}
