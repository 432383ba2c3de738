//! Global search with a certificate.
//!
//! Once per shape: Bézier pieces in a tree of boxes, and for each piece the squared distance function, up to the
//! query, in Bernstein form. Per query: best-first descent to promising pieces, local iteration there for an upper
//! bound, then proofs for every piece that could hold something nearer.

pub(crate) mod arithmetic;
pub(crate) mod curve;
pub(crate) mod gap;
pub(crate) mod proof;
pub(crate) mod surface;
pub(crate) mod tree;
