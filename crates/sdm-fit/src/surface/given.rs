//! Surfaces from which a fit begins: how near they are already.

use crate::polish::may_vanish;
use crate::primitive::start;
use crate::shape::ActiveShape;
use crate::{Error, FitOptions, FitReport, Smoothing, Status};
use distance_field::{DistanceField, PrincipalFrame, Search, SurfaceField};
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;

/// Points that are asked how near the surface is.
const ASKED: usize = 2000;
/// Root mean square distance, as a share of the size, up to which points lie on a surface exactly.
const EXACT: f64 = 1e-13;

/// Largest coordinate of points that are given about a middle.
pub(super) fn size_of(points: &[Vector3<f64>]) -> f64 {
    points.iter().map(|p| p.amax()).fold(0.0, f64::max).max(f64::MIN_POSITIVE)
}

/// The frames of all points, if they lie on the surface exactly and no energy was asked for: then there is nothing to be done.
pub(super) fn exact(
    points: &[Vector3<f64>],
    surface: &BsplineSurface,
    options: &FitOptions,
) -> Result<Option<(Vec<PrincipalFrame<3>>, FitReport)>, Error> {
    if !may_vanish(options.smoothing)
        || points.is_empty()
        || points.iter().any(|p| !p.iter().all(|c| c.is_finite()))
    {
        return Ok(None);
    }
    let field = SurfaceField::new(surface)?;
    let limit = EXACT * size_of(points);
    if rms(&field.frames(&start::thinned(points, ASKED), Search::Global, &[])) > limit {
        return Ok(None);
    }
    let frames = field.frames(points, Search::Global, &[]);
    let rms = rms(&frames);
    if rms > limit {
        return Ok(None);
    }
    let distances = frames.iter().map(|f| f.distance.abs()).enumerate();
    let (max_index, max) = distances.fold((0, 0.0), |best, (i, d)| if d > best.1 { (i, d) } else { best });
    let report = FitReport {
        status: Status::Converged,
        initial_rms: rms,
        rms,
        max,
        max_index,
        lambda: 0.0,
        samples: points.len(),
        used: points.len(),
        history: Vec::new(),
    };
    Ok(Some((frames, report)))
}

/// The schedule of an energy that weighs no more, to begin with, than the squared distances that a shape leaves already: more would draw it
/// away from the points again.
pub(crate) fn begun_at<S: ActiveShape<3>>(
    points: &[Vector3<f64>],
    shape: &S,
    options: &FitOptions,
) -> Result<Smoothing, Error> {
    let first = match options.smoothing {
        Smoothing::Fixed { .. } => return Ok(options.smoothing),
        Smoothing::Continuation { start, .. } | Smoothing::Automatic { start, .. } => start,
    };
    let finite = points.iter().all(|p| p.iter().all(|c| c.is_finite()));
    let bend = bending(shape, options.energy);
    if !finite || bend == 0.0 {
        return Ok(options.smoothing);
    }
    let left = rms(&shape.frames(&start::thinned(points, ASKED), Search::Global, &[])?);
    let most = first.min(left * left / bend);
    Ok(match options.smoothing {
        Smoothing::Continuation { factor, floor, .. } => {
            Smoothing::Continuation { start: most.max(floor), factor, floor }
        }
        Smoothing::Automatic { factor, .. } => Smoothing::Automatic { start: most, factor },
        fixed @ Smoothing::Fixed { .. } => fixed,
    })
}

/// The energy of a shape.
pub(crate) fn bending<S: ActiveShape<3>>(shape: &S, weights: [f64; 3]) -> f64 {
    let (cells, net) = (shape.cells(), shape.coefficients());
    let of_cell = |gram: &crate::CellGram| {
        let columns = cells.columns(gram.cell);
        let line = |(k, row): (usize, &[f64])| {
            let image: Vector3<f64> = row.iter().zip(columns).map(|(g, &c)| net[c] * *g).sum();
            net[columns[k]].dot(&image)
        };
        gram.gram.chunks_exact(columns.len()).enumerate().map(line).sum::<f64>()
    };
    shape.energy(weights).iter().map(of_cell).sum::<f64>().max(0.0)
}

/// Root mean square distance; of none, or none that is finite, as of points far away.
fn rms(frames: &[PrincipalFrame<3>]) -> f64 {
    let square = frames.iter().map(|f| f.distance * f.distance).sum::<f64>() / frames.len().max(1) as f64;
    if square.is_finite() { square.sqrt() } else { f64::MAX.sqrt() }
}
