//! Zero sets of functions on regular grids: where an implicit curve or surface lies, and how it bends.

mod contour;
mod field;
mod grid;
mod spline;

pub use field::LevelSetField;
pub use grid::Grid;
