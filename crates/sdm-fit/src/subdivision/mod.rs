//! Loop subdivision surfaces.
//!
//! Points of the limit surface are linear in the control points, as those of splines are (\[P05, sec. 4.2\], Fig. 5), so that the
//! same loop fits them, with any topology and without patches that have to be joined.

mod active;
mod coarsen;
mod fit;
mod folded;

pub use active::ActiveLoop;
pub use coarsen::coarsened;
pub use fit::{SubdivisionFit, fit_subdivision, fit_subdivision_with_progress, subdivision_options};
pub use folded::{FoldedEdges, folded_edges};
