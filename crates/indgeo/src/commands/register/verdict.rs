//! What the end of a registration is worth: the words for a doubt, flat clouds, and poses that a symmetric model does not tell apart.

use crate::commands::register::field::RegistrationField;
use crate::commands::register::model::RegistrationModel;
use crate::commands::register::request::Job;
use crate::commands::register::results::Checks;
use crate::commands::register::sight::Sights;
use crate::error::Error;
use industrial_geometry::mesh::nalgebra::{Matrix3x6, Matrix6, Vector3};
use industrial_geometry::register::{
    Coverage, Doubt, FreeMotion, Pose, RegisterOptions, RegisterReport, Status, Support, is_flat,
    shows_a_surface,
};

/// Uncertainty of the pose at the corners of the model, as a share of its size, that is told, and from which on the pose is open.
const NOTED: f64 = 0.01;
const OPEN: f64 = 0.05;

/// Share of the points that count from which nothing was left out that could fix what the others leave free.
const HARDLY_LEFT_OUT: f64 = 0.97;

/// The result, unless cloud and model both are clouds in a plane: then nothing fixes the motions in it.
pub(crate) fn flat(
    model: &RegistrationModel,
    points: &[Vector3<f64>],
    result: RegisterReport<3>,
) -> RegisterReport<3> {
    let RegistrationModel::Cloud(cloud) = model else { return result };
    if matches!(result.status, Status::Cancelled | Status::Diverged) || !is_flat(points) {
        return result;
    }
    let positions: Vec<Vector3<f64>> = cloud.positions().iter().map(|point| point.coords).collect();
    let status = if is_flat(&positions) { Status::Underdetermined } else { result.status };
    RegisterReport { status, ..result }
}

/// What is to be said about a result.
pub(crate) fn warning(result: &RegisterReport<3>, checks: &Checks, job: &Job<'_>) -> Option<String> {
    let (points, model) = (job.points.display(), job.model.display());
    let support = &result.support;
    if let Some(error) = checks.lever.filter(|_| support.doubt.is_none()) {
        let share = 100.0 * error / checks.model_size;
        return Some(format!(
            "{points} covers so little of {model} that the pose is uncertain by {error:.3} at the far corners of the model, {share:.1} % of \
             its size (two standard deviations): add points far from each other"
        ));
    }
    if result.status == Status::Underdetermined && support.doubt != Some(Doubt::Unfixed) {
        return Some(format!(
            "{points} and {model} lie in a plane each, in which nothing fixes the motion: give a model with some depth, or a profile \
             as a NURBS curve of the plane"
        ));
    }
    let advice = match support.doubt {
        None if result.status == Status::NoOverlap => {
            return Some(format!("no points of {points} are left that count; give a better start (--init)"));
        }
        None if held_back(support) => {
            return Some(format!(
                "the locked degrees of freedom keep {points} off {model} by much more than its noise ({support}): lock less, or start \
                 nearer, if that is not what is meant"
            ));
        }
        None if checks.has_another_copy => {
            return Some(format!(
                "about as many other points of {points} lie on {model} in another position: the cloud holds the part more than once, and \
                 this is one of its places; a start (--init) tells which one is meant"
            ));
        }
        None if support.exceeds_noise() && support.relative_rms > 0.005 => {
            return Some(format!(
                "{points} deviates from {model} by much more than its own noise ({support}): the pose is the best fit of a part \
                 that differs from its model, if it is the right part and place"
            ));
        }
        None => return None,
        Some(Doubt::Bare) => {
            let covered = checks.coverage.map_or_else(String::new, |coverage| format!(", {coverage}"));
            return Some(format!(
                "the pose is not to be trusted ({support}{covered}): the points are of something else that touches the model, or in \
                 another place: give a start (--init), or choose --start global"
            ));
        }
        Some(Doubt::FreeSpace) => {
            let found: Vec<String> =
                checks.free_space.iter().map(|one| format!("of the {}: {}", one.scan, one.found)).collect();
            return Some(format!(
                "the pose is not to be trusted ({support}; {}): what one scan saw through cannot be where the other one has points: \
                 give another start (--init), or choose --start global",
                found.join("; ")
            ));
        }
        Some(Doubt::Elsewhere) => {
            let found = checks.elsewhere.map_or_else(String::new, |elsewhere| elsewhere.to_string());
            return Some(format!(
                "the pose is not to be trusted ({support}): {found}: give a start near that (--init), or choose --start global"
            ));
        }
        Some(Doubt::Rival) => {
            let count = checks.rivals.len();
            return Some(format!(
                "the pose is not determined ({support}): the model nearly has a symmetry, and the points fit {} as well, where \
                 the model is not the same (`rival_poses`): they are not from where it tells \
                 them apart, of which more points are needed",
                if count == 1 {
                    "in another position".to_owned()
                } else {
                    format!("in {count} other positions")
                }
            ));
        }
        Some(Doubt::Mirrored) => {
            let found = checks.mirrored.map_or_else(String::new, |mirrored| mirrored.gain());
            return Some(format!(
                "the pose is not to be trusted ({support}): the mirror image of {points} fits better, {found}: check which hand the part \
                 is of, and that the axes of the file are right-handed"
            ));
        }
        Some(Doubt::Unresolved) => {
            return Some(format!(
                "the pose is not to be trusted ({support}): the points of {model} show no surface, as where a sheet is thinner than they are \
                 apart: give a denser cloud, one side of the sheet, or a mesh"
            ));
        }
        Some(Doubt::Unfixed) if job.options.scale => {
            "the points that count fit at other scales as well, as those of a plane do: add points of other faces, or leave out --scale"
        }
        Some(Doubt::Unfixed) => {
            return Some(format!(
                "the pose is not determined ({support}): the points leave open {}, which what was left out, or what {model} has elsewhere, \
                 would fix: give scans that have more in common, points of more of the model, or another start (--init, --start global)",
                result.free_motions.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
            ));
        }
        Some(Doubt::FewPoints) => {
            "hardly any points lie on the model: check that both are of the same part and in the same unit (--scale), give a start \
             (--init), or choose --start global"
        }
        Some(Doubt::NoSeparation) => {
            "as many points are just beside the model as on it, as where surfaces cross: give another start (--init), or choose \
             --start global"
        }
        Some(Doubt::Locks) => {
            "the locked degrees of freedom keep the points off the model: lock less, or start nearer"
        }
        Some(Doubt::Collapsed) => {
            "the estimated scale is none: give a start with about the right scale (--init)"
        }
        Some(_) => {
            "the points are much farther from the model than their own noise: another part, another place (--start global, --init), \
             or another unit (--scale)"
        }
    };
    Some(format!("the pose is not to be trusted ({support}): {advice}"))
}

