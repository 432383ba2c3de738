//! Global search with a certificate.
//!
//! Once per shape: Bézier pieces in a tree of boxes, and for each piece the squared distance function, up to the
//! query, in Bernstein form. Per query: best-first descent to promising pieces, local iteration there for an upper
//! bound, then proofs for every piece that could hold something nearer.

pub(crate) mod all_feet;
pub(crate) mod all_feet_curve;
pub(crate) mod all_feet_line;
pub(crate) mod bernstein;
pub(crate) mod box_tests;
pub(crate) mod cells;
pub(crate) mod descend;
pub(crate) mod evaluate;
pub(crate) mod fine;
pub(crate) mod gap;
pub(crate) mod geometry;
pub(crate) mod hulls;
mod landing_lanes;
pub(crate) mod lanes;
pub(crate) mod line;
mod nearest_sample;
pub(crate) mod newton_lanes;
pub(crate) mod patch;
pub(crate) mod piece;
pub(crate) mod pole;
pub(crate) mod polish;
pub(crate) mod polish_curve;
pub(crate) mod power;
pub(crate) mod products;
pub(crate) mod prove;
mod refine;
mod refine_curve;
pub(crate) mod scratch;
pub(crate) mod search;
pub(crate) mod search_curve;
pub(crate) mod seeds;
pub(crate) mod sides;
pub(crate) mod sides_curve;
pub(crate) mod simd;
pub(crate) mod split;
pub(crate) mod tree;
pub(crate) mod valley;
