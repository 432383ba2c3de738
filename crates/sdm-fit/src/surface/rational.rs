//! Control points and weights together: the extension to NURBS ([P05, sec. 4.1]).
//!
//! As for curves, each step takes the derivatives by the control points `dᵢ` and the logarithms of the weights `wᵢ`, which stay
//! positive: `∂s/∂dᵢ = Rᵢ`, `∂s/∂ln wᵢ = Rᵢ (dᵢ − s)` with the rational basis functions `Rᵢ`.

use super::active::unknowns_of;
use super::base::choose;
use super::initial::{BaseShape, approximate};
use crate::assemble::add_products;
use crate::freedom::Freedom;
use crate::iterate::Progress;
use crate::layout::{Blocks, Layout, triangle};
use crate::primitive::{PrimitiveOptions, fit_cone, fit_cylinder, fit_torus};
use crate::shape::CellTable;
use crate::simd::vectorized;
use crate::{Error, FitReport, Status, StepRecord, parallel};
use distance_field::{DistanceField, Hint, PrincipalFrame, Search, SurfaceField};
use nalgebra::{SVector, Vector3};
use nurbs_core::{BsplineSurface, Cylinder, Interval, KnotVector, MAX_DEGREE, basis};
use std::f64::consts::FRAC_1_SQRT_2;

/// Steps at most.
const STEPS: usize = 100;
/// Damping: first, least and last, as a share of the mean of the diagonal.
const DAMPING: [f64; 3] = [1e-3, 1e-12, 1e6];
/// Largest change of the logarithm of a weight in a step, and of the weights from 1 in all.
const CHANGE: f64 = 0.7;
const RANGE: f64 = 6.0;
/// Share of the size below which a surface counts as exact, and is not improved further.
pub(super) const EXACT: f64 = 1e-9;
const ROUNDING: f64 = 1e-13;
const EXACTLY: f64 = 1e-11;
/// Share of an open direction by which a start reaches beyond the points.
const MARGIN: f64 = 0.05;
/// Arcs of which a full turn is made.
const ARCS: usize = 4;

/// A state of the iteration.
#[derive(Clone, Debug)]
pub(super) struct Weighted {
    pub(super) surface: BsplineSurface,
    pub(super) frames: Vec<PrincipalFrame<3>>,
    /// Mean squared distance.
    cost: f64,
}

impl Weighted {
    fn new(surface: BsplineSurface, points: &[Vector3<f64>], hints: &[Hint]) -> Result<Self, Error> {
        let search = if hints.is_empty() { Search::Global } else { Search::Local };
        let frames = SurfaceField::new(&surface)?.frames(points, search, hints);
        let used = frames.iter().filter(|f| f.is_finite());
        let cost = used.map(|f| f.distance * f.distance).sum::<f64>() / points.len().max(1) as f64;
        Ok(Self { surface, frames, cost })
    }

    /// Root mean square distance.
    pub(super) fn rms(&self) -> f64 {
        self.cost.sqrt()
    }

    fn hints(&self) -> Vec<Hint> {
        self.frames.iter().map(|frame| frame.hint).collect()
    }

    /// What the report of the loop says, for this state.
    pub(super) fn report(
        &self,
        before: Option<FitReport>,
        status: Status,
        steps: Vec<StepRecord>,
    ) -> FitReport {
        let distances = self.frames.iter().map(|f| f.distance.abs()).enumerate();
        let (max_index, max) =
            distances.fold((0, 0.0), |best, (i, d)| if d > best.1 { (i, d) } else { best });
        let mut history = before.as_ref().map_or_else(Vec::new, |report| report.history.clone());
        history.extend(steps);
        (1..).zip(&mut history).for_each(|(number, step)| step.iteration = number);
        FitReport {
            status,
            initial_rms: before.map_or_else(|| history.first().map_or(0.0, |s| s.rms), |b| b.initial_rms),
            rms: self.cost.sqrt(),
            max,
            max_index,
            lambda: 0.0,
            samples: self.frames.len(),
            used: self.frames.iter().filter(|f| f.is_finite()).count(),
            history,
        }
    }
}

