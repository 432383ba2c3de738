//! The foot of a query on the quadric that osculates a shape at a known foot.

use crate::PrincipalFrame;
use crate::local_geometry::{of_bend, of_point};
use nalgebra::{SMatrix, SVector};

/// Rounds of the fixed point iteration for the place on the quadric: each gains the square of the slope.
const ROUNDS: usize = 3;
/// `1 − dκ` is kept above this: beyond lies the centre of curvature.
const BEFORE_CENTRE: f64 = 0.1;

/// The frame that `x` has when the shape is replaced by the quadric `z = ½ Σ κᵢ ξᵢ²` over the tangent plane of a frame
/// (a parabola over the tangent, a point), with the foot kept within `reach` of the old one.
///
/// Exact up to the third order of the distance from the query that the frame belongs to.
pub(crate) fn frame_nearby<const D: usize>(
    frame: &PrincipalFrame<D>,
    x: &SVector<f64, D>,
    reach: f64,
) -> PrincipalFrame<D> {
    let (count, last) = (frame.tangent_dimension, D - 1);
    let local = frame.axes.tr_mul(&(x - frame.foot));
    let mut place = SVector::<f64, D>::zeros();
    for _ in 0..ROUNDS {
        let height = local[last] - place[last];
        let mut sum = 0.0;
        for i in 0..count {
            let factor = (1.0 - height * frame.curvatures[i]).max(BEFORE_CENTRE);
            place[i] = (local[i] / factor).clamp(-reach, reach);
            sum += 0.5 * frame.curvatures[i] * place[i] * place[i];
        }
        place[last] = sum;
    }
    let foot = frame.foot + frame.axes * place;
    let residual = x - foot;
    let normal = frame.axes.column(last).into_owned();
    let mut out = PrincipalFrame { foot, ..*frame };
    if count == last {
        // A hypersurface: its normal has turned.
        let slopes =
            SVector::<f64, D>::from_fn(|i, _| if i < last { frame.curvatures[i] * place[i] } else { 0.0 });
        out.axes = turned_axes(&frame.axes, &slopes);
        let turned = out.axes.column(last);
        out.distance = residual.dot(&turned);
    } else {
        let geometry = if count == 0 {
            of_point(&residual, Some(&normal))
        } else {
            let bend = normal * frame.curvatures[0];
            let tangent = (frame.axes.column(0) + bend * place[0]).normalize();
            of_bend(&tangent, &(bend - tangent * tangent.dot(&bend)), &residual, Some(&normal))
        };
        out.axes = geometry.axes;
        out.curvatures = geometry.curvatures;
        out.distance = geometry.distance;
    }
    out
}

/// The axes of a graph over the first ones where it has these slopes (the last of them 0): the last one is the normal, the
/// others are turned as little as possible, the first before the second.
fn turned_axes<const D: usize>(axes: &SMatrix<f64, D, D>, slopes: &SVector<f64, D>) -> SMatrix<f64, D, D> {
    let mut out = *axes;
    // The normal without its part along the first axis; sums of squares alone, so that steep slopes leave no rounding.
    let slope = slopes[0];
    let mut others = *slopes;
    others[0] = 0.0;
    let across = axes.column(D - 1) - axes * others;
    let flat = 1.0 + others.norm_squared();
    let squared = flat + slope * slope;
    let normal = (across - axes.column(0) * slope) / squared.sqrt();
    out.set_column(D - 1, &normal);
    if D > 1 {
        let first = (axes.column(0) * flat + across * slope) / (flat * squared).sqrt();
        out.set_column(0, &first);
    }
    if D == 3 {
        let first = out.column(0).into_owned();
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            out[(i, 1)] = normal[j] * first[k] - normal[k] * first[j];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

    #[test]
    fn turned_axes_stay_orthonormal_and_end_with_the_normal() {
        let axes = *nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1).matrix();
        for slopes in [
            Vector3::zeros(),
            Vector3::new(0.2, -0.4, 0.0),
            Vector3::new(-3.0, 5.0, 0.0),
            Vector3::new(1e9, -2e3, 0.0),
        ] {
            let turned = turned_axes(&axes, &slopes);
            assert!((turned.tr_mul(&turned) - Matrix3::identity()).norm() < 1e-14);
            let normal = (axes.column(2) - axes.column(0) * slopes.x - axes.column(1) * slopes.y).normalize();
            assert!((turned.column(2) - normal).norm() < 1e-15 && turned.determinant() > 0.0);
            // The first axis leaves the plane of the old one and the normal in no other direction.
            assert!(turned.column(0).dot(&normal.cross(&axes.column(0))).abs() < 1e-14);
        }
        let turned = turned_axes(&Matrix2::identity(), &Vector2::new(0.75, 0.0));
        assert!((turned - Matrix2::new(0.8, -0.6, 0.6, 0.8)).norm() < 1e-15);
    }
}
