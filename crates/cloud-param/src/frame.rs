//! Coordinates about an axis.

use crate::Error;
use nalgebra::{Matrix3, Vector3};

/// An orthonormal frame whose third axis is that of a turntable: coordinates are two across and the height along it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct AxisFrame {
    /// A point of the axis.
    pub origin: Vector3<f64>,
    /// Two unit vectors across the axis and the one along it, right-handed.
    pub axes: [Vector3<f64>; 3],
}

impl AxisFrame {
    /// The frame at `origin` with an axis along `direction`.
    ///
    /// # Errors
    /// [`Error::Option`] for a direction that is zero or not finite.
    pub fn new(origin: Vector3<f64>, direction: &Vector3<f64>) -> Result<Self, Error> {
        let unit = direction.try_normalize(0.0).filter(|d| d.iter().all(|c| c.is_finite()));
        let Some(along) = unit else {
            return Err(Error::Option {
                name: "axis",
                value: direction.norm(),
                allowed: "a direction of positive length",
            });
        };
        let first = Vector3::ith(along.iamin(), 1.0);
        let second = along.cross(&first).normalize();
        Ok(Self { origin, axes: [second.cross(&along), second, along] })
    }

    /// Coordinates across (two) and along the axis.
    #[must_use]
    pub fn to_local(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let d = x - self.origin;
        Vector3::new(d.dot(&self.axes[0]), d.dot(&self.axes[1]), d.dot(&self.axes[2]))
    }

    /// The point with given coordinates.
    #[must_use]
    pub fn to_world(&self, local: &Vector3<f64>) -> Vector3<f64> {
        self.origin + self.rotation() * local
    }

    /// The matrix with the axes as columns.
    #[must_use]
    pub fn rotation(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&self.axes)
    }
}
