//! Where a moving system stands.

use super::Displacement;
use super::rotation::{self, orthonormalized};
use crate::Error;
use nalgebra::{SMatrix, SVector, Vector3};

/// How far `RᵀR` may be from the identity, and the rows of a matrix from those of a motion.
const ORTHOGONALITY: f64 = 1e-6;

/// The position of a moving system: `x ↦ s R (x − a) + b` takes a point of the source to the frame of the model.
///
/// `a` is a point of the source (the centre of its points) and `b` where it is now. Keeping both, instead of one
/// translation, is what lets clouds far from the origin keep their digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<const D: usize> {
    /// `s`, 1 unless the scale is estimated.
    pub scale: f64,
    /// `R`, a rotation.
    pub rotation: SMatrix<f64, D, D>,
    /// `a`, in the coordinates of the source.
    pub source_origin: SVector<f64, D>,
    /// `b`, in the coordinates of the model.
    pub target_origin: SVector<f64, D>,
}

impl<const D: usize> Default for Pose<D> {
    fn default() -> Self {
        Self::identity()
    }
}

impl<const D: usize> Pose<D> {
    /// The pose that leaves every point where it is.
    #[must_use]
    pub fn identity() -> Self {
        Self::new(SMatrix::identity(), SVector::zeros())
    }

    /// `x ↦ R x + t`; the rotation is taken as it is.
    #[must_use]
    pub fn new(rotation: SMatrix<f64, D, D>, translation: SVector<f64, D>) -> Self {
        Self { scale: 1.0, rotation, source_origin: SVector::zeros(), target_origin: translation }
    }

    /// From the linear part `s R` and the translation of `x ↦ s R x + t`.
    ///
    /// # Errors
    /// [`Error::NotAMotion`] if a number is not finite, or the linear part is not a rotation times a positive scale
    /// within 1e-6 (what is left of this is removed).
    pub fn from_linear(linear: &SMatrix<f64, D, D>, translation: &SVector<f64, D>) -> Result<Self, Error> {
        let finite = linear.iter().chain(translation.iter()).all(|c| c.is_finite());
        let scale = (linear.norm_squared() / D as f64).sqrt();
        if !finite || scale.is_nan() || scale <= 0.0 {
            return Err(Error::NotAMotion { deviation: f64::NAN });
        }
        let rotation = linear / scale;
        let deviation = (rotation.tr_mul(&rotation) - SMatrix::<f64, D, D>::identity()).norm();
        if deviation.is_nan() || deviation > ORTHOGONALITY {
            return Err(Error::NotAMotion { deviation });
        }
        let rotation = orthonormalized(&rotation);
        if handedness(&rotation) < 0.0 {
            return Err(Error::NotAMotion { deviation: 2.0 });
        }
        // A scale that is 1 but for the rounding of the file is 1.
        let scale = if (scale - 1.0).abs() <= ORTHOGONALITY { 1.0 } else { scale };
        Ok(Self { scale, ..Self::new(rotation, *translation) })
    }

    /// The image of a point of the source.
    #[inline]
    #[must_use]
    pub fn apply(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        self.rotation * (x - self.source_origin) * self.scale + self.target_origin
    }

    /// The image of a direction of the source, without the scale.
    #[inline]
    #[must_use]
    pub fn rotate(&self, direction: &SVector<f64, D>) -> SVector<f64, D> {
        self.rotation * direction
    }

    /// The translation `t` of `x ↦ s R x + t`, in the files' coordinates.
    #[must_use]
    pub fn translation(&self) -> SVector<f64, D> {
        self.target_origin - self.rotation * self.source_origin * self.scale
    }

    /// The same map, written with another point of the source as origin.
    #[must_use]
    pub fn with_source_origin(&self, origin: SVector<f64, D>) -> Self {
        Self { source_origin: origin, target_origin: self.apply(&origin), ..*self }
    }

