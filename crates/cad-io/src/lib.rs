//! CAD files in and out: STEP (feature `step`) and IGES.
//!
//! Readers produce and writers consume the plain data of [`brep_core::description`].

mod builder;
mod edges;
mod error;
mod iges;
mod model_builder;
mod natural;
#[cfg(feature = "step")]
mod step;
mod step_text;
mod write;

pub use brep_core::description;
pub use error::{Error, Location, Place};
pub use iges::{is_iges, read_iges, read_iges_file, to_iges};
pub use model_builder::ModelBuilder;
#[cfg(feature = "step")]
pub use step::{is_step, read_step, read_step_file};
pub use step_text::to_step;
