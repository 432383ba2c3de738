//! Surfaces in files, evaluated by de Boor's recursion, and clouds of known shapes: nothing here is shared with the fits.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use super::{Bench, Run};
use serde_json::Value;
use std::f64::consts::TAU;

pub(crate) type P = [f64; 3];

/// A B-spline or NURBS surface as it is in the file.
pub(crate) struct Surface {
    degrees: [usize; 2],
    knots: [Vec<f64>; 2],
    pub(crate) net: Vec<Vec<[f64; 4]>>,
    /// Loops in the parameters that bound it; none for the whole surface.
    trim: Vec<Vec<[f64; 2]>>,
}

impl Surface {
    pub(crate) fn read(bench: &Bench, name: &str) -> Self {
        let json: Value = serde_json::from_str(&bench.text(name)).unwrap();
        let numbers = |value: &Value| -> Vec<f64> { serde_json::from_value(value.clone()).unwrap() };
        let net: Vec<Vec<P>> = serde_json::from_value(json["control_points"].clone()).unwrap();
        let weights: Option<Vec<Vec<f64>>> = serde_json::from_value(json["weights"].clone()).unwrap();
        let weight = |i: usize, j: usize| weights.as_ref().map_or(1.0, |w| w[i][j]);
        let point = |(i, row): (usize, &Vec<P>)| {
            row.iter()
                .enumerate()
                .map(|(j, p)| (weight(i, j), p))
                .map(|(w, p)| [w * p[0], w * p[1], w * p[2], w])
                .collect()
        };
        Self {
            degrees: ["degree_u", "degree_v"]
                .map(|key| usize::try_from(json[key].as_u64().unwrap()).unwrap()),
            knots: [numbers(&json["knots_u"]), numbers(&json["knots_v"])],
            net: net.iter().enumerate().map(point).collect(),
            trim: serde_json::from_value::<Option<_>>(json["trim"].clone()).unwrap().unwrap_or_default(),
        }
    }

    fn de_boor(degree: usize, knots: &[f64], points: &[[f64; 4]], t: f64) -> [f64; 4] {
        let last = knots.len() - degree - 2;
        let span =
            (degree..=last).rev().find(|&k| knots[k] <= t && knots[k] < knots[k + 1]).unwrap_or(degree);
        let mut d: Vec<[f64; 4]> = (0..=degree).map(|j| points[j + span - degree]).collect();
        for r in 1..=degree {
            for j in (r..=degree).rev() {
                let (a, b) = (knots[j + span - degree], knots[j + 1 + span - r]);
                let share = (t - a) / (b - a);
                d[j] = std::array::from_fn(|c| d[j - 1][c] * (1.0 - share) + d[j][c] * share);
            }
        }
        d[degree]
    }

    /// The parameters at shares of the domain.
    fn parameters(&self, shares: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| {
            let (p, k) = (self.degrees[d], &self.knots[d]);
            let (a, b) = (k[p], k[k.len() - 1 - p]);
            a + (b - a) * shares[d].clamp(0.0, 1.0 - 1e-12)
        })
    }

    /// Whether shares of the domain lie in what loops bound: an odd number of their edges is to the right.
    fn has(&self, shares: [f64; 2]) -> bool {
        let [u, v] = self.parameters(shares);
        let edges = self.trim.iter().flat_map(|l| l.iter().zip(l.iter().cycle().skip(1)));
        let right = edges.filter(|(a, b)| {
            (a[1] > v) != (b[1] > v) && u < a[0] + (v - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        self.trim.is_empty() || right.count() % 2 == 1
    }

    /// The point at shares of the domain.
    pub(crate) fn at(&self, shares: [f64; 2]) -> P {
        let [u, v] = self.parameters(shares);
        let row: Vec<[f64; 4]> =
            self.net.iter().map(|row| Self::de_boor(self.degrees[1], &self.knots[1], row, v)).collect();
        let h = Self::de_boor(self.degrees[0], &self.knots[0], &row, u);
        [h[0] / h[3], h[1] / h[3], h[2] / h[3]]
    }

    /// Largest distance of the surface, as far as its loops go, from a shape, of samples all over it, the edges included.
    pub(crate) fn farthest(&self, distance: impl Fn(P) -> f64) -> f64 {
        let n = 120;
        let shares = |k: usize| [(k / (n + 1)) as f64 / n as f64, (k % (n + 1)) as f64 / n as f64];
        let places = (0..(n + 1) * (n + 1)).map(shares).filter(|s| self.has(*s));
        places.map(|s| self.at(s)).map(distance).fold(0.0, f64::max)
    }
}

/// Numbers from 0 to 1 that look like chance (splitmix64).
pub(crate) fn chance(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

pub(crate) fn cloud(count: usize, seed: u64, mut place: impl FnMut(&mut dyn FnMut() -> f64) -> P) -> String {
    let mut next = chance(seed);
    (0..count).map(|_| place(&mut next)).map(|[x, y, z]| format!("{x} {y} {z}\n")).collect()
}

/// A number with the normal distribution.
pub(crate) fn normal(next: &mut dyn FnMut() -> f64) -> f64 {
    (-2.0 * (1.0 - next()).ln()).sqrt() * (TAU * next()).cos()
}

/// How far a number is outside of a range.
pub(crate) fn outside(x: f64, low: f64, high: f64) -> f64 {
    (low - x).max(x - high).max(0.0)
}

pub(crate) fn results(run: &Run) -> Value {
    run.report()["results"].clone()
}

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}
