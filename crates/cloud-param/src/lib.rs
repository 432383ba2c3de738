//! From an unorganised cloud to parameters and a base surface, each step usable alone.

mod error;

pub use error::Error;
