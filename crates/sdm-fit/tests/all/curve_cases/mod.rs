//! The cases of `fixtures/fit-cases`, and made ones.

#![allow(dead_code, clippy::unwrap_used, reason = "tests may panic, and not every test uses every case")]

use nalgebra::{SVector, Vector2};
use nurbs_core::{BsplineCurve, KnotVector, ParametricCurve};
use std::f64::consts::TAU;

fn text(name: &str) -> String {
    let path = format!("{}/../../fixtures/fit-cases/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

/// The points of a case.
pub(crate) fn points<const D: usize>(name: &str) -> Vec<SVector<f64, D>> {
    let line = |line: &str| {
        let values: Vec<f64> = line.split_whitespace().map(|x| x.parse().unwrap()).collect();
        SVector::from_fn(|i, _| values[i])
    };
    text(name).lines().filter(|l| !l.trim().is_empty()).map(line).collect()
}

/// A curve to start from.
pub(crate) fn start(name: &str) -> BsplineCurve<2> {
    let value: serde_json::Value = serde_json::from_str(&text(name)).unwrap();
    let numbers = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let net = value["control_points"].as_array().unwrap().iter().map(|p| {
        let p = numbers(p);
        Vector2::new(p[0], p[1])
    });
    BsplineCurve::new(KnotVector::periodic(3, numbers(&value["knots"])).unwrap(), net.collect(), None)
        .unwrap()
}

/// A sequence without a pattern, uniform in (0, 1).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
    }

    /// Normally distributed (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// A lobed closed shape.
pub(crate) fn lobes(t: f64) -> Vector2<f64> {
    let r = 1.5 * (1.0 + 0.25 * (3.0 * t).cos() + 0.15 * (2.0 * t).sin());
    Vector2::new(1.4 * r * t.cos(), r * t.sin())
}

/// Points of it with noise, in no order.
pub(crate) fn noisy_lobes(count: usize, sigma: f64, seed: u64) -> Vec<Vector2<f64>> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let place = lobes(TAU * random.uniform());
            place + Vector2::new(random.normal(), random.normal()) * sigma
        })
        .collect()
}

/// Root mean square distance of a curve (by length) from a polygon of many points.
pub(crate) fn deviation(curve: &BsplineCurve<2>, truth: impl Fn(f64) -> Vector2<f64>) -> f64 {
    let truth: Vec<_> = (0..3000).map(|k| truth(TAU * f64::from(k) / 3000.0)).collect();
    let at = |k: usize| curve.point(curve.domain().lerp(k as f64 / 600.0));
    let (mut sum, mut length) = (0.0, 0.0);
    for k in 0..600 {
        let (p, step) = (at(k), (at(k + 1) - at(k)).norm());
        let near = truth.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
        sum += near * near * step;
        length += step;
    }
    (sum / length).sqrt()
}
