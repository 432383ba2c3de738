//! Least squares surfaces from the parameters of a base surface.

mod anchors;
mod ease;
mod finish;
mod knots;
mod outliers;

pub use finish::{FinishOutcome, FinishReport, finish_fit, finish_fit_with_progress, finish_options};
pub use outliers::{Resolution, consistent, crowded, resolution};

use crate::{Error, SurfaceDefects, parallel};
use anchors::Anchors;
use footpoint::{SurfaceFootpoint, SurfaceProjector};
use knots::Spans;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface, SurfaceFitOptions};
use sdm_fit::Folds;

/// How many times cells that fold are drawn to the base surface.
const UNFOLDINGS: usize = 10;
/// How many times the energy is raised after that if there are folds left, and by what factor.
const STIFFENINGS: usize = 8;
const STIFFER: f64 = 10.0;

/// How a surface is fitted to points with parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitOptions {
    /// Number of control points in `u` (different ones, where `u` is closed) and `v`; default 30 and 30.
    pub control_points: [usize; 2],
    /// Degrees in `u` and `v`; default 3 and 3.
    pub degrees: [usize; 2],
    /// Factor of the thin plate energy, of which a little bridges holes; default 1e-10. The energy is measured with the domain
    /// scaled to the unit square, so that the factor does not depend on the unit of length.
    pub regularisation: f64,
    /// How many times the knots are moved to where the distances are large; default 8, with 0 they are equally spaced.
    pub redistributions: usize,
    /// How many times parameters are corrected by projecting the points onto the fitted surface, each followed by another
    /// fit; default 2. Ends before the surface folds.
    pub corrections: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            control_points: [30, 30],
            degrees: [3, 3],
            regularisation: 1e-10,
            redistributions: 8,
            corrections: 2,
        }
    }
}

/// A fitted surface.
#[derive(Clone, Debug)]
pub struct SurfaceFit {
    /// The surface, with the domain of the base surface; periodic in `u` if that was closed.
    pub surface: BsplineSurface,
    /// Root mean square of the orthogonal distances of all points that count, after each fit.
    pub history: Vec<f64>,
    /// Footpoints of the points on the surface, those that do not count included.
    pub feet: Vec<SurfaceFootpoint>,
    /// Root mean square of the orthogonal distances at the end.
    pub rms: f64,
    /// Largest orthogonal distance at the end.
    pub max: f64,
    /// Number of points that count.
    pub used: usize,
}

