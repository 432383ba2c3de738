//! What a registration of many views found, for machines.

use crate::commands::register::results::Rotation;
use crate::commands::register_views::scan_views::ViewFile;
use industrial_geometry::mesh::nalgebra::Matrix6;
use industrial_geometry::register::views::{PairReport, ViewReport, ViewsReport, ViewsStep};
use serde::Serialize;
use std::path::PathBuf;

/// Where all views came to lie: the content of `poses.json`.
#[derive(Debug, Serialize)]
pub(crate) struct ViewsResults {
    /// How the iteration ended.
    pub(crate) status: &'static str,
    /// Root mean square distance over all matched points.
    pub(crate) rms: f64,
    /// Number of steps.
    pub(crate) iterations: usize,
    /// Where it began: `given`, `init` or `search`.
    pub(crate) start: &'static str,
    /// One entry per view, in the order in which they were given.
    pub(crate) views: Vec<ViewResult>,
    /// The pairs of views that overlap, by their indices (from 0).
    pub(crate) pairs: Vec<PairReport>,
    /// The views that hang together, by their indices; the first of each list stayed where it was.
    pub(crate) components: Vec<Vec<usize>>,
    /// Every step.
    pub(crate) history: Vec<ViewsStep>,
}

/// Where one view came to lie.
#[derive(Debug, Serialize)]
pub(crate) struct ViewResult {
    /// The file that was read.
    #[serde(serialize_with = "crate::report::lossy")]
    pub(crate) path: PathBuf,
    /// The scan of it, by its number from 0 on, of a file of several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) scan: Option<usize>,
    /// The file that was written.
    #[serde(serialize_with = "crate::report::lossy")]
    pub(crate) moved: PathBuf,
    /// `x ↦ R x + t` from the file, whose scans are placed by their poses, to the common frame, in homogeneous coordinates, by rows.
    pub(crate) matrix: [[f64; 4]; 4],
    /// The rotation in two more forms.
    pub(crate) rotation: Rotation,
    /// `t`.
    pub(crate) translation: [f64; 3],
    /// How well the pose is determined with respect to the view that was held.
    pub(crate) covariance: Option<ViewCovariance>,
    /// Index of its list in `components`.
    pub(crate) component: usize,
    /// Points in the file, and those that are not finite (or of no triangle, in a mesh) and do not count.
    pub(crate) points: usize,
    pub(crate) points_dropped: usize,
}

/// Covariance of the pose of a view.
#[derive(Debug, Serialize)]
pub(crate) struct ViewCovariance {
    /// By rows, for the displacement of `origin` and the rotation vector about it; zero for a view that was held.
    pub(crate) rows: Vec<Vec<f64>>,
    /// A point of the common frame.
    pub(crate) origin: [f64; 3],
}

impl ViewsResults {
    /// From a result; `files` are the input and the output of each view with its number of points.
    pub(crate) fn new(
        found: &ViewsReport,
        start: &'static str,
        files: impl Iterator<Item = (ViewFile, PathBuf, usize)>,
    ) -> Self {
        let origin = found.centre.into();
        let view = |((file, moved, points), view): ((ViewFile, PathBuf, usize), &ViewReport)| {
            let (axis, angle) = view.pose.axis_angle();
            ViewResult {
                path: file.path,
                scan: file.scan,
                moved,
                matrix: view.pose.to_row_major(),
                rotation: Rotation { quaternion: view.pose.quaternion(), axis: axis.into(), angle },
                translation: view.pose.translation().into(),
                covariance: view.covariance.as_ref().map(|all| ViewCovariance { rows: rows(all), origin }),
                component: view.component,
                points,
                points_dropped: view.dropped,
            }
        };
        Self {
            status: found.status.name(),
            rms: found.rms,
            iterations: found.history.len(),
            start,
            views: files.zip(&found.views).map(view).collect(),
            pairs: found.pairs.clone(),
            components: found.components.clone(),
            history: found.history.clone(),
        }
    }
}

/// The rows of a covariance, translations before rotations; the library has the rotations first.
fn rows(all: &Matrix6<f64>) -> Vec<Vec<f64>> {
    let entry = |i: usize, j: usize| all[((i + 3) % 6, (j + 3) % 6)];
    (0..6).map(|i| (0..6).map(|j| entry(i, j)).collect()).collect()
}
