//! Surfaces that are known, and points of them.

use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// Places per direction at which a truth is known.
const FINE: usize = 300;

type Place = fn(f64, f64) -> Vector3<f64>;
type Mask = fn(f64, f64) -> bool;

/// A known surface: a piece of a parameter rectangle.
pub(crate) struct Truth {
    pub(crate) name: &'static str,
    /// From the unit square.
    at: Place,
    /// What of the unit square belongs to it.
    has: Mask,
    /// Places all over it, and the area that each stands for.
    pub(crate) places: Vec<Vector3<f64>>,
    areas: Vec<f64>,
    parameters: Vec<Vector2<f64>>,
}

impl Truth {
    fn new(name: &'static str, at: Place, has: Mask) -> Self {
        let mut truth = Self { name, at, has, places: Vec::new(), areas: Vec::new(), parameters: Vec::new() };
        let step = 1.0 / FINE as f64;
        for k in 0..=FINE {
            for l in 0..=FINE {
                let (u, v) = (k as f64 * step, l as f64 * step);
                if has(u, v) {
                    let side = |du: f64, dv: f64| {
                        let low = at((u - du).max(0.0), (v - dv).max(0.0));
                        let high = at((u + du).min(1.0), (v + dv).min(1.0));
                        high - low
                    };
                    truth.places.push(at(u, v));
                    truth.areas.push(0.25 * side(step, 0.0).cross(&side(0.0, step)).norm());
                    truth.parameters.push(Vector2::new(u, v));
                }
            }
        }
        truth
    }

    pub(crate) fn area(&self) -> f64 {
        self.areas.iter().sum()
    }

    /// Diagonal of the box around it.
    pub(crate) fn size(&self) -> f64 {
        let [low, high] = self.bounds();
        (high - low).norm()
    }

    fn bounds(&self) -> [Vector3<f64>; 2] {
        let start = [Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)];
        self.places.iter().fold(start, |[low, high], p| [low.inf(p), high.sup(p)])
    }

    /// Random points, uniform by area, with noise in all directions, others anywhere about the surface, and which ones these are.
    pub(crate) fn sample(
        &self,
        count: usize,
        sigma: f64,
        outliers: f64,
        seed: u64,
    ) -> (Vec<Vector3<f64>>, Vec<bool>) {
        let mut random = Random::new(seed);
        let mut sums = vec![0.0];
        for (k, area) in self.areas.iter().enumerate() {
            sums.push(sums[k] + area);
        }
        let [low, high] = self.bounds();
        let margin = 0.1 * (high - low).norm();
        let half = 0.5 / FINE as f64;
        (0..count)
            .map(|_| {
                if random.uniform() < outliers {
                    let share = Vector3::new(random.uniform(), random.uniform(), random.uniform());
                    let wide = high - low + Vector3::repeat(2.0 * margin);
                    return (low - Vector3::repeat(margin) + wide.component_mul(&share), true);
                }
                loop {
                    let s = random.uniform() * sums[self.areas.len()];
                    let k = sums.partition_point(|sum| *sum <= s).clamp(1, self.areas.len()) - 1;
                    let shift = Vector2::new(random.uniform() - 0.5, random.uniform() - 0.5) * (2.0 * half);
                    let p = self.parameters[k] + shift;
                    if p.iter().all(|x| (0.0..=1.0).contains(x)) && (self.has)(p.x, p.y) {
                        let noise = Vector3::new(random.normal(), random.normal(), random.normal()) * sigma;
                        return ((self.at)(p.x, p.y) + noise, false);
                    }
                }
            })
            .unzip()
    }
}

fn wavy(x: f64, y: f64) -> Vector3<f64> {
    Vector3::new(x, y, 0.8 * (0.7 * x).sin() * (0.5 * y).cos())
}

fn dished(u: f64, v: f64) -> Vector3<f64> {
    let (x, y) = (10.0 * u - 5.0, 10.0 * v - 5.0);
    Vector3::new(x, y, 0.03 * (x * x + 0.5 * y * y))
}

fn turned(radius: f64, angle: f64, height: f64) -> Vector3<f64> {
    Vector3::new(radius * angle.cos(), radius * angle.sin(), height)
}

fn all_of_it(_: f64, _: f64) -> bool {
    true
}

/// The kinds of surfaces that are measured.
pub(crate) fn all() -> Vec<Truth> {
    vec![
        Truth::new("field", |u, v| wavy(10.0 * u, 8.0 * v), all_of_it),
        Truth::new("plane", |u, v| Vector3::new(10.0 * u, 6.0 * v, 2.0 * u - v), all_of_it),
        Truth::new("roof", |u, v| Vector3::new(4.0 * u - 2.0, 4.0 * v, -(4.0 * u - 2.0).abs()), all_of_it),
        Truth::new("disc", dished, |u, v| (u - 0.5).hypot(v - 0.5) <= 0.5),
        Truth::new("L", dished, |u, v| u <= 0.4 || v <= 0.4),
        Truth::new("triangle", dished, |u, v| u + v <= 1.0),
        Truth::new("frame", dished, |u, v| (u - 0.5).hypot(v - 0.45) >= 0.2),
        Truth::new("tube", |u, v| turned(3.0, TAU * u, 10.0 * v), all_of_it),
        Truth::new("vase", |u, v| turned(3.0 + 0.8 * (6.0 * v).sin(), TAU * u, 9.0 * v), all_of_it),
        Truth::new("cone", |u, v| turned(4.0 - 2.0 * v, TAU * u, 6.0 * v), all_of_it),
        Truth::new("half tube", |u, v| turned(3.0, PI * u, 8.0 * v), all_of_it),
        Truth::new(
            "cut tube",
            |u, v| turned(3.0, TAU * u, 10.0 * v),
            |u, v| v <= 0.75 + 0.2 * (TAU * u).cos(),
        ),
        Truth::new("dome", |u, v| turned(5.0 * (1.2 * v).sin(), TAU * u, 5.0 * (1.2 * v).cos()), all_of_it),
    ]
}

/// A sequence without a pattern.
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

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}
