//! CAD files in and out: STEP (feature `step`) and IGES.
//!
//! Readers produce and writers consume the plain data of [`brep_core::description`]. What holds geometry and cannot be
//! used is listed there with its number in the file and the reason; what is no file of the format is an [`Error`] that says
//! where, what and what to do.
//!
//! ```
//! # #[cfg(feature = "step")] {
//! let error = cad_io::read_step(b"solid cube").unwrap_err();
//! assert!(error.to_string().contains("does not begin with ISO-10303-21"));
//! # }
//! ```

mod error;
#[cfg(feature = "step")]
mod step;

pub use brep_core::description;
pub use error::{Error, Location, Place};
#[cfg(feature = "step")]
pub use step::{is_step, read_step, read_step_file};
