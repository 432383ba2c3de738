//! The motions that carry a shape into itself.

use crate::start::{OrientedPoints, Placement, axis_placements, refine_placement};
use crate::{Outliers, Pose, RegisterOptions, RegisterReport, Source, parallel, register, rotation};
use distance_field::{DistanceField, Search};
use nalgebra::Vector3;

/// Points of the shape that are laid on it, in the coarse look and in the exact one.
const COARSE_POINTS: usize = 300;
const POINTS: usize = 600;
/// Points by which is judged whether all of the shape lies on itself.
const CHECKED: usize = 6000;
/// How much farther than few points all may be: holes of meshes are polygons.
const ROUNDED: f64 = 5.0;
/// Root mean square displacement, as a share of the size, by which a motion may be known.
const MOVED: f64 = 0.01;
/// Most motions that are found: 60 is what an icosahedron has, 2n a prism with n sides.
const MOST: usize = 240;
/// Largest distance, as a share of the size of the shape, of points that a motion lays on the shape.
const EXACT: f64 = 1e-4;
/// Share of the points that a motion lays on the shape roughly, for it to be looked at.
const ROUGH: f64 = 0.8;
/// Root mean square displacement, as a share of the size, from which a motion is another one than a known symmetry.
const NEAR: f64 = 0.03;
/// Angle, in radians, and distance as a share of the size, up to which two motions are the same.
const SAME: f64 = 5e-3;

/// The proper motions (no reflections) that carry a shape into itself but for `abs_tolerance`, the identity first: 24 for a cube,
/// 4 for a box, 12 for a hexagonal prism, 1 for most shapes.
///
/// `samples` are points with normals spread evenly over the shape. Found are the groups that follow from the principal axes, which
/// are those of all solids with finitely many symmetries that have no more than 240; for surfaces of revolution, which have infinitely
/// many, the result is the identity alone. A distance up to a ten-thousandth of the size of the shape always counts as none.
#[must_use]
pub fn symmetries(
    field: &dyn DistanceField<3>,
    samples: &OrientedPoints,
    abs_tolerance: f64,
) -> Vec<Pose<3>> {
    symmetries_and_near(field, samples, abs_tolerance).0
}

/// [`symmetries`], and motions that lay most of the shape near itself, but not all of it: what a plate with one hole has. The latter are
/// roughly known.
#[must_use]
pub fn symmetries_and_near(
    field: &dyn DistanceField<3>,
    samples: &OrientedPoints,
    abs_tolerance: f64,
) -> (Vec<Pose<3>>, Vec<Pose<3>>) {
    let identity = Pose::identity();
    let Some(bounds) = samples.bounding_box().filter(|bounds| bounds.diagonal() > 0.0) else {
        return (vec![identity], Vec::new());
    };
    let rough = roughly(samples, &bounds.centre(), bounds.diagonal());
    if rough.len() < 2 {
        // Most shapes do not lie on themselves in any other position.
        return (vec![identity], Vec::new());
    }
    let group = exact(field, samples, abs_tolerance, &rough);
    // Of bodies of revolution there would be no end.
    let Some(group) = group else { return (vec![identity], Vec::new()) };
    let step = samples.len().div_ceil(POINTS).max(1);
    let apart = |a: &Pose<3>, b: &Pose<3>| {
        let moved = samples.points().iter().step_by(step).map(|x| (a.apply(x) - b.apply(x)).norm_squared());
        let count = samples.points().iter().step_by(step).count().max(1);
        (moved.sum::<f64>() / count as f64).sqrt() > NEAR * bounds.diagonal()
    };
    let near = rough.into_iter().filter(|motion| group.iter().all(|known| apart(known, motion))).collect();
    (group, near)
}

/// Whether a motion carries a shape into itself but for `abs_tolerance`, and for what it is roughly known by: a hundredth of its size.
///
/// `samples` are points with normals spread evenly over the shape.
#[must_use]
pub fn is_symmetry(
    field: &dyn DistanceField<3>,
    samples: &OrientedPoints,
    motion: &Pose<3>,
    abs_tolerance: f64,
) -> bool {
    let size = samples.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
    let every = |most: usize| samples.points().iter().step_by(samples.len().div_ceil(most).max(1));
    let points: Vec<Vector3<f64>> = every(POINTS).copied().collect();
    let tolerance = abs_tolerance.max(EXACT * size);
    let Some(found) = next_to(field, &points, motion).filter(|found| found.pose.is_finite()) else {
        return false;
    };
    let moved = points.iter().map(|x| (found.pose.apply(x) - motion.apply(x)).norm_squared()).sum::<f64>();
    moved <= (MOVED * size).powi(2) * points.len() as f64
        && lies_on_itself(field, samples, &found.pose, tolerance)
}

