//! Control points and weights together: the extension to NURBS ([P05, sec. 4.1]).
//!
//! A rational curve is not linear in its unknowns; each step takes its derivatives by the control points `dᵢ` and by the
//! logarithms of the weights `wᵢ`, which stay positive: `∂c/∂dᵢ = Rᵢ`, `∂c/∂ln wᵢ = Rᵢ (dᵢ − c)` with the rational basis
//! functions `Rᵢ`.

use super::start::Layout;
use super::work::{State, Work};
use crate::options::{FitOptions, Smoothing};
use crate::rational::{LARGEST_CHANGE, LARGEST_LOGARITHM, LIMITS, SMALL_DECREASE, conic_knots};
use crate::{Error, Status};
use distance_field::{CurveField, DistanceField, ErrorTerm, PrincipalFrame, Search};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use nurbs_core::{BsplineCurve, MAX_DEGREE, ParametricCurve, basis};
use sdm_core::{Controller, Problem, StepControl, StepDirection, StepTaken, Stop, Trial, minimise};

/// Most unknowns of the dense system.
const UNKNOWNS: usize = 600;
/// Steps at most.
const STEPS: usize = 200;
/// Root mean square distance as a share of the size that is rounding.
const ROUNDING: f64 = 1e-15;
/// Share of the size below which a curve counts as exact.
const EXACT: f64 = 1e-9;
/// Numbers of conic arcs that are tried.
const ARCS: [usize; 4] = [1, 2, 3, 4];

/// The curve with weights: conic arcs if they are exact, otherwise the given curve with weights.
pub(super) fn with_weights<const D: usize>(
    work: &mut Work<'_, D>,
    state: State<D>,
    layout: Option<&Layout<D>>,
) -> Result<State<D>, Error> {
    if work.cancelled {
        return Ok(state);
    }
    if let Some(layout) = layout {
        // With a number of control points that is given as many arcs as it has room for, and knots that change nothing for the rest.
        let asked = work.options.controls;
        for arcs in ARCS.into_iter().filter(|&arcs| arcs > 1 || !layout.closed) {
            let controls = if layout.closed { 2 * arcs } else { 2 * arcs + 1 };
            if controls > work.points.len().min(asked.unwrap_or(work.options.max_controls)) {
                continue;
            }
            let start = layout.curve_on(conic_knots(arcs, layout.closed)?)?;
            let smoothing = Smoothing::Continuation { start: 1e-3, factor: 0.5, floor: 1e-6 };
            let fit = FitOptions { smoothing, ..work.loop_options() }.with_max_iterations(30);
            let first = work.run(start, &fit, "conic")?;
            let mut found = improved(work, first)?;
            work.note(&found, "weights");
            if found.report.rms <= EXACT * work.size {
                let more = asked.map_or(0, |n| n - controls);
                let domain = found.curve.domain();
                let knots: Vec<f64> =
                    (1..=more).map(|k| domain.lerp((k as f64 - 0.5) / more as f64 * 0.999)).collect();
                found.curve = found.curve.refine(&knots)?;
                work.keep(&found);
                return Ok(found);
            }
        }
    }
    if state.curve.knots().distinct_count() * (D + 1) > UNKNOWNS {
        return Ok(state);
    }
    let before = state.report.rms;
    let found = improved(work, state.clone())?;
    work.note(&found, "weights");
    if found.report.rms < before {
        work.keep(&found);
        return Ok(found);
    }
    Ok(state)
}

/// A state of the iteration.
struct Place<const D: usize> {
    curve: BsplineCurve<D>,
    frames: Vec<PrincipalFrame<D>>,
    /// Mean squared distance.
    cost: f64,
}

impl<const D: usize> Place<D> {
    fn new(curve: BsplineCurve<D>, points: &[SVector<f64, D>]) -> Result<Self, Error> {
        let frames = CurveField::new(&curve)?.frames(points, Search::Global, &[]);
        let cost = frames.iter().map(|f| f.distance * f.distance).sum::<f64>() / points.len() as f64;
        Ok(Self { curve, frames, cost })
    }
}

/// Levenberg and Marquardt with the tangent model of the distances.
fn improved<const D: usize>(work: &Work<'_, D>, mut state: State<D>) -> Result<State<D>, Error> {
    let place = Place::new(state.curve.clone(), work.points)?;
    let mut run = Run { points: work.points, size: work.size, place };
    let mut control = Controller::new(StepControl::LevenbergMarquardt, LIMITS);
    let status = match minimise(&mut run, &mut control, STEPS)? {
        // The cost falls strictly until rounding is all that is left of it.
        Status::Stalled => Status::Converged,
        status => status,
    };
    let place = run.place;
    let distances = place.frames.iter().map(|f| f.distance.abs());
    let (max_index, max) =
        distances.enumerate().fold((0, 0.0), |best, (i, d)| if d > best.1 { (i, d) } else { best });
    state.report.status = status;
    state.report.rms = place.cost.sqrt();
    (state.report.max, state.report.max_index) = (max, max_index);
    state.curve = place.curve;
    Ok(state)
}

/// The iteration in control points and weights.
struct Run<'a, const D: usize> {
    points: &'a [SVector<f64, D>],
    size: f64,
    place: Place<D>,
}

