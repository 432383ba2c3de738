//! Frames from derivatives: how a surface, an edge, a curve or a point bends as seen from a query.
//!
//! The residual `r` of a query is `x − foot`. Each function returns axes whose last one is the direction in which the
//! distance is measured, with the sign chosen so that it lies on the positive side of the shape if that has one.

use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};
use nurbs_core::{CurveJet, SurfaceJet};

/// Length of what is left of a unit vector without its parts along others, below which it is a combination of these.
const INDEPENDENT: f64 = 1e-6;

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
    Some(of_principal(&frame.directions, &frame.normal, frame.curvatures, residual.dot(&frame.normal)))
}

/// A surface point with known principal directions, normal and curvatures.
#[inline]
pub(crate) fn of_principal(
    directions: &[Vector3<f64>; 2],
    normal: &Vector3<f64>,
    curvatures: [f64; 2],
    distance: f64,
) -> LocalGeometry<3> {
    LocalGeometry {
        axes: Matrix3::from_columns(&[directions[0], directions[1], *normal]),
        curvatures: Vector3::new(curvatures[0], curvatures[1], 0.0),
        tangent_dimension: 2,
        distance,
    }
}

/// A surface point with a second fundamental form, given as a symmetric tensor whose part normal to `normal` counts.
pub(crate) fn of_tensor(tensor: &Matrix3<f64>, normal: &Vector3<f64>, distance: f64) -> LocalGeometry<3> {
    let [x, y] = tangents(normal);
    let (tx, ty) = (tensor * x, tensor * y);
    let (directions, curvatures) = principal_axes([x.dot(&tx), x.dot(&ty), y.dot(&ty)], [x, y]);
    of_principal(&directions, normal, curvatures, distance)
}

/// A point of a curve in the plane with a known unit normal, and its second fundamental form as a symmetric tensor of
/// which the part along the tangent counts.
pub(crate) fn of_plane_normal(
    tensor: &Matrix2<f64>,
    normal: &Vector2<f64>,
    distance: f64,
) -> LocalGeometry<2> {
    let tangent = Vector2::new(-normal.y, normal.x);
    LocalGeometry {
        axes: Matrix2::from_columns(&[tangent, *normal]),
        curvatures: Vector2::new(tangent.dot(&(tensor * tangent)), 0.0),
        tangent_dimension: 1,
        distance,
    }
}

/// Principal directions and curvatures `κ₁ ≥ κ₂` of the form `a ξ² + 2 b ξη + c η²` on orthonormal tangents.
pub(crate) fn principal_axes(
    [a, b, c]: [f64; 3],
    [x, y]: [Vector3<f64>; 2],
) -> ([Vector3<f64>; 2], [f64; 2]) {
    let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
    let square = half * half + b * b;
    let radius = if square.is_normal() { square.sqrt() } else { half.hypot(b) };
    // Half of the angle of (half, b), between −90 and 90 degrees: its larger function by the root, the other by their product.
    let larger = if radius > 0.0 { (0.5 + 0.5 * half.abs() / radius).sqrt() } else { 1.0 };
    let smaller = if radius > 0.0 { 0.5 * b.abs() / radius / larger } else { 0.0 };
    let (cosine, sine) = if half < 0.0 { (smaller, larger) } else { (larger, smaller) };
    let sine = sine.copysign(b);
    ([x * cosine + y * sine, y * cosine - x * sine], [mean + radius, mean - radius])
}

/// A point of a curve or of an edge of a surface: the foot moves along the tangent only, and all directions normal to
/// it are measured in full (\[P05, eqs. (3)-(4)\] in the plane).
///
/// `side` tells which directions count as positive. `None` at singular points.
pub(crate) fn of_curve<const D: usize>(
    jet: &CurveJet<D>,
    residual: &SVector<f64, D>,
    side: Option<&SVector<f64, D>>,
) -> Option<LocalGeometry<D>> {
    let tangent = jet.unit_tangent()?;
    let bend = jet.curvature_vector()?;
    Some(of_bend(&tangent, &bend, residual, side))
}

/// A point of a curve with the given unit tangent and curvature vector.
pub(crate) fn of_bend<const D: usize>(
    tangent: &SVector<f64, D>,
    bend: &SVector<f64, D>,
    residual: &SVector<f64, D>,
    side: Option<&SVector<f64, D>>,
) -> LocalGeometry<D> {
    let across = residual - tangent * tangent.dot(residual);
    let sign = if side.is_some_and(|s| s.dot(&across) < 0.0) { -1.0 } else { 1.0 };
    let found = independent(&(across * sign), &[*tangent]);
    let chosen = || side.and_then(|s| independent(s, &[*tangent])).or_else(|| independent(bend, &[*tangent]));
    let normal = found.or_else(chosen).unwrap_or_else(|| another(&[*tangent]));
    let mut curvatures = SVector::zeros();
    curvatures[0] = bend.dot(&normal);
    LocalGeometry {
        axes: completed(&[*tangent], &normal),
        curvatures,
        tangent_dimension: 1,
        distance: residual.dot(&normal),
    }
}