/// Whether a motion lays all samples of a shape on it but for a tolerance.
fn lies_on_itself(
    field: &dyn DistanceField<3>,
    samples: &OrientedPoints,
    motion: &Pose<3>,
    tolerance: f64,
) -> bool {
    let every = samples.points().iter().step_by(samples.len().div_ceil(CHECKED).max(1));
    let moved: Vec<Vector3<f64>> = every.map(|x| motion.apply(x)).collect();
    let frames = field.frames(&moved, Search::Global, &[]);
    frames.iter().all(|frame| frame.is_finite() && frame.distance.abs() <= ROUNDED * tolerance)
}

/// The registration of points of a shape to it from a motion.
fn next_to(
    field: &dyn DistanceField<3>,
    points: &[Vector3<f64>],
    from: &Pose<3>,
) -> Option<RegisterReport<3>> {
    let options = RegisterOptions::default().with_outliers(Outliers::None).with_max_iterations(30);
    register(field, &Source::new(points), from, &options).ok()
}

/// The group of the motions next to rough ones that carry a shape into itself; `None` where one of them is not alone.
fn exact(
    field: &dyn DistanceField<3>,
    samples: &OrientedPoints,
    abs_tolerance: f64,
    rough: &[Pose<3>],
) -> Option<Vec<Pose<3>>> {
    let identity = Pose::identity();
    let size = samples.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
    let tolerance = abs_tolerance.max(EXACT * size);
    let step = samples.len().div_ceil(POINTS).max(1);
    let points: Vec<Vector3<f64>> = samples.points().iter().copied().step_by(step).collect();
    let Some(Some(_)) = exactly(field, &points, &identity, tolerance) else { return None };
    let exact = parallel::tasks(rough.len(), |k| exactly(field, &points, &rough[k], tolerance));
    // Few points do not meet every small hole.
    let exact = exact.into_iter().map(|found| match found {
        Some(Some(motion)) if !lies_on_itself(field, samples, &motion, tolerance) => None,
        other => other,
    });
    let mut group = vec![identity];
    let mut generators: Vec<Pose<3>> = Vec::new();
    let centre = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let same = |a: &Pose<3>, b: &Pose<3>| {
        let turn = rotation::logarithm(&(a.rotation.transpose() * b.rotation)).norm();
        turn < SAME && (a.apply(&centre) - b.apply(&centre)).norm() < SAME * size
    };
    for found in exact.flatten() {
        let found = found?;
        if !group.iter().any(|known| same(known, &found)) {
            generators.push(found);
            close(&mut group, &generators, &same);
            if group.len() > MOST {
                return None;
            }
        }
    }
    // Products of found motions carry rounding along, and whoever is no symmetry by itself is none.
    let settled = parallel::tasks(group.len(), |k| {
        if k == 0 { Some(Some(identity)) } else { exactly(field, &points, &group[k], tolerance) }
    });
    Some(
        settled
            .into_iter()
            .map(Option::flatten)
            .collect::<Option<Vec<_>>>()
            .unwrap_or_else(|| vec![identity]),
    )
}

/// All products of generators, as long as they are not too many.
fn close(group: &mut Vec<Pose<3>>, generators: &[Pose<3>], same: &dyn Fn(&Pose<3>, &Pose<3>) -> bool) {
    let mut next = 0;
    group.truncate(1);
    while next < group.len() && group.len() <= MOST {
        for generator in generators {
            let product = group[next].followed_by(generator);
            if !group.iter().any(|known| same(known, &product)) {
                group.push(product);
            }
        }
        next += 1;
    }
}

/// Motions that lay most of the samples near others, from the principal axes.
fn roughly(samples: &OrientedPoints, centre: &Vector3<f64>, size: f64) -> Vec<Pose<3>> {
    let few: Vec<usize> = (0..samples.len()).step_by((samples.len() / 3000).max(1)).collect();
    let scaled = samples.scaled(&few, centre, size);
    let placements: Vec<Placement> = axis_placements(&scaled);
    let found = refine_placement(&scaled, &placements, COARSE_POINTS);
    let good = found.into_iter().filter(|(share, _)| *share >= ROUGH);
    good.map(|(_, placement)| placement.to_pose(centre, centre, size)).collect()
}

/// The motion next to a given one that carries the shape into itself: `None` if there is none, `Some(None)` if it is not the only
/// one, as on surfaces of revolution.
#[allow(clippy::option_option, reason = "no motion, and not one motion alone, are different answers")]
fn exactly(
    field: &dyn DistanceField<3>,
    points: &[Vector3<f64>],
    from: &Pose<3>,
    tolerance: f64,
) -> Option<Option<Pose<3>>> {
    let report = next_to(field, points, from)?;
    let moved: Vec<Vector3<f64>> = points.iter().map(|x| report.pose.apply(x)).collect();
    let frames = field.frames(&moved, Search::Global, &[]);
    let fits = frames.iter().all(|frame| frame.is_finite() && frame.distance.abs() <= tolerance);
    fits.then(|| report.free_motions.is_empty().then_some(report.pose))
}
