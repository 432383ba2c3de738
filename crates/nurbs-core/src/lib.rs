//! B-spline and NURBS curves and surfaces: the parametric layer of a CAD kernel.
//!
//! Curves live in `R^D` ([`BsplineCurve`]), surfaces in `R³` ([`BsplineSurface`]); both may be rational
//! (weights stored apart from the points), clamped, floating or periodic. Everything that an algorithm
//! needs at a parameter comes out of one evaluation, the *jet* (point, first and second derivatives):
//! see [`ParametricCurve`] and [`ParametricSurface`].
//!
//! Interpolation, least squares, skinning, sweeping and degree reduction need a sparse solver: feature `fit`.
//!
//! ```
//! use nurbs_core::{BsplineCurve, KnotVector, ParametricCurve};
//! use nalgebra::Vector2;
//!
//! let knots = KnotVector::uniform_clamped(2, 4)?;
//! let points = vec![Vector2::new(0., 0.), Vector2::new(1., 2.), Vector2::new(3., 2.), Vector2::new(4., 0.)];
//! let curve = BsplineCurve::new(knots, points, None)?;
//! let jet = curve.jet(0.5);
//! assert_eq!(jet.point, Vector2::new(2.0, 2.0));
//! assert!(jet.d1.y.abs() < 1e-15);
//! # Ok::<(), nurbs_core::Error>(())
//! ```

mod analytic;
pub mod basis;
mod basis_fixed;
mod batch;
mod bernstein;
mod bezier;
mod bounds;
pub mod construct;
mod curve;
mod curve_eval;
mod differential;
mod direction;
mod error;
mod fit;
#[cfg(feature = "serde")]
mod form;
mod interval;
mod jet;
mod knot_ops;
mod knots;
#[cfg(feature = "fit")]
pub mod linear;
pub mod magnitude;
mod measure;
mod modify;
mod offset;
mod rational;
mod simd;
mod span_table;
mod surface;
mod surface_eval;
mod tessellate;
mod traits;
mod trim_loops;

pub use analytic::{
    AnalyticSurface, Circle, Cone, CurveFoot, Cylinder, Ellipse, Frame, Helix, Line, Plane, Sphere,
    SurfaceFoot, Torus,
};
pub use bezier::{BezierCurve, BezierPatch};
pub use bounds::Aabb;
pub use curve::BsplineCurve;
pub use differential::{FirstForm, FrenetFrame, PrincipalFrame, SecondForm};
pub use direction::Direction;
pub use error::Error;
#[cfg(feature = "fit")]
pub use fit::{CurveFitOptions, Fitted, GridOptions, SurfaceFitOptions};
pub use fit::{ParameterMethod, closed_parameters, gauss_legendre, grid_parameters, parameters};
pub use interval::Interval;
pub use jet::{CurveJet, SurfaceJet};
pub use knots::{KnotVector, MAX_DEGREE};
pub use magnitude::{MAX_COORDINATE, MAX_WEIGHT_RATIO};
pub use measure::{ArcLength, MEASURE_TOLERANCE, Measure, arc_length, area};
pub use modify::Removal;
pub use nalgebra;
pub use offset::{OffsetCurve, OffsetSurface, SurfaceThird, ThirdOrderCurve, ThirdOrderSurface};
pub use surface::BsplineSurface;
pub use tessellate::{Polyline, Tessellation, TessellationOptions};
pub use traits::{Break, CurveFn, ParametricCurve, ParametricSurface, SurfaceFn};
pub use trim_loops::TrimLoops;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
