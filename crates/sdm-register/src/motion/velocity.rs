//! Velocity fields of rigid motions and the helical motions that follow them.

use super::rotation::{cross, exponential};
use super::{Displacement, MAX_UNKNOWNS, rigid_unknowns, rotations};
use nalgebra::{SVector, Vector3};

/// The velocity field `v(x) = c̄ + c × x` of a moving system (\[P05, sec. 5\]), with a rate of growth when the scale is
/// unknown, too: `v(x) = c̄ + c × x + σ x`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Velocity<const D: usize> {
    /// `c̄`, the velocity of the origin. A length.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
    pub translation: SVector<f64, D>,
    /// `c`, the vector of angular velocity; in the plane the angular velocity is its first component.
    #[cfg_attr(feature = "serde", serde(serialize_with = "crate::report::as_slice"))]
    pub rotation: Vector3<f64>,
    /// `σ`, the logarithm of the growth.
    pub growth: f64,
}

impl<const D: usize> Velocity<D> {
    /// No motion.
    #[must_use]
    pub fn zero() -> Self {
        Self { translation: SVector::zeros(), rotation: Vector3::zeros(), growth: 0.0 }
    }

    /// The velocity `v(x)`.
    #[must_use]
    pub fn at(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        self.translation + cross::<D>(&self.rotation) * x + x * self.growth
    }

    /// The same field with another origin, given in coordinates of the present one.
    #[must_use]
    pub(crate) fn about_origin(&self, origin: &SVector<f64, D>) -> Self {
        Self { translation: self.at(origin), ..*self }
    }

    /// From the unknowns of a step: translation, rotation, growth.
    #[must_use]
    pub(crate) fn from_unknowns(unknowns: &SVector<f64, MAX_UNKNOWNS>) -> Self {
        let n = rotations(D);
        Self {
            translation: SVector::from_fn(|i, _| unknowns[i]),
            rotation: Vector3::from_fn(|i, _| if i < n { unknowns[D + i] } else { 0.0 }),
            growth: unknowns[rigid_unknowns(D)],
        }
    }

    /// The unknowns of a step.
    #[must_use]
    pub(crate) fn to_unknowns(self) -> SVector<f64, MAX_UNKNOWNS> {
        let mut out = SVector::zeros();
        for i in 0..D {
            out[i] = self.translation[i];
        }
        for i in 0..rotations(D) {
            out[D + i] = self.rotation[i];
        }
        out[rigid_unknowns(D)] = self.growth;
        out
    }

    /// The share of each unknown in `⟨e, v(x)⟩`.
    #[inline]
    #[must_use]
    pub(crate) fn row(e: &SVector<f64, D>, x: &SVector<f64, D>) -> SVector<f64, MAX_UNKNOWNS> {
        let mut out = SVector::zeros();
        for i in 0..D {
            out[i] = e[i];
        }
        if D == 2 {
            out[2] = x[0] * e[1] - x[1] * e[0];
        } else {
            // ⟨e, c × x⟩ = ⟨c, x × e⟩.
            out[3] = x[1] * e[2] - x[2] * e[1];
            out[4] = x[2] * e[0] - x[0] * e[2];
            out[5] = x[0] * e[1] - x[1] * e[0];
        }
        out[rigid_unknowns(D)] = e.dot(x);
        out
    }

    /// The angle of the helical motion, `atan |c|`: moving a point by its velocity along the tangent of its helix turns
    /// it by that much, not by `|c|`.
    #[must_use]
    pub fn angle(&self) -> f64 {
        self.rotation.norm().atan()
    }

    /// The pitch `p = ⟨c, c̄⟩/c²` of the helical motion, a length per radian; `None` for a translation.
    #[must_use]
    pub fn pitch(&self) -> Option<f64> {
        let square = self.rotation.norm_squared();
        let along = if D == 3 { (0..D).map(|i| self.rotation[i] * self.translation[i]).sum() } else { 0.0 };
        (square > 0.0).then(|| along / square)
    }