impl<const D: usize> Problem for Run<'_, D> {
    /// Matrix and half the negative gradient.
    type Linear = (DMatrix<f64>, DVector<f64>);
    type Step = DVector<f64>;
    type Trial = Place<D>;
    type Error = Error;

    fn linearise(&mut self) -> Result<Self::Linear, Stop<Error>> {
        if self.place.cost.sqrt() <= ROUNDING * self.size {
            return Err(Stop::Ended(Status::Converged));
        }
        Ok(system(&self.place, self.points))
    }

    fn cost(&self, _: &Self::Linear) -> f64 {
        self.place.cost
    }

    fn direction(
        &mut self,
        (matrix, vector): &Self::Linear,
        damping: f64,
    ) -> Result<StepDirection<Self::Step>, Stop<Error>> {
        let lift = damping * matrix.diagonal().mean();
        let mut damped = matrix.clone();
        for i in 0..damped.nrows() {
            damped[(i, i)] += lift;
        }
        let step = damped.cholesky().map(|factor| factor.solve(vector));
        Ok(step.map_or(StepDirection::Singular, |step| {
            let slope = -2.0 * vector.dot(&step);
            StepDirection::along(step, slope)
        }))
    }

    fn advance(
        &mut self,
        _: &Self::Linear,
        step: &Self::Step,
        factor: f64,
    ) -> Result<Option<Place<D>>, Stop<Error>> {
        let curve = moved(&self.place.curve, &(step * factor));
        Ok(curve.map(|curve| Place::new(curve, self.points)).transpose()?)
    }

    fn accept(&mut self, _: Self::Linear, trial: Place<D>, _: StepTaken) -> Result<(), Stop<Error>> {
        let still = self.place.cost - trial.cost <= SMALL_DECREASE * self.place.cost;
        self.place = trial;
        if still { Err(Stop::Ended(Status::Converged)) } else { Ok(()) }
    }
}

impl<const D: usize> Trial for Place<D> {
    fn cost(&self) -> f64 {
        self.cost
    }
}

/// Normal equations in the unknowns `(dᵢ, ln wᵢ)`, those of a control point together.
fn system<const D: usize>(place: &Place<D>, points: &[SVector<f64, D>]) -> (DMatrix<f64>, DVector<f64>) {
    let (curve, knots) = (&place.curve, place.curve.knots());
    let (p, n, width) = (knots.degree(), knots.distinct_count(), D + 1);
    let mut matrix = DMatrix::zeros(n * width, n * width);
    let mut vector = DVector::zeros(n * width);
    let mut row = [0.0; MAX_DEGREE + 1];
    for (x, frame) in points.iter().zip(&place.frames).filter(|(_, frame)| frame.is_finite()) {
        let t = knots.normalize(frame.hint.parameter[0]);
        let span = knots.span(t);
        basis::values(knots, span, t, &mut row);
        let total: f64 = (0..=p).map(|j| row[j] * curve.weight(span - p + j)).sum();
        let foot = curve.point_in_span(span, t);
        let model: SMatrix<f64, D, D> = ErrorTerm::Tangent.model(frame).matrix();
        let force = model * (x - foot);
        let parts: Vec<(usize, f64, SVector<f64, D>)> = (0..=p)
            .map(|j| {
                let i = span - p + j;
                let share = row[j] * curve.weight(i) / total;
                (i % n, share, (curve.control_points()[i] - foot) * share)
            })
            .collect();
        for &(i, share, lever) in &parts {
            for c in 0..D {
                vector[i * width + c] += share * force[c];
            }
            vector[i * width + D] += lever.dot(&force);
            let bent = model * lever;
            for &(k, other, far) in &parts {
                for a in 0..D {
                    for b in 0..D {
                        matrix[(i * width + a, k * width + b)] += share * other * model[(a, b)];
                    }
                    matrix[(i * width + D, k * width + a)] += other * bent[a];
                    matrix[(k * width + a, i * width + D)] += other * bent[a];
                }
                matrix[(i * width + D, k * width + D)] += bent.dot(&far);
            }
        }
    }
    (matrix, vector)
}

/// The curve after a step; `None` if it is none.
fn moved<const D: usize>(curve: &BsplineCurve<D>, step: &DVector<f64>) -> Option<BsplineCurve<D>> {
    let (knots, n, width) = (curve.knots(), curve.knots().distinct_count(), D + 1);
    let mut points = Vec::with_capacity(knots.basis_count());
    let mut logs = Vec::with_capacity(knots.basis_count());
    for i in 0..n {
        points.push(SVector::from_fn(|c, _| curve.control_points()[i][c] + step[i * width + c]));
        logs.push(curve.weight(i).ln() + step[i * width + D].clamp(-LARGEST_CHANGE, LARGEST_CHANGE));
    }
    // A common factor of the weights means nothing.
    let mean = logs.iter().sum::<f64>() / n as f64;
    let mut weights: Vec<f64> =
        logs.iter().map(|l| (l - mean).clamp(-LARGEST_LOGARITHM, LARGEST_LOGARITHM).exp()).collect();
    points.extend_from_within(..knots.basis_count() - n);
    weights.extend_from_within(..knots.basis_count() - n);
    BsplineCurve::new(knots.clone(), points, Some(weights)).ok()
}
