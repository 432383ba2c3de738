//! Ruled surfaces, and layers of them.
//!
//! A surface of degree 1 in v is ruled: its lines in v are straight from one section (a row of control points along u) to the
//! next. Two sections make one ruled surface, more of them make layers (\[P05, sec. 4.5\]): strips that a cylindrical cutter
//! mills with its side, a hot wire cuts, or plates and laths cover.

mod active;
mod cloud;
mod developability;
mod fit;
mod start;

pub use active::ActiveRuled;
pub use cloud::{
    OffsetPoints, RuledCloudFit, RuledCloudOptions, fit_ruled_cloud, fit_ruled_cloud_with_progress,
    offset_points,
};
pub use developability::Developability;
pub use fit::{RuledFit, RuledOptions, RuledReport, fit_ruled, fit_ruled_with_progress};
pub use start::initial_ruled;
