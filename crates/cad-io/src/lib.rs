//! CAD files in and out: STEP (feature `step`) and IGES.
//!
//! Readers produce and writers consume the plain data of [`brep_core::description`].

mod error;

pub use brep_core::description;
pub use error::{Error, Location, Place};
