//! How deviations are measured and judged.

use crate::{Error, Tolerance};
use footpoint::ProjectionOptions;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Along which line a point is projected onto the nominal shape.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Along {
    /// The shortest one: to the closest point of the shape.
    #[default]
    Shortest,
    /// The normal that the point itself has, in either sense, to the nearest point in which it meets the shape.
    Normal,
    /// A given direction, in either sense, to the nearest point in which the line meets the shape.
    Direction([f64; 3]),
}

/// Options of an inspection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct InspectionOptions {
    /// Allowed deviations.
    pub tolerance: Tolerance,
    /// Share of the points that must lie within the tolerance to pass, 0 to 1; default 1, all of them.
    pub min_share: f64,
    /// Along which line points are projected; default [`Along::Shortest`].
    pub along: Along,
    /// Largest angle, in radians, between the normal of a point and that of the shape at a foot or crossing that counts;
    /// `None` (default; JSON: `null`), and π, for no limit. A thin wall is then measured on the face that was scanned.
    ///
    /// Normals within a right angle of each other have a positive scalar product; one of exactly 0 is no longer within.
    pub max_angle: Option<f64>,
    /// Points farther from the shape than this are counted, but not used; default infinite (JSON: `null`). A length.
    pub max_distance: f64,
    /// Whether points beyond the boundary of an open shape, whose footpoints lie on it, are counted, but not used;
    /// default `false`: their distance from the boundary is a deviation like any other.
    pub drop_beyond_boundary: bool,
    /// How many of the worst points are listed; default 10.
    pub worst: usize,
    /// Up to how many measured points, of all surfaces, quantiles and histogram are computed from the values themselves; default
    /// 4 194 304. Beyond,
    /// values count in cells of a relative width of `2⁻¹²` (see [`Distribution`](crate::Distribution)).
    pub exact_limit: usize,
    /// How footpoints on NURBS are searched; default certified.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub projection: ProjectionOptions,
}

impl InspectionOptions {
    /// The default options with a tolerance.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self {
            tolerance,
            min_share: 1.0,
            along: Along::Shortest,
            max_angle: None,
            max_distance: f64::INFINITY,
            drop_beyond_boundary: false,
            worst: 10,
            exact_limit: 1 << 22,
            projection: ProjectionOptions::default(),
        }
    }

    /// Sets the share of points that must lie within the tolerance.
    #[must_use]
    pub fn with_min_share(self, min_share: f64) -> Self {
        Self { min_share, ..self }
    }

    /// Sets along which line points are projected.
    #[must_use]
    pub fn with_along(self, along: Along) -> Self {
        Self { along, ..self }
    }

    /// Sets the largest angle between normals, in radians.
    #[must_use]
    pub fn with_max_angle(self, max_angle: f64) -> Self {
        Self { max_angle: Some(max_angle), ..self }
    }

    /// Sets the distance beyond which points are not used.
    #[must_use]
    pub fn with_max_distance(self, max_distance: f64) -> Self {
        Self { max_distance, ..self }
    }

    /// Sets whether points beyond the boundary are not used.
    #[must_use]
    pub fn with_drop_beyond_boundary(self, drop_beyond_boundary: bool) -> Self {
        Self { drop_beyond_boundary, ..self }
    }

    /// Sets how many of the worst points are listed.
    #[must_use]
    pub fn with_worst(self, worst: usize) -> Self {
        Self { worst, ..self }
    }

    /// Sets up to how many values quantiles are exact.
    #[must_use]
    pub fn with_exact_limit(self, exact_limit: usize) -> Self {
        Self { exact_limit, ..self }
    }

    /// Sets how footpoints are searched.
    #[must_use]
    pub fn with_projection(self, projection: ProjectionOptions) -> Self {
        Self { projection, ..self }
    }

    /// Checks that every option can be used.
    ///
    /// # Errors
    /// [`Error::Option`], [`Error::Tolerance`], [`Error::Direction`] or [`Error::Projection`].
    pub fn validate(&self) -> Result<(), Error> {
        Tolerance::new(self.tolerance.lower, self.tolerance.upper)?;
        let option = |option, value, what| Err(Error::Option { option, value, what });
        if !(0.0..=1.0).contains(&self.min_share) {
            return option("min_share", self.min_share, "it must be between 0 and 1");
        }
        if self.max_distance.is_nan() || self.max_distance <= 0.0 {
            return option("max_distance", self.max_distance, "it must be positive");
        }
        if let Some(angle) = self.max_angle.filter(|angle| !(*angle > 0.0 && *angle <= PI)) {
            return option("max_angle", angle, "it must be above 0 and at most π (180 degrees)");
        }
        if let Along::Direction(direction) = self.along {
            unit(&Vector3::from(direction))?;
        }
        Ok(self.projection.validate()?)
    }

    /// The largest angle, where there is one.
    pub(crate) fn angle_limit(&self) -> Option<f64> {
        self.max_angle.filter(|angle| *angle < PI)
    }
}

/// A vector of length 1.
pub(crate) fn unit(direction: &Vector3<f64>) -> Result<Vector3<f64>, Error> {
    let largest = direction.amax();
    // The largest component first: squares of tiny or huge ones would vanish or overflow.
    let unit = (largest > 0.0 && largest.is_finite()).then(|| (direction / largest).normalize());
    unit.filter(|unit| unit.iter().all(|value| value.is_finite())).ok_or(Error::Direction {
        x: direction.x,
        y: direction.y,
        z: direction.z,
    })
}