    /// The helical motion along this field, in its frame: the growth about the origin, then the rotation by
    /// [`Velocity::angle`] about the axis of the field with the translation by pitch times angle along it.
    #[must_use]
    pub fn helical(&self) -> Displacement<D> {
        let norm = self.rotation.norm();
        // The field runs for the time atan|c|/|c|, 1 in the limit of a translation.
        let time = if norm > 0.0 { norm.atan() / norm } else { 1.0 };
        let (rotation, mean) = exponential::<D>(&(self.rotation * time));
        Displacement { scale: self.growth.exp(), rotation, translation: mean * self.translation * time }
    }

    /// The rotation by [`Velocity::angle`] about a pivot, then the translation by the pivot's velocity. To second order
    /// in the velocity the pivot moves on a straight line, which is what a locked translation of the pivot needs.
    #[must_use]
    pub(crate) fn about(&self, pivot: &SVector<f64, D>) -> Displacement<D> {
        let turn = Self { translation: SVector::zeros(), ..*self }.helical();
        let centre = pivot + self.at(pivot);
        Displacement { translation: centre - turn.rotation * pivot * turn.scale, ..turn }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_the_velocity() {
        let v = Velocity::<3> {
            translation: Vector3::new(0.1, -0.2, 0.3),
            rotation: Vector3::new(0.5, 0.4, -0.7),
            growth: 0.2,
        };
        let (e, x) = (Vector3::new(0.3, 0.9, -0.2), Vector3::new(1.0, -2.0, 0.7));
        let row = Velocity::<3>::row(&e, &x);
        assert!((row.dot(&v.to_unknowns()) - e.dot(&v.at(&x))).abs() < 1e-15);
        assert_eq!(Velocity::<3>::from_unknowns(&v.to_unknowns()), v);
    }

    #[test]
    fn the_helical_motion_keeps_its_axis_and_pitch() {
        let v = Velocity::<3> {
            translation: Vector3::new(1.0, 0.5, -0.3),
            rotation: Vector3::new(0.2, -0.1, 0.9),
            growth: 0.0,
        };
        let c = v.rotation;
        // A point of the axis: p = c × c̄ / c² moves along the axis by pitch × angle.
        let on_axis = c.cross(&v.translation) / c.norm_squared();
        let moved = v.helical().apply(&on_axis);
        let expected = on_axis + c.normalize() * (v.pitch().unwrap() * c.norm() * v.angle() / c.norm());
        assert!((moved - on_axis - c.normalize() * v.pitch().unwrap() * v.angle()).norm() < 1e-15 * 4.0);
        assert!((moved - expected).norm() < 1e-15 * 4.0);
        let x = Vector3::new(0.3, 0.2, 0.1);
        let tiny = Velocity { translation: v.translation * 1e-6, rotation: v.rotation * 1e-6, growth: 0.0 };
        assert!((tiny.helical().apply(&x) - x - tiny.at(&x)).norm() < 1e-11);
    }

    #[test]
    fn a_locked_pivot_moves_on_a_line() {
        let v = Velocity::<3> {
            translation: Vector3::new(1.0, 0.5, -0.3),
            rotation: Vector3::new(0.2, -0.1, 0.9),
            growth: 0.3,
        };
        let pivot = Vector3::new(0.4, -2.0, 1.0);
        assert!((v.about(&pivot).apply(&pivot) - pivot - v.at(&pivot)).norm() < 1e-14);
        let plane = Velocity::<2> { translation: SVector::zeros(), rotation: Vector3::x(), growth: 0.0 };
        assert!((plane.angle() - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
        let moved = plane.helical().apply(&SVector::from([1.0, 0.0]));
        assert!((moved - SVector::from([0.5f64.sqrt(), 0.5f64.sqrt()])).norm() < 1e-15);
    }
}
