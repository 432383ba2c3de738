//! Positions elsewhere in which the points fit distinctly better than where the iteration ended.
//!
//! A scan that ends tilted through a thin plate, or with one flange of a bracket on the other, lies near the model everywhere, and its
//! distances may be no larger than those of a part that was made badly. What tells the two apart is that the badly made part fits
//! nowhere better.

use crate::commands::register::field::{Fit, RegistrationField};
use industrial_geometry::mesh::nalgebra::{Matrix3, SymmetricEigen, Vector3};
use industrial_geometry::register::{Pose, RegisterReport, rotation};
use std::f64::consts::PI;
use std::fmt;

/// Root mean square distance, as a share of the size of the points that count, from which an end is looked at if it is more than the noise
/// of the points explains.
const NOTED: f64 = 0.002;
/// Share of the points that count below which all positions are searched: on a model with an area, and on a cloud, which need not have
/// much in common with the points; and the share below which positions beside the end are tried, which takes less time.
pub(crate) const LEFT_OUT: f64 = 0.97;
const LEFT_OUT_OF_CLOUDS: f64 = 0.35;
const LEFT_OUT_BESIDE: f64 = 0.97;
/// The same for all positions, where the points that count leave motions free: the few others are all that could tell.
const LEFT_OUT_IF_FREE: f64 = 0.997;
/// Limit of the distances, as a share of the size of the model, and share of the points within, over that at the end, from which half a
/// turn of a cloud is worth a registration; and points that are looked at.
const ROUGHLY: f64 = 0.03;
const MOST: f64 = 0.8;
const LOOKED_AT: usize = 300;
/// Score of a position over that of the end below which it is distinctly better: the root mean square distance is seven tenths then.
/// An end that is not where the start leads, but where the model nearly lies on itself, has to be the best one.
const DISTINCTLY: f64 = 0.5;
const AT_ALL: f64 = 0.9;
/// Root mean square distance in units of the noise that the points show among themselves above which positions beside the end are tried.
const UNEXPLAINED: f64 = 1.5;
/// How far beside, in root mean square distances: points spread evenly between the sides of a sheet are off by at most 1.7 of them.
const BESIDE: f64 = 3.5;
/// Share of the points near the model that are near it in another position, at least, and that are so in both, at most, for these to be
/// of two copies of the part.
const AS_MANY: f64 = 0.7;
const IN_COMMON: f64 = 0.2;
/// Scores that differ by less do not differ.
const SAME: f64 = 1e-4;
/// Overlap of a position over that of the end above which it is distinctly better, where clouds are compared by it.
const MORE: f64 = 1.5;

/// A position in which the points fit distinctly better than at the end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Elsewhere {
    /// How well they fit at the end, and there.
    pub(crate) fits: [Fit; 2],
    /// Angle between the two, radians.
    pub(crate) angle: f64,
    /// Whether they were compared by the overlap of two clouds.
    pub(crate) by_overlap: bool,
}

impl Elsewhere {
    /// By what they fit better there.
    pub(crate) fn gain(&self) -> String {
        let [end, there] = &self.fits;
        if self.by_overlap {
            let [here, other] = [end, there].map(|fit| 100.0 * fit.overlap);
            format!("{other:.1} % of the points lie on the model instead of {here:.1} %")
        } else {
            let [here, other] = [end, there].map(|fit| 100.0 * fit.typical_distance());
            format!("the points are {other:.2} % of the size of the model from it instead of {here:.2} %")
        }
    }
}

impl fmt::Display for Elsewhere {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let degrees = self.angle.to_degrees();
        write!(f, "in another position, turned by {degrees:.1} degrees, {}", self.gain())
    }
}

/// Which other positions are to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Look {
    /// None: the end explains the points.
    Nowhere,
    /// Half turns of the points, and the sides of a sheet through which they may lie.
    Beside,
    /// All positions.
    Everywhere,
}

impl Look {
    /// Where to look, by what an end leaves unexplained; `explained` is the share of the points that lie on the model or are scattered
    /// off it.
    pub(crate) fn after(result: &RegisterReport<3>, explained: f64, is_on_cloud: bool) -> Self {
        let support = &result.support;
        let all = match (is_on_cloud, result.free_motions.is_empty()) {
            (true, true) => LEFT_OUT_OF_CLOUDS,
            (true, false) => LEFT_OUT_BESIDE,
            (false, true) => LEFT_OUT,
            (false, false) => LEFT_OUT_IF_FREE,
        };
        if support.exceeds_noise() && support.relative_rms > NOTED || explained < all {
            Self::Everywhere
        } else if is_unexplained(result) || explained < LEFT_OUT_BESIDE {
            Self::Beside
        } else {
            Self::Nowhere
        }
    }
}

/// Whether one fit is distinctly better than another one, or, if `at_all`, better.
pub(crate) fn is_better(fit: &Fit, than: &Fit, by_overlap: bool, at_all: bool) -> bool {
    let is_closer = fit.score < if at_all { AT_ALL } else { DISTINCTLY } * than.score - SAME;
    if by_overlap {
        fit.overlap > MORE * than.overlap || is_closer && fit.overlap > than.overlap
    } else {
        is_closer
    }
}

