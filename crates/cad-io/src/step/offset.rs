//! Offsets of free-form surfaces, which have no exact form as B-splines.

use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface};

/// Distance from the exact offset, as a share of the size of the surface, within which the B-spline stays.
const NEAR: f64 = 1e-8;
/// Degree of the B-spline in both directions.
const DEGREE: usize = 5;
/// Pieces into which each span is divided first, and how often these are halved at most.
const PIECES: usize = 4;
const HALVED: u32 = 5;
/// Control points at most.
const MOST: usize = 100_000;

/// The B-spline through points at a distance along the normal `S_u × S_v`, as many as it takes.
///
/// # Errors
/// A surface without a normal somewhere, and one that bends too sharply to be followed.
pub(super) fn offset(surface: &BsplineSurface, distance: f64) -> Result<BsplineSurface, String> {
    let size = surface.control_box().diagonal().max(distance.abs());
    if !distance.is_finite() {
        return Err(format!("its distance is {distance}"));
    }
    let at = |u: f64, v: f64| {
        let jet = surface.jet(u, v);
        let normal =
            jet.unit_normal().ok_or("the surface that it is an offset of has no normal everywhere")?;
        Ok::<_, String>(jet.point + normal * distance)
    };
    let domain = surface.domain();
    let spans: [Vec<f64>; 2] = [0, 1].map(|i| {
        let inner = surface.breaks()[i]
            .clone()
            .into_iter()
            .filter(|t| *t > domain[i].start() && *t < domain[i].end());
        [domain[i].start()].into_iter().chain(inner).chain([domain[i].end()]).collect()
    });
    for round in 0..HALVED {
        let pieces = PIECES << round;
        let [us, vs] = [0, 1].map(|i| places(&spans[i], pieces));
        if us.len() * vs.len() > MOST {
            break;
        }
        let mut points = Vec::with_capacity(us.len() * vs.len());
        for u in &us {
            for v in &vs {
                points.push(at(*u, *v)?);
            }
        }
        let why = |error: nurbs_core::Error| error.to_string();
        let knots = [&us, &vs].map(|places| KnotVector::averaged(DEGREE, places));
        let [knots_u, knots_v] = knots;
        let found = BsplineSurface::interpolate_grid_at(
            [knots_u.map_err(why)?, knots_v.map_err(why)?],
            [&us, &vs],
            &points,
        )
        .map_err(why)?;
        // Between its points the surface is farthest away.
        let mut off = 0.0_f64;
        for u in us.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])) {
            for v in vs.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])) {
                off = off.max((found.point(u, v) - at(u, v)?).norm());
            }
        }
        if off <= NEAR * size {
            return Ok(found);
        }
    }
    Err("the offset of its surface cannot be followed by a B-spline: it bends too sharply".to_owned())
}

/// The ends of spans, and places between them.
fn places(breaks: &[f64], pieces: usize) -> Vec<f64> {
    let mut out: Vec<f64> = breaks.first().copied().into_iter().collect();
    for pair in breaks.windows(2) {
        for k in 1..=pieces {
            let s = k as f64 / pieces as f64;
            out.push(if k == pieces { pair[1] } else { pair[0] + (pair[1] - pair[0]) * s });
        }
    }
    // One span of few pieces has too few places for the degree.
    if out.len() <= DEGREE && breaks.len() >= 2 { places(breaks, pieces * 2) } else { out }
}
