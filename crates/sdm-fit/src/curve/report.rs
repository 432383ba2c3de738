//! What a curve fit found.

use crate::{CurveCoverage, FitStep, Status};
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
    /// Number of points so far from all others that no curve can be fitted to them; they count as points that are far away.
    #[cfg_attr(feature = "serde", serde(rename = "points_astray"))]
    pub astray: usize,
    /// Number of points that count at the end; others only if outliers are to be left out.
    #[cfg_attr(feature = "serde", serde(rename = "points_used"))]
    pub used: usize,
    /// Number of control points (those that repeat counted once).
    #[cfg_attr(feature = "serde", serde(rename = "control_points"))]
    pub controls: usize,
    /// Degree.
    pub degree: usize,
    /// Root mean square of the orthogonal distances of the points that count.
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
    /// The curve seen from the points, and the other way round.
    pub coverage: CurveCoverage,
    /// The gap between the ends of an open curve, if it is no wider than gaps between neighbours may be: whether the curve is closed is then left
    /// open by the points, and must be told. `None` where that was asked for.
    pub open_ends: Option<f64>,
    /// How often the curve crosses itself though the path through the points, by which it was found, does not.
    pub loops: usize,
    /// Whether every part of the curve is near to points, every point that counts near to the curve, whether it is closed no question, and there are no
    /// loops.
    pub covered: bool,
    /// Factor of the energy at the end.
    pub lambda: f64,
    /// Number of iterations of all runs.
    pub iterations: usize,
    /// Number of steps of the runs that were kept whose matrix was lifted to be positive definite: with the Taylor model and without control
    /// of steps these are no literal Newton steps.
    pub steps_lifted: usize,
    /// The runs.
    pub stages: Vec<StageRecord>,
    /// Parameters at which the curve crosses itself (plane curves).
    pub crossings: Vec<[f64; 2]>,
    /// Every iteration of the runs whose curve was kept.
    pub history: Vec<FitStep>,
}

impl Default for CurveReport {
    fn default() -> Self {
        Self {
            status: Status::Converged,
            closed: false,
            closure: Closure::Asked,
            start: CurveStart::Given,
            points: 0,
            dropped: 0,
            astray: 0,
            used: 0,
            controls: 0,
            degree: 0,
            rms: 0.0,
            max: 0.0,
            max_index: 0,
            tolerance: None,
            share_within: None,
            reached: None,
            coverage: CurveCoverage::default(),
            open_ends: None,
            loops: 0,
            covered: true,
            lambda: 0.0,
            iterations: 0,
            steps_lifted: 0,
            stages: Vec::new(),
            crossings: Vec::new(),
            history: Vec::new(),
        }
    }
}

impl CurveReport {
    /// Several curves in one report: numbers of all, the worst status, places and parameters of the curve on which they are.
    ///
    /// That of the only one, if there is one only; nothing, converged, for none.
    #[must_use]
    pub fn together(reports: &[Self]) -> Self {
        let worst = reports.iter().max_by_key(|r| {
            (matches!(r.status, Status::Diverged | Status::Singular | Status::Cancelled), !r.is_converged())
        });
        let furthest = reports.iter().max_by(|a, b| a.max.total_cmp(&b.max));
        let (Some(first), Some(worst), Some(furthest)) = (reports.first(), worst, furthest) else {
            return Self::default();
        };
        if reports.len() == 1 {
            return first.clone();
        }
        let sum = |f: fn(&Self) -> usize| reports.iter().map(f).sum::<usize>();
        let used = sum(|r| r.used).max(1) as f64;
        let mean = |f: fn(&Self) -> f64| reports.iter().map(|r| f(r) * r.used as f64).sum::<f64>() / used;
        let tolerance = first.tolerance;
        let reached = tolerance.map(|_| reports.iter().all(|r| r.reached == Some(true)));
        Self {
            status: worst.status,
            closed: reports.iter().all(|r| r.closed),
            closure: first.closure,
            start: first.start,
            points: sum(|r| r.points),
            dropped: sum(|r| r.dropped),
            astray: sum(|r| r.astray),
            used: sum(|r| r.used),
            controls: sum(|r| r.controls),
            degree: reports.iter().map(|r| r.degree).max().unwrap_or(0),
            rms: mean(|r| r.rms * r.rms).sqrt(),
            max: furthest.max,
            max_index: furthest.max_index,
            tolerance,
            share_within: tolerance.map(|_| mean(|r| r.share_within.unwrap_or(0.0))),
            reached,
            open_ends: reports.iter().find_map(|r| r.open_ends),
            loops: sum(|r| r.loops),
            covered: reports.iter().all(|r| r.covered),
            coverage: CurveCoverage::together(&reports.iter().map(|r| &r.coverage).collect::<Vec<_>>()),
            lambda: worst.lambda,
            iterations: sum(|r| r.iterations),
            steps_lifted: sum(|r| r.steps_lifted),
            stages: reports.iter().flat_map(|r| r.stages.clone()).collect(),
            crossings: reports.iter().flat_map(|r| r.crossings.clone()).collect(),
            history: reports.iter().flat_map(|r| r.history.clone()).collect(),
        }
    }

