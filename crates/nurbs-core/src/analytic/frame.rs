//! Positions in space: an origin and three axes.

use crate::Error;
use nalgebra::Vector3;

/// Sine of the angle between the two given axes below which they count as parallel.
const PARALLEL: f64 = 1e-9;

/// A right-handed orthonormal coordinate system in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    origin: Vector3<f64>,
    x: Vector3<f64>,
    y: Vector3<f64>,
    z: Vector3<f64>,
}

impl Frame {
    /// The coordinate system itself.
    pub const WORLD: Self = Self {
        origin: Vector3::new(0.0, 0.0, 0.0),
        x: Vector3::new(1.0, 0.0, 0.0),
        y: Vector3::new(0.0, 1.0, 0.0),
        z: Vector3::new(0.0, 0.0, 1.0),
    };

    /// The frame with the given origin, `z` along the axis and `x` along the part of `reference` that
    /// is normal to it, as CAD files give positions. Neither vector needs to be a unit vector.
    ///
    /// # Errors
    /// [`Error::Argument`] when a number is not finite, a vector is zero, or the two are parallel.
    ///
    /// ```
    /// # use nurbs_core::Frame;
    /// # use nalgebra::Vector3;
    /// let f = Frame::new(Vector3::zeros(), Vector3::new(0., 0., 2.), Vector3::new(3., 0., 1.))?;
    /// assert_eq!(f, Frame::WORLD);
    /// assert!(Frame::new(Vector3::zeros(), Vector3::z(), -Vector3::z()).is_err());
    /// # Ok::<(), nurbs_core::Error>(())
    /// ```
    pub fn new(origin: Vector3<f64>, axis: Vector3<f64>, reference: Vector3<f64>) -> Result<Self, Error> {
        finite("origin", origin.as_slice())?;
        let z = unit("axis", axis)?;
        let towards = unit("reference direction", reference)?;
        let along = towards.dot(&z);
        // Unit vectors that are normal already stay as they are, so that frames survive files.
        let x = if along.abs() <= 4.0 * f64::EPSILON { towards } else { towards - z * along };
        let sine = x.norm();
        if sine <= PARALLEL {
            return Err(Error::argument(format!(
                "axis {axis:?} and reference direction {reference:?} are parallel; the x axis has no direction"
            )));
        }
        let x = unit("reference direction", x)?;
        Ok(Self { origin, x, y: z.cross(&x), z })
    }

    /// The frame with the given origin and `z` axis; `x` is chosen, always the same for the same axis.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_axis(origin: Vector3<f64>, axis: Vector3<f64>) -> Result<Self, Error> {
        let z = unit("axis", axis)?;
        // The coordinate axis that is least parallel to z.
        let mut reference = Vector3::zeros();
        reference[z.iamin()] = 1.0;
        Self::new(origin, axis, reference)
    }

    /// Origin.
    #[must_use]
    pub fn origin(&self) -> Vector3<f64> {
        self.origin
    }

    /// Unit vector of the first axis.
    #[must_use]
    pub fn x(&self) -> Vector3<f64> {
        self.x
    }

    /// Unit vector of the second axis, `z × x`.
    #[must_use]
    pub fn y(&self) -> Vector3<f64> {
        self.y
    }

    /// Unit vector of the third axis, the axis of rotation of surfaces that have one.
    #[must_use]
    pub fn z(&self) -> Vector3<f64> {
        self.z
    }

    /// The point with the given coordinates in this frame.
    #[must_use]
    pub fn point(&self, local: &Vector3<f64>) -> Vector3<f64> {
        self.origin + self.vector(local)
    }

    /// The vector with the given components in this frame.
    #[must_use]
    pub fn vector(&self, local: &Vector3<f64>) -> Vector3<f64> {
        self.x * local.x + self.y * local.y + self.z * local.z
    }

    /// Coordinates of a point in this frame.
    #[must_use]
    pub fn local(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let d = point - self.origin;
        Vector3::new(d.dot(&self.x), d.dot(&self.y), d.dot(&self.z))
    }
}

fn unit(name: &str, vector: Vector3<f64>) -> Result<Vector3<f64>, Error> {
    finite(name, vector.as_slice())?;
    // Scaled first: squares of very large or small components leave the range of doubles.
    let scale = vector.amax();
    if scale == 0.0 {
        return Err(Error::argument(format!("the {name} is the zero vector; it has no direction")));
    }
    if (vector.norm_squared() - 1.0).abs() <= 4.0 * f64::EPSILON {
        return Ok(vector);
    }
    Ok((vector / scale).normalize())
}

/// An error that names what is not finite.
pub(crate) fn finite(name: &str, values: &[f64]) -> Result<(), Error> {
    match values.iter().find(|v| !v.is_finite()) {
        Some(value) => Err(Error::argument(format!("the {name} holds {value}; it must be finite"))),
        None => Ok(()),
    }
}

/// An error that names what is not a positive finite number.
pub(crate) fn positive(name: &str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(Error::argument(format!("the {name} is {value}; it must be positive and finite")))
    }
}
