//! Differential geometry at a point: everything that a jet tells about the shape.
//!
//! Nothing here depends on the parameterisation beyond the orientation it gives to curve and surface.

mod curve;
mod forms;
mod principal;

pub use curve::FrenetFrame;
pub use forms::{FirstForm, SecondForm};
pub use principal::PrincipalFrame;
