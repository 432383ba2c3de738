//! The nominal surfaces.

use crate::fit::Placement;
use industrial_geometry::nurbs::nalgebra::Vector3;
use industrial_geometry::nurbs::{BsplineSurface, Cylinder, Error, Frame, Interval, KnotVector};
use std::f64::consts::TAU;

/// Nominal (major) diameter in mm.
pub(crate) const DIAMETER: f64 = 12.0;
/// Pitch in mm.
pub(crate) const PITCH: f64 = 1.75;

/// Control points per turn of the helix: at 32 the spline stays within 1e-4 mm of the helix.
const PER_TURN: usize = 32;

/// The corners of the profile over one pitch, from the middle of a root to the middle of the next: position relative to the crest in
/// pitches, radius.
///
/// ISO 68-1: crest P/8 wide, root P/4 wide, depth 5/8 H with H = √3/2 P, flank angle 60°.
pub(crate) const PROFILE: [(f64, fn() -> f64); 6] = [
    (-1.0 / 2.0, root_radius),
    (-3.0 / 8.0, root_radius),
    (-1.0 / 16.0, crest_radius),
    (1.0 / 16.0, crest_radius),
    (3.0 / 8.0, root_radius),
    (1.0 / 2.0, root_radius),
];

/// Radius of the crests.
pub(crate) fn crest_radius() -> f64 {
    0.5 * DIAMETER
}

/// Radius of the roots.
pub(crate) fn root_radius() -> f64 {
    0.5 * DIAMETER - 0.625 * 0.75f64.sqrt() * PITCH
}

/// Radius of the profile at a position between −½ and ½ pitch from the crest.
pub(crate) fn radius(position: f64) -> f64 {
    let pair = PROFILE.windows(2).find(|pair| position <= pair[1].0).unwrap_or(&PROFILE[4..]);
    let ((x0, r0), (x1, r1)) = (pair[0], pair[1]);
    let part = (position - x0) / (x1 - x0);
    r0() * (1.0 - part) + r1() * part
}

/// The thread between two heights, as the profile of one pitch carried along the helix: `u` is the angle in turns, `v` runs along the
/// profile with a crease at each of its corners. The normal points outwards.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number of spans")]
pub(crate) fn thread(placement: &Placement, heights: [f64; 2]) -> Result<BsplineSurface, Error> {
    let turn = PITCH * placement.hand;
    // The profile reaches half a pitch to both sides of the helix of its crest.
    let limits = [heights[0] + 0.5 * PITCH, heights[1] - 0.5 * PITCH]
        .map(|height| (height - placement.phase) / turn * PER_TURN as f64);
    let (first, last) = (limits[0].min(limits[1]).ceil(), limits[0].max(limits[1]).floor());
    let spans = (last - first) as usize;
    let mut rows = Vec::new();
    // A uniform cubic B-spline through a circle at its knots: c = (p₋₁ + 4 p₀ + p₁) / 6.
    let step = TAU / PER_TURN as f64;
    let inflate = 6.0 / (4.0 + 2.0 * step.cos());
    for index in 0..spans + 3 {
        let at = first + index as f64 - 1.0;
        let (angle, height) = (at * step, placement.phase + turn * at / PER_TURN as f64);
        let point = |&(x, r): &(f64, fn() -> f64)| placement.point(r() * inflate, angle, height + x * PITCH);
        rows.push(PROFILE.iter().map(point).collect::<Vec<_>>());
    }
    let knots_v = KnotVector::new(1, vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0])?;
    BsplineSurface::new(clamp(&mut rows, spans)?, knots_v, rows.concat(), None)
}

/// Turns the ends of a uniform cubic net into clamped ones, without changing the surface (knots inserted at the ends).
fn clamp(rows: &mut [Vec<Vector3<f64>>], spans: usize) -> Result<KnotVector, Error> {
    for column in 0..rows[0].len() {
        let mut end = |outer: usize, middle: usize, inner: usize| {
            let [a, b, c] = [outer, middle, inner].map(|row| rows[row][column]);
            rows[outer][column] = (a + b * 4.0 + c) / 6.0;
            rows[middle][column] = (b * 2.0 + c) / 3.0;
        };
        end(0, 1, 2);
        end(spans + 2, spans + 1, spans);
    }
    let mut knots = vec![0.0; 3];
    knots.extend((0..=spans).map(|knot| knot as f64 / PER_TURN as f64));
    knots.extend([spans as f64 / PER_TURN as f64; 3]);
    KnotVector::new(3, knots)
}

/// The shank between two heights: an exact rational cylinder of nominal diameter.
pub(crate) fn shank(placement: &Placement, heights: [f64; 2]) -> Result<BsplineSurface, Error> {
    let frame = Frame::new(placement.origin, placement.axis, placement.e1)?;
    Cylinder::new(frame, crest_radius(), Interval::new(heights[0], heights[1])?)?.to_nurbs()
}
