//! Iterations without bounds or safeguards, every step recorded.

use super::LocalOptions;
use super::options::residual_noise;
use super::step::{CurveResidual, TangentPlane, surface_tangent};
use crate::Status;
use crate::local::step::Tangent;
use nalgebra::{SVector, Vector3};
use nurbs_core::{ParametricCurve, ParametricSurface, SurfaceJet};

/// One step of an iteration on a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveStep {
    /// The parameter before the step.
    pub parameter: f64,
    /// The increment `Δt`.
    pub delta: f64,
    /// Distance of the test point before the step.
    pub distance: f64,
    /// Deviation from 90° of the angle between residual and tangent before the step, in radians.
    pub angle: f64,
}

/// The history of an iteration on a curve and where it ended.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveTrace<const D: usize> {
    /// The steps, in order.
    pub steps: Vec<CurveStep>,
    /// Last parameter, possibly outside the domain.
    pub parameter: f64,
    /// The curve (or its continuation) there.
    pub point: SVector<f64, D>,
    /// Distance of the test point from it.
    pub distance: f64,
    /// `Converged` if the residual is normal at the end.
    pub status: Status,
}

/// One step of an iteration on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SurfaceStep {
    /// The parameters before the step.
    pub parameter: [f64; 2],
    /// The increments `(Δu, Δv)`.
    pub delta: [f64; 2],
    /// Distance of the test point before the step.
    pub distance: f64,
    /// Angle between residual and normal before the step, in radians.
    pub angle: f64,
}

/// The history of an iteration on a surface and where it ended.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTrace {
    /// The steps, in order.
    pub steps: Vec<SurfaceStep>,
    /// Last parameters, possibly outside the domain.
    pub parameter: [f64; 2],
    /// The surface (or its continuation) there.
    pub point: Vector3<f64>,
    /// Distance of the test point from it.
    pub distance: f64,
    /// `Converged` if the residual is normal at the end.
    pub status: Status,
}

/// Repeats the step of `options.method` from `start` until the parameter or angle rule holds.
///
/// Nothing is clamped, wrapped or damped: outside the domain the end pieces continue, and the method may
/// diverge ([`Status::Diverged`]) or end where the optimality condition does not hold
/// ([`Status::Stalled`]). To get a footpoint use [`project_curve`](super::project_curve).
///
/// ```
/// use footpoint::local::{LocalOptions, Method, iterate_curve};
/// use nurbs_core::{CurveFn, CurveJet, Interval, nalgebra::Vector2};
///
/// let sine = CurveFn::new(Interval::new(0.0, 6.5)?, |t: f64| CurveJet {
///     point: Vector2::new(t, t.sin()),
///     d1: Vector2::new(1.0, t.cos()),
///     d2: Vector2::new(0.0, -t.sin()),
/// });
/// let options = LocalOptions::default().with_method(Method::SecondOrderTaylor);
/// let trace = iterate_curve(&sine, &Vector2::new(1.0, 0.8), 0.898, &options);
/// assert!(trace.status.is_converged());
/// assert!((trace.parameter - 0.982347293153578).abs() < 1e-12);
/// # Ok::<(), nurbs_core::Error>(())
/// ```
pub fn iterate_curve<const D: usize, C: ParametricCurve<D> + ?Sized>(
    curve: &C,
    x: &SVector<f64, D>,
    start: f64,
    options: &LocalOptions,
) -> CurveTrace<D> {
    let tolerance = options.parameter_tolerance * curve.domain().length();
    let mut trace = CurveTrace {
        steps: Vec::new(),
        parameter: start,
        point: SVector::repeat(f64::NAN),
        distance: f64::NAN,
        status: Status::InvalidPoint,
    };
    if !x.iter().all(|c| c.is_finite()) {
        return trace;
    }
    let mut small = false;
    loop {
        let jet = curve.jet(trace.parameter);
        trace.point = jet.point;
        trace.distance = (x - jet.point).norm();
        if !trace.distance.is_finite() || !trace.parameter.is_finite() {
            trace.status = Status::Diverged;
            return trace;
        }
        let noise = residual_noise(x.norm() + jet.point.norm());
        let Some(residual) = CurveResidual::new(&jet, x) else {
            trace.status = Status::Stalled;
            return trace;
        };
        let tangential = residual.tangential.abs();
        if small || options.angle_stops(tangential, trace.distance) {
            trace.status = exit_status(options, tangential, trace.distance, noise, Status::Stalled);
            return trace;
        }
        let step = options.method.curve_step(&jet, x);
        let (Some(delta), true) = (step, trace.steps.len() < options.max_iterations as usize) else {
            trace.status = exit_status(options, tangential, trace.distance, noise, Status::MaxIterations);
            return trace;
        };
        let angle = angle(tangential, trace.distance);
        trace.steps.push(CurveStep { parameter: trace.parameter, delta, distance: trace.distance, angle });
        trace.parameter += delta;
        small = delta.abs() <= tolerance;
    }
}

