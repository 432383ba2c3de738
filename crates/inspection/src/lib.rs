//! Deviations of a cloud from a shape: statistics, tolerance bands, colour maps and reports.
//!
//! A [`Nominal`] shape is made of NURBS surfaces, of a mesh or of analytic surfaces. It measures the signed distance of
//! each point ([`Deviation`]), on the exact shape and never through triangles in its place: along the shortest line, along
//! the normal of the point or in a given direction ([`Along`]). A [`Partial`] result counts what was measured and can be
//! merged with those of other tiles, bit for bit as if all had been one; [`Partial::finish`] gives statistics and verdict
//! ([`Inspection`]). With the feature `html`, `html::write` makes one self-contained page of it.
//!
//! ```
//! use inspection::{InspectionOptions, Nominal, Tolerance};
//! use nalgebra::{Point3, Vector3};
//! use nurbs_core::{Cylinder, Frame, Interval};
//!
//! let frame = Frame::new(Vector3::zeros(), Vector3::z(), Vector3::x())?;
//! let shaft = Nominal::from_analytic(&[Cylinder::new(frame, 5.0, Interval::new(0.0, 20.0)?)?.into()])?;
//! let points = [Point3::new(5.02, 0.0, 3.0), Point3::new(0.0, 4.99, 8.0), Point3::new(-5.06, 0.0, 8.0)];
//! let inspection = shaft.inspect(&points, &InspectionOptions::new(Tolerance::symmetric(0.05)?))?;
//! assert!(!inspection.verdict.pass);
//! assert_eq!((inspection.total.under, inspection.total.within, inspection.total.over), (0, 2, 1));
//! assert_eq!(inspection.worst[0].index, 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Units are those of the coordinates. Nothing depends on the number of threads.

mod backdrop;
#[cfg(feature = "serde")]
mod base64;
mod colour;
mod deviation;
mod distribution;
mod error;
mod exact_sum;
mod histogram;
#[cfg(feature = "html")]
pub mod html;
mod inspection;
mod nominal;
mod options;
mod parallel;
mod partial;
mod percent;
mod picture;
mod record;
mod statistics;
mod tally;
mod tolerance;
mod worst;

pub use backdrop::Backdrop;
pub use colour::{ColourScale, diverging};
pub use deviation::{Deviation, Outcome, Place};
pub use distribution::Distribution;
pub use error::Error;
pub use exact_sum::ExactSum;
pub use footpoint::{Progress, no_progress};
pub use histogram::Histogram;
pub use inspection::{Inspection, PartDeviations, ShapeDeviations, Verdict};
pub use nominal::{Nominal, ShapeInfo};
pub use options::{Along, InspectionOptions};
pub use partial::Partial;
pub use percent::{Rounding, percent, percent_in_full, percent_of_share};
pub use picture::Picture;
pub use record::DeviationRecord;
pub use statistics::{Moments, Quantile, Statistics};
pub use tally::Deviations;
pub use tolerance::{Class, Tolerance};
pub use worst::WorstPoint;

// The crates whose types occur in the interface of this one.
pub use brep_core;
pub use mesh_core;
pub use nalgebra;
pub use nurbs_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
