//! What a registration found, for machines.

use crate::commands::inspect::job::InspectionResults;
use crate::commands::register::elsewhere::Elsewhere;
use crate::commands::register::field::Fit;
use industrial_geometry::register::{
    Covariance, Coverage, FreeSpace, Pose, RegisterReport, RegisterStep, Support,
};
use serde::Serialize;

/// A motion with all that is known about it: the content of a transform file.
#[derive(Debug, Serialize)]
pub(crate) struct TransformFile {
    /// `x ↦ s R x + t` in homogeneous coordinates, by rows.
    pub(crate) matrix: [[f64; 4]; 4],
    /// The rotation in two more forms.
    pub(crate) rotation: Rotation,
    /// `t`.
    pub(crate) translation: [f64; 3],
    /// `s`, 1 unless it was estimated.
    pub(crate) scale: f64,
    /// How the iteration ended.
    pub(crate) status: &'static str,
    /// Root mean square distance of the points that count.
    pub(crate) rms: f64,
    /// The same of the same points in the starting pose.
    pub(crate) initial_rms: f64,
    /// Number of steps.
    pub(crate) iterations: usize,
    /// Points given, those that are finite, and those that count at the end.
    pub(crate) points: usize,
    pub(crate) points_used: usize,
    pub(crate) points_dropped: usize,
    /// Largest distance that counts, where outliers were told apart.
    pub(crate) distance_limit: Option<f64>,
    /// How well the pose is determined.
    pub(crate) covariance: Option<Covariance<3>>,
    /// Motions that the shape does not fix.
    pub(crate) free_motions: Vec<String>,
    /// What the points that count say about the pose.
    pub(crate) support: Support,
    /// How much of what the scan could see of the model has points; none where that is not known.
    pub(crate) coverage: Option<Coverage>,
    /// What the rays of the model's scan, and of that of the points, say about the other; none where their viewpoints are not known.
    pub(crate) free_space: Vec<FreeSpaceResult>,
    /// Every pose that the model does not tell apart from this one because of its symmetries, this one first; none where they were
    /// not looked for.
    pub(crate) equivalent_poses: Vec<[[f64; 4]; 4]>,
    /// Poses in which the points fit as well, though the model is not the same there; of those that were looked at.
    pub(crate) rival_poses: Vec<[[f64; 4]; 4]>,
    /// Every step.
    pub(crate) history: Vec<RegisterStep>,
}

/// What the rays of a scan say about the other one.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct FreeSpaceResult {
    /// Whose rays: `model` or `points`.
    pub(crate) scan: &'static str,
    /// What they say.
    #[serde(flatten)]
    pub(crate) found: FreeSpace,
}

/// What was found out about the end of a registration.
#[derive(Clone, Debug, Default)]
pub(crate) struct Checks {
    pub(crate) coverage: Option<Coverage>,
    pub(crate) free_space: Vec<FreeSpaceResult>,
    /// A position in which the points fit distinctly better.
    pub(crate) elsewhere: Option<Elsewhere>,
    /// Twice the standard deviation of the pose at the corners of the model, where it is large for its size.
    pub(crate) lever: Option<f64>,
    /// The size of the model.
    pub(crate) model_size: f64,
    /// Whether as many other points lie on the model in another position.
    pub(crate) has_another_copy: bool,
    /// Positions that are none of a symmetry of the model, in which the points fit as well.
    pub(crate) rivals: Vec<Pose<3>>,
    /// How much better the mirror image of the points fits, where it does so distinctly.
    pub(crate) mirrored: Option<Elsewhere>,
}

/// A rotation.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Rotation {
    /// `[w, x, y, z]`.
    pub(crate) quaternion: [f64; 4],
    /// Unit axis.
    pub(crate) axis: [f64; 3],
    /// Angle about it in radians.
    pub(crate) angle: f64,
}

impl Rotation {
    /// That of a pose.
    pub(crate) fn of(pose: &Pose<3>) -> Self {
        let (axis, angle) = pose.axis_angle();
        Self { quaternion: pose.quaternion(), axis: axis.into(), angle }
    }
}

/// The content of the transform file of a result, with the poses that are equivalent to it.
pub(crate) fn transform(
    result: &RegisterReport<3>,
    equivalent: &[Pose<3>],
    checks: &Checks,
) -> TransformFile {
    let pose = &result.pose;
    TransformFile {
        matrix: pose.to_row_major(),
        rotation: Rotation::of(pose),
        translation: pose.translation().into(),
        scale: pose.scale,
        status: result.status.name(),
        rms: result.rms,
        initial_rms: result.initial_rms,
        iterations: result.iterations,
        points: result.points,
        points_used: result.used,
        points_dropped: result.dropped,
        distance_limit: result.limit,
        covariance: result.covariance.clone(),
        free_motions: result.free_motions.iter().map(ToString::to_string).collect(),
        support: result.support,
        coverage: checks.coverage,
        free_space: checks.free_space.clone(),
        equivalent_poses: equivalent.iter().map(Pose::<3>::to_row_major).collect(),
        rival_poses: checks.rivals.iter().map(Pose::<3>::to_row_major).collect(),
        history: result.history.clone(),
    }
}

/// One start and where it led.
#[derive(Debug, Serialize)]
pub(crate) struct StartResult {
    /// `given`, `init` or `search`.
    pub(crate) origin: &'static str,
    /// The starting pose, by rows.
    pub(crate) start: [[f64; 4]; 4],
    /// The pose it led to.
    pub(crate) matrix: [[f64; 4]; 4],
    /// How the iteration ended.
    pub(crate) status: &'static str,
    /// Number of steps.
    pub(crate) iterations: usize,
    /// Root mean square distance of the points that count.
    pub(crate) rms: f64,
    /// Mean squared distance, limited to 1.2 % of the diagonal of the model, as a share of that limit squared: by this
    /// the results are compared.
    pub(crate) score: f64,
    /// Share of the points within that limit.
    pub(crate) share_near: f64,
    /// Share of the points that lie on the model beyond what chance explains; by this registrations of clouds to clouds are compared.
    pub(crate) overlap: f64,
    /// Number of points that were registered: of a start that leads nowhere, some of them.
    pub(crate) points: usize,
    /// Seconds it took.
    pub(crate) seconds: f64,
}

impl StartResult {
    /// From a result.
    pub(crate) fn new(
        origin: &'static str,
        start: &Pose<3>,
        result: &RegisterReport<3>,
        fit: &Fit,
        seconds: f64,
    ) -> Self {
        Self {
            origin,
            start: start.to_row_major(),
            matrix: result.pose.to_row_major(),
            status: result.status.name(),
            iterations: result.iterations,
            rms: result.rms,
            score: fit.score,
            share_near: fit.near,
            overlap: fit.overlap,
            points: result.points,
            seconds,
        }
    }
}

/// What a registration found.
#[derive(Debug, Serialize)]
pub(crate) struct RegistrationResults {
    /// The motion.
    #[serde(flatten)]
    pub(crate) transform: TransformFile,
    /// Every start.
    pub(crate) starts: Vec<StartResult>,
    /// Index of the start that counts.
    pub(crate) best_start: usize,
    /// The deviations of the moved points, where they were to be judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) inspection: Option<Box<InspectionResults>>,
}

impl RegistrationResults {
    /// From the motion of the best result and all starts.
    pub(crate) fn new(transform: TransformFile, starts: Vec<StartResult>, best_start: usize) -> Self {
        Self { transform, starts, best_start, inspection: None }
    }
}