/// Repeats the step of `options.method` from `start` until the parameter or angle rule holds.
///
/// As [`iterate_curve`]: nothing is clamped, wrapped or damped. To get a footpoint use
/// [`project_surface`](super::project_surface).
pub fn iterate_surface<S: ParametricSurface + ?Sized>(
    surface: &S,
    x: &Vector3<f64>,
    start: [f64; 2],
    options: &LocalOptions,
) -> SurfaceTrace {
    let tolerance = surface.domain().map(|d| d.length() * options.parameter_tolerance);
    let mut trace = SurfaceTrace {
        steps: Vec::new(),
        parameter: start,
        point: Vector3::repeat(f64::NAN),
        distance: f64::NAN,
        status: Status::InvalidPoint,
    };
    if !x.iter().all(|c| c.is_finite()) {
        return trace;
    }
    let mut small = false;
    loop {
        let [u, v] = trace.parameter;
        let jet = surface.jet(u, v);
        trace.point = jet.point;
        trace.distance = (x - jet.point).norm();
        if !(trace.distance.is_finite() && u.is_finite() && v.is_finite()) {
            trace.status = Status::Diverged;
            return trace;
        }
        let noise = residual_noise(x.norm() + jet.point.norm());
        let tangential = match surface_tangent(&jet) {
            Tangent::Plane(plane) => tangential_length(&plane, &jet, x),
            _ => f64::INFINITY,
        };
        if small || options.angle_stops(tangential, trace.distance) {
            trace.status = exit_status(options, tangential, trace.distance, noise, Status::Stalled);
            return trace;
        }
        let Some(delta) = options.method.surface_step(&jet, x) else {
            trace.status = Status::Stalled;
            return trace;
        };
        if trace.steps.len() >= options.max_iterations as usize {
            trace.status = exit_status(options, tangential, trace.distance, noise, Status::MaxIterations);
            return trace;
        }
        let angle = angle(tangential, trace.distance);
        trace.steps.push(SurfaceStep { parameter: [u, v], delta, distance: trace.distance, angle });
        trace.parameter = [u + delta[0], v + delta[1]];
        small = delta[0].abs() <= tolerance[0] && delta[1].abs() <= tolerance[1];
    }
}

/// Length of the tangential part of `x − s`.
fn tangential_length(plane: &TangentPlane, jet: &SurfaceJet, x: &Vector3<f64>) -> f64 {
    let w = x - jet.point;
    (w - plane.normal * w.dot(&plane.normal)).norm()
}

fn angle(tangential: f64, distance: f64) -> f64 {
    if distance > 0.0 { (tangential / distance).min(1.0).asin() } else { 0.0 }
}

fn exit_status(options: &LocalOptions, tangential: f64, distance: f64, noise: f64, other: Status) -> Status {
    if options.accepts(tangential, distance, noise) { Status::Converged } else { other }
}
