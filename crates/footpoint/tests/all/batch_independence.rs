//! An answer does not depend on the other points of its batch: alone, in any order, in any part of the points, it has the same bits.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use footpoint::{
    CurveFootpoint, CurveProjector, Mode, ProjectionOptions, SurfaceFootpoint, SurfaceProjector, no_progress,
};
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Circle, Cylinder, Frame, Interval, KnotVector, ParametricCurve,
    ParametricSurface, Sphere, Torus,
};

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

    fn vector<const D: usize>(&mut self, size: f64) -> SVector<f64, D> {
        SVector::from_fn(|_, _| self.between(-size, size))
    }

    /// A permutation of the numbers below `n`.
    fn order(&mut self, n: usize) -> Vec<usize> {
        let mut keyed: Vec<_> = (0..n).map(|i| (self.unit(), i)).collect();
        keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
        keyed.into_iter().map(|k| k.1).collect()
    }
}

fn surface_bits(foot: &SurfaceFootpoint) -> (Vec<u64>, String) {
    let numbers = [foot.distance, foot.signed_distance, foot.lower_bound];
    let all = foot.parameter.iter().chain(foot.point.iter()).chain(&numbers);
    let rest = format!("{:?} {:?} {:?} {}", foot.status, foot.location, foot.multiplicity, foot.iterations);
    (all.map(|n| n.to_bits()).chain([foot.shape as u64]).collect(), rest)
}

fn curve_bits<const D: usize>(foot: &CurveFootpoint<D>) -> (Vec<u64>, String) {
    let all = foot.point.iter().chain([&foot.parameter, &foot.distance, &foot.lower_bound]);
    let rest = format!("{:?} {:?} {:?} {}", foot.status, foot.location, foot.multiplicity, foot.iterations);
    (all.map(|n| n.to_bits()).chain([foot.shape as u64]).collect(), rest)
}

/// Compares what is told of each point alone with the answers of batches.
fn check<const D: usize, F, B: PartialEq + std::fmt::Debug>(
    name: &str,
    points: &[SVector<f64, D>],
    alone: impl Fn(&SVector<f64, D>) -> F,
    many: impl Fn(&[SVector<f64, D>]) -> Vec<F>,
    bits: impl Fn(&F) -> B,
) {
    let wanted: Vec<B> = points.iter().map(|x| bits(&alone(x))).collect();
    let mut random = Random(9);
    let orders = [(0..points.len()).collect(), (0..points.len()).rev().collect(), random.order(points.len())];
    for order in orders {
        for size in [points.len(), points.len() / 3 + 1, 2] {
            for part in order.chunks(size) {
                let batch: Vec<_> = part.iter().map(|&i| points[i]).collect();
                for (&i, found) in part.iter().zip(many(&batch)) {
                    assert_eq!(
                        wanted[i],
                        bits(&found),
                        "{name}, point {i} of {:?} in batches of {size}",
                        points[i]
                    );
                }
            }
        }
    }
}

fn surface(name: &str, surface: &BsplineSurface, places: &[Vector3<f64>]) {
    let mut random = Random(4);
    let domain = surface.domain();
    let mut points = places.to_vec();
    for k in 0..60 {
        let foot = surface.point(domain[0].lerp(random.unit()), domain[1].lerp(random.unit()));
        // On the shape, near it, around it.
        let off = [0.0, 0.0, 1e-9, 1e-3, 0.3][k % 5];
        points.push(foot + random.vector::<3>(off));
    }
    let projector = SurfaceProjector::new(surface);
    for mode in [Mode::Certified, Mode::Fast] {
        let options = ProjectionOptions::default().with_mode(mode);
        check(
            &format!("{name} {mode:?}"),
            &points,
            |x| projector.project_with(x, &options).unwrap(),
            |points| projector.project_many(points, &options, &no_progress).unwrap(),
            surface_bits,
        );
    }
}

