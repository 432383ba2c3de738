//! CAD files in and out: STEP (feature `step`) and IGES.
//!
//! Readers produce and writers consume the plain data of [`brep_core::description`].

mod error;
#[cfg(feature = "step")]
mod step;

pub use brep_core::description;
pub use error::{Error, Location, Place};
#[cfg(feature = "step")]
pub use step::{is_step, read_step, read_step_file};