/// Whether locks alone keep the points far from the model for their noise.
fn held_back(support: &Support) -> bool {
    let released = support.unlocked_rms.is_some_and(|rms| rms < 0.7 * support.relative_rms);
    support.exceeds_noise() && released
}

/// The result with what model and points say about it besides: how much of the model has points, and, of scans on scans of which it is
/// known from where they were seen, whether one floats in front of the other. A pose that is contradicted is
/// doubtful, and so is one that fits distinctly worse than another one.
pub(crate) fn checked(
    model: &RegistrationModel,
    field: &RegistrationField,
    result: RegisterReport<3>,
    points: &[Vector3<f64>],
    sights: &Sights,
    others: Checks,
) -> (RegisterReport<3>, Checks) {
    let mut checks = others;
    if !result.pose.is_finite() || result.status == Status::Cancelled {
        return (result, checks);
    }
    if let RegistrationField::Space(field) = field {
        checks.coverage = model
            .few_samples()
            .and_then(|samples| Coverage::of(field.as_ref(), &samples, points, &result.pose, result.limit));
        checks.free_space = sights.look(&result.pose);
    }
    let floats = checks.free_space.iter().find_map(|one| one.found.doubt());
    let bare = checks.coverage.and_then(|coverage| coverage.doubt(result.support.share));
    let better = checks.elsewhere.map(|_| Doubt::Elsewhere);
    let better = better.or((!checks.rivals.is_empty()).then_some(Doubt::Rival));
    let better = better.or(checks.mirrored.map(|_| Doubt::Mirrored)).or_else(|| of_clouds(model, &result));
    let is_unfixed = result.status == Status::Converged && is_fixed_by_model(model, field, &result);
    let better = better.or(is_unfixed.then_some(Doubt::Unfixed));
    // Where a part differs from its model its distances say little about the pose.
    if result.status == Status::Converged && !result.support.exceeds_noise() {
        (checks.lever, checks.model_size) = (lever(field, &result), field.diagonal());
    }
    match floats.or(bare).or(better).filter(|_| result.status == Status::Converged) {
        Some(doubt) => {
            let support = Support { doubt: Some(doubt), ..result.support };
            (RegisterReport { status: doubt.status(), support, ..result }, checks)
        }
        None if checks.lever.is_some_and(|error| error > OPEN * checks.model_size) => {
            (RegisterReport { status: Status::Underdetermined, ..result }, checks)
        }
        None => (result, checks),
    }
}

