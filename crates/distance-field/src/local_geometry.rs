//! Frames from derivatives: how a surface, an edge, a curve or a point bends as seen from a query.
//!
//! The residual `r` of a query is `x − foot`. Each function returns axes whose last one is the direction in which the
//! distance is measured, with the sign chosen so that it lies on the positive side of the shape if that has one.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// The part of a [`PrincipalFrame`](crate::PrincipalFrame) that follows from derivatives and residual.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalGeometry<const D: usize> {
    pub(crate) axes: SMatrix<f64, D, D>,
    pub(crate) curvatures: SVector<f64, D>,
    pub(crate) tangent_dimension: usize,
    pub(crate) distance: f64,
}

/// A regular point of a smooth surface (\[P05, eq. (5)\]); `None` where the surface is not regular.
#[inline]
pub(crate) fn of_surface(jet: &SurfaceJet, residual: &Vector3<f64>) -> Option<LocalGeometry<3>> {
    let frame = jet.principal_frame()?;
    Some(of_principal(&frame.directions, &frame.normal, frame.curvatures, residual))
}

/// A surface point with known principal directions, normal and curvatures.
#[inline]
pub(crate) fn of_principal(
    directions: &[Vector3<f64>; 2],
    normal: &Vector3<f64>,
    curvatures: [f64; 2],
    residual: &Vector3<f64>,
) -> LocalGeometry<3> {
    LocalGeometry {
        axes: Matrix3::from_columns(&[directions[0], directions[1], *normal]),
        curvatures: Vector3::new(curvatures[0], curvatures[1], 0.0),
        tangent_dimension: 2,
        distance: residual.dot(normal),
    }
}

/// A point of a curve in space or of an edge of a surface: the foot moves along the tangent only, and the normal plane
/// is measured in full. `side` tells which directions count as positive. `None` at singular points.
pub(crate) fn of_space_curve(
    jet: &CurveJet<3>,
    residual: &Vector3<f64>,
    side: Option<&Vector3<f64>>,
) -> Option<LocalGeometry<3>> {
    let tangent = jet.unit_tangent()?;
    let across = residual - tangent * tangent.dot(residual);
    let bend = jet.curvature_vector()?;
    let fallback = || {
        let side = side.map(|s| s - tangent * tangent.dot(s)).filter(|s| s.norm_squared() > 1e-20);
        let chosen = side.unwrap_or(bend);
        chosen.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(|| completed(&tangent)[0])
    };
    let (normal, distance) = oriented(&across, side).unwrap_or_else(|| (fallback(), 0.0));
    Some(LocalGeometry {
        axes: Matrix3::from_columns(&[tangent, normal.cross(&tangent), normal]),
        curvatures: Vector3::new(bend.dot(&normal), 0.0, 0.0),
        tangent_dimension: 1,
        distance,
    })
}

/// A point that cannot move: a corner, an apex, the end of a curve. `side` as for [`of_space_curve`].
pub(crate) fn of_point(residual: &Vector3<f64>, side: Option<&Vector3<f64>>) -> LocalGeometry<3> {
    let fallback = || side.and_then(|s| s.try_normalize(f64::MIN_POSITIVE)).unwrap_or_else(Vector3::z);
    let (normal, distance) = oriented(residual, side).unwrap_or_else(|| (fallback(), 0.0));
    let [first, second] = completed(&normal);
    LocalGeometry {
        axes: Matrix3::from_columns(&[first, second, normal]),
        curvatures: Vector3::zeros(),
        tangent_dimension: 0,
        distance,
    }
}

/// Direction and signed length of a vector; negative on the side away from `side`.
pub(crate) fn oriented<const D: usize>(
    vector: &SVector<f64, D>,
    side: Option<&SVector<f64, D>>,
) -> Option<(SVector<f64, D>, f64)> {
    let length = vector.norm();
    let sign = if side.is_some_and(|s| s.dot(vector) < 0.0) { -1.0 } else { 1.0 };
    (length > f64::MIN_POSITIVE).then(|| (vector * (sign / length), sign * length))
}

/// Two unit vectors that with `normal` make a right-handed orthonormal system (in this order, `normal` last).
pub(crate) fn completed(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let mut reference = Vector3::zeros();
    reference[normal.iamin()] = 1.0;
    let first = (reference - normal * normal.dot(&reference)).normalize();
    [first, normal.cross(&first)]
}
