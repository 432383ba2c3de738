//! Dynamic base surfaces from four boundary curves: the method that came before.

use super::{RefineOptions, RefineReport, SampleGrid, refine};
use crate::defects::SurfaceDefects;
use crate::{Error, Neighbourhood};
use nurbs_core::construct::BoundaryCurves;
use nurbs_core::{BsplineSurface, Interval, ParametricSurface};

/// The dynamic base surface of a cloud within four given boundary curves (\[Az04\]): a grid on their Coons patch is projected
/// onto the cloud along the normals and relaxed, a surface is laid through it, and again. Its boundary is exactly the curves, and its domain the unit
/// square.
///
/// The baseline to which [`base_curves`](crate::base_curves) is the alternative: someone has to give the curves, and where
/// the Coons patch is far from the cloud the grid folds; the report counts these crossovers, and its last state is the surface that is returned.
///
/// # Errors
/// [`Error::Nurbs`] for curves that do not meet within `abs_tolerance` (a length), or with weights; [`Error::Option`] for a grid of fewer than four
/// places in a direction; as [`refine`].
pub fn dynamic_base_surface(
    cloud: &Neighbourhood,
    boundary: &BoundaryCurves,
    abs_tolerance: f64,
    size: [usize; 2],
    options: &RefineOptions,
) -> Result<(BsplineSurface, RefineReport), Error> {
    let unit = Interval::new(0.0, 1.0)?;
    let coons = boundary.coons(abs_tolerance)?.reparameterized([unit; 2])?;
    if let Some(&few) = size.iter().find(|&&n| n < 4) {
        return Err(Error::Option { name: "size", value: few as f64, allowed: "at least 4" });
    }
    let [m, n] = size;
    let at = |k: usize| coons.point((k / n) as f64 / (m - 1) as f64, (k % n) as f64 / (n - 1) as f64);
    let grid = SampleGrid { size, points: (0..m * n).map(at).collect(), closed: false };
    let options = RefineOptions { equalise: false, hold_boundary: true, ..*options };
    let (_, surface, mut report) = refine(&grid, cloud, None, &options)?;
    // The surface through the grid follows the curves between its places only nearly.
    let surface = boundary.imposed_on(&surface, abs_tolerance)?;
    report.history[report.kept].defects = SurfaceDefects::of(&surface, None);
    Ok((surface, report))
}
