//! Which points count, and how much.

mod reject;
mod robust;

pub use distance_field::Kernel;
pub use reject::Rejection;
pub use robust::Outliers;
pub(crate) use robust::{Rule, Weighting};
