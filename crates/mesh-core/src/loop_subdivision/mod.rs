//! Subdivision surfaces of triangle meshes after Loop (\[Lo87\]).

mod masks;
mod scheme;

pub use masks::Mask;
pub use scheme::{LimitPoint, LoopScheme};
