//! Affine maps of shapes: they act on the control points, weights stay.

use crate::{BsplineCurve, BsplineSurface, Error};
use nalgebra::{AbstractRotation, Isometry, Isometry3, Matrix3, Point, Point3, SMatrix, SVector, Vector3};

impl<const D: usize> BsplineCurve<D> {
    pub(crate) fn mapped(&self, map: impl Fn(&SVector<f64, D>) -> SVector<f64, D>) -> Result<Self, Error> {
        let points = self.control_points().iter().map(map).collect();
        Self::new(self.knots().clone(), points, self.weights().map(<[f64]>::to_vec))
    }

    /// The image under `x ↦ linear x + offset`.
    ///
    /// # Errors
    /// When a coordinate becomes infinite or NaN.
    pub fn transformed(&self, linear: &SMatrix<f64, D, D>, offset: &SVector<f64, D>) -> Result<Self, Error> {
        self.mapped(|p| linear * p + offset)
    }

    /// The image under a rigid motion.
    ///
    /// # Errors
    /// When a coordinate becomes infinite or NaN.
    pub fn moved<R: AbstractRotation<f64, D>>(&self, motion: &Isometry<f64, R, D>) -> Result<Self, Error> {
        self.mapped(|p| motion.transform_point(&Point::from(*p)).coords)
    }

    /// The curve moved by `offset`.
    ///
    /// # Errors
    /// When a coordinate becomes infinite or NaN.
    pub fn translated(&self, offset: &SVector<f64, D>) -> Result<Self, Error> {
        self.mapped(|p| p + offset)
    }

    /// The curve scaled by `factor` about `centre`.
    ///
    /// # Errors
    /// When a coordinate becomes infinite or NaN.
    pub fn scaled(&self, factor: f64, centre: &SVector<f64, D>) -> Result<Self, Error> {
        self.mapped(|p| centre + (p - centre) * factor)
    }
}

impl BsplineSurface {
    pub(crate) fn mapped(&self, map: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Result<Self, Error> {
        let points = self.control_points().iter().map(map).collect();
        let weights = self.weights().map(<[f64]>::to_vec);
        Self::new(self.knots_u().clone(), self.knots_v().clone(), points, weights)
    }

    /// The image under `x ↦ linear x + offset`.
    ///
    /// # Errors
    /// When a coordinate becomes infinite or NaN.
    pub fn transformed(&self, linear: &Matrix3<f64>, offset: &Vector3<f64>) -> Result<Self, Error> {
        self.mapped(|p| linear * p + offset)
    }

    /// The image under a rigid motion.
    ///
    /// # Errors
    /// When a coordinate becomes infinite or NaN.
    pub fn moved(&self, motion: &Isometry3<f64>) -> Result<Self, Error> {
        self.mapped(|p| motion.transform_point(&Point3::from(*p)).coords)
    }

    /// The surface moved by `offset`.
    ///
    /// # Errors
    /// When a coordinate becomes infinite or NaN.
    pub fn translated(&self, offset: &Vector3<f64>) -> Result<Self, Error> {
        self.mapped(|p| p + offset)
    }

    /// The surface scaled by `factor` about `centre`.
    ///
    /// # Errors
    /// When a coordinate becomes infinite or NaN.
    pub fn scaled(&self, factor: f64, centre: &Vector3<f64>) -> Result<Self, Error> {
        self.mapped(|p| centre + (p - centre) * factor)
    }
}