/// Whether a position of points, or of their image, is worth a registration: about as many of them lie roughly on the model as at the end.
pub(crate) fn lies_roughly(
    field: &RegistrationField,
    [points, image]: [&[Vector3<f64>]; 2],
    end: &Pose<3>,
    there: &Pose<3>,
) -> bool {
    let near = |points: &[Vector3<f64>], pose: &Pose<3>| {
        let step = points.len().div_ceil(LOOKED_AT).max(1);
        let some = points.iter().step_by(step).filter(|x| x.iter().all(|c| c.is_finite()));
        let moved: Vec<Vector3<f64>> = some.map(|x| pose.apply(x)).collect();
        let limit = ROUGHLY * field.diagonal();
        field.distances(&moved).iter().filter(|distance| **distance < limit).count() as f64
    };
    near(image, there) >= MOST * near(points, end)
}

/// Whether two positions lay about as many points on the model, but other ones: the cloud holds the part twice.
pub(crate) fn is_another_copy(here: &[bool], there: &[bool]) -> bool {
    let count = |near: &[bool]| near.iter().filter(|near| **near).count() as f64;
    let common = here.iter().zip(there).filter(|(one, other)| **one && **other).count() as f64;
    let own = count(here);
    count(there) >= AS_MANY * own && common <= IN_COMMON * own
}

/// Whether an end leaves so much unexplained that the mirror image of the points is to be tried: a part of the other hand fits in most
/// places, and where it does not its points are left out.
pub(crate) fn may_be_mirrored(result: &RegisterReport<3>, explained: f64) -> bool {
    is_unexplained(result) || explained < LEFT_OUT_BESIDE
}

/// Whether the distances are more than the noise that the points show among themselves.
fn is_unexplained(result: &RegisterReport<3>) -> bool {
    let support = &result.support;
    support.own_noise.is_some_and(|noise| support.relative_rms > UNEXPLAINED * noise)
}

/// Moved points, their centre and their principal axes, the thinnest one first; in the plane its axes.
struct Axes {
    moved: Vec<Vector3<f64>>,
    centre: Vector3<f64>,
    axes: Vec<Vector3<f64>>,
}

impl Axes {
    /// `None` without points.
    fn of(points: &[Vector3<f64>], pose: &Pose<3>, is_planar: bool) -> Option<Self> {
        let moved: Vec<Vector3<f64>> = points.iter().map(|x| pose.apply(x)).collect();
        let finite = || moved.iter().filter(|x| x.iter().all(|c| c.is_finite()));
        let count = finite().count();
        let centre = finite().sum::<Vector3<f64>>() / count.max(1) as f64;
        let spread = finite().fold(Matrix3::zeros(), |sum, x| sum + (x - centre) * (x - centre).transpose());
        if count == 0 || !spread.iter().all(|value| value.is_finite()) {
            return None;
        }
        if is_planar {
            return Some(Self { moved, centre, axes: vec![Vector3::x(), Vector3::y()] });
        }
        let eigen = SymmetricEigen::new(spread);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
        let axes = order.map(|k| eigen.eigenvectors.column(k).normalize());
        Some(Self { moved, centre, axes: axes.to_vec() })
    }
}

/// Positions beside an end: the points turned by half a turn about their principal axes, where parts that are flat, or long, come to lie as
/// well, and shifted along the thinnest one to either side, by a multiple of their root mean square distance, where that is more than noise.
pub(crate) fn beside(points: &[Vector3<f64>], end: &RegisterReport<3>, is_planar: bool) -> Vec<Pose<3>> {
    let pose = &end.pose;
    let Some(Axes { centre, axes, .. }) = Axes::of(points, pose, is_planar) else { return Vec::new() };
    let turned = |axis: &Vector3<f64>| {
        let turn = rotation::exponential::<3>(&(axis * PI)).0;
        pose.followed_by(&Pose { scale: 1.0, rotation: turn, source_origin: centre, target_origin: centre })
    };
    if is_planar {
        return vec![turned(&Vector3::z())];
    }
    let shifted =
        |side: f64| Pose { target_origin: pose.target_origin + axes[0] * (side * BESIDE * end.rms), ..*pose };
    let sides = if is_unexplained(end) { vec![shifted(1.0), shifted(-1.0)] } else { Vec::new() };
    sides.into_iter().chain(axes.iter().map(turned)).collect()
}

/// The mirror images of moved points through their centre across each of their principal axes, with what mirrors their directions.
pub(crate) fn mirror_images(
    points: &[Vector3<f64>],
    pose: &Pose<3>,
    is_planar: bool,
) -> Vec<(Vec<Vector3<f64>>, Matrix3<f64>)> {
    let Some(Axes { moved, centre, axes }) = Axes::of(points, pose, is_planar) else { return Vec::new() };
    let image = |axis: &Vector3<f64>| {
        let across = Matrix3::identity() - axis * axis.transpose() * 2.0;
        (moved.iter().map(|x| across * (x - centre) + centre).collect(), across)
    };
    axes.iter().map(image).collect()
}
