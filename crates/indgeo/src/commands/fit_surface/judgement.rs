//! Whether the points of a cloud are near a surface that was fitted: all of them, one by one and as neighbours.

use crate::report::Report;
use crate::report::wording::counted;
use industrial_geometry::fit::{Robust, SurfaceCoverage, SurfaceDistances};
use industrial_geometry::mesh::CloudIndex;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use std::path::Path;

/// How much residuals of neighbours differ, 1 where they have nothing to do with each other, below which a surface does not follow the
/// points.
const ALIKE: f64 = 0.5;
/// Standard deviations of the distances beyond which a point is not met, if it is farther than others are apart, too.
pub(crate) const WILD: f64 = 6.0;

/// Number and share of the points from which on those that were left out and lie together are a part of the data that is missed, if one of them is far
/// from the surface, and share of all points that may be left out.
const TOGETHER: (usize, f64) = (8, 0.005);
const LEFT_OUT: f64 = 0.3;

/// What is wrong with the distances of the points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Judgement {
    /// Points that are on no part of the surface, whether they were used or not.
    pub(crate) far: usize,
    /// The largest distance of one of them.
    pub(crate) far_max: f64,
    /// Whether the points are farther from the surface than from each other, and neighbours alike.
    pub(crate) unresolved: bool,
    /// Points that were left out as outliers but lie together, or are too many to be outliers.
    pub(crate) missed: usize,
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
        if self.missed > 0 {
            report.warnings.push(format!(
                "{}: {} left out as outliers lie together, or are too many: a part of the data that the surface misses",
                path.display(),
                counted(self.missed, "point")
            ));
        }
        !self.is_clean()
    }

    /// Whether all points are met.
    pub(crate) fn is_clean(&self) -> bool {
        self.far == 0 && !self.unresolved && self.missed == 0
    }
}

impl Judgement {
    /// From all points and their distances, a tolerance, and what is assumed about outliers.
    pub(crate) fn of(
        points: &[Vector3<f64>],
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
            missed: if purposely { missed(points, found, limit, coverage.limit) } else { 0 },
        }
    }
}

/// Number of points far from the surface that were left out and lie together, or that are too many to be outliers.
fn missed(points: &[Vector3<f64>], found: &SurfaceDistances, far: f64, reach: f64) -> usize {
    let numbers: Vec<usize> =
        (0..points.len()).filter(|&i| found.weights[i] == 0.0 && found.distances[i].is_finite()).collect();
    let left: Vec<Point3<f64>> = numbers.iter().map(|&i| Point3::from(points[i])).collect();
    let total = found.finite();
    let all = numbers.iter().filter(|&&i| found.distances[i] > far).count();
    if all as f64 > LEFT_OUT * total as f64 {
        return all;
    }
    let Ok(index) = CloudIndex::new(&left) else { return 0 };
    let fewest = (TOGETHER.0 as f64).max(TOGETHER.1 * total as f64);
    let mut seen = vec![false; left.len()];
    let mut sum = 0;
    for first in 0..left.len() {
        let (mut group, mut open, mut is_far) = (0, vec![first], false);
        while let Some(i) = open.pop() {
            if std::mem::replace(&mut seen[i], true) {
                continue;
            }
            group += 1;
            is_far |= found.distances[numbers[i]] > far;
            // Neighbours on a surface are less than a spacing apart, a third of what is without data.
            open.extend(
                index.within(&left[i], 0.5 * reach).into_iter().map(|n| n.index).filter(|&j| !seen[j]),
            );
        }
        if is_far && group as f64 >= fewest {
            sum += group;
        }
    }
    sum
}
