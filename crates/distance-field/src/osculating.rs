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

    /// A frame at the origin whose axes are those of the coordinates.
    fn frame_at_origin<const D: usize>(curvatures: SVector<f64, D>, count: usize) -> PrincipalFrame<D> {
        PrincipalFrame {
            foot: SVector::zeros(),
            axes: SMatrix::identity(),
            curvatures,
            tangent_dimension: count,
            distance: 0.3,
            ..PrincipalFrame::invalid(footpoint::Status::Converged)
        }
    }

    /// The foot of `(a, h)` on the parabola `y = ½ κ x²`, to all digits.
    fn on_parabola(k: f64, a: f64, h: f64) -> Vector2<f64> {
        let mut p = a / (1.0 - h * k);
        for _ in 0..50 {
            p -= ((p - a) + (0.5 * k * p * p - h) * k * p) / (1.0 + 1.5 * k * k * p * p - h * k);
        }
        Vector2::new(p, 0.5 * k * p * p)
    }

    #[test]
    fn each_round_gains_two_orders_on_a_parabola() {
        for (k, h) in [(0.5, 0.4), (-0.8, 0.3), (1.5, -0.2)] {
            let frame = frame_at_origin(Vector2::new(k, 0.0), 1);
            let error = |a: f64| {
                let near = frame_nearby(&frame, &Vector2::new(a, h), 10.0);
                let exact = on_parabola(k, a, h);
                // The normal of the parabola, and the distance along it.
                let slope = k * near.foot.x;
                let normal = Vector2::new(-slope, 1.0) / 1.0f64.hypot(slope);
                assert!((near.normal() - normal).norm() < 1e-15, "{near:?}");
                let residual = Vector2::new(a, h) - near.foot;
                assert!((near.distance - residual.dot(&normal)).abs() < 1e-16);
                (near.foot - exact).norm()
            };
            // Three rounds: the first neglected term is of the order 7.
            let errors = [0.2, 0.1, 0.05].map(error);
            assert!(errors[0] < 1e-5 && errors[1] < 1e-7 && errors[2] < 1e-9, "{errors:?}");
            assert!(errors.windows(2).all(|e| e[0] > 100.0 * e[1]), "{errors:?}");
        }
    }

    #[test]
    fn both_directions_of_a_quadric_count() {
        let frame = frame_at_origin(Vector3::new(0.5, -0.8, 0.0), 2);
        let x = Vector3::new(0.02, 0.03, 0.4);
        let near = frame_nearby(&frame, &x, 10.0);
        // At the foot the residual is normal to both tangents of z = ½ (κ₁ x² + κ₂ y²).
        let [p, q] = [near.foot.x, near.foot.y];
        assert!((near.foot.z - 0.5 * (0.5 * p * p - 0.8 * q * q)).abs() < 1e-9);
        let residual = x - near.foot;
        for tangent in [Vector3::new(1.0, 0.0, 0.5 * p), Vector3::new(0.0, 1.0, -0.8 * q)] {
            assert!(residual.dot(&tangent).abs() < 1e-9, "{near:?}");
        }
        assert!((near.normal().cross(&residual)).norm() < 1e-9 && near.distance > 0.0);
    }

    #[test]
    fn the_foot_stays_within_reach_and_before_the_centre() {
        let frame = frame_at_origin(Vector2::new(2.0, 0.0), 1);
        for (a, expected) in [(5.0, 0.25), (-5.0, -0.25)] {
            let near = frame_nearby(&frame, &Vector2::new(a, 0.1), 0.25);
            assert_eq!(near.foot, Vector2::new(expected, 0.0625));
        }
        // At the centre of curvature, and beyond it, the foot moves ten times as far as the query.
        for h in [0.5, 0.9] {
            let near = frame_nearby(&frame, &Vector2::new(1e-4, h), 0.25);
            assert!((near.foot.x - 1e-3).abs() < 1e-12, "{near:?}");
        }
        // Before it the exact factor counts.
        let near = frame_nearby(&frame, &Vector2::new(1e-6, 0.25), 0.25);
        assert!((near.foot.x - 2e-6).abs() < 1e-15, "{near:?}");
    }

    #[test]
    fn frames_along_a_circle_in_space_are_those_of_the_circle() {
        // The circle of radius 2 about (0, 0, 2) in the plane of the first and last axes, as seen from between.
        let frame = frame_at_origin(Vector3::new(0.5, 0.0, 0.0), 1);
        let error = |a: f64| {
            let x = Vector3::new(a, 0.3, 0.4);
            let near = frame_nearby(&frame, &x, 10.0);
            // The exact foot, and the curvature towards the query.
            let inwards = Vector3::new(-a, 0.0, 2.0 - x.z).normalize();
            let foot = Vector3::new(0.0, 0.0, 2.0) - inwards * 2.0;
            let residual = x - foot;
            let curvature = 0.5 * inwards.dot(&residual.normalize());
            let tangent = Vector3::new(inwards.z, 0.0, -inwards.x);
            assert!((near.axes.tr_mul(&near.axes) - Matrix3::identity()).norm() < 1e-12);
            // Taylor's parabola leaves the circle with the order 4, its tangent and curvature with the order 3 and 2.
            [
                (near.foot - foot).norm(),
                (near.distance - residual.norm()).abs(),
                (near.axes.column(0).cross(&tangent)).norm(),
                (near.curvatures[0] - curvature).abs(),
            ]
        };
        let errors = [0.1, 0.05, 0.025].map(error);
        for (e, order) in [(0, 3), (1, 4), (2, 3), (3, 2)] {
            let least = 0.8 * 2.0f64.powi(order);
            assert!(errors.windows(2).all(|w| w[0][e] > least * w[1][e]), "{e}: {errors:?}");
            assert!(errors[0][e] < 0.05 * 0.1f64.powi(order - 1), "{e}: {errors:?}");
        }
    }
}
