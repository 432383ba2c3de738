//! What the commands that fit surfaces have in common: their options, their input, and numbers of a fit.

pub(crate) mod arguments;
pub(crate) mod boundary;
pub(crate) mod input;
pub(crate) mod numbers;
pub(crate) mod page;
pub(crate) mod summary;
