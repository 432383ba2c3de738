//! Orthogonal projection of points onto parametric curves and surfaces.

mod error;
mod footpoint;
mod global;
mod options;
mod projector;
mod status;

pub use error::Error;
pub use footpoint::{CurveFootpoint, SurfaceFootpoint};
pub use options::{Mode, ProjectionOptions};
pub use projector::{CurveFeet, CurveProjector, Progress, SurfaceFeet, SurfaceProjector, no_progress};
pub use status::{Location, Multiplicity, Status};
