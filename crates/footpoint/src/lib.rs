//! Orthogonal projection of points onto parametric curves and surfaces.

mod error;
mod footpoint;
mod global;
pub mod local;
mod options;
mod projector;
mod status;

pub use error::Error;
pub use footpoint::{CurveFootpoint, SurfaceFootpoint};
pub use options::{Mode, ProjectionOptions};
pub use projector::{CurveProjector, Progress, SurfaceProjector, no_progress};
pub use status::{Location, Multiplicity, Status};
