//! Curves that are known, and points of them.

use nalgebra::Vector2;
use std::f64::consts::{PI, TAU};

/// A known curve, its points dense enough to be the truth.
pub(crate) struct Truth {
    pub(crate) name: &'static str,
    /// Polygons, closed ones with the first point repeated.
    pub(crate) pieces: Vec<Vec<Vector2<f64>>>,
    /// Whether points are as dense as the parameter goes slowly, instead of evenly by length.
    uneven: bool,
}

/// Points of a polygon of the truth.
const FINE: usize = 6000;

fn parametric(name: &'static str, range: f64, at: impl Fn(f64) -> Vector2<f64>) -> Truth {
    let points = (0..=FINE).map(|k| at(range * k as f64 / FINE as f64)).collect();
    Truth { name, pieces: vec![points], uneven: false }
}

fn polygon(name: &'static str, corners: &[[f64; 2]]) -> Truth {
    let mut points = Vec::new();
    for (k, a) in corners.iter().enumerate() {
        let (a, b) = (Vector2::from(*a), Vector2::from(corners[(k + 1) % corners.len()]));
        points.extend(
            (0..FINE / corners.len()).map(|i| a + (b - a) * (i * corners.len()) as f64 / FINE as f64),
        );
    }
    points.push(points[0]);
    Truth { name, pieces: vec![points], uneven: false }
}

fn polar(r: f64, a: f64) -> Vector2<f64> {
    Vector2::new(r * a.cos(), r * a.sin())
}

/// The kinds of curves that are measured.
pub(crate) fn all() -> Vec<Truth> {
    let mut two = parametric("two ellipses", TAU, |t| Vector2::new(15.0 * t.cos(), 10.0 * t.sin()));
    let inner = parametric("", TAU, |t| Vector2::new(4.0 + 5.0 * t.cos(), 1.0 + 3.0 * t.sin()));
    two.pieces.extend(inner.pieces);
    // Points lie dense at its ends and wide apart on its sides, which are near to each other.
    let mut thin = parametric("thin section", TAU, |t| {
        let a = t - 0.3 * (2.0 * t).sin();
        Vector2::new(20.0 * a.cos(), 1.5 * a.sin() + 1.5 * (0.5 * PI * a.cos()).cos())
    });
    thin.uneven = true;
    vec![
        thin,
        parametric("arc", 4.5, |t| polar(10.0, t)),
        parametric("wave", 30.0, |t| Vector2::new(t, 3.0 * t.sin())),
        parametric("rose of 3", PI, |t| polar(10.0 * (3.0 * t).cos(), t)),
        parametric("rose of 4", TAU, |t| polar(10.0 * (2.0 * t).cos(), t)),
        parametric("limacon", TAU, |t| polar(4.0 + 8.0 * t.cos(), t)),
        parametric("eight", TAU, |t| Vector2::new(10.0 * t.sin(), 5.0 * (2.0 * t).sin())),
        parametric("spiral", 5.0 * PI, |t| polar(1.0 + 0.6 * t, t)),
        parametric("disc", TAU, |t| polar(10.0, t)),
        parametric("wheel", TAU, |t| polar(10.0 + 2.0 * (8.0 * t).cos(), t)),
        polygon("L", &[[0.0, 0.0], [10.0, 0.0], [10.0, 3.0], [3.0, 3.0], [3.0, 10.0], [0.0, 10.0]]),
        polygon("triangle", &[[0.0, 0.0], [10.0, 0.0], [4.0, 7.0]]),
        two,
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

impl Truth {
    pub(crate) fn length(&self) -> f64 {
        self.pieces.iter().flat_map(|p| p.windows(2)).map(|p| (p[1] - p[0]).norm()).sum()
    }

    /// Diagonal of the box around it.
    pub(crate) fn size(&self) -> f64 {
        let [low, high] = self.bounds();
        (high - low).norm()
    }

    fn bounds(&self) -> [Vector2<f64>; 2] {
        let mut bounds = [Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY)];
        for p in self.pieces.iter().flatten() {
            bounds = [bounds[0].inf(p), bounds[1].sup(p)];
        }
        bounds
    }

    /// Random points of it, uniform by length, with noise across and along it, others anywhere about it, and which ones these are.
    pub(crate) fn sample(
        &self,
        count: usize,
        sigma: f64,
        outliers: f64,
        seed: u64,
    ) -> (Vec<Vector2<f64>>, Vec<bool>) {
        let mut random = Random::new(seed);
        let edges: Vec<[Vector2<f64>; 2]> =
            self.pieces.iter().flat_map(|p| p.windows(2)).map(|p| [p[0], p[1]]).collect();
        let mut lengths = vec![0.0];
        for (k, [a, b]) in edges.iter().enumerate() {
            lengths.push(lengths[k] + (b - a).norm());
        }
        let total = lengths[edges.len()];
        let [low, high] = self.bounds();
        (0..count)
            .map(|_| {
                if random.uniform() < outliers {
                    let share = Vector2::new(random.uniform(), random.uniform()) * 1.2 - Vector2::repeat(0.1);
                    return (low + (high - low).component_mul(&share), true);
                }
                let s = random.uniform();
                let s = if self.uneven { along(&lengths, s) } else { s * total };
                let k = lengths.partition_point(|l| *l <= s).clamp(1, edges.len()) - 1;
                let [a, b] = edges[k];
                let share = (s - lengths[k]) / (lengths[k + 1] - lengths[k]).max(f64::MIN_POSITIVE);
                (a + (b - a) * share + Vector2::new(random.normal(), random.normal()) * sigma, false)
            })
            .unzip()
    }
}

/// The length at a share of the places, which lengths lead up to.
fn along(lengths: &[f64], share: f64) -> f64 {
    let at = share * (lengths.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place among them")]
    let k = (at as usize).min(lengths.len() - 2);
    lengths[k] + (lengths[k + 1] - lengths[k]) * (at - k as f64)
}
