//! What is measured: a curve or a surface, made alike.

use super::random::Random;
use footpoint::local::{LocalOptions, iterate_curve, iterate_surface, project_curve, project_surface};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, ParametricCurve, ParametricSurface};

/// A shape over `[0, 1]` or `[0, 1]²` with its iterations.
pub(crate) trait Subject {
    type Point: Copy;
    type Parameter: Copy;

    /// A parameter at least `margin` inside the domain.
    fn parameter(&self, random: &mut Random, margin: f64) -> Self::Parameter;

    /// The parameter moved by `length` in a random direction.
    fn beside(&self, parameter: Self::Parameter, length: f64, random: &mut Random) -> Self::Parameter;

    /// The point at `distance` (a share of the size, with a sign) along the normal at a parameter, if that
    /// parameter then is a strict local minimum of the distance.
    fn above(&self, parameter: Self::Parameter, distance: f64) -> Option<Self::Point>;

    /// A point of the bounding box enlarged to twice its size.
    fn anywhere(&self, random: &mut Random) -> Self::Point;

    /// Errors against `exact` before each of the first steps of the bare iteration.
    fn errors(
        &self,
        x: Self::Point,
        start: Self::Parameter,
        exact: Self::Parameter,
        options: &LocalOptions,
    ) -> Vec<f64>;

    /// Steps of the bare iteration if it reaches a footpoint inside the domain.
    fn bare(&self, x: Self::Point, start: Self::Parameter, options: &LocalOptions) -> Option<u32>;

    /// Steps of the safeguarded iteration if it reaches a footpoint.
    fn safeguarded(&self, x: Self::Point, start: Self::Parameter, options: &LocalOptions) -> Option<u32>;
}

/// Smallest `1 − κd` of a test point: closer to the centre of curvature every method is slow.
const CLEAR_OF_CENTRE: f64 = 0.2;

/// Lower corner and diagonal of the bounding box of control points.
fn frame<const D: usize>(points: &[nalgebra::SVector<f64, D>]) -> [nalgebra::SVector<f64, D>; 2] {
    let mut low = nalgebra::SVector::<f64, D>::repeat(f64::INFINITY);
    let mut high = -low;
    for p in points {
        low = low.inf(p);
        high = high.sup(p);
    }
    [low, high - low]
}

fn steps(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

pub(crate) struct CurveSubject {
    curve: BsplineCurve<2>,
    low: Vector2<f64>,
    extent: Vector2<f64>,
}

impl CurveSubject {
    pub(crate) fn new(curve: BsplineCurve<2>) -> Self {
        let [low, extent] = frame(curve.control_points());
        Self { curve, low, extent }
    }
}

impl Subject for CurveSubject {
    type Point = Vector2<f64>;
    type Parameter = f64;

    fn parameter(&self, random: &mut Random, margin: f64) -> f64 {
        random.between(margin, 1.0 - margin)
    }

    fn beside(&self, t: f64, length: f64, random: &mut Random) -> f64 {
        if random.between(0.0, 1.0) < 0.5 { t - length } else { t + length }
    }

    fn above(&self, t: f64, distance: f64) -> Option<Vector2<f64>> {
        let jet = self.curve.jet(t);
        let normal = Vector2::new(-jet.d1.y, jet.d1.x).normalize();
        let offset = normal * (distance * self.extent.norm());
        let factor = 1.0 - offset.dot(&jet.d2) / jet.d1.norm_squared();
        (factor > CLEAR_OF_CENTRE).then(|| jet.point + offset)
    }

    fn anywhere(&self, random: &mut Random) -> Vector2<f64> {
        self.low + self.extent.map(|e| e * random.between(-0.5, 1.5))
    }

    fn errors(&self, x: Vector2<f64>, start: f64, exact: f64, options: &LocalOptions) -> Vec<f64> {
        let trace = iterate_curve(&self.curve, &x, start, options);
        trace.steps.iter().map(|s| (s.parameter - exact).abs()).collect()
    }

    fn bare(&self, x: Vector2<f64>, start: f64, options: &LocalOptions) -> Option<u32> {
        let trace = iterate_curve(&self.curve, &x, start, options);
        let reached = trace.status.is_converged() && (0.0..=1.0).contains(&trace.parameter);
        reached.then(|| steps(trace.steps.len()))
    }

    fn safeguarded(&self, x: Vector2<f64>, start: f64, options: &LocalOptions) -> Option<u32> {
        let foot = project_curve(&self.curve, &x, start, options);
        foot.status.is_converged().then_some(foot.iterations)
    }
}

pub(crate) struct SurfaceSubject {
    surface: BsplineSurface,
    low: Vector3<f64>,
    extent: Vector3<f64>,
}

impl SurfaceSubject {
    pub(crate) fn new(surface: BsplineSurface) -> Self {
        let [low, extent] = frame(surface.control_points());
        Self { surface, low, extent }
    }
}

impl Subject for SurfaceSubject {
    type Point = Vector3<f64>;
    type Parameter = [f64; 2];

    fn parameter(&self, random: &mut Random, margin: f64) -> [f64; 2] {
        let u = random.between(margin, 1.0 - margin);
        [u, random.between(margin, 1.0 - margin)]
    }

    fn beside(&self, [u, v]: [f64; 2], length: f64, random: &mut Random) -> [f64; 2] {
        let (s, c) = random.between(0.0, std::f64::consts::TAU).sin_cos();
        [u + length * c, v + length * s]
    }

    fn above(&self, [u, v]: [f64; 2], distance: f64) -> Option<Vector3<f64>> {
        let jet = self.surface.jet(u, v);
        let offset = jet.normal_direction().normalize() * (distance * self.extent.norm());
        let [e, f, g] = [jet.du.norm_squared(), jet.du.dot(&jet.dv), jet.dv.norm_squared()];
        let (a, b, c) = (e - offset.dot(&jet.duu), f - offset.dot(&jet.duv), g - offset.dot(&jet.dvv));
        // Product of both 1 − κd, and their sum.
        let (product, sum) =
            ((a * c - b * b) / (e * g - f * f), (a * g - 2.0 * b * f + c * e) / (e * g - f * f));
        let smaller = 0.5 * sum - (0.25 * sum * sum - product).max(0.0).sqrt();
        (smaller > CLEAR_OF_CENTRE).then(|| jet.point + offset)
    }

    fn anywhere(&self, random: &mut Random) -> Vector3<f64> {
        self.low + self.extent.map(|e| e * random.between(-0.5, 1.5))
    }

    fn errors(&self, x: Vector3<f64>, start: [f64; 2], exact: [f64; 2], options: &LocalOptions) -> Vec<f64> {
        let trace = iterate_surface(&self.surface, &x, start, options);
        let error = |p: [f64; 2]| f64::hypot(p[0] - exact[0], p[1] - exact[1]);
        trace.steps.iter().map(|s| error(s.parameter)).collect()
    }

    fn bare(&self, x: Vector3<f64>, start: [f64; 2], options: &LocalOptions) -> Option<u32> {
        let trace = iterate_surface(&self.surface, &x, start, options);
        let inside = trace.parameter.iter().all(|t| (0.0..=1.0).contains(t));
        (trace.status.is_converged() && inside).then(|| steps(trace.steps.len()))
    }

    fn safeguarded(&self, x: Vector3<f64>, start: [f64; 2], options: &LocalOptions) -> Option<u32> {
        let foot = project_surface(&self.surface, &x, start, options);
        foot.status.is_converged().then_some(foot.iterations)
    }
}
