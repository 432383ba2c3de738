//! What a curve fit found.

use crate::{Status, StepRecord};
use nalgebra::SVector;
use nurbs_core::BsplineCurve;

/// Why a curve is closed or open.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Closure {
    /// It was asked for.
    Asked,
    /// The given start is so.
    Start,
    /// The gap between the ends of the path through the points is within or beyond what neighbours on it are apart.
    Gap {
        /// Distance between the ends.
        gap: f64,
        /// What it was compared with.
        limit: f64,
    },
    /// The points lie on a line.
    Line,
}

/// Where the iteration started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum CurveStart {
    /// A given curve.
    Given,
    /// Through the points in their order.
    Order,
    /// Along the cloud: through its points if they lie on a curve, else along its skeleton.
    Skeleton,
    /// A contour that grew inside the points.
    Contour,
    /// An ellipse about the principal axes.
    Ellipse,
    /// A line along the principal axis.
    Line,
}

/// One run of the loop with a fixed number of control points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StageRecord {
    /// What the stage was for: `fit`, `insert`, `remove`, `choose`, `uncross`, `finish`, `polish`, `conic`, `weights`.
    pub stage: &'static str,
    /// Number of control points.
    #[cfg_attr(feature = "serde", serde(rename = "control_points"))]
    pub controls: usize,
    /// Root mean square distance.
    pub rms: f64,
    /// Largest distance.
    pub max: f64,
    /// Factor of the energy at its end.
    pub lambda: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// How it ended.
    pub status: Status,
    /// Whether its curve was kept.
    pub kept: bool,
}

/// How a curve fit went.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveReport {
    /// How the last run of the loop ended.
    pub status: Status,
    /// Whether the curve is closed.
    pub closed: bool,
    /// Why.
    pub closure: Closure,
    /// Where the iteration started.
    pub start: CurveStart,
    /// Number of points given.
    pub points: usize,
    /// Number of points left out because they are not finite.
    #[cfg_attr(feature = "serde", serde(rename = "points_dropped"))]
    pub dropped: usize,
    /// Number of points that count at the end.
    #[cfg_attr(feature = "serde", serde(rename = "points_used"))]
    pub used: usize,
    /// Number of control points (those that repeat counted once).
    #[cfg_attr(feature = "serde", serde(rename = "control_points"))]
    pub controls: usize,
    /// Degree.
    pub degree: usize,
    /// Root mean square of the orthogonal distances of the points.
    pub rms: f64,
    /// The largest one.
    pub max: f64,
    /// The point that has it.
    pub max_index: usize,
    /// The tolerance that was asked for.
    pub tolerance: Option<f64>,
    /// Share of the points within it.
    pub share_within: Option<f64>,
    /// Whether all of them are.
    #[cfg_attr(feature = "serde", serde(rename = "within_tolerance"))]
    pub reached: Option<bool>,
    /// Factor of the energy at the end.
    pub lambda: f64,
    /// Number of iterations of all runs.
    pub iterations: usize,
    /// The runs.
    pub stages: Vec<StageRecord>,
    /// Parameters at which the curve crosses itself (plane curves).
    pub crossings: Vec<[f64; 2]>,
    /// Every iteration of the runs whose curve was kept.
    pub history: Vec<StepRecord>,
}

impl CurveReport {
    /// Whether the curve is a local minimum.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.status.is_converged()
    }
}

impl std::fmt::Display for CurveReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kind = if self.closed { "closed" } else { "open" };
        write!(
            f,
            "{kind} curve of degree {} with {} control points, rms {:.4e}, max {:.4e}, {} after {} iterations",
            self.degree, self.controls, self.rms, self.max, self.status, self.iterations
        )?;
        if let (Some(tolerance), Some(share), Some(false)) = (self.tolerance, self.share_within, self.reached)
        {
            write!(f, "; tolerance {tolerance} not reached: a share of {share} of the points within")?;
        }
        if !self.crossings.is_empty() {
            write!(f, "; crosses itself {} times", self.crossings.len())?;
        }
        Ok(())
    }
}

/// The foot of a point on the fitted curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointFoot<const D: usize> {
    /// Parameter; NaN for a point that is not finite.
    pub parameter: f64,
    /// The nearest point of the curve.
    pub foot: SVector<f64, D>,
    /// Its distance.
    pub distance: f64,
}

/// A fitted curve.
#[derive(Clone, Debug)]
pub struct CurveFit<const D: usize> {
    /// The curve.
    pub curve: BsplineCurve<D>,
    /// How it came about.
    pub report: CurveReport,
    /// The foot of every point, in their order.
    pub feet: Vec<PointFoot<D>>,
    /// The curve before the first and after each iteration of the runs that were kept, if asked for.
    pub evolution: Vec<BsplineCurve<D>>,
}