fn curve<const D: usize>(name: &str, curve: &BsplineCurve<D>, places: &[SVector<f64, D>]) {
    let mut random = Random(5);
    let mut points = places.to_vec();
    for k in 0..60 {
        let foot = curve.point(curve.domain().lerp(random.unit()));
        points.push(foot + random.vector::<D>([0.0, 0.0, 1e-9, 1e-3, 0.3][k % 5]));
    }
    let projector = CurveProjector::new(curve);
    for mode in [Mode::Certified, Mode::Fast] {
        let options = ProjectionOptions::default().with_mode(mode);
        check(
            &format!("{name} {mode:?}"),
            &points,
            |x| projector.project_with(x, &options).unwrap(),
            |points| projector.project_many(points, &options, &no_progress).unwrap(),
            curve_bits,
        );
    }
}

/// A bicubic surface over 7 x 7 control points, with weights between `1 / range` and `range`.
fn random_surface(seed: u64, range: f64) -> BsplineSurface {
    let mut random = Random(seed);
    let knots = KnotVector::uniform_clamped(3, 7).unwrap();
    let places = (0..7).flat_map(|i| (0..7).map(move |j| [f64::from(i) / 6.0, f64::from(j) / 6.0]));
    let points: Vec<_> = places.map(|[x, y]| Vector3::new(x, y, random.between(-0.2, 0.2))).collect();
    let weights = points.iter().map(|_| range.powf(random.between(-1.0, 1.0))).collect();
    BsplineSurface::new(knots.clone(), knots, points, (range > 1.0).then_some(weights)).unwrap()
}

#[test]
fn ordinary_surfaces() {
    surface("noise", &random_surface(1, 1.0), &[Vector3::repeat(f64::NAN), Vector3::new(0.5, 0.5, 9.0)]);
}

#[test]
fn unequal_weights() {
    surface("weights", &random_surface(2, 1e3), &[]);
}

#[test]
fn quadrics_and_their_axes() {
    let axis: Vec<_> = (-4..=4).map(|k| Vector3::new(0.0, 0.0, 0.5 * f64::from(k))).collect();
    surface("sphere", &Sphere::new(Frame::WORLD, 1.0).unwrap().to_nurbs().unwrap(), &axis);
    surface("torus", &Torus::new(Frame::WORLD, 2.0, 0.5).unwrap().to_nurbs().unwrap(), &axis);
    let heights = Interval::new(-1.0, 1.0).unwrap();
    surface("cylinder", &Cylinder::new(Frame::WORLD, 0.7, heights).unwrap().to_nurbs().unwrap(), &axis);
}

#[test]
fn collapsed_edges() {
    let knots = KnotVector::uniform_clamped(3, 7).unwrap();
    let place = |i: i32, j: i32| {
        let (angle, radius) = (0.9 * f64::from(i), f64::from(j) / 6.0);
        Vector3::new(radius * angle.cos(), radius * angle.sin(), (1.0 - radius).powi(2))
    };
    let points = (0..7).flat_map(|i| (0..7).map(move |j| place(i, j))).collect();
    let fan = BsplineSurface::new(knots.clone(), knots, points, None).unwrap();
    let near = |off: f64| Vector3::new(off, 0.5 * off, 1.0 - off);
    surface("fan", &fan, &[near(0.0), near(1e-12), near(1e-8), near(1e-4), near(1e-2), Vector3::zeros()]);
}

#[test]
fn curves() {
    let mut random = Random(6);
    let points = (0..9).map(|_| random.vector::<3>(1.0)).collect();
    curve(
        "space",
        &BsplineCurve::new(KnotVector::uniform_clamped(3, 9).unwrap(), points, None).unwrap(),
        &[],
    );
    let points: Vec<_> =
        (0..9).map(|k| Vector2::new(0.2 * f64::from(k), random.between(-0.3, 0.3))).collect();
    let weights = points.iter().map(|_| 1e3f64.powf(random.between(-1.0, 1.0))).collect();
    let knots = KnotVector::uniform_clamped(3, 9).unwrap();
    curve("weights", &BsplineCurve::new(knots, points, Some(weights)).unwrap(), &[]);
    let circle = Circle::new(Vector2::new(1.0, 2.0), 3.0).unwrap().to_nurbs().unwrap();
    curve(
        "circle",
        &circle,
        &[Vector2::new(1.0, 2.0), Vector2::new(1.0, 2.0 + 1e-9), Vector2::new(f64::NAN, 0.0)],
    );
}
