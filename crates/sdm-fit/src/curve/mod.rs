//! Curves fitted to points and to models.

mod active;

pub use active::ActiveCurve;
