//! Rigid registration of clouds to shapes and to each other by quadratic models of the squared distance.

mod error;
pub(crate) mod parallel;
pub mod start;

pub use error::Error;
