//! Base curves drawn to the cloud.

use super::{ClosedCurve, LayerCurve, MOST_SAMPLES, SAMPLE_SPACING};
use crate::defects::self_loops;
use crate::directed::project;
use crate::{AxisFrame, DirectedOptions, Error, Neighbourhood, parallel};
use nalgebra::{Vector2, Vector3};

/// Distance from the cloud, in spacings, beyond which a place is not drawn to it: there is a hole.
const FAR: f64 = 4.0;
/// Smoothing steps that a curve with loops gets before it keeps its old shape.
const SMOOTHINGS: usize = 4;

/// How base curves are drawn to the cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveOptions {
    /// Directed projection of the samples.
    pub directed: DirectedOptions,
    /// Most iterations; default 10.
    pub max_iterations: usize,
    /// Change of the root mean square distance, as a share of it, below which the iteration ends; default 0.01.
    pub threshold: f64,
    /// Number of samples of the longest curve; default so that they are about 2.5 times its pitch apart.
    pub samples: Option<usize>,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self { directed: DirectedOptions::default(), max_iterations: 10, threshold: 0.01, samples: None }
    }
}

/// One iteration over all curves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveStep {
    /// Root mean square distance of the samples from their nearest points of the cloud ([MPK, sec. 4]). It has a floor of the
    /// order of the spacing of the cloud.
    pub rms: f64,
    /// Number of samples.
    pub samples: usize,
    /// Number of places where curves cross themselves.
    pub self_loops: usize,
}

/// What drawing curves to a cloud achieved.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveReport {
    /// The state before the first iteration and after each.
    pub history: Vec<CurveStep>,
    /// Whether the change fell below the threshold.
    pub converged: bool,
    /// Number of curves that had to be smoothed to keep them from crossing themselves.
    pub smoothed: usize,
}

/// Draws base curves to the cloud: samples at equal lengths are projected along the normals of their curve in the plane of
/// its layer, a curve is laid through them, and again, until the distances stop changing ([MPK, sec. 3.5]).
///
/// No curve is replaced by one that crosses itself.
///
/// # Errors
/// [`Error::Option`].
pub fn project_curves(
    frame: &AxisFrame,
    cloud: &Neighbourhood,
    curves: &mut [LayerCurve],
    options: &CurveOptions,
) -> Result<CurveReport, Error> {
    options.directed.check()?;
    let longest = curves.iter().map(|c| c.curve.length()).fold(0.0, f64::max);
    let automatic = (SAMPLE_SPACING * cloud.pitch()).max(longest / MOST_SAMPLES as f64);
    let step = options.samples.map_or(automatic, |n| longest / n.max(5) as f64);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let count = |curve: &ClosedCurve| (curve.length() / step).round().clamp(8.0, 4096.0) as usize;
    let mut report = CurveReport::default();
    report.history.push(state(frame, cloud, curves, &count));
    for _ in 0..options.max_iterations {
        let moved = parallel::tasks(curves.len(), |j| {
            let layer = &curves[j];
            let samples = layer.curve.resampled_with_normals(count(&layer.curve));
            let places: Vec<Vector2<f64>> =
                samples.iter().map(|(p, n)| draw(frame, cloud, layer, p, n, &options.directed)).collect();
            without_loops(places)
        });
        for (layer, moved) in curves.iter_mut().zip(moved) {
            if let Some((curve, smoothed)) = moved {
                layer.curve = curve;
                report.smoothed += usize::from(smoothed);
            }
        }
        let before = report.history[report.history.len() - 1].rms;
        report.history.push(state(frame, cloud, curves, &count));
        let after = report.history[report.history.len() - 1].rms;
        if (before - after).abs() <= options.threshold * before {
            report.converged = true;
            break;
        }
    }
    Ok(report)
}

/// A sample drawn to the cloud in its layer.
fn draw(
    frame: &AxisFrame,
    cloud: &Neighbourhood,
    layer: &LayerCurve,
    p: &Vector2<f64>,
    n: &Vector2<f64>,
    options: &DirectedOptions,
) -> Vector2<f64> {
    let place = layer.lift(frame, p);
    let direction = frame.rotation() * Vector3::new(n.x, n.y, 0.0);
    if direction.norm_squared() < 0.5 || cloud.distance(&place) > FAR * cloud.pitch() {
        return *p;
    }
    let foot = project(cloud, &place, &direction, options);
    // Beyond this the neighbours do not belong to the place.
    let limit = FAR * cloud.pitch();
    p + n * foot.offset.clamp(-limit, limit)
}

/// A curve through places, smoothed as far as it takes to be free of loops, and whether that was needed.
fn without_loops(mut places: Vec<Vector2<f64>>) -> Option<(ClosedCurve, bool)> {
    for smoothing in 0..=SMOOTHINGS {
        let curve = ClosedCurve::through(&places)?;
        if self_loops(&curve.polygon(4)) == 0 {
            return Some((curve, smoothing > 0));
        }
        let n = places.len();
        places =
            (0..n).map(|i| places[i] / 2.0 + (places[(i + n - 1) % n] + places[(i + 1) % n]) / 4.0).collect();
    }
    None
}

fn state(
    frame: &AxisFrame,
    cloud: &Neighbourhood,
    curves: &[LayerCurve],
    count: &(dyn Fn(&ClosedCurve) -> usize + Sync),
) -> CurveStep {
    let parts = parallel::tasks(curves.len(), |j| {
        let layer = &curves[j];
        let samples = layer.curve.resampled(count(&layer.curve), 0.0);
        let sum: f64 = samples.iter().map(|p| cloud.distance(&layer.lift(frame, p)).powi(2)).sum();
        (sum, samples.len(), self_loops(&layer.curve.polygon(4)))
    });
    let (sum, samples, self_loops) = parts.iter().fold((0.0, 0, 0), |s, p| (s.0 + p.0, s.1 + p.1, s.2 + p.2));
    CurveStep { rms: (sum / samples.max(1) as f64).sqrt(), samples, self_loops }
}
