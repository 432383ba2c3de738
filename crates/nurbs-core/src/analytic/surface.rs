//! Any analytic surface.

use super::{Cone, Cylinder, Plane, Sphere, SurfaceFoot, Torus};
use crate::{BsplineSurface, Error, Interval, ParametricSurface, SurfaceJet};
use nalgebra::Vector3;

/// One of the analytic surfaces, as they come from files.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnalyticSurface {
    /// A rectangle.
    Plane(Plane),
    /// A sphere.
    Sphere(Sphere),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A cone.
    Cone(Cone),
    /// A torus.
    Torus(Torus),
}

macro_rules! each {
    ($value:expr, $s:ident => $body:expr) => {
        match $value {
            AnalyticSurface::Plane($s) => $body,
            AnalyticSurface::Sphere($s) => $body,
            AnalyticSurface::Cylinder($s) => $body,
            AnalyticSurface::Cone($s) => $body,
            AnalyticSurface::Torus($s) => $body,
        }
    };
}

impl AnalyticSurface {
    /// The closest point of the surface.
    #[must_use]
    pub fn footpoint(&self, x: &Vector3<f64>) -> SurfaceFoot {
        each!(self, s => s.footpoint(x))
    }

    /// The exact B-spline surface.
    ///
    /// # Errors
    /// None, unless coordinates overflow.
    pub fn to_nurbs(&self) -> Result<BsplineSurface, Error> {
        each!(self, s => s.to_nurbs())
    }
}

impl ParametricSurface for AnalyticSurface {
    fn domain(&self) -> [Interval; 2] {
        each!(self, s => s.domain())
    }
    fn period(&self) -> [Option<f64>; 2] {
        each!(self, s => s.period())
    }
    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        each!(self, s => s.jet(u, v))
    }
}

macro_rules! from {
    ($($name:ident),*) => {$(
        impl From<$name> for AnalyticSurface {
            fn from(surface: $name) -> Self {
                Self::$name(surface)
            }
        }
    )*};
}
from!(Plane, Sphere, Cylinder, Cone, Torus);
