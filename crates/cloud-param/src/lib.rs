//! From an unorganised cloud to parameters and a base surface, each step usable alone.

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
pub use fit::{FitOptions, SurfaceFit, fit_parameters};
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
    Boundary, RefineOptions, RefineReport, RefineStep, SampleGrid, dynamic_base_surface, grid_of_curves,
    refine,
};
pub use turntable::{
    AxisChoice, AxisEstimate, AxisOrigin, Circle, Coverage, Turntable, TurntableView, bounding_circle,
    estimate_axis,
};
pub use visibility::{Sharpness, View, Visibility, visible_points};
