//! Zero sets of functions on regular grids: where an implicit curve or surface lies, and how it bends.

mod contour;
mod field;
mod foot;
mod grid;
mod spline;

pub use contour::Saddles;
pub(crate) use contour::crossings;
pub use field::LevelSetField;
pub(crate) use foot::ZeroSet;
pub use grid::Grid;
pub(crate) use spline::GridSpline;
