//! Subdivision surfaces of triangle meshes after Loop (\[Lo87\]).

mod box_spline;
mod limit_patch;
mod limit_surface;
mod masks;
mod neighbourhood;
mod scheme;

pub use limit_surface::{LimitJet, LoopSurface};
pub use masks::Mask;
pub use scheme::{LimitPoint, LoopScheme};