/// The least squares B-spline surface of points with parameters, closed in `u` if the base surface is, open at the other
/// ends ([MPK, sec. 4]).
///
/// Where the surface would fold, since there is more to see than its net resolves or less data than it needs, it is drawn to the
/// base surface, which does not; if the net does not resolve that either, it is smoothed.
///
/// `feet` are the footpoints on the base surface; `counts` says which points take part.
///
/// # Errors
/// [`Error::Option`], [`Error::Nurbs`] where data leave control points undetermined.
pub fn fit_parameters(
    points: &[Vector3<f64>],
    base: &BsplineSurface,
    feet: &[SurfaceFootpoint],
    counts: &[bool],
    options: &FitOptions,
) -> Result<SurfaceFit, Error> {
    let [n_u, n_v] = options.control_points;
    let [p, q] = options.degrees;
    for (n, degree) in [(n_u, p), (n_v, q)] {
        if n <= degree || degree == 0 {
            return Err(Error::Option {
                name: "control_points",
                value: n as f64,
                allowed: "more than the degree, which is at least 1",
            });
        }
    }
    for (name, found) in [("feet", feet.len()), ("counts", counts.len())] {
        if found != points.len() {
            return Err(Error::Option { name, value: found as f64, allowed: "one for each point" });
        }
    }
    let used: Vec<usize> = (0..points.len()).filter(|&i| counts[i]).collect();
    let data: Vec<Vector3<f64>> = used.iter().map(|&i| points[i]).collect();
    let mut parameters: Vec<[f64; 2]> = used.iter().map(|&i| feet[i].parameter).collect();
    let closed = base.knots_u().is_periodic();
    let [u, v] = base.domain();
    let mut spans =
        [Spans::uniform(u, if closed { n_u } else { n_u - p }, closed), Spans::uniform(v, n_v - q, false)];
    let knots = |spans: &[Spans; 2]| -> Result<_, Error> { Ok([spans[0].knots(p)?, spans[1].knots(q)?]) };
    // The energy has the unit of the squared distances.
    let fit =
        poles(base, SurfaceFitOptions::default().with_regularization(options.regularisation), [n_u, n_v]);
    let mut best = (f64::INFINITY, spans.clone());
    for k in 0..=options.redistributions {
        if options.redistributions == 0 {
            break;
        }
        let surface = BsplineSurface::approximate(knots(&spans)?, &parameters, &data, &fit)?.shape;
        let squares = parallel::map(data.len(), |i| {
            let [u, v] = parameters[i];
            (surface.point(u, v) - data[i]).norm_squared()
        });
        let sum: f64 = squares.iter().sum();
        if sum < best.0 {
            best = (sum, spans.clone());
        }
        if k == options.redistributions {
            break;
        }
        let errors = [0, 1].map(|axis| {
            let mut sums = vec![(0.0, 0usize); spans[axis].count()];
            for (square, parameter) in squares.iter().zip(&parameters) {
                let slot = &mut sums[spans[axis].of(parameter[axis])];
                *slot = (slot.0 + square, slot.1 + 1);
            }
            sums.iter().map(|&(sum, count)| sum / count.max(1) as f64).collect::<Vec<f64>>()
        });
        spans = [spans[0].redistributed(&errors[0]), spans[1].redistributed(&errors[1])];
    }
    // Moves may overshoot: the best knots count.
    let knots = knots(&best.1)?;
    // Where the net does not resolve what the data show, it folds. The base surface does not: there it counts, too.
    let mut anchors = Anchors::none(best.1.map(|s| s.ends), closed);
    let per_cell = data.len() as f64 / ((n_u - p).max(1) * (n_v - q).max(1)) as f64;
    let mut energy = options.regularisation;
    let solve = |parameters: &[[f64; 2]], anchors: &Anchors, energy: f64| -> Result<BsplineSurface, Error> {
        let held = anchors.points(base, per_cell);
        let mut weights = vec![1.0; data.len()];
        weights.extend(held.weights);
        let options = fit.clone().with_weights(weights).with_regularization(energy);
        let (parameters, points) =
            ([parameters, &held.parameters].concat(), [&data[..], &held.points].concat());
        Ok(BsplineSurface::approximate(knots.clone(), &parameters, &points, &options)?.shape)
    };
    let mut first = solve(&parameters, &anchors, energy)?;
    let mut folded = Folds::of(&first).folded;
    for _ in 0..UNFOLDINGS {
        if folded.is_empty() {
            break;
        }
        anchors.strengthen(&folded);
        first = solve(&parameters, &anchors, energy)?;
        folded = Folds::of(&first).folded;
    }
    // Nor does it resolve the base: a smoother surface.
    for _ in 0..STIFFENINGS {
        if folded.is_empty() {
            break;
        }
        energy = STIFFER * energy.max(f64::EPSILON);
        first = solve(&parameters, &anchors, energy)?;
        folded = Folds::of(&first).folded;
    }
    let folds = |surface: &BsplineSurface| SurfaceDefects::of(surface, None).crossovers;
    let mut history = Vec::new();
    let mut next = Some(first);
    let mut best: Option<(BsplineSurface, Vec<SurfaceFootpoint>)> = None;
    while let Some(surface) = next.take() {
        // Parameters that make the surface fold are no better, however near it comes.
        if best.as_ref().is_some_and(|(before, _)| folds(&surface) > folds(before)) {
            break;
        }
        let projector = SurfaceProjector::new(&surface);
        let all = projector.project_all(points);
        let distance = rms(&used, &all);
        if history.last().is_some_and(|&before| distance > before) {
            break;
        }
        history.push(distance);
        parameters = used.iter().map(|&i| all[i].parameter).collect();
        best = Some((surface, all));
        if history.len() <= options.corrections {
            next = Some(solve(&parameters, &anchors, energy)?);
        }
    }
    let Some((surface, feet)) = best else {
        return Err(Error::TooFewPoints { total: points.len(), usable: used.len(), needed: n_u * n_v });
    };
    let max = used.iter().map(|&i| feet[i].distance).fold(0.0, f64::max);
    let rms = rms(&used, &feet);
    Ok(SurfaceFit { surface, history, feet, rms, max, used: used.len() })
}

/// Root mean square distance of the points that count.
fn rms(used: &[usize], feet: &[SurfaceFootpoint]) -> f64 {
    (used.iter().map(|&i| feet[i].distance.powi(2)).sum::<f64>() / used.len().max(1) as f64).sqrt()
}

/// Holds the control points of ends that are collapsed to a point in the base surface.
fn poles(base: &BsplineSurface, mut options: SurfaceFitOptions, [n_u, n_v]: [usize; 2]) -> SurfaceFitOptions {
    let [u, v] = base.domain();
    let size =
        base.control_points().iter().map(|p| (p - base.control_points()[0]).norm()).fold(0.0, f64::max);
    for (end, j) in [(v.start(), 0), (v.end(), n_v - 1)] {
        let pole = base.point(u.start(), end);
        let collapsed =
            (1..8).all(|k| (base.point(u.lerp(f64::from(k) / 8.0), end) - pole).norm() <= 1e-9 * size);
        if collapsed {
            for i in 0..n_u {
                options = options.with_fixed(i, j, pole);
            }
        }
    }
    options
}
