//! Which normals agree with a direction.

use crate::Error;
use nalgebra::Vector3;

/// A direction with the largest angle to it: the normal of a scanned point, say, which tells from which side of a thin wall
/// the point was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facing {
    direction: Vector3<f64>,
    max_angle: f64,
    cosine: f64,
}

impl Facing {
    /// Normals within `max_angle`, in radians, of `direction`, of any length.
    ///
    /// # Errors
    /// [`Error::Option`] unless the angle is above 0 and at most π, [`Error::NonFinitePoint`] for a direction without length or
    /// with a coordinate that is not finite.
    pub fn new(direction: &Vector3<f64>, max_angle: f64) -> Result<Self, Error> {
        if !(max_angle > 0.0 && max_angle <= std::f64::consts::PI) {
            let what = "it must be above 0 and at most π";
            return Err(Error::Option { option: "max_angle", value: max_angle, what });
        }
        let largest = direction.amax();
        // The largest component first: squares of tiny or huge ones would vanish or overflow.
        let unit = (largest > 0.0 && largest.is_finite()).then(|| (direction / largest).normalize());
        let unit = unit.filter(|unit| unit.iter().all(|c| c.is_finite()));
        let direction = unit.ok_or(Error::NonFinitePoint { index: 0 })?;
        Ok(Self { direction, max_angle, cosine: max_angle.cos() })
    }

    /// The direction, of length 1.
    #[must_use]
    pub fn direction(&self) -> &Vector3<f64> {
        &self.direction
    }

    /// The largest angle, in radians.
    #[must_use]
    pub fn max_angle(&self) -> f64 {
        self.max_angle
    }

    /// Whether a normal, of any length, is within the angle: its cosine is at least that of the largest angle.
    ///
    /// At a right angle a surface that stands upright does not agree. A normal without length never does.
    #[must_use]
    pub fn agrees(&self, normal: &Vector3<f64>) -> bool {
        let largest = normal.amax();
        let normal = normal / largest;
        largest > 0.0 && normal.dot(&self.direction) >= self.cosine * normal.norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn right_angles_and_odd_directions() {
        let up = Facing::new(&(Vector3::z() * 1e-200), FRAC_PI_2).unwrap();
        assert_eq!(up.direction(), &Vector3::z());
        assert!(up.agrees(&Vector3::new(5.0, 0.0, 1e-9)) && !up.agrees(&Vector3::x()));
        assert!(!up.agrees(&-Vector3::z()) && !up.agrees(&Vector3::zeros()));
        assert!(!up.agrees(&Vector3::repeat(f64::NAN)));
        assert!(up.agrees(&(Vector3::z() * 1e-300)) && up.agrees(&(Vector3::z() * 1e300)));
        assert!(Facing::new(&Vector3::z(), PI).unwrap().agrees(&-Vector3::z()));
        for angle in [0.0, -1.0, 4.0, f64::NAN] {
            assert!(Facing::new(&Vector3::z(), angle).is_err(), "{angle}");
        }
        for direction in [Vector3::zeros(), Vector3::repeat(f64::NAN), Vector3::x() * f64::INFINITY] {
            assert!(Facing::new(&direction, 1.0).is_err(), "{direction}");
        }
    }
}
