//! Polylines and triangles within a chord tolerance.

mod bounds;
mod curve;
mod grid;
mod options;
mod surface;
mod trimmed;

pub use curve::Polyline;
pub use options::TessellationOptions;
pub use surface::Tessellation;
