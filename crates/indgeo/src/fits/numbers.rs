//! What all fits report, under the same names.

use crate::report::Outcome;
use crate::runtime::progress::Progress;
use industrial_geometry::fit::{FitReport, FitStep, Status};
use serde::Serialize;
use std::ops::ControlFlow;

/// Tells a person about an iteration; never asks to stop.
pub(crate) fn told(progress: &Progress, step: &FitStep, most: usize) -> ControlFlow<()> {
    let about = format!("{} control points, rms {:.3e}", step.coefficients, step.rms);
    progress.iteration(step.iteration, most, &about)
}

/// A fit in numbers.
#[derive(Debug, Serialize)]
pub(crate) struct FitNumbers {
    /// How the iteration ended.
    pub(crate) status: Status,
    /// Points that were fitted: those of the file that are finite, and those that were added.
    pub(crate) points: usize,
    /// Points that do not count because they are not finite.
    pub(crate) points_dropped: usize,
    /// Points on the triangles of a thinned mesh that were taken besides its vertices.
    pub(crate) points_added: usize,
    /// Points that count at the end.
    pub(crate) points_used: usize,
    /// Root mean square distance before the first iteration.
    pub(crate) initial_rms: f64,
    /// Root mean square distance of the points that count.
    pub(crate) rms: f64,
    /// The largest distance of one of them.
    pub(crate) max: f64,
    /// That point, from 0 among the finite ones.
    pub(crate) max_index: usize,
    /// Factor of the bending energy at the end.
    pub(crate) lambda: f64,
    /// Number of iterations.
    pub(crate) iterations: usize,
    /// The tolerance that was asked for.
    pub(crate) tolerance: Option<f64>,
    /// Share of the points within it.
    pub(crate) share_within: Option<f64>,
    /// Whether the tolerance holds.
    pub(crate) within_tolerance: Option<bool>,
    /// Every iteration.
    pub(crate) history: Vec<FitStep>,
}

/// A tolerance, and what became of it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Within {
    /// What was asked for.
    pub(crate) tolerance: Option<f64>,
    /// Share of the points within it.
    pub(crate) share: Option<f64>,
    /// Whether that is enough.
    pub(crate) holds: bool,
}

impl FitNumbers {
    /// From the report of the library.
    pub(crate) fn new(fit: FitReport, dropped: usize, added: usize, within: Within) -> Self {
        Self {
            status: fit.status,
            points: fit.samples,
            points_dropped: dropped,
            points_added: added,
            points_used: fit.used,
            initial_rms: fit.initial_rms,
            rms: fit.rms,
            max: fit.max,
            max_index: fit.max_index,
            lambda: fit.lambda,
            iterations: fit.history.len(),
            tolerance: within.tolerance,
            share_within: within.share,
            within_tolerance: within.tolerance.map(|_| within.holds),
            history: fit.history,
        }
    }

    /// Whether the iteration came to an end of its own, or to what was asked for.
    pub(crate) fn verdict(&self) -> FitVerdict {
        FitVerdict::of(self.status, self.within_tolerance)
    }
}

/// Whether a fit is what was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FitVerdict {
    /// It is.
    Good,
    /// The tolerance does not hold.
    OutOfTolerance,
    /// The iteration ended before it had come to rest.
    NotConverged,
    /// It came to rest, but the shape has faults.
    Defective,
}

impl FitVerdict {
    /// One rule for all fits: with a tolerance the tolerance decides, without one the iteration; a run that failed is no result.
    pub(crate) fn of(status: Status, within: Option<bool>) -> Self {
        match (status, within) {
            (_, Some(false)) => Self::OutOfTolerance,
            (Status::Diverged | Status::Singular | Status::Cancelled, _) => Self::NotConverged,
            (_, Some(true)) | (Status::Converged, None) => Self::Good,
            (_, None) => Self::NotConverged,
        }
    }

    /// The outcome of a command that ends with this verdict.
    pub(crate) fn outcome(self, summary: String) -> Outcome {
        Outcome { summary, converged: self == Self::Good, otherwise: self.name() }
    }

    /// The same, if the shape has no faults.
    pub(crate) fn without(self, faults: bool) -> Self {
        if self == Self::Good && faults { Self::Defective } else { self }
    }

    /// The status in the report.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Good => "done",
            Self::OutOfTolerance => "out_of_tolerance",
            Self::NotConverged => "not_converged",
            Self::Defective => "defective",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tolerance_decides_where_there_is_one() {
        let stopped = [Status::Stalled, Status::MaxIterations];
        for status in stopped {
            assert_eq!(FitVerdict::of(status, None), FitVerdict::NotConverged);
            assert_eq!(FitVerdict::of(status, Some(true)), FitVerdict::Good);
            assert_eq!(FitVerdict::of(status, Some(false)), FitVerdict::OutOfTolerance);
        }
        assert_eq!(FitVerdict::of(Status::Converged, None), FitVerdict::Good);
        assert_eq!(FitVerdict::of(Status::Converged, Some(false)), FitVerdict::OutOfTolerance);
        for status in [Status::Diverged, Status::Singular] {
            assert_eq!(FitVerdict::of(status, Some(true)), FitVerdict::NotConverged);
        }
        assert_eq!(FitVerdict::Good.without(true).name(), "defective");
        assert_eq!(FitVerdict::OutOfTolerance.without(true).name(), "out_of_tolerance");
    }
}
