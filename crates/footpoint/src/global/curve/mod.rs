//! The search on the Bézier pieces of curves.

pub(crate) mod all_feet;
pub(crate) mod all_feet_line;
pub(crate) mod piece;
pub(crate) mod polish;
pub(crate) mod refine;
pub(crate) mod scratch;
pub(crate) mod search;
pub(crate) mod sides;