    /// First this pose, then a motion given in the frame of the model with [`Pose::target_origin`] as origin.
    #[must_use]
    pub fn then(&self, step: &Displacement<D>) -> Self {
        Self {
            scale: self.scale * step.scale,
            rotation: orthonormalized(&(step.rotation * self.rotation)),
            source_origin: self.source_origin,
            target_origin: self.target_origin + step.translation,
        }
    }

    /// First this pose, then another.
    #[must_use]
    pub fn followed_by(&self, next: &Self) -> Self {
        Self {
            scale: self.scale * next.scale,
            rotation: orthonormalized(&(next.rotation * self.rotation)),
            source_origin: self.source_origin,
            target_origin: next.apply(&self.target_origin),
        }
    }

    /// The inverse map.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self {
            scale: 1.0 / self.scale,
            rotation: self.rotation.transpose(),
            source_origin: self.target_origin,
            target_origin: self.source_origin,
        }
    }

    /// Whether every number is finite and the scale positive.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let numbers = self.rotation.iter().chain(self.source_origin.iter()).chain(self.target_origin.iter());
        self.scale.is_finite() && self.scale > 0.0 && numbers.copied().all(f64::is_finite)
    }

    /// The rotation as a vector, axis times angle (the angle itself in the plane).
    #[must_use]
    pub fn rotation_vector(&self) -> Vector3<f64> {
        rotation::logarithm(&self.rotation)
    }
}

#[cfg(feature = "serde")]
impl<const D: usize> serde::Serialize for Pose<D> {
    /// Scale, rotation by rows, translation of `x ↦ s R x + t`, and both origins.
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let rows: Vec<Vec<f64>> = (0..D).map(|i| (0..D).map(|j| self.rotation[(i, j)]).collect()).collect();
        let mut out = serializer.serialize_struct("Pose", 5)?;
        out.serialize_field("scale", &self.scale)?;
        out.serialize_field("rotation", &rows)?;
        out.serialize_field("translation", self.translation().as_slice())?;
        out.serialize_field("source_origin", self.source_origin.as_slice())?;
        out.serialize_field("target_origin", self.target_origin.as_slice())?;
        out.end()
    }
}

impl Pose<3> {
    /// From a matrix of four rows.
    ///
    /// # Errors
    /// [`Error::NotAMotion`] as for [`Pose::from_linear`], and if the last row is not `0 0 0 1`.
    pub fn from_row_major(rows: &[[f64; 4]; 4]) -> Result<Self, Error> {
        let last = [rows[3][0], rows[3][1], rows[3][2], rows[3][3] - 1.0];
        let deviation = last.iter().fold(0.0f64, |sum, c| sum + c.abs());
        if deviation.is_nan() || deviation > ORTHOGONALITY {
            return Err(Error::NotAMotion { deviation });
        }
        let linear = SMatrix::from_fn(|i, j| rows[i][j]);
        Self::from_linear(&linear, &SVector::from_fn(|i, _| rows[i][3]))
    }

    /// The matrix of `x ↦ s R x + t` in homogeneous coordinates, by rows.
    #[must_use]
    pub fn to_row_major(&self) -> [[f64; 4]; 4] {
        let (linear, translation) = (self.rotation * self.scale, self.translation());
        let mut rows = [[0.0, 0.0, 0.0, 1.0]; 4];
        for i in 0..3 {
            rows[i] = [linear[(i, 0)], linear[(i, 1)], linear[(i, 2)], translation[i]];
        }
        rows
    }

    /// The rotation as a unit quaternion `[w, x, y, z]`, `w ≥ 0`.
    #[must_use]
    pub fn quaternion(&self) -> [f64; 4] {
        rotation::to_quaternion(&self.rotation)
    }

    /// The unit axis and the angle of the rotation.
    #[must_use]
    pub fn axis_angle(&self) -> (Vector3<f64>, f64) {
        rotation::to_axis_angle(&self.rotation)
    }
}

