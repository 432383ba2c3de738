//! The search on the Bézier patches of surfaces.

pub(crate) mod all_feet;
pub(crate) mod cells;
pub(crate) mod descend;
pub(crate) mod evaluate;
pub(crate) mod foot;
pub(crate) mod geometry;
pub(crate) mod landing_lanes;
pub(crate) mod nearest_sample;
pub(crate) mod newton_lanes;
pub(crate) mod patch;
pub(crate) mod pole;
pub(crate) mod pole_edge;
pub(crate) mod polish;
pub(crate) mod refine;
pub(crate) mod sampling;
pub(crate) mod scratch;
pub(crate) mod search;
pub(crate) mod seeds;
pub(crate) mod sides;
