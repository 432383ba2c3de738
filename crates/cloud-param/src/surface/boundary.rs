//! Dynamic base surfaces from four boundary curves: the method that came before.

use super::{RefineOptions, RefineReport, SampleGrid, refine};
use crate::{Error, Neighbourhood};
use nurbs_core::{BsplineCurve, BsplineSurface, ParametricSurface, construct};

/// Four curves around a patch.
#[derive(Clone, Copy, Debug)]
pub struct Boundary<'a> {
    /// The curves `v = 0` and `v = 1`, both running in `u`.
    pub along_u: [&'a BsplineCurve<3>; 2],
    /// The curves `u = 0` and `u = 1`, both running in `v`.
    pub along_v: [&'a BsplineCurve<3>; 2],
}

/// The dynamic base surface of a cloud within four given boundary curves (\[Az04\]): a grid on their Coons patch is projected
/// onto the cloud along the normals and relaxed, a surface is laid through it, and again.
///
/// The baseline to which [`base_curves`](crate::base_curves) is the alternative: someone has to give the curves, and where
/// the Coons patch is far from the cloud the grid folds; the report counts these crossovers.
///
/// # Errors
/// [`Error::Nurbs`] for curves that do not meet; as [`refine`].
pub fn dynamic_base_surface(
    cloud: &Neighbourhood,
    boundary: &Boundary<'_>,
    size: [usize; 2],
    options: &RefineOptions,
) -> Result<(BsplineSurface, RefineReport), Error> {
    let tolerance = 1e-6 * boundary.along_u[0].control_points().iter().map(|p| p.norm()).fold(0.0, f64::max);
    let coons = construct::coons(boundary.along_u, boundary.along_v, tolerance)?;
    let [u, v] = coons.domain();
    if let Some(&few) = size.iter().find(|&&n| n < 4) {
        return Err(Error::Option { name: "size", value: few as f64, allowed: "at least 4" });
    }
    let [m, n] = size;
    let at = |k: usize| {
        coons.point(u.lerp((k / n) as f64 / (m - 1) as f64), v.lerp((k % n) as f64 / (n - 1) as f64))
    };
    let grid = SampleGrid { size, points: (0..m * n).map(at).collect(), closed: false };
    let (_, surface, report) = refine(&grid, cloud, None, options)?;
    Ok((surface, report))
}
