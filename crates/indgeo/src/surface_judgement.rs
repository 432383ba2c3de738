//! Whether the points of a cloud are near a surface that was fitted: all of them, one by one and as neighbours.

use crate::report::Report;
use crate::wording::counted;
use industrial_geometry::fit::{Robust, SurfaceCoverage, SurfaceDistances};
use std::path::Path;

/// How much residuals of neighbours differ, 1 where they have nothing to do with each other, below which a surface does not follow the
/// points.
const ALIKE: f64 = 0.5;
/// Standard deviations of the distances beyond which a point is not met, if it is farther than others are apart, too.
const WILD: f64 = 6.0;

/// What is wrong with the distances of the points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Judgement {
    /// Points that are on no part of the surface, whether they were used or not.
    pub(crate) far: usize,
    /// The largest distance of one of them.
    pub(crate) far_max: f64,
    /// Whether the points are farther from the surface than from each other, and neighbours alike.
    pub(crate) unresolved: bool,
}

impl Judgement {
    /// Says what is wrong; returns whether anything is.
    pub(crate) fn warn(&self, path: &Path, rms: f64, report: &mut Report) -> bool {
        if self.far > 0 {
            report.warnings.push(format!(
                "{}: {} far from all parts of the surface, up to {:.3e}; `--outliers automatic` leaves out what does not belong",
                path.display(),
                counted(self.far, "point"),
                self.far_max
            ));
        }
        if self.unresolved {
            report.warnings.push(format!(
                "the points are {rms:.3e} from the surface on average, farther than they are from each other, and neighbours alike: it does \
                 not follow them; take more control points or another --shape"
            ));
        }
        self.far > 0 || self.unresolved
    }
}

impl Judgement {
    /// From the distances of all points, a tolerance, and what is assumed about outliers.
    pub(crate) fn of(
        found: &SurfaceDistances,
        coverage: &SurfaceCoverage,
        abs_tolerance: Option<f64>,
        robust: Robust,
    ) -> Self {
        // A tolerance, and the share of the points that must be within it, decide about all of them.
        if abs_tolerance.is_some() {
            return Self::default();
        }
        // Points are left out on purpose where outliers are expected.
        let purposely = robust != Robust::None;
        let limit = coverage.limit.max(WILD * SurfaceCoverage::noise_of(&found.distances));
        let is_far = |i: &usize| found.distances[*i] > limit && !(purposely && found.weights[*i] == 0.0);
        let far: Vec<usize> = (0..found.distances.len()).filter(is_far).collect();
        Self {
            far: far.len(),
            far_max: far.iter().map(|&i| found.distances[i]).fold(0.0, f64::max),
            unresolved: found.rms > coverage.spacing && found.disagreement < ALIKE,
        }
    }
}
