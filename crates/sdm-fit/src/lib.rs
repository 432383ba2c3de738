//! Active curves and surfaces fitted to clouds and shapes by quadratic models of the squared distance.
//!
//! One loop serves all shapes and all error terms (\[P05, sec. 4\]): footpoints give quadratic models of the squared
//! distance, their sum and a smoothing energy are minimised in the control points, and again. [`fit()`] is that loop. A shape
//! enters it as an [`ActiveShape`], the data as a [`Target`]; point, tangent and squared distance minimisation differ in the
//! [`ErrorTerm`](distance_field::ErrorTerm) only.
//!
//! ```
//! use nalgebra::Vector2;
//! use nurbs_core::{BsplineCurve, KnotVector};
//! use sdm_fit::{ActiveCurve, Constraints, FitOptions, Target, fit};
//!
//! // A closed curve of eight control points, from a circle to an ellipse.
//! let turn = |i: usize, n: usize| std::f64::consts::TAU * i as f64 / n as f64;
//! let circle = (0..11).map(|i| Vector2::new(turn(i, 8).cos(), turn(i, 8).sin()) * 2.0).collect();
//! let start = BsplineCurve::new(KnotVector::uniform_periodic(3, 8)?, circle, None)?;
//! let ellipse: Vec<_> = (0..60).map(|i| Vector2::new(3.0 * turn(i, 60).cos(), turn(i, 60).sin())).collect();
//!
//! let target = Target::Points { points: &ellipse, weights: None };
//! let fitted = fit(ActiveCurve::new(start)?, target, &Constraints::none(), &FitOptions::default())?;
//! assert!(fitted.report.rms < 0.01, "{}", fitted.report);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod assemble;
mod cloud_kind;
mod constraint;
mod coverage_curve;
mod coverage_surface;
pub mod curve;
mod error;
mod fairing;
mod freedom;
mod iterate;
mod layout;
mod noise;
mod options;
mod parallel;
mod polish;
pub mod primitive;
mod rational;
mod report;
pub mod ruled;
mod shape;
mod simd;
mod smoothing;
mod spacing;
pub mod subdivision;
mod surface;
mod target;
mod weights;

pub use cloud_kind::{CloudKind, cloud_kind, measurable, tight_axes};
pub use constraint::{Constraints, LinearCondition};
pub use coverage_curve::{CurveCoverage, Stretch};
pub use coverage_surface::{PieceWithData, SurfaceCoverage, data_outline};
pub use curve::ActiveCurve;
pub use error::Error;
pub use iterate::{Progress, fit, fit_with_progress, no_progress};
pub use options::{FitOptions, Smoothing};
pub use report::{FitReport, FitStep, Fitted};
pub use sdm_core::{FootpointPolicy, Robust, Status, StepControl};
pub use shape::{ActiveShape, CellGram, CellTable, Penalty};
pub use surface::{
    ActiveSurface, BaseShape, Folds, InitialSurface, NetSize, SurfaceCost, SurfaceDistances, SurfaceFit,
    SurfaceOptions, SurfaceReport, cut_to_feet, fit_cloud, fit_cloud_with_progress, fit_surface,
    fit_surface_to_model, fit_surface_to_model_with_progress, fit_surface_with_progress, initial_surface,
    residual_disagreement, surface_costs, surface_frames, with_controls,
};
pub use target::Target;

// The crates whose types occur in the interface of this one.
pub use distance_field;
pub use mesh_core;
pub use nalgebra;
pub use nurbs_core;
pub use sdm_core;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
