//! The shapes of the benchmarks and points around them.

use nurbs_core::nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Circle, Cylinder, Frame, Interval, KnotVector, ParametricCurve,
    ParametricSurface, Sphere, Torus,
};

/// Points per set.
pub(crate) const COUNT: usize = 64;

/// A name and points.
pub(crate) type Set<const D: usize> = (&'static str, Vec<SVector<f64, D>>);

/// A surface and where distances to it are degenerate: axes, centres, poles.
pub(crate) struct Shape {
    pub(crate) name: &'static str,
    pub(crate) surface: BsplineSurface,
    singular: Option<[Vector3<f64>; 2]>,
}

/// The fractional parts of multiples of an irrational number: spread evenly, in no order.
pub(crate) fn spread(i: usize, step: f64) -> f64 {
    (i as f64 * step).fract()
}

/// A wavy surface with `n` control points in each direction.
pub(crate) fn wavy(n: usize) -> BsplineSurface {
    let knots = KnotVector::uniform_clamped(3, n).expect("valid knots");
    let at = |k: usize| k as f64 / (n - 1) as f64;
    let net = (0..n * n)
        .map(|k| (at(k / n), at(k % n)))
        .map(|(x, y)| Vector3::new(x, y, 0.05 * (19.0 * x).sin() * (17.0 * y).cos()))
        .collect();
    BsplineSurface::new(knots.clone(), knots, net, None).expect("valid surface")
}

fn fixture(name: &str) -> Vec<u8> {
    let path = format!("{}/../../fixtures/footpoint-cases/{name}.json", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(path).expect("the fixture exists")
}

/// The kinds of surfaces that are measured.
pub(crate) fn surfaces() -> Vec<Shape> {
    let stored = |name: &str| serde_json::from_slice::<BsplineSurface>(&fixture(name)).expect("a surface");
    let axis = Some([Vector3::new(0.0, 0.0, -1.0), Vector3::new(0.0, 0.0, 1.0)]);
    let shape = |name, surface, singular| Shape { name, surface, singular };
    let torus = Torus::new(Frame::WORLD, 3.0, 1.0).and_then(|s| s.to_nurbs());
    let sphere = Sphere::new(Frame::WORLD, 1.0).and_then(|s| s.to_nurbs());
    let cylinder = Cylinder::new(Frame::WORLD, 1.0, Interval::UNIT).and_then(|s| s.to_nurbs());
    let collapsed = stored("s_degen");
    let [u, v] = collapsed.domain();
    let pole = [v.start(), v.lerp(1e-6)].map(|v| collapsed.point(u.midpoint(), v));
    vec![
        shape("example-3", stored("s_hw3"), None),
        shape("wavy-50x50", wavy(50), None),
        shape("torus", torus.expect("a torus"), axis),
        shape("sphere", sphere.expect("a sphere"), Some([Vector3::zeros(), Vector3::new(0.0, 0.0, 1e-9)])),
        shape("cylinder", cylinder.expect("a cylinder"), axis),
        shape("collapsed-edge", collapsed, Some(pole)),
    ]
}

pub(crate) fn cubic_2d() -> BsplineCurve<2> {
    serde_json::from_slice(&fixture("c_hw2")).expect("a curve")
}

/// Four turns of a helix, as a cubic B-spline curve.
pub(crate) fn helix() -> BsplineCurve<3> {
    let n = 32;
    let angle = |i: usize| i as f64 / (n - 1) as f64 * 8.0 * std::f64::consts::PI;
    let net = (0..n).map(|i| Vector3::new(angle(i).cos(), angle(i).sin(), 0.1 * angle(i))).collect();
    BsplineCurve::new(KnotVector::uniform_clamped(3, n).expect("valid knots"), net, None).expect("valid")
}

pub(crate) fn circle() -> BsplineCurve<2> {
    Circle::new(Vector2::zeros(), 1.0).and_then(|c| c.to_nurbs()).expect("a circle")
}

fn diagonal<const D: usize>(points: &[SVector<f64, D>]) -> f64 {
    let low = points.iter().fold(points[0], |a, p| a.inf(p));
    let high = points.iter().fold(points[0], |a, p| a.sup(p));
    (high - low).norm()
}

/// A unit vector, different for every `i`.
fn direction<const D: usize>(i: usize) -> SVector<f64, D> {
    let steps = [0.754_877_666, 0.569_840_291, 0.430_159_709];
    SVector::<f64, D>::from_fn(|d, _| spread(i + 7, steps[d % 3]) - 0.5).normalize()
}

/// Points at distances from feet of the shape: shares of its diagonal.
fn around<const D: usize>(size: f64, foot: impl Fn(usize) -> SVector<f64, D>) -> Vec<Set<D>> {
    let set = |name, low: f64, high: f64| {
        let share = |i: usize| low + (high - low) * spread(i, 0.381_966);
        (name, (0..COUNT).map(|i| foot(i) + direction::<D>(i) * (size * share(i))).collect())
    };
    vec![set("on", 0.0, 0.0), set("near", 1e-3, 0.01), set("mid", 0.05, 0.25), set("far", 1.5, 4.0)]
}

/// The parameters of the points of a set.
fn parameter(i: usize) -> [f64; 2] {
    [spread(i, 0.618_033_988_749_895), spread(i, 0.754_877_666_246_693)]
}

impl Shape {
    /// A point of the surface, in no order.
    pub(crate) fn parameters(&self, i: usize) -> [f64; 2] {
        let ([u, v], [a, b]) = (self.surface.domain(), parameter(i));
        [u.lerp(0.01 + 0.98 * a), v.lerp(0.01 + 0.98 * b)]
    }

    pub(crate) fn size(&self) -> f64 {
        diagonal(self.surface.control_points())
    }

    /// Sets of points on, near, beside and far from the surface, beyond its boundary, at centres and on axes.
    pub(crate) fn sets(&self) -> Vec<Set<3>> {
        let at = |i: usize| {
            let [u, v] = self.parameters(i);
            self.surface.point(u, v)
        };
        let mut sets = around(self.size(), at);
        if let Some([a, b]) = self.singular {
            sets.push(("singular", (0..COUNT).map(|i| a + (b - a) * parameter(i)[0]).collect()));
        } else {
            // Away from the middle of the surface, from points of its boundary.
            let [u, v] = self.surface.domain();
            let middle = self.surface.point(u.midpoint(), v.midpoint());
            let beyond = |i: usize| {
                let edge = self
                    .surface
                    .point(u.lerp(parameter(i)[0]), if i.is_multiple_of(2) { v.start() } else { v.end() });
                edge + (edge - middle) * (0.05 + 0.3 * parameter(i)[1])
            };
            sets.push(("beyond", (0..COUNT).map(beyond).collect()));
        }
        sets
    }
}

/// Sets of points on, near, beside and far from a curve, and at a centre if it has one.
pub(crate) fn curve_sets<const D: usize>(
    curve: &BsplineCurve<D>,
    centre: Option<SVector<f64, D>>,
) -> Vec<Set<D>> {
    let at = |i: usize| curve.point(curve.domain().lerp(parameter(i)[0]));
    let mut sets = around(diagonal(curve.control_points()), at);
    if let Some(centre) = centre {
        sets.push(("singular", vec![centre; COUNT]));
    }
    sets
}
