//! Which points count, and how much.

mod kernel;
mod reject;
mod robust;
mod scale;

pub use kernel::Kernel;
pub use reject::Rejection;
pub use robust::Outliers;
pub(crate) use robust::{Rule, Weighting};
pub(crate) use scale::Spread;
