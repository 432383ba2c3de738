//! Lower bounds hold whatever stops the proof: checked against points of the surface that are computed in twice the precision.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use footpoint::{Mode, ProjectionOptions, SurfaceProjector};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Interval, KnotVector};
use std::ops::{Add, Mul, Sub};

/// A number as the sum of two, exact to about 32 digits.
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn sum(a: f64, b: f64) -> Self {
        let s = a + b;
        let t = s - a;
        Self(s, (a - (s - t)) + (b - t))
    }
}

impl From<f64> for Double {
    fn from(value: f64) -> Self {
        Self(value, 0.0)
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let s = Self::sum(self.0, other.0);
        Self::sum(s.0, s.1 + self.1 + other.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self(-other.0, -other.1)
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = self.0 * other.0;
        let error = self.0.mul_add(other.0, -p);
        Self::sum(p, error + self.0 * other.1 + self.1 * other.0)
    }
}

/// A small generator: the same numbers in every run.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// One patch over the unit square.
struct Patch {
    degrees: [usize; 2],
    points: Vec<Vector3<f64>>,
    weights: Option<Vec<f64>>,
}

impl Patch {
    fn new(degrees: [usize; 2], mut point: impl FnMut(f64, f64) -> Vector3<f64>) -> Self {
        let [p, q] = degrees;
        let share = |i: usize, n: usize| i as f64 / n as f64;
        let places = (0..=p).flat_map(|i| (0..=q).map(move |j| [share(i, p), share(j, q)]));
        Self { degrees, points: places.map(|[x, y]| point(x, y)).collect(), weights: None }
    }

    fn surface(&self) -> BsplineSurface {
        let [u, v] = self.degrees.map(|degree| KnotVector::bezier(degree, Interval::UNIT).unwrap());
        BsplineSurface::new(u, v, self.points.clone(), self.weights.clone()).unwrap()
    }

    /// The squared distance of a point of the surface, in twice the precision, times its squared weight; and that.
    fn squared(&self, x: &Vector3<f64>, [s, t]: [f64; 2]) -> [Double; 2] {
        let [p, q] = self.degrees;
        let one = Double::from(1.0);
        let reduce = |mut values: Vec<Double>, s: f64| {
            let s = Double::from(s);
            while values.len() > 1 {
                values = values.windows(2).map(|w| w[0] * (one - s) + w[1] * s).collect();
            }
            values[0]
        };
        let component = |c: usize| {
            let coefficient = |k: usize| {
                let w = Double::from(self.weights.as_ref().map_or(1.0, |w| w[k]));
                if c == 3 { w } else { w * (Double::from(self.points[k][c]) - Double::from(x[c])) }
            };
            let rows = (0..=p).map(|i| reduce((0..=q).map(|j| coefficient(i * (q + 1) + j)).collect(), t));
            reduce(rows.collect(), s)
        };
        let [a, b, c, w] = [0, 1, 2, 3].map(component);
        [a * a + b * b + c * c, w * w]
    }

    /// Whether no point that a search of places finds is nearer than a bound; the share by which it is, if it is.
    fn excess(&self, x: &Vector3<f64>, bound: f64, starts: &[[f64; 2]]) -> f64 {
        let measure = |at: [f64; 2]| {
            let [squared, weight] = self.squared(x, at);
            let bound = Double::from(bound) * Double::from(bound);
            let excess = bound * weight - squared;
            excess.0 / (weight.0 * bound.0.max(f64::MIN_POSITIVE))
        };
        let mut worst = f64::NEG_INFINITY;
        for &start in starts {
            let (mut at, mut best) = (start, measure(start));
            let mut step = 0.05;
            while step > 1e-9 {
                let ways = [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]];
                let next = ways.map(|way| [0, 1].map(|d| (at[d] + way[d]).clamp(0.0, 1.0)));
                let found = next
                    .map(|at| (measure(at), at))
                    .into_iter()
                    .fold((best, at), |a, b| if b.0 > a.0 { b } else { a });
                if found.0 > best {
                    (best, at) = found;
                } else {
                    step *= 0.5;
                }
            }
            worst = worst.max(best);
        }
        worst
    }
}

