//! Active curves and surfaces fitted to clouds and shapes by quadratic models of the squared distance.
//!
//! One loop serves all shapes and all error terms (\[P05, sec. 4\]): footpoints give quadratic models of the squared
//! distance, their sum and a smoothing energy are minimised in the control points, and again.

mod error;
mod parallel;
pub mod primitive;

pub use error::Error;
