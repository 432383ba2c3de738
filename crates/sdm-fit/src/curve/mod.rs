//! Curves fitted to points and to models.
//!
//! [`fit_curve`] goes all the way from points to a curve; [`ActiveCurve`] is the shape for those who run the loop
//! ([`fit`](crate::fit())) themselves.

mod active;
mod adapt;
mod attempt;
mod conclude;
mod crossing;
mod ends;
mod fit;
mod front;
mod improve;
mod judge;
mod nodes;
mod options;
mod parts;
mod path;
mod pieces;
mod places;
mod rational;
mod report;
mod several;
mod shortest;
mod start;
mod to_model;
mod tour;
mod tree;
mod work;

pub use active::ActiveCurve;
pub use crossing::self_crossings;
pub use fit::{fit_curve, fit_curve_with_progress};
pub use options::{CurveEnd, CurveOptions};
pub use report::{Closure, CurveFit, CurveReport, CurveStart, PointFoot, StageRecord};
pub use several::{CurvePart, fit_curves, fit_curves_with_progress};
pub use to_model::{fit_curve_to_model, fit_curve_to_model_with_progress};
