//! Curves fitted to points and to models.
//!
//! [`fit_curve`] goes all the way from points to a curve; [`ActiveCurve`] is the shape for those who run the loop
//! ([`fit`](crate::fit())) themselves.

mod active;
mod adapt;
mod crossing;
mod fit;
mod front;
mod improve;
mod options;
mod path;
mod places;
mod rational;
mod report;
mod start;
mod tour;
mod tree;

pub use active::ActiveCurve;
pub use crossing::self_crossings;
pub use fit::{fit_curve, fit_curve_with_progress};
pub use options::CurveOptions;
pub use report::{Closure, CurveFit, CurveReport, CurveStart, PointFoot, StageRecord};
