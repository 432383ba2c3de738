//! Orthogonal projection of points onto parametric curves and surfaces.
//!
//! Two ways lead to a footpoint:
//!
//! - [`CurveProjector`] and [`SurfaceProjector`] are built once for B-spline or NURBS shapes and then find, for any
//!   query, the nearest point of all, together with a lower bound that proves it. Batches run in parallel
//!   ([`SurfaceProjector::project_many`]), and points that have moved a little get new feet from their old ones
//!   ([`SurfaceProjector::update_many`]).
//! - [`local`] holds the iterations of \[HW05\] and others on any [`ParametricCurve`](nurbs_core::ParametricCurve) or
//!   [`ParametricSurface`](nurbs_core::ParametricSurface), from a start of your choice.
//!
//! ```
//! use footpoint::{Multiplicity, SurfaceProjector};
//! use nalgebra::Vector3;
//! use nurbs_core::{Frame, Sphere};
//!
//! let sphere = Sphere::new(Frame::new(Vector3::zeros(), Vector3::z(), Vector3::x())?, 2.0)?.to_nurbs()?;
//! let projector = SurfaceProjector::new(&sphere);
//! let foot = projector.project(&Vector3::new(0.0, 3.0, 4.0));
//! assert!((foot.distance - 3.0).abs() < 1e-12 && foot.lower_bound > 2.999_999);
//! // Every point of the sphere is as near to its centre as any other.
//! assert_eq!(projector.project(&Vector3::zeros()).multiplicity, Multiplicity::Continuum);
//! # Ok::<(), nurbs_core::Error>(())
//! ```
//!
//! Nothing depends on the unit of length; coordinates far from the origin lose nothing, because every piece works
//! relative to its own centre. The same input gives the same bits on any number of threads and on any machine: no
//! fused operations are used.

mod error;
mod facing;
mod footpoint;
mod global;
pub mod local;
mod options;
mod projector;
mod status;
mod tolerance;

pub use error::Error;
pub use facing::Facing;
pub use footpoint::{CurveFootpoint, SurfaceFootpoint};
pub use options::{Mode, ProjectionOptions, UpdateOptions};
pub use projector::{CurveFeet, CurveProjector, Progress, SurfaceFeet, SurfaceProjector, no_progress};
pub use status::{Location, Multiplicity, Status};

// The crates whose types occur in the interface of this one.
pub use nalgebra;
pub use nurbs_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
