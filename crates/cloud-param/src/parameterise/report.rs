//! What the whole way found.

use crate::defects::SurfaceDefects;
use crate::{AxisEstimate, CurveStep, RefineStep, ShapeDecision};
use footpoint::SurfaceFootpoint;
use nurbs_core::BsplineSurface;
use std::fmt;

/// A part of the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Stage {
    /// Neighbours, parts.
    Preparation,
    /// The axis and the kind of surface.
    Axis,
    /// Views and base curves.
    BaseCurves,
    /// Base curves drawn to the cloud.
    Projection,
    /// The base surface refined and relaxed.
    Refinement,
    /// The footpoints of all points.
    Parameters,
}

impl Stage {
    /// The name used in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Preparation => "preparation",
            Self::Axis => "axis",
            Self::BaseCurves => "base_curves",
            Self::Projection => "projection",
            Self::Refinement => "refinement",
            Self::Parameters => "parameters",
        }
    }
}

/// Time that a stage took.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StageTime {
    /// The stage.
    pub stage: Stage,
    /// Seconds.
    pub seconds: f64,
}

/// How it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum ParameterStatus {
    /// The base surface is free of folds and loops, and follows the cloud.
    Converged,
    /// The base surface folds over or crosses itself somewhere: see the defects. Parameters are wrong there.
    Folded,
    /// Much of the base surface lies over holes, many points lie beyond its ends, or it is farther from the points than these
    /// are from each other.
    Incomplete,
}

impl ParameterStatus {
    /// The name used in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Folded => "folded",
            Self::Incomplete => "incomplete",
        }
    }
}

impl fmt::Display for ParameterStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What was found on the way.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ParameteriseReport {
    /// How it ended.
    pub status: ParameterStatus,
    /// The kind of surface, and why.
    pub shape: ShapeDecision,
    /// The axis.
    pub axis: AxisEstimate,
    /// Points given.
    pub points: usize,
    /// Points that are not finite.
    #[cfg_attr(feature = "serde", serde(rename = "points_dropped"))]
    pub dropped: usize,
    /// Points apart from the cloud, which the base surface does not follow.
    pub strays: usize,
    /// Points that count for a fit: on the base surface or as near to it as others.
    #[cfg_attr(feature = "serde", serde(rename = "points_used"))]
    pub used: usize,
    /// Points beyond the open ends or without a foot.
    pub beyond_ends: usize,
    /// Share of the finite points with one nearest point on the base surface only.
    pub unique: f64,
    /// Root mean square distance from the base surface of the points that count.
    pub rms: f64,
    /// The largest of these distances.
    pub max: f64,
    /// Side of the square that a point has to itself, on average.
    pub spacing: f64,
    /// Number of views, 0 where there was no turntable.
    pub views: usize,
    /// Share of the points that some view shows.
    pub seen: f64,
    /// Layers with a base curve, and layers tried.
    pub layers: [usize; 2],
    /// Layers whose curve does not come from the views.
    pub radial_layers: usize,
    /// Samples in `u` and `v` of the base surface.
    pub grid: [usize; 2],
    /// The base curves before the first projection and after each.
    pub curve_history: Vec<CurveStep>,
    /// Curves that had to be smoothed to stay free of loops.
    pub smoothed_curves: usize,
    /// The surface before the first refinement and after each.
    pub refine_history: Vec<RefineStep>,
    /// Share of the base surface without points near it.
    pub unsupported: f64,
    /// What is wrong with the base surface.
    pub defects: SurfaceDefects,
    /// Time of each stage.
    pub times: Vec<StageTime>,
}

impl ParameteriseReport {
    pub(super) fn new(shape: ShapeDecision, axis: &AxisEstimate) -> Self {
        Self {
            status: ParameterStatus::Converged,
            shape,
            axis: axis.clone(),
            points: 0,
            dropped: 0,
            strays: 0,
            used: 0,
            beyond_ends: 0,
            unique: 0.0,
            rms: 0.0,
            max: 0.0,
            spacing: 0.0,
            views: 0,
            seen: 1.0,
            layers: [0; 2],
            radial_layers: 0,
            grid: [0; 2],
            curve_history: Vec::new(),
            smoothed_curves: 0,
            refine_history: Vec::new(),
            unsupported: 0.0,
            defects: SurfaceDefects::default(),
            times: Vec::new(),
        }
    }
}

impl fmt::Display for ParameteriseReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} of {} samples, rms {:.4e}, {} of {} points, {} loops, {} crossovers",
            self.status,
            self.shape.shape.name(),
            self.grid.map(|n| n.to_string()).join(" x "),
            self.rms,
            self.used,
            self.points,
            self.defects.self_loops,
            self.defects.crossovers
        )
    }
}

/// A base surface with the parameters of a cloud.
#[derive(Clone, Debug)]
pub struct Parameterisation {
    /// The base surface; periodic in `u` for cylinder- and sphere-like clouds.
    pub base: BsplineSurface,
    /// The footpoint of each point on it, in the order of the points; those that are not finite have
    /// [`footpoint::Status::InvalidPoint`].
    pub feet: Vec<SurfaceFootpoint>,
    /// For each point whether it counts for a fit.
    pub counts: Vec<bool>,
    /// How it came about.
    pub report: ParameteriseReport,
}

impl Parameterisation {
    /// Whether the base surface is free of folds and follows the cloud.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.report.status == ParameterStatus::Converged
    }
}
