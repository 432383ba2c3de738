//! From an unorganised cloud to parameters and a fitted B-spline surface, without boundary curves and without a choice.
//!
//! A least squares surface needs a parameter pair for every point. [`parameterise`] finds them as \[MPK\] do for clouds around
//! an axis: the cloud on a virtual turntable ([`Turntable`]) is seen from several sides ([`visible_points`]), each view becomes
//! a height field ([`multilevel`]), these give a closed curve in each layer ([`base_curves`]), the curves are drawn to the cloud
//! ([`project_curves`]), the surface through them is refined ([`refine`]), and the footpoints on it are the parameters.
//! [`fit_parameters`] makes a surface of them. Every step can be used alone. Clouds that are height fields or closed all around
//! get base surfaces of their own; [`Shape::Auto`] decides and says why.
//!
//! ```
//! use cloud_param::{FitOptions, ParameteriseOptions, fit_parameters, parameterise};
//! use nalgebra::Vector3;
//!
//! // A tube that widens, its points in no order.
//! let at = |i: u32| (f64::from(i) * 2.399963, (f64::from(i) * 0.7548777).fract());
//! let point = |(a, h): (f64, f64)| Vector3::new((1.0 + h * h) * a.cos(), (1.0 + h * h) * a.sin(), 4.0 * h);
//! let points: Vec<_> = (0..4000).map(at).map(point).collect();
//! let found = parameterise(&points, &ParameteriseOptions::default())?;
//! let options = FitOptions { control_points: [12, 8], ..FitOptions::default() };
//! let fit = fit_parameters(&points, &found.base, &found.feet, &found.counts, &options)?;
//! assert!(fit.rms < 2e-3 && fit.surface.knots_u().is_periodic());
//! # Ok::<(), cloud_param::Error>(())
//! ```

mod components;
mod curves;
mod defects;
mod directed;
mod error;
mod fit;
mod frame;
mod hull;
mod multilevel;
mod neighbourhood;
pub(crate) mod parallel;
mod parameterise;
mod plane_frame;
mod section;
mod shape;
mod surface;
mod turntable;
mod visibility;

pub use curves::{
    BaseCurveOptions, BaseCurves, ClosedCurve, CurveOptions, CurveOrigin, CurveReport, CurveStep, LayerCurve,
    ViewField, base_curves, project_curves,
};
pub use defects::{SurfaceDefects, self_loops};
pub use directed::{DirectedFoot, DirectedOptions, DirectedWeight, project_directed};
pub use error::Error;
pub use fit::{
    FinishOutcome, FinishReport, FitOptions, Resolution, SurfaceFit, consistent, crowded, finish_fit,
    finish_fit_with_progress, finish_options, fit_parameters, resolution,
};
pub use frame::AxisFrame;
pub use hull::ConvexHull;
pub use multilevel::{
    HeightField, LevelRecord, MultilevelOptions, MultilevelReport, MultilevelStatus, Trend, Weighting,
    multilevel,
};
pub use nalgebra;
pub use neighbourhood::Neighbourhood;
pub use parameterise::{
    ParameterStatus, Parameterisation, ParameteriseOptions, ParameteriseReport, Progress, Stage, StageTime,
    no_progress, parameterise, parameterise_with_progress,
};
pub use shape::{Shape, ShapeDecision, decide};
pub use surface::{
    RefineOptions, RefineReport, RefineStep, SampleGrid, dynamic_base_surface, grid_of_curves, refine,
};
pub use turntable::{
    AxisChoice, AxisEstimate, AxisOrigin, Circle, Coverage, Turntable, TurntableView, bounding_circle,
    estimate_axis,
};
pub use visibility::{Sharpness, View, Visibility, visible_points};

// The crates whose types occur in the interface of this one.
pub use nurbs_core;
pub use sdm_fit;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