    /// Whether this curve is the better one of two for the same points: it stays with them, reaches the tolerance, crosses itself less often, is nearer.
    pub(crate) fn is_better_than(&self, other: &Self) -> bool {
        let faults = |r: &Self| {
            let lost = matches!(r.status, Status::Diverged | Status::Singular);
            (lost, !r.covered, r.reached == Some(false), r.crossings.len())
        };
        let (own, others) = (faults(self), faults(other));
        own < others || own == others && self.rms < other.rms
    }

    /// Where curve and points are not near to each other, if anywhere.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        let coverage = &self.coverage;
        if self.covered {
            return None;
        }
        if coverage.spread_out {
            return Some(format!(
                "the points spread {:.4e} (rms) about a curve of length {:.4e}: they do not lie on a curve",
                self.rms, coverage.length
            ));
        }
        if let Some(stretch) = coverage.without_data.first() {
            return Some(format!(
                "{:.4e} of the curve ({:.1} spacings of the points) has no points between t = {} and {}, near {}{}",
                stretch.length,
                stretch.length / coverage.spacing.max(f64::MIN_POSITIVE),
                stretch.from,
                stretch.to,
                place(&stretch.place),
                if coverage.without_data.len() > 1 {
                    format!(", and {} other parts", coverage.without_data.len() - 1)
                } else {
                    String::new()
                }
            ));
        }
        if coverage.unresolved && coverage.points_far == 0 {
            return Some(format!(
                "the points are {:.4e} (rms) from the curve, more than noise ({:.4e}) and their spacing ({:.4e}) explain: it does not follow \
                 them",
                self.rms, coverage.noise, coverage.spacing
            ));
        }
        if self.loops > 0 && coverage.holds() {
            return Some(format!(
                "the curve crosses itself {} times, the path through the points does not",
                self.loops
            ));
        }
        if let Some(gap) = self.open_ends.filter(|_| coverage.holds()) {
            return Some(format!(
                "the ends of the curve are {gap:.4e} apart, no further than neighbours on it may be ({:.4e}): the points leave open whether it is \
                 closed",
                coverage.limit
            ));
        }
        Some(format!(
            "{} of {} points are further from the curve than {:.4e}, what spacing and noise explain; point {} (from 0) by {:.4e}",
            coverage.points_far, self.points, coverage.distance_limit, self.max_index, self.max
        ))
    }

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
        match self.fault() {
            Some(fault) => write!(f, "; {fault}"),
            None => Ok(()),
        }
    }
}

/// A place for people.
fn place(coordinates: &[f64]) -> String {
    let list: Vec<String> = coordinates.iter().map(|c| format!("{c:.6}")).collect();
    format!("({})", list.join(", "))
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
