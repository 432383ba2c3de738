//! Curves that continue others.

use super::start::{Start, start};
use crate::error::Error;
use crate::fits::boundary::ContinuityChoice;
use crate::report::Report;
use industrial_geometry::fit::curve::CurveEnd;
use industrial_geometry::nurbs::nalgebra::{SVector, Vector3};
use industrial_geometry::nurbs::{BsplineCurve, ParametricCurve};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What counts as met: gap as a share of the length, and angle in radians.
const GAP: f64 = 1e-9;
const ANGLE: f64 = 1e-6;

/// The curves that a curve continues.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joins<'a> {
    pub(crate) files: &'a [PathBuf],
    pub(crate) continuity: ContinuityChoice,
}

/// An end that continues another curve.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CurveJoin {
    /// The file of that curve.
    pub(crate) file: PathBuf,
    /// Distance of the end from it.
    pub(crate) gap: f64,
    /// Angle between the tangents there, in radians.
    pub(crate) angle: f64,
}

impl Joins<'_> {
    /// The ends of the neighbours that are nearest to the points: places, and directions away from the neighbours.
    pub(crate) fn read(
        &self,
        points: &[Vector3<f64>],
        report: &mut Report,
    ) -> Result<Vec<[Vector3<f64>; 2]>, Error> {
        self.files
            .iter()
            .map(|path| {
                let ends = match start(path, "neighbour", report)? {
                    Start::Plane(curve) => ends_of(&curve),
                    Start::Space(curve) => ends_of(&curve),
                };
                let away = |end: &[Vector3<f64>; 2]| {
                    points.iter().map(|p| (p - end[0]).norm_squared()).fold(f64::INFINITY, f64::min)
                };
                let nearest = ends.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)));
                nearest.ok_or_else(|| closed(path))
            })
            .collect()
    }

    /// The ends as options of the fit.
    pub(crate) fn given(&self, ends: &[[Vector3<f64>; 2]]) -> [Option<CurveEnd>; 2] {
        [0, 1].map(|k| {
            ends.get(k).map(|[place, direction]| CurveEnd {
                point: (*place).into(),
                direction: (self.continuity == ContinuityChoice::G1).then_some((*direction).into()),
            })
        })
    }

    /// How the ends of a curve meet those of the neighbours; whether not well enough is said.
    pub(crate) fn measured<const D: usize>(
        &self,
        ends: &[[Vector3<f64>; 2]],
        curve: &BsplineCurve<D>,
        length: f64,
        report: &mut Report,
    ) -> (Vec<CurveJoin>, bool) {
        // Directions out of the neighbour, and so into the curve.
        let own = ends_of(curve).map(|[place, direction]| [place, -direction]);
        let mut unmet = false;
        let joins = ends.iter().zip(self.files).map(|([place, direction], file)| {
            let gap_to = |end: &[Vector3<f64>; 2]| (end[0] - place).norm();
            let [a, b] = &own;
            let end = if gap_to(b) < gap_to(a) { b } else { a };
            let angle = end[1].cross(direction).norm().atan2(end[1].dot(direction));
            let join = CurveJoin { file: file.clone(), gap: gap_to(end), angle };
            let is_bent = self.continuity == ContinuityChoice::G1 && (angle.is_nan() || angle.abs() > ANGLE);
            if join.gap.is_nan() || join.gap > GAP * length || is_bent {
                report.warnings.push(format!(
                    "{}: the curve ends {:.3e} from it, at an angle of {angle:.3e} radians",
                    file.display(),
                    join.gap
                ));
                unmet = true;
            }
            join
        });
        let joins = joins.collect();
        (joins, unmet)
    }
}

fn closed(path: &Path) -> Error {
    Error::content(path, "the curve is closed: it has no end to go on from", "give an open curve")
}

/// The ends of a curve, each with the unit direction out of it.
fn ends_of<const D: usize>(curve: &BsplineCurve<D>) -> [[Vector3<f64>; 2]; 2] {
    let domain = curve.domain();
    [(domain.start(), -1.0), (domain.end(), 1.0)].map(|(t, sense)| {
        let jet = curve.jet(t);
        let in_space = |v: &SVector<f64, D>| Vector3::from_fn(|i, _| if i < D { v[i] } else { 0.0 });
        let direction = jet.unit_tangent().map_or_else(Vector3::zeros, |way| in_space(&way) * sense);
        [in_space(&jet.point), direction]
    })
}
