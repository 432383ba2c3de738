//! Sides of a surface that are given.

use crate::Error;
use crate::spacing::{LocalSpacing, distinct};
use nalgebra::Vector3;
use nurbs_core::construct::Side;
use nurbs_core::{BsplineSurface, ParametricCurve};

/// Chords by which the length of a side is measured, and most samples along it.
const CHORDS: usize = 256;
const MOST: usize = 100_000;

/// Points, and samples along the sides that are held, half as far apart as the points.
pub(super) fn with_sides(
    points: &[Vector3<f64>],
    surface: &BsplineSurface,
    held: [usize; 4],
) -> Result<Vec<Vector3<f64>>, Error> {
    let mut out = points.to_vec();
    let apart = 0.5 * LocalSpacing::new(&distinct(points))?.typical();
    for side in Side::ALL.into_iter().filter(|side| held[side.index()] > 0) {
        let knots = [surface.knots_u(), surface.knots_v()][side.constant().index()];
        if knots.is_periodic() {
            continue;
        }
        let domain = knots.domain();
        let curve =
            surface.iso_curve(side.constant(), if side.is_end() { domain.end() } else { domain.start() })?;
        let at = |k: usize, count: usize| curve.point(curve.domain().lerp(k as f64 / count as f64));
        let length: f64 = (0..CHORDS).map(|k| (at(k + 1, CHORDS) - at(k, CHORDS)).norm()).sum();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive number of samples"
        )]
        let count = (length / apart).ceil().clamp(1.0, MOST as f64) as usize;
        out.extend((0..=count).map(|k| at(k, count)));
    }
    Ok(out)
}
