//! What a registration of many views found.

use std::fmt;

use nalgebra::{Matrix6, Vector3};

use crate::Pose;

/// How the registration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum ViewsStatus {
    /// All views are linked, and steps became smaller than the tolerance.
    Converged,
    /// The views fall into several components that do not overlap: within each the iteration converged, from one to
    /// another nothing is known. [`ViewsReport::components`] says which views belong together.
    Disconnected,
    /// No two views overlap; nothing was moved.
    NoOverlap,
    /// The overlaps let some views move freely (planes, spheres, cylinders); along those motions they stayed where they
    /// were.
    Underdetermined,
    /// The iteration converged, but some views that overlap are much farther apart than their own noise:
    /// [`PairReport::is_doubtful`] says which.
    Doubtful,
    /// The iteration converged, but some views lie on others about as well in another place, or fit others best there:
    /// [`PairReport::is_ambiguous`] says which.
    Ambiguous,
    /// The limit on iterations was reached first.
    MaxIterations,
    /// The caller cancelled; the poses are those reached so far.
    Cancelled,
}

impl ViewsStatus {
    /// Whether all views found their places.
    #[must_use]
    pub fn is_converged(self) -> bool {
        self == Self::Converged
    }

    /// The name used in files: `converged`, `disconnected`, …
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Disconnected => "disconnected",
            Self::NoOverlap => "no_overlap",
            Self::Underdetermined => "underdetermined",
            Self::Doubtful => "doubtful",
            Self::Ambiguous => "ambiguous",
            Self::MaxIterations => "max_iterations",
            Self::Cancelled => "cancelled",
        }
    }
}

impl fmt::Display for ViewsStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Where a view came to lie.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ViewReport {
    /// Maps the view into the common frame.
    pub pose: Pose<3>,
    /// Covariance of a small motion `v(x) = c̄ + c × (x − m)` of the view, in the order `(c, c̄)`, with `m` the centre of all
    /// views ([`ViewsReport::centre`]): `σ̂² (JᵀJ)⁻¹`. Zero for the view that is held; `None` where it is not known.
    #[cfg_attr(feature = "serde", serde(serialize_with = "optional_matrix"))]
    pub covariance: Option<Matrix6<f64>>,
    /// The component the view belongs to.
    pub component: usize,
    /// Number of points left out because they are not finite.
    pub dropped: usize,
}

/// How two views that overlap fit together.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PairReport {
    /// The two views, the smaller index first.
    pub views: [usize; 2],
    /// Share of the first view that the second covers, and the other way round, at the end.
    pub overlap: [f64; 2],
    /// Number of points of both that are matched at the end.
    pub count: usize,
    /// Root mean square distance at the initial poses, in the units of the views.
    pub rms_before: f64,
    /// The same at the end.
    pub rms_after: f64,
    /// Whether that is more than 0.5 % of the size of the larger view, and more than three times the noise that both views show among
    /// their own points: where the two lie on each other wrongly, or show parts of another shape.
    #[cfg_attr(feature = "serde", serde(rename = "doubtful"))]
    pub is_doubtful: bool,
    /// Whether the two are linked by places alone that no search confirmed as the only ones ([`PairSearch`](super::PairSearch)).
    #[cfg_attr(feature = "serde", serde(rename = "ambiguous"))]
    pub is_ambiguous: bool,
}

/// One step of all views.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ViewsStep {
    /// Number of matched points.
    pub count: usize,
    /// Root mean square distance, weighted, before the step.
    pub rms: f64,
    /// Distance beyond which a matched point counts nothing.
    pub limit: f64,
    /// The largest motion of a point of any view by the step.
    pub motion: f64,
}

/// The poses of all views.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ViewsReport {
    /// How the registration ended.
    pub status: ViewsStatus,
    /// One entry per view, in their order.
    pub views: Vec<ViewReport>,
    /// The pairs that overlap.
    pub pairs: Vec<PairReport>,
    /// The views that hang together, each component in increasing order; the first view of each is held.
    pub components: Vec<Vec<usize>>,
    /// The centre to which covariances refer.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
    pub centre: Vector3<f64>,
    /// Root mean square distance over all matched points at the end.
    pub rms: f64,
    /// The steps.
    pub history: Vec<ViewsStep>,
}

impl fmt::Display for ViewsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} views in {} component(s), {} overlaps, {} steps, rms {:.3e}",
            self.status,
            self.views.len(),
            self.components.len(),
            self.pairs.len(),
            self.history.len(),
            self.rms
        )
    }
}

#[cfg(feature = "serde")]
fn optional_matrix<S: serde::Serializer>(
    matrix: &Option<Matrix6<f64>>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(&matrix.as_ref().map(Matrix6::as_slice), serializer)
}
