//! Positions elsewhere in which the points fit distinctly better than where the iteration ended.
//!
//! A scan that ends tilted through a thin plate, or with one flange of a bracket on the other, lies near the model everywhere, and its
//! distances may be no larger than those of a part that was made badly. What tells the two apart is that the badly made part fits
//! nowhere better.

use crate::registration_field::Fit;
use industrial_geometry::mesh::nalgebra::{Matrix3, SymmetricEigen, Vector3};
use industrial_geometry::register::{Pose, RegisterReport, rotation};
use std::f64::consts::PI;
use std::fmt;

/// Root mean square distance, as a share of the size of the points that count, from which an end is looked at if it is more than the noise
/// of the points explains.
const NOTED: f64 = 0.002;
/// Share of the points that count below which all positions are searched: on a model with an area, and on a cloud, which need not have
/// much in common with the points; and the share below which positions beside the end are tried, which takes less time.
const LEFT_OUT: f64 = 0.85;
const LEFT_OUT_OF_CLOUDS: f64 = 0.35;
const LEFT_OUT_BESIDE: f64 = 0.97;
/// Score of a position over that of the end below which it is distinctly better: the root mean square distance is seven tenths then.
/// An end that is not where the start leads, but where the model nearly lies on itself, has to be the best one.
const DISTINCTLY: f64 = 0.5;
const AT_ALL: f64 = 0.9;
/// Root mean square distance in units of the noise that the points show among themselves above which positions beside the end are tried.
const UNEXPLAINED: f64 = 1.5;
/// How far beside, in root mean square distances: points spread evenly between the sides of a sheet are off by at most 1.7 of them.
const BESIDE: f64 = 3.5;
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

impl fmt::Display for Elsewhere {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [end, there] = &self.fits;
        let degrees = self.angle.to_degrees();
        if self.by_overlap {
            let [here, other] = [end, there].map(|fit| 100.0 * fit.overlap);
            write!(
                f,
                "in another position, turned by {degrees:.1} degrees, {other:.1} % of the points lie on the model instead of {here:.1} %"
            )
        } else {
            let [here, other] = [end, there].map(|fit| 100.0 * fit.typical_distance());
            write!(
                f,
                "in another position, turned by {degrees:.1} degrees, the points are {other:.2} % of the size of the model from it \
                 instead of {here:.2} %"
            )
        }
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
    /// Where to look, by what an end leaves unexplained.
    pub(crate) fn after(result: &RegisterReport<3>, is_on_cloud: bool) -> Self {
        let support = &result.support;
        let [all, beside] = if is_on_cloud { [LEFT_OUT_OF_CLOUDS; 2] } else { [LEFT_OUT, LEFT_OUT_BESIDE] };
        if support.exceeds_noise() && support.relative_rms > NOTED || support.share < all {
            Self::Everywhere
        } else if support.own_noise.is_some_and(|noise| support.relative_rms > UNEXPLAINED * noise)
            || support.share < beside
        {
            Self::Beside
        } else {
            Self::Nowhere
        }
    }
}

/// Whether one fit is distinctly better than another one, or, if `at_all`, better.
pub(crate) fn is_better(fit: &Fit, than: &Fit, by_overlap: bool, at_all: bool) -> bool {
    if by_overlap {
        fit.overlap > MORE * than.overlap
    } else {
        fit.score < if at_all { AT_ALL } else { DISTINCTLY } * than.score - SAME
    }
}

/// Positions beside an end: the points turned by half a turn about their principal axes, where parts that are flat, or long, come to lie as
/// well, and shifted along the thinnest one to either side, by a multiple of their root mean square distance.
pub(crate) fn beside(points: &[Vector3<f64>], end: &RegisterReport<3>, is_planar: bool) -> Vec<Pose<3>> {
    let pose = &end.pose;
    let moved: Vec<Vector3<f64>> =
        points.iter().filter(|x| x.iter().all(|c| c.is_finite())).map(|x| pose.apply(x)).collect();
    let centre = moved.iter().sum::<Vector3<f64>>() / moved.len().max(1) as f64;
    let spread = moved.iter().fold(Matrix3::zeros(), |sum, x| sum + (x - centre) * (x - centre).transpose());
    if moved.is_empty() || !spread.iter().all(|value| value.is_finite()) {
        return Vec::new();
    }
    let eigen = SymmetricEigen::new(spread);
    let axis = |k: usize| if is_planar { Vector3::z() } else { eigen.eigenvectors.column(k).normalize() };
    let turned = (0..if is_planar { 1 } else { 3 }).map(|k| {
        let turn = rotation::exponential::<3>(&(axis(k) * PI)).0;
        pose.followed_by(&Pose { scale: 1.0, rotation: turn, source_origin: centre, target_origin: centre })
    });
    // In the plane the thinnest axis is z, which is none.
    let thinnest = if is_planar { None } else { Some(axis(eigen.eigenvalues.imin())) };
    let shifted = thinnest.into_iter().flat_map(|axis| {
        [1.0, -1.0].map(|side| Pose {
            target_origin: pose.target_origin + axis * (side * BESIDE * end.rms),
            ..*pose
        })
    });
    shifted.chain(turned).collect()
}