/// A point that cannot move: a corner, an apex, the end of a curve. `side` as for [`of_curve`].
pub(crate) fn of_point<const D: usize>(
    residual: &SVector<f64, D>,
    side: Option<&SVector<f64, D>>,
) -> LocalGeometry<D> {
    let sign = if side.is_some_and(|s| s.dot(residual) < 0.0) { -1.0 } else { 1.0 };
    let found = independent(&(residual * sign), &[]);
    let normal = found.or_else(|| side.and_then(|s| independent(s, &[]))).unwrap_or_else(|| another(&[]));
    LocalGeometry {
        axes: completed(&[], &normal),
        curvatures: SVector::zeros(),
        tangent_dimension: 0,
        distance: residual.dot(&normal),
    }
}

/// The unit vector of the part of `vector` that is normal to orthonormal `others`; `None` if there is none.
fn independent<const D: usize>(
    vector: &SVector<f64, D>,
    others: &[SVector<f64, D>],
) -> Option<SVector<f64, D>> {
    let mut unit = vector.try_normalize(f64::MIN_POSITIVE)?;
    // Twice: the first time leaves rounding errors along the others if little remains.
    for _ in 0..2 {
        for other in others {
            unit -= other * other.dot(&unit);
        }
        unit = unit.try_normalize(INDEPENDENT)?;
    }
    Some(unit)
}

/// A unit vector normal to orthonormal `others` (fewer than `D`), always the same for the same.
fn another<const D: usize>(others: &[SVector<f64, D>]) -> SVector<f64, D> {
    let mut best = SVector::zeros();
    let mut longest = -1.0;
    for i in (0..D).rev() {
        let mut axis = SVector::<f64, D>::zeros();
        axis[i] = 1.0;
        for other in others {
            axis -= other * other.dot(&axis);
        }
        if axis.norm() > longest + 1e-3 {
            (longest, best) = (axis.norm(), axis);
        }
    }
    independent(&best, others).unwrap_or(best)
}

/// Orthonormal axes with the given first ones and the given last one.
fn completed<const D: usize>(first: &[SVector<f64, D>], last: &SVector<f64, D>) -> SMatrix<f64, D, D> {
    let mut axes = SMatrix::<f64, D, D>::zeros();
    let mut known = [*last; D];
    known[1..=first.len()].copy_from_slice(first);
    for i in 0..D - 1 {
        if i >= first.len() {
            known[i + 1] = another(&known[..=i]);
        }
        axes.set_column(i, &known[i + 1]);
    }
    axes.set_column(D - 1, last);
    axes
}

/// Two unit vectors that with `normal` as third make a right-handed orthonormal system.
pub(crate) fn tangents(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let mut reference = Vector3::zeros();
    reference[normal.iamin()] = 1.0;
    let first = (reference - normal * normal.dot(&reference)).normalize();
    [first, normal.cross(&first)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_axes_are_those_of_the_half_angle() {
        let tangents = [Vector3::x(), Vector3::y()];
        for (a, b, c) in [
            (2.0, 0.5, -1.0),
            (-1.0, 0.5, 2.0),
            (-1.0, -0.5, 2.0),
            (3.0, 0.0, 1.0),
            (1.0, 0.0, 3.0),
            (1.0, -0.0, 3.0),
            (1.0, 2.0, 1.0),
            (1.0, -2.0, 1.0),
            (1e-300, 3e-300, -2e-300),
            (1e300, 3e300, -2e300),
        ] {
            let ([first, second], [high, low]) = principal_axes([a, b, c], tangents);
            let (half, mean) = (0.5 * (a - c), 0.5 * a + 0.5 * c);
            let (sine, cosine) = (0.5 * b.atan2(half)).sin_cos();
            let expected = Vector3::new(cosine, sine, 0.0);
            assert!((first - expected).norm() < 1e-15, "{a} {b} {c}: {first} {expected}");
            assert!(first.dot(&second).abs() < 1e-16 && second.dot(&tangents[1]) >= 0.0);
            let size = half.hypot(b);
            assert!((high - mean - size).abs() <= 1e-15 * size && (mean - low - size).abs() <= 1e-15 * size);
        }
        let (axes, curvatures) = principal_axes([4.0, 0.0, 4.0], tangents);
        assert_eq!((axes, curvatures), (tangents, [4.0, 4.0]));
    }
}
