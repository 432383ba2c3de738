//! Rotations: exponential and logarithm, quaternions, axis and angle.

use nalgebra::{Matrix3, Rotation3, SMatrix, UnitQuaternion, Vector3};

/// The matrix `W` of the cross product, `W x = w × x`. In the plane only `w.x` counts: `W x = w.x (−x₂, x₁)`.
#[must_use]
pub fn cross<const D: usize>(w: &Vector3<f64>) -> SMatrix<f64, D, D> {
    const { assert!(D == 2 || D == 3, "motions are those of the plane and of space") }
    let mut out = SMatrix::zeros();
    if D == 2 {
        out[(0, 1)] = -w.x;
        out[(1, 0)] = w.x;
    } else {
        out[(0, 1)] = -w.z;
        out[(1, 0)] = w.z;
        out[(0, 2)] = w.y;
        out[(2, 0)] = -w.y;
        out[(1, 2)] = -w.x;
        out[(2, 1)] = w.x;
    }
    out
}

/// `(sin θ/θ, (1 − cos θ)/θ², (θ − sin θ)/θ³)`, by series where the quotients cancel.
fn coefficients(angle: f64) -> [f64; 3] {
    let t = angle * angle;
    if t < 1e-2 {
        // Terms up to θ⁸ leave 1e-18.
        let a = 1.0 - t / 6.0 * (1.0 - t / 20.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0)));
        let b = 0.5 * (1.0 - t / 12.0 * (1.0 - t / 30.0 * (1.0 - t / 56.0 * (1.0 - t / 90.0))));
        let c = (1.0 - t / 20.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0 * (1.0 - t / 110.0)))) / 6.0;
        [a, b, c]
    } else {
        let (sine, cosine) = angle.sin_cos();
        [sine / angle, (1.0 - cosine) / t, (angle - sine) / (t * angle)]
    }
}

/// The rotation by the angle `|w|` about the direction `w`, and the mean of the rotations by `τ w`, `0 ≤ τ ≤ 1`.
///
/// The second one turns a constant velocity into a displacement; it is also the derivative of the first with respect
/// to `w`, seen in the fixed frame (the left Jacobian).
#[must_use]
pub fn exponential<const D: usize>(w: &Vector3<f64>) -> (SMatrix<f64, D, D>, SMatrix<f64, D, D>) {
    let [a, b, c] = coefficients(if D == 2 { w.x.abs() } else { w.norm() });
    let (cross, identity) = (cross::<D>(w), SMatrix::<f64, D, D>::identity());
    let square = cross * cross;
    (identity + cross * a + square * b, identity + cross * b + square * c)
}

/// The vector `w` of a rotation matrix, `|w| ≤ π`; in the plane the angle is in `w.x`.
#[must_use]
pub fn logarithm<const D: usize>(rotation: &SMatrix<f64, D, D>) -> Vector3<f64> {
    if D == 2 {
        return Vector3::new(rotation[(1, 0)].atan2(rotation[(0, 0)]), 0.0, 0.0);
    }
    unit_quaternion(&Matrix3::from_fn(|i, j| rotation[(i, j)])).scaled_axis()
}

fn unit_quaternion(rotation: &Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation))
}

/// The unit quaternion `[w, x, y, z]` of a rotation, `w ≥ 0`.
#[must_use]
pub fn to_quaternion(rotation: &Matrix3<f64>) -> [f64; 4] {
    let q = unit_quaternion(rotation);
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    [q.w, q.i, q.j, q.k].map(|c| c * sign)
}

/// The rotation of a quaternion `[w, x, y, z]` of any length but 0; `None` if it is 0 or not finite.
#[must_use]
pub fn from_quaternion(quaternion: [f64; 4]) -> Option<Matrix3<f64>> {
    let [w, x, y, z] = quaternion;
    let q = nalgebra::Quaternion::new(w, x, y, z);
    UnitQuaternion::try_new(q, 0.0)
        .filter(|q| q.coords.iter().all(|c| c.is_finite()))
        .map(|q| q.to_rotation_matrix().into_inner())
}

/// Unit axis and angle in `[0, π]`; the axis of the identity is `z`.
#[must_use]
pub fn to_axis_angle(rotation: &Matrix3<f64>) -> (Vector3<f64>, f64) {
    let w = logarithm(rotation);
    let angle = w.norm();
    if angle > 0.0 { (w / angle, angle) } else { (Vector3::z(), 0.0) }
}

/// The rotation about an axis of any length by an angle; `None` if the axis is 0 or something is not finite.
#[must_use]
pub fn from_axis_angle(axis: &Vector3<f64>, angle: f64) -> Option<Matrix3<f64>> {
    let unit = axis.try_normalize(0.0)?;
    let rotation = exponential::<3>(&(unit * angle)).0;
    rotation.iter().all(|c| c.is_finite()).then_some(rotation)
}

/// The rotation next to a matrix that is one but for rounding (Newton-Schulz iteration; error squared at each step).
#[must_use]
pub(crate) fn orthonormalized<const D: usize>(matrix: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    let mut out = *matrix;
    for _ in 0..2 {
        out = out * (SMatrix::<f64, D, D>::identity() * 3.0 - out.tr_mul(&out)) * 0.5;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_inverts_the_exponential() {
        for scale in [0.0, 1e-12, 1e-6, 0.09, 0.11, 1.0, 3.1] {
            let w = Vector3::new(0.6, -0.48, 0.64) * scale;
            let (rotation, _) = exponential::<3>(&w);
            assert!((rotation.tr_mul(&rotation) - Matrix3::identity()).norm() < 1e-15 * 10.0);
            assert!((logarithm(&rotation) - w).norm() <= 1e-15 + 1e-14 * scale, "{scale}");
            let plane = exponential::<2>(&(Vector3::x() * scale)).0;
            assert!((logarithm(&plane).x - scale).abs() <= 1e-15 + 1e-15 * scale);
        }
    }

    #[test]
    fn the_mean_rotation_is_the_left_jacobian() {
        let (w, dw) = (Vector3::new(0.4, 1.1, -0.3), Vector3::new(0.2, -0.1, 0.5));
        let h = 1e-6;
        let (plus, minus) = (exponential::<3>(&(w + dw * h)).0, exponential::<3>(&(w - dw * h)).0);
        let (middle, jacobian) = exponential::<3>(&w);
        let spin = (plus - minus) / (2.0 * h) * middle.transpose();
        assert!((spin - cross::<3>(&(jacobian * dw))).norm() < 1e-9);
    }

    #[test]
    fn series_and_quotients_agree() {
        for (x, y) in coefficients(0.1 - 1e-12).iter().zip(coefficients(0.1 + 1e-12)) {
            assert!((x - y).abs() < 1e-12, "{x} {y}");
        }
    }

    #[test]
    fn quaternions_and_axes_return() {
        let rotation = exponential::<3>(&Vector3::new(1.0, -2.0, 0.5)).0;
        let back = from_quaternion(to_quaternion(&rotation)).unwrap();
        assert!((back - rotation).norm() < 1e-15 * 10.0);
        let (axis, angle) = to_axis_angle(&rotation);
        assert!((from_axis_angle(&axis, angle).unwrap() - rotation).norm() < 1e-14);
        assert!(from_quaternion([0.0; 4]).is_none() && from_axis_angle(&Vector3::zeros(), 1.0).is_none());
        assert!(from_quaternion([f64::NAN, 0.0, 0.0, 1.0]).is_none());
        assert_eq!(to_axis_angle(&Matrix3::identity()), (Vector3::z(), 0.0));
    }
}