impl Pose<2> {
    /// From a matrix of three rows.
    ///
    /// # Errors
    /// [`Error::NotAMotion`] as for [`Pose::from_linear`], and if the last row is not `0 0 1`.
    pub fn from_row_major(rows: &[[f64; 3]; 3]) -> Result<Self, Error> {
        let deviation = rows[2][0].abs() + rows[2][1].abs() + (rows[2][2] - 1.0).abs();
        if deviation.is_nan() || deviation > ORTHOGONALITY {
            return Err(Error::NotAMotion { deviation });
        }
        let linear = SMatrix::from_fn(|i, j| rows[i][j]);
        Self::from_linear(&linear, &SVector::from_fn(|i, _| rows[i][2]))
    }

    /// The matrix of `x ↦ s R x + t` in homogeneous coordinates, by rows.
    #[must_use]
    pub fn to_row_major(&self) -> [[f64; 3]; 3] {
        let (linear, translation) = (self.rotation * self.scale, self.translation());
        let mut rows = [[0.0, 0.0, 1.0]; 3];
        for i in 0..2 {
            rows[i] = [linear[(i, 0)], linear[(i, 1)], translation[i]];
        }
        rows
    }
}

/// The sign of the determinant of a matrix that is orthogonal, 1 or −1.
fn handedness<const D: usize>(m: &SMatrix<f64, D, D>) -> f64 {
    if D == 2 {
        m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)]
    } else {
        let column = |j: usize| Vector3::new(m[(0, j)], m[(1, j)], m[(2, j)]);
        column(0).cross(&column(1)).dot(&column(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Velocity;
    use nalgebra::Matrix3;

    fn example() -> Pose<3> {
        let rotation = rotation::exponential::<3>(&Vector3::new(0.3, -1.0, 2.0)).0;
        Pose { scale: 1.5, ..Pose::new(rotation, Vector3::new(1e6, -2e6, 3.0)) }
    }

    #[test]
    fn matrices_return_and_bad_ones_are_refused() {
        let pose = example();
        let back = Pose::<3>::from_row_major(&pose.to_row_major()).unwrap();
        assert!((back.rotation - pose.rotation).norm() < 1e-15 * 4.0 && (back.scale - 1.5).abs() < 1e-15);
        let mut mirrored = Pose::<3>::identity().to_row_major();
        mirrored[0][0] = -1.0;
        let mut sheared = Pose::<3>::identity().to_row_major();
        sheared[0][1] = 0.1;
        let mut infinite = Pose::<3>::identity().to_row_major();
        infinite[0][3] = f64::INFINITY;
        let mut projective = Pose::<3>::identity().to_row_major();
        projective[3][0] = 0.1;
        for bad in [mirrored, sheared, infinite, projective, [[0.0; 4]; 4], [[f64::NAN; 4]; 4]] {
            assert!(matches!(Pose::<3>::from_row_major(&bad), Err(Error::NotAMotion { .. })), "{bad:?}");
        }
        let plane = Pose::<2>::from_row_major(&[[0.0, -1.0, 3.0], [1.0, 0.0, 4.0], [0.0, 0.0, 1.0]]).unwrap();
        assert_eq!(plane.apply(&SVector::from([1.0, 0.0])), SVector::from([3.0, 5.0]));
        assert_eq!(plane.to_row_major()[1], [1.0, 0.0, 4.0]);
    }

    #[test]
    fn composition_inverse_and_origins_agree() {
        let pose = example();
        let x = Vector3::new(0.4, 5.0, -2.0);
        let image = pose.apply(&x);
        assert!((pose.inverse().apply(&image) - x).norm() < 1e-9);
        assert!((pose.with_source_origin(Vector3::new(1.0, 2.0, 3.0)).apply(&x) - image).norm() < 1e-9);
        assert!((pose.followed_by(&pose.inverse()).apply(&x) - x).norm() < 1e-9);
        let step = Velocity { rotation: Vector3::x(), ..Velocity::zero() }.helical();
        let moved = pose.then(&step).apply(&x);
        assert!((moved - step.apply(&(image - pose.target_origin)) - pose.target_origin).norm() < 1e-9);
        let identity: Matrix3<f64> = pose.rotation.tr_mul(&pose.then(&step).rotation);
        assert!((rotation::logarithm(&identity).norm() - std::f64::consts::FRAC_PI_4).abs() < 1e-14);
    }
}
