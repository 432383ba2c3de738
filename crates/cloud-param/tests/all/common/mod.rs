//! Clouds for tests.
#![allow(dead_code, reason = "every test uses a part of it")]

use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Evenly scattered numbers in `[0, 1)`, two for each index.
pub(crate) fn scattered(i: u32) -> [f64; 2] {
    [(f64::from(i) * 0.754_877_666_246_692_8).fract(), (f64::from(i) * 0.569_840_290_998_053_2).fract()]
}

/// Numbers in `[-0.5, 0.5)` from a seed.
pub(crate) fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// Noise of a given size along each axis, nearly normal.
pub(crate) fn noise(seed: &mut u64, size: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| (0..12).map(|_| random(seed)).sum::<f64>() * size)
}

/// A vase about the z axis with lobes around it and a waist, 10 high, some 3 wide.
pub(crate) fn vase_point(around: f64, height: f64) -> Vector3<f64> {
    let (a, h) = (TAU * around, height);
    let radius = 3.0 + 0.8 * (4.0 * h).sin() + 0.5 * (5.0 * a + 2.0 * h).cos();
    Vector3::new(radius * a.cos(), radius * a.sin(), 10.0 * h - 5.0)
}

/// The vase, `count` points in no order, with noise.
pub(crate) fn vase(count: u32, size: f64) -> Vec<Vector3<f64>> {
    let mut seed = 7;
    (0..count).map(scattered).map(|[a, h]| vase_point(a, h) + noise(&mut seed, size)).collect()
}
