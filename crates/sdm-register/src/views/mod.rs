//! Many scans of one object, registered all at once.
//!
//! Every view is a moving system with a velocity `vᵢ(x) = c̄ᵢ + cᵢ × x`. A point `x` of view `i` whose foot on view `j` has the
//! normal `n` and the distance `d` contributes `(d + ⟨n, vᵢ(x) − vⱼ(x)⟩)²`, and so do the points of view `j` with feet on view
//! `i`; the sum over all overlapping pairs is minimised in one system of `6 (n − 1)` unknowns (\[PLH02\]). Errors do not
//! accumulate along a chain of scans, and loops close by themselves.

mod anywhere;
mod chain;
mod graph;
mod matching;
mod options;
mod register;
mod report;
mod surface;
mod system;
mod view;

pub use anywhere::register_views_from;
pub use chain::{PairSearch, have_much_in_common};
pub use options::ViewsOptions;
pub use register::register_views;
pub use report::{PairReport, ViewReport, ViewsReport, ViewsStatus, ViewsStep};
pub use view::View;
