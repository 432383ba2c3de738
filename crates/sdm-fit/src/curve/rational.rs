//! Control points and weights together: the extension to NURBS ([P05, sec. 4.1]).
//!
//! A rational curve is not linear in its unknowns; each step takes its derivatives by the control points `dᵢ` and by the
//! logarithms of the weights `wᵢ`, which stay positive: `∂c/∂dᵢ = Rᵢ`, `∂c/∂ln wᵢ = Rᵢ (dᵢ − c)` with the rational basis
//! functions `Rᵢ`.

use super::start::Layout;
use super::work::{State, Work};
use crate::options::{FitOptions, Smoothing};
use crate::{Error, Status};
use distance_field::{CurveField, DistanceField, ErrorTerm, PrincipalFrame, Search};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use nurbs_core::{BsplineCurve, KnotVector, MAX_DEGREE, ParametricCurve, basis};

/// Most unknowns of the dense system.
const UNKNOWNS: usize = 600;
/// Steps at most.
const STEPS: usize = 200;
/// Damping: first, least and last, as a share of the mean of the diagonal.
const DAMPING: [f64; 3] = [1e-3, 1e-12, 1e6];
/// Largest change of the logarithm of a weight in a step, and of the weights from 1 in all.
const CHANGE: f64 = 0.7;
const RANGE: f64 = 6.0;
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

/// Knots of degree 2 whose pieces are joined without derivatives, so that each can be any arc of a conic.
fn conic_knots(arcs: usize, closed: bool) -> Result<KnotVector, Error> {
    let at = |k: isize| k as f64 / arcs as f64;
    let last = arcs.cast_signed();
    Ok(if closed {
        // Period 1; the domain starts with the second of two equal knots.
        let knots = (-1..=last + 1).flat_map(|k| [at(k), at(k)]).collect::<Vec<_>>();
        KnotVector::periodic(2, knots[1..].to_vec())?
    } else {
        let mut knots = vec![0.0];
        knots.extend((0..=last).flat_map(|k| [at(k), at(k)]));
        knots.push(1.0);
        KnotVector::new(2, knots)?
    })
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
    let mut place = Place::new(state.curve.clone(), work.points)?;
    let mut damping = DAMPING[0];
    let mut status = Status::MaxIterations;
    for _ in 0..STEPS {
        if place.cost.sqrt() <= 1e-15 * work.size {
            status = Status::Converged;
            break;
        }
        let (matrix, vector) = system(&place, work.points);
        let mean = matrix.diagonal().mean();
        let mut next = None;
        while damping <= DAMPING[2] {
            let mut damped = matrix.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] += damping * mean;
            }
            let step = damped.cholesky().map(|factor| factor.solve(&vector));
            if let Some(curve) = step.and_then(|step| moved(&place.curve, &step)) {
                let trial = Place::new(curve, work.points)?;
                if trial.cost < place.cost {
                    next = Some(trial);
                    break;
                }
            }
            damping *= 10.0;
        }
        let Some(trial) = next else {
            status = Status::Converged;
            break;
        };
        damping = (damping * 0.1).max(DAMPING[1]);
        let still = place.cost - trial.cost <= 1e-9 * place.cost;
        place = trial;
        if still {
            status = Status::Converged;
            break;
        }
    }
    let distances = place.frames.iter().map(|f| f.distance.abs());
    let (max_index, max) =
        distances.enumerate().fold((0, 0.0), |best, (i, d)| if d > best.1 { (i, d) } else { best });
    state.report.status = status;
    state.report.rms = place.cost.sqrt();
    (state.report.max, state.report.max_index) = (max, max_index);
    state.curve = place.curve;
    Ok(state)
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
        logs.push(curve.weight(i).ln() + step[i * width + D].clamp(-CHANGE, CHANGE));
    }
    // A common factor of the weights means nothing.
    let mean = logs.iter().sum::<f64>() / n as f64;
    let mut weights: Vec<f64> = logs.iter().map(|l| (l - mean).clamp(-RANGE, RANGE).exp()).collect();
    points.extend_from_within(..knots.basis_count() - n);
    weights.extend_from_within(..knots.basis_count() - n);
    BsplineCurve::new(knots.clone(), points, Some(weights)).ok()
}