/// Patches that are hard in different ways.
fn patches() -> Vec<(&'static str, Patch)> {
    let mut random = Random(3);
    let noise = Patch::new([4, 4], |x, y| Vector3::new(x, y, random.between(-0.5, 0.5)));
    let steep = Patch::new([3, 3], |x, y| {
        let inner = (x - 0.5).abs() < 0.3 && (y - 0.5).abs() < 0.3;
        Vector3::new(x, y, if inner { 20.0 } else { 0.0 })
    });
    let mut weighted = Patch::new([3, 3], |x, y| Vector3::new(x, y, random.between(-0.3, 0.3)));
    weighted.weights = Some((0..16).map(|_| 1e3f64.powf(random.between(-1.0, 1.0))).collect());
    let high = Patch::new([9, 5], |x, y| Vector3::new(x, y, random.between(-0.4, 0.4)));
    vec![("noise", noise), ("steep", steep), ("weighted", weighted), ("high", high)]
}

#[test]
fn bounds_hold_when_the_work_is_limited() {
    for (name, patch) in patches() {
        let projector = SurfaceProjector::new(&patch.surface());
        let mut random = Random(8);
        let mut open = 0;
        for _ in 0..12 {
            let height = if name == "steep" { 9.0 } else { 0.5 };
            let x = Vector3::new(random.unit(), random.unit(), random.between(-0.2, 1.0) * height);
            let full = projector.project(&x);
            for max_boxes in [0, 10, 30, 100, 300, 1000, 3000] {
                let options = ProjectionOptions { max_boxes, ..ProjectionOptions::default() };
                let foot = projector.project_with(&x, &options).unwrap();
                open += usize::from(foot.gap() > 1e-6 * foot.distance);
                let starts = [full.parameter, foot.parameter];
                let excess = patch.excess(&x, foot.lower_bound, &starts);
                assert!(excess <= 1e-13, "{name}, {max_boxes} boxes: {excess:e} at {x:?}: {foot:?}");
                // As near as without a proof, but for the gap.
                let fast = projector.project_with(&x, &options.with_mode(Mode::Fast)).unwrap();
                assert!(foot.distance <= fast.distance * (1.0 + 1e-7), "{name}: {foot:?} {fast:?}");
            }
        }
        assert!(open > 0, "{name}: the limit has never stopped a proof");
    }
}

#[test]
fn bounds_hold_close_to_the_surface_far_from_the_origin() {
    let mut random = Random(21);
    for shift in [0.0, 1e3, 1e6] {
        let patch = Patch::new([3, 3], |x, y| {
            Vector3::new(x, y, 0.4 * random.between(-1.0, 1.0)) + Vector3::new(shift, -shift, 2.0 * shift)
        });
        let surface = patch.surface();
        let projector = SurfaceProjector::new(&surface);
        for _ in 0..40 {
            let at = [random.unit(), random.unit()];
            let off =
                Vector3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let distance = 10f64.powf(random.between(-9.0, -2.0));
            let x = nurbs_core::ParametricSurface::point(&surface, at[0], at[1]) + off * distance;
            // With the gap asked for, and with none: then all depends on the rounding errors.
            for gap in [1e-7, 0.0] {
                let options = ProjectionOptions {
                    relative_gap: gap,
                    size_gap: gap * 1e-3,
                    ..ProjectionOptions::default()
                };
                let foot = projector.project_with(&x, &options).unwrap();
                let excess = patch.excess(&x, foot.lower_bound, &[foot.parameter, at]);
                // Coordinates in the patch are rounded, too.
                let allowed = 1e-13 + 8.0 * f64::EPSILON / foot.distance.max(1e-300);
                assert!(excess <= allowed, "{shift} {gap}: {excess:e} above {allowed:e} at {x:?}: {foot:?}");
                assert!(foot.distance <= (surface_distance(&surface, at, &x)) * (1.0 + 1e-9) + 1e-15);
            }
        }
    }
}

fn surface_distance(surface: &BsplineSurface, at: [f64; 2], x: &Vector3<f64>) -> f64 {
    (nurbs_core::ParametricSurface::point(surface, at[0], at[1]) - x).norm()
}
