//! What the writers of STEP and IGES have in common.

pub(crate) mod flat;
pub(crate) mod number;
pub(crate) mod shape;
