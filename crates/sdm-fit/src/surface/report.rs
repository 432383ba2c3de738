//! What a fit of a surface found.

use super::base_shape::BaseShape;
use super::folds::Folds;
use crate::FitReport;
use crate::coverage_surface::SurfaceCoverage;
use distance_field::PrincipalFrame;
use nurbs_core::{BsplineSurface, TrimLoops};

/// A surface and how it came about.
#[derive(Clone, Debug)]
pub struct SurfaceFit {
    /// The surface.
    pub surface: BsplineSurface,
    /// How it came about.
    pub report: SurfaceReport,
    /// The frame of every finite point at its foot, with its parameters as hint.
    pub frames: Vec<PrincipalFrame<3>>,
}

/// How the fit of a surface went.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SurfaceReport {
    /// The last run of the loop; its history is that of all runs.
    pub fit: FitReport,
    /// What gave the first parameters; `None` for a start that was given.
    pub base: Option<BaseShape>,
    /// Control points in u and v that are not repetitions.
    #[cfg_attr(feature = "serde", serde(rename = "control_points"))]
    pub controls: [usize; 2],
    /// Runs of the loop, one for each knot refinement and one to begin with.
    pub runs: usize,
    /// Share of the points within the tolerance, if there is one.
    pub share_within: Option<f64>,
    /// Whether the tolerance holds; true without one.
    pub within_tolerance: bool,
    /// Cells in which the surface folds back on itself.
    pub folds: Folds,
    /// How near the parts of the surface, as far as the data go, are to the points, unless that was not asked for.
    pub coverage: Option<SurfaceCoverage>,
    /// The loops that bound what of the surface is near points, where parts of it are not; `None` where it is whole.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub trim: Option<TrimLoops>,
    /// Points left out because they are not finite.
    #[cfg_attr(feature = "serde", serde(rename = "points_dropped"))]
    pub dropped: usize,
}

impl std::fmt::Display for SurfaceReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [u, v] = self.controls;
        write!(f, "{}, {u} × {v} control points", self.fit)?;
        match self.folds.count() {
            0 => Ok(()),
            folds => write!(f, ", {folds} of {} cells folded", self.folds.cells),
        }
    }
}
