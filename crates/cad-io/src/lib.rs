//! CAD files in and out: STEP (feature `step`) and IGES.
//!
//! Readers produce and writers consume the plain data of [`brep_core::description`]: parts with faces, loops, edges, vertices and
//! free curves, their names and the unit.
//!
//! | format | reading | writing |
//! |---|---|---|
//! | IGES | [`read_iges`]: trimmed, bounded and whole surfaces, solids, free curves | [`to_iges`]: trimmed B-spline surfaces and B-spline curves |
//! | STEP | `read_step`, with the feature `step` | [`to_step`]: AP242, carriers and curves as they are |
//!
//! B-splines keep every bit both ways. What a file holds and is not read is listed; faults name the line and the entity. The same
//! model always gives the same bytes. [`ModelBuilder`] makes models of fitted surfaces and curves.
//!
//! ```
//! use cad_io::description::LengthUnit;
//! use nurbs_core::nalgebra::Vector3;
//! use nurbs_core::construct::bilinear;
//!
//! let corner = |x, y| Vector3::new(x, y, x * y);
//! let surface = bilinear([[corner(0.0, 0.0), corner(0.0, 1.0)], [corner(2.0, 0.0), corner(2.0, 1.0)]])?;
//! let mut model = cad_io::ModelBuilder::new("saddle", Some(LengthUnit::millimetre()));
//! model.surface("skin", surface);
//! let written = cad_io::to_iges(&model.finish())?;
//!
//! let read = cad_io::read_iges(&written)?;
//! assert_eq!((read.name.as_str(), read.unit), ("saddle", Some(LengthUnit::millimetre())));
//! assert_eq!(read.parts[0].faces[0].name, "skin");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod builder;
mod edges;
mod error;
mod iges;
mod model_builder;
mod natural;
#[cfg(feature = "step")]
mod step;
mod step_text;
mod trimmed;
mod write;

pub use brep_core::description;
pub use error::{Error, Location, Place};
pub use iges::{is_iges, read_iges, read_iges_file, to_iges};
pub use model_builder::ModelBuilder;
#[cfg(feature = "step")]
pub use step::{is_step, read_step, read_step_file};
pub use step_text::to_step;

// The crates whose types occur in the interface of this one.
pub use brep_core;
pub use nurbs_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