/// Whether the points leave motions free that the model fixes: they are not from where it does.
fn is_fixed_by_model(
    model: &RegistrationModel,
    field: &RegistrationField,
    result: &RegisterReport<3>,
) -> bool {
    if result.free_motions.is_empty() || matches!(model, RegistrationModel::Cloud(_)) {
        return false;
    }
    let RegistrationField::Space(field) = field else { return false };
    let Some(samples) = model.few_samples() else { return false };
    // Ends that the points lie between hold shifts, and turns in a plane, though none of the points resists them.
    let shifts = result.free_motions.iter().filter(|free| matches!(free, FreeMotion::Translation { .. }));
    let mut turns = result.free_motions.iter().filter(|free| matches!(free, FreeMotion::Rotation { .. }));
    shifts.count() <= 1 && turns.any(|free| free.is_fixed_by(field.as_ref(), &samples))
}

/// Why a pose of a cloud on a cloud is not believed: distances that two scans of one thing do not have, a model that shows no surface, or
/// motions that what the two have in common leaves free.
fn of_clouds(model: &RegistrationModel, result: &RegisterReport<3>) -> Option<Doubt> {
    let RegistrationModel::Cloud(cloud) = model else { return None };
    if result.status != Status::Converged {
        return None;
    }
    let is_unfixed = !result.free_motions.is_empty() && result.support.share < HARDLY_LEFT_OUT;
    if result.support.is_large_for_scans() {
        Some(Doubt::LargeDistances)
    } else if !shows_a_surface(cloud.positions()) {
        Some(Doubt::Unresolved)
    } else {
        is_unfixed.then_some(Doubt::Unfixed)
    }
}

/// Twice the standard deviation of the pose at that corner of the model where it is largest, if it is large for the size of the model.
fn lever(field: &RegistrationField, result: &RegisterReport<3>) -> Option<f64> {
    let covariance = result.covariance.as_ref().filter(|covariance| covariance.rows.len() >= 6)?;
    let matrix = Matrix6::from_fn(|i, j| covariance.rows[i][j]);
    let variance = |corner: &Vector3<f64>| {
        let arm = corner - covariance.origin;
        let moves = Matrix3x6::from_fn(|i, j| {
            if j < 3 { f64::from(u8::from(i == j)) } else { Vector3::ith(j - 3, 1.0).cross(&arm)[i] }
        });
        (moves * matrix * moves.transpose()).symmetric_eigenvalues().max()
    };
    let error = 2.0 * field.corners().iter().map(variance).fold(0.0, f64::max).sqrt();
    (error > NOTED * field.diagonal()).then_some(error)
}

/// Whether it makes sense to look for poses that the model does not tell apart, or hardly.
pub(crate) fn may_be_symmetric(
    model: &RegistrationModel,
    result: &RegisterReport<3>,
    options: &RegisterOptions<3>,
) -> bool {
    let has_area = matches!(
        model,
        RegistrationModel::Surfaces(_) | RegistrationModel::Mesh(_) | RegistrationModel::Cad(_)
    );
    has_area && result.is_converged() && !options.locks.any()
}

/// Of the poses that a symmetric model does not tell apart, the one nearest to the start, improved from there, and all of them.
pub(crate) fn nearest(
    group: &[Pose<3>],
    result: RegisterReport<3>,
    start: &Pose<3>,
    points: &[Vector3<f64>],
    improve: impl Fn(&Pose<3>) -> Result<RegisterReport<3>, Error>,
) -> Result<(RegisterReport<3>, Vec<Pose<3>>), Error> {
    // The first motion is the identity.
    let of = |pose: &Pose<3>| {
        let others = group.iter().skip(1).map(|motion| pose.followed_by(motion));
        std::iter::once(*pose).chain(others).collect::<Vec<_>>()
    };
    let distance = |pose: &Pose<3>| {
        let step = points.len().div_ceil(500).max(1);
        let finite = points.iter().step_by(step).filter(|x| x.iter().all(|c| c.is_finite()));
        finite.map(|x| (pose.apply(x) - start.apply(x)).norm_squared()).sum::<f64>()
    };
    let poses = of(&result.pose);
    let nearest = (1..poses.len()).fold(0, |best, i| {
        // Of equals, the first.
        if distance(&poses[i]) < distance(&poses[best]) * (1.0 - 1e-6) { i } else { best }
    });
    if nearest == 0 {
        return Ok((result, poses));
    }
    let other = improve(&poses[nearest])?;
    if !other.is_converged() || other.rms > result.rms * 1.01 + 1e-12 * result.pose.target_origin.norm() {
        return Ok((result, poses));
    }
    let poses = of(&other.pose);
    // What was told of the way there is that of the first result.
    let other = RegisterReport {
        initial_rms: result.initial_rms,
        iterations: result.iterations + other.iterations,
        evaluations: result.evaluations + other.evaluations,
        history: [result.history, other.history].concat(),
        ..other
    };
    Ok((other, poses))
}