/// Levenberg and Marquardt with the tangent model of the distances, from a surface with or without weights.
pub(super) fn improved(
    points: &[Vector3<f64>],
    surface: BsplineSurface,
    progress: Progress<'_>,
) -> Result<(Weighted, Status, Vec<StepRecord>), Error> {
    let size = points.iter().map(|p| p.amax()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut place = Weighted::new(surface, points, &[])?;
    let unknowns = Unknowns::new(&place.surface);
    let mut layout = Layout::new(&unknowns.cells, unknowns.count);
    let (mut damping, mut status) = (DAMPING[0], Status::MaxIterations);
    let mut steps: Vec<StepRecord> = Vec::new();
    while steps.len() < STEPS {
        if place.cost.sqrt() <= ROUNDING * size {
            status = Status::Converged;
            break;
        }
        let (matrix, vector) = unknowns.system(&layout, &place, points);
        let mean = layout.mean_diagonal::<1>(&matrix);
        let nothing = layout.zeros(1);
        let mut next = None;
        while damping <= DAMPING[2] {
            let factor = layout.factor::<1>(&matrix, (0.0, &nothing), damping * mean, &Freedom::full());
            let step = factor.and_then(|factor| factor.solve(&vector));
            if let Some((surface, moved)) = step.and_then(|step| unknowns.moved(&place.surface, &step)) {
                let trial = Weighted::new(surface, points, &place.hints())?;
                if trial.cost < place.cost {
                    next = Some((trial, moved));
                    break;
                }
            }
            damping *= 10.0;
        }
        let Some((trial, moved)) = next else {
            status = Status::Converged;
            break;
        };
        let record = StepRecord {
            iteration: steps.len() + 1,
            lambda: 0.0,
            rms: trial.cost.sqrt(),
            max: trial.frames.iter().map(|f| f.distance.abs()).fold(0.0, f64::max),
            cost: trial.cost,
            displacement: moved / size,
            factor: 1.0,
            damping,
            evaluations: 1,
            samples: points.len(),
            coefficients: unknowns.weight_count(),
            lifted: false,
        };
        steps.push(record);
        let still = place.cost - trial.cost <= 1e-9 * place.cost;
        place = trial;
        if progress(&record).is_break() {
            status = Status::Cancelled;
            break;
        }
        if still {
            status = Status::Converged;
            break;
        }
        damping = (damping * 0.1).max(DAMPING[1]);
    }
    // Rounding keeps on changing the last digits.
    if status == Status::MaxIterations && place.cost.sqrt() <= EXACTLY * size {
        status = Status::Converged;
    }
    // The feet that were followed are the nearest ones, or this tells.
    let found = Weighted::new(place.surface, points, &[])?;
    Ok((found, status, steps))
}

/// Where the unknowns stand: coordinates of control points first, logarithms of weights behind them.
struct Unknowns {
    /// Number of the point of each control point, which repetitions and poles share, and of its weight, which poles do not.
    points: Vec<usize>,
    weights: Vec<usize>,
    point_count: usize,
    count: usize,
    /// The unknowns of each cell: three coordinates and the weight of one control point after the other.
    cells: CellTable,
    spans: [Vec<usize>; 2],
}

impl Unknowns {
    fn new(surface: &BsplineSurface) -> Self {
        let (points, point_count) = unknowns_of(surface);
        let (d_u, d_v) = (surface.knots_u().distinct_count(), surface.knots_v().distinct_count());
        let n_v = surface.n_v();
        let weights: Vec<usize> = (0..points.len()).map(|k| (k / n_v % d_u) * d_v + k % n_v % d_v).collect();
        let spans = [surface.knots_u(), surface.knots_v()].map(|k| k.spans().collect::<Vec<_>>());
        let controls = |u: usize, v: usize| controls_of(surface, u, v);
        let mut table = Vec::new();
        for &u in &spans[0] {
            for &v in &spans[1] {
                let of = |k: usize| {
                    let p = 3 * points[k];
                    [p, p + 1, p + 2, 3 * point_count + weights[k]]
                };
                table.push(controls(u, v).flat_map(of).collect::<Vec<_>>());
            }
        }
        let count = 3 * point_count + d_u * d_v;
        Self { points, weights, point_count, count, cells: CellTable::new(table), spans }
    }

    fn weight_count(&self) -> usize {
        self.count - 3 * self.point_count
    }

    /// Normal equations of the mean squared distance.
    fn system(
        &self,
        layout: &Layout,
        place: &Weighted,
        points: &[Vector3<f64>],
    ) -> (Blocks, Vec<SVector<f64, 1>>) {
        let surface = &place.surface;
        let knots = [surface.knots_u(), surface.knots_v()];
        let mut members = vec![Vec::new(); self.cells.len()];
        for (i, frame) in place.frames.iter().enumerate().filter(|(_, frame)| frame.is_finite()) {
            let [u, v] = [0, 1].map(|d| {
                let span = knots[d].span(knots[d].normalize(frame.hint.parameter[d]));
                self.spans[d].partition_point(|&s| s < span).min(self.spans[d].len() - 1)
            });
            members[u * self.spans[1].len() + v].push(i);
        }
        let share = 1.0 / points.len().max(1) as f64;
        let sums = parallel::tasks(self.cells.len(), |cell| {
            let width = self.cells.columns(cell).len();
            let (mut pairs, mut products) = (vec![0.0; triangle(width)], vec![0.0; triangle(width)]);
            let (mut vector, mut form) = (vec![0.0; width], vec![0.0; width]);
            let spans = [cell / self.spans[1].len(), cell % self.spans[1].len()];
            let spans = [0, 1].map(|d| self.spans[d][spans[d]]);
            for &i in &members[cell] {
                let frame = &place.frames[i];
                let levers = levers(surface, spans, frame.hint.parameter);
                // The directions in which the foot cannot move.
                for axis in frame.axes.column_iter().skip(frame.tangent_dimension) {
                    for (slot, (value, lever)) in form.chunks_exact_mut(4).zip(&levers) {
                        for c in 0..3 {
                            slot[c] = value * axis[c];
                        }
                        slot[3] = lever.dot(&axis);
                    }
                    let residual = (points[i] - frame.foot).dot(&axis) * share;
                    vector.iter_mut().zip(&form).for_each(|(v, f)| *v += f * residual);
                    vectorized(
                        #[inline(always)]
                        || add_products(&form, &[share], &mut products, &mut pairs),
                    );
                }
            }
            (pairs, vector)
        });
        let mut matrix = layout.zeros(1);
        let mut vector = vec![SVector::<f64, 1>::zeros(); self.count];
        for (cell, (pairs, part)) in sums.iter().enumerate() {
            if members[cell].is_empty() {
                continue;
            }
            layout.scatter(&self.cells, cell, pairs, &mut matrix);
            for (&column, value) in self.cells.columns(cell).iter().zip(part) {
                vector[column].x += value;
            }
        }
        (matrix, vector)
    }

    /// The surface after a step and the longest way of a control point; `None` if it is none.
    fn moved(&self, surface: &BsplineSurface, step: &[SVector<f64, 1>]) -> Option<(BsplineSurface, f64)> {
        let (n_v, mut longest) = (surface.n_v(), 0.0f64);
        let mut net = Vec::with_capacity(self.points.len());
        let mut logs = vec![0.0; self.weight_count()];
        for (k, (&point, &weight)) in self.points.iter().zip(&self.weights).enumerate() {
            let way = Vector3::from_fn(|c, _| step[3 * point + c].x);
            longest = longest.max(way.norm());
            net.push(surface.control_points()[k] + way);
            let change = step[3 * self.point_count + weight].x.clamp(-CHANGE, CHANGE);
            logs[weight] = surface.weight(k / n_v, k % n_v).ln() + change;
        }
        // A common factor of the weights means nothing.
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let weights = self.weights.iter().map(|&w| (logs[w] - mean).clamp(-RANGE, RANGE).exp()).collect();
        let (u, v) = (surface.knots_u().clone(), surface.knots_v().clone());
        Some((BsplineSurface::new(u, v, net, Some(weights)).ok()?, longest))
    }
}

/// The control points that act on the cell of two spans.
fn controls_of(surface: &BsplineSurface, span_u: usize, span_v: usize) -> impl Iterator<Item = usize> {
    let (p, q, n_v) = (surface.degree_u(), surface.degree_v(), surface.n_v());
    (span_u - p..=span_u).flat_map(move |i| (span_v - q..=span_v).map(move |j| i * n_v + j))
}

/// `Rᵢ` and `Rᵢ (dᵢ − s)` of the control points that act at a parameter.
fn levers(surface: &BsplineSurface, spans: [usize; 2], parameter: [f64; 2]) -> Vec<(f64, Vector3<f64>)> {
    let knots = [surface.knots_u(), surface.knots_v()];
    let mut rows = [[0.0; MAX_DEGREE + 1]; 2];
    for d in 0..2 {
        basis::values(knots[d], spans[d], knots[d].normalize(parameter[d]), &mut rows[d]);
    }
    let (width, n_v) = (surface.degree_v() + 1, surface.n_v());
    let mut out: Vec<(f64, Vector3<f64>)> = controls_of(surface, spans[0], spans[1])
        .enumerate()
        .map(|(at, k)| {
            let value = rows[0][at / width] * rows[1][at % width] * surface.weight(k / n_v, k % n_v);
            (value, surface.control_points()[k])
        })
        .collect();
    let total: f64 = out.iter().map(|(value, _)| value).sum();
    let point = out.iter().map(|(value, d)| d * (value / total)).sum::<Vector3<f64>>();
    for (value, d) in &mut out {
        *value /= total;
        *d = (*d - point) * *value;
    }
    out
}

/// Surfaces to start from on which quadrics and tori can be exact: degree 2 with double knots around, and along them straight
/// lines, one arc, or two.
pub(super) fn conic_starts(points: &[Vector3<f64>], asked: BaseShape) -> Result<Vec<BsplineSurface>, Error> {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let local: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
    let mut base = choose(&local, asked)?;
    // The starts reach beyond the points where they are open: points at an edge that gives way hold up the convergence.
    let open = match base.shape {
        BaseShape::Plane | BaseShape::Auto => [true, true],
        BaseShape::Cylinder => [false, true],
        BaseShape::Sphere | BaseShape::Torus => [false, false],
    };
    for parameter in &mut base.parameters {
        for d in (0..2).filter(|&d| open[d]) {
            parameter[d] = MARGIN + (1.0 - 2.0 * MARGIN) * parameter[d];
        }
    }
    let candidates = match base.shape {
        BaseShape::Cylinder => vec![[closed_arcs()?, line()?], [closed_arcs()?, arcs(1)?]],
        BaseShape::Sphere => vec![[closed_arcs()?, arcs(2)?]],
        BaseShape::Torus => Vec::new(),
        BaseShape::Plane | BaseShape::Auto => vec![[arcs(1)?, arcs(1)?]],
    };
    // From a net with kinks the way to a cylinder or torus can be long, and least squares ones are at hand.
    let mut starts: Vec<BsplineSurface> = Vec::new();
    for primitive in primitives(&local, base.shape) {
        starts.push(primitive.translated(&middle)?);
    }
    let start = |knots: [KnotVector; 2]| -> Result<BsplineSurface, Error> {
        Ok(with_arc_weights(approximate(&local, &base, knots)?)?.translated(&middle)?)
    };
    for knots in candidates {
        starts.push(start(knots)?);
    }
    Ok(starts)
}

/// The least squares cylinder (a little longer than the points) and cone, or torus.
fn primitives(points: &[Vector3<f64>], shape: BaseShape) -> Vec<BsplineSurface> {
    let options = PrimitiveOptions::default();
    let cylinder = || {
        let found = fit_cylinder(points, &options).ok()?;
        let cylinder = found.shape;
        let heights = points.iter().map(|p| cylinder.frame().local(p).z);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        let margin = MARGIN * (high - low);
        let heights = Interval::new(low - margin, high + margin).ok()?;
        let surface = Cylinder::new(*cylinder.frame(), cylinder.radius(), heights).ok()?.to_nurbs().ok()?;
        Some((found.rms, surface))
    };
    let cone = || {
        let found = fit_cone(points, &options).ok()?;
        Some((found.rms, found.shape.to_nurbs().ok()?))
    };
    let torus = || fit_torus(points, &options).ok()?.shape.to_nurbs().ok();
    match shape {
        BaseShape::Torus => torus().into_iter().collect(),
        BaseShape::Cylinder => {
            // A cylinder is a cone, too: only one that is nearer comes first, since its ends are straight.
            let size = points.iter().map(|p| p.amax()).fold(0.0, f64::max);
            let mut found: Vec<(f64, BsplineSurface)> = [cylinder(), cone()].into_iter().flatten().collect();
            if let [(first, _), (second, _)] = found[..]
                && first > EXACT * size
                && second < first
            {
                found.reverse();
            }
            found.into_iter().map(|(_, surface)| surface).collect()
        }
        BaseShape::Plane | BaseShape::Sphere | BaseShape::Auto => Vec::new(),
    }
}

/// The surface with the weights of circles where knots are those of several arcs: every second control point lies between the
/// ends of an arc of a quarter turn.
fn with_arc_weights(surface: BsplineSurface) -> Result<BsplineSurface, Error> {
    let [along_u, along_v] = [surface.knots_u(), surface.knots_v()].map(|knots| {
        let quarters = knots.degree() == 2 && knots.spans().count() > 1;
        let weight = |i: usize| if quarters && i % 2 == 1 { FRAC_1_SQRT_2 } else { 1.0 };
        (0..knots.basis_count()).map(weight).collect::<Vec<_>>()
    });
    let (u, v, net, _) = surface.into_parts();
    let weights = along_u.iter().flat_map(|a| along_v.iter().map(move |b| a * b)).collect();
    Ok(BsplineSurface::new(u, v, net, Some(weights))?)
}

fn line() -> Result<KnotVector, Error> {
    Ok(KnotVector::bezier(1, Interval::UNIT)?)
}

/// Knots of degree 2 whose pieces are joined without derivatives, so that each can be any arc of a conic.
fn arcs(count: usize) -> Result<KnotVector, Error> {
    let mut knots = vec![0.0];
    knots.extend((0..=count).flat_map(|k| [k as f64 / count as f64; 2]));
    knots.push(1.0);
    Ok(KnotVector::new(2, knots)?)
}

fn closed_arcs() -> Result<KnotVector, Error> {
    let last = ARCS.cast_signed();
    // Period 1; the domain starts with the second of two equal knots.
    let knots = (-1..=last + 1).flat_map(|k| [k as f64 / ARCS as f64; 2]).collect::<Vec<_>>();
    Ok(KnotVector::periodic(2, knots[1..].to_vec())?)
}
