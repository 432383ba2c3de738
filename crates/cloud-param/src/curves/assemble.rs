//! One polygon out of the height fields of all views.

use super::view_fields::{Sample, ViewField};
use nalgebra::Vector2;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Distance from the cloud, in pitches, beyond which a sample of a height field means nothing.
const FAR: f64 = 1.5;
/// Gap between neighbouring height fields, in pitches, up to which they count as meeting.
const GAP: f64 = 3.0;
/// Weight of the squared angle off the bisector of two views against the squared gap in pitches.
const ANGLE_WEIGHT: f64 = 3.0;
/// Most samples of a layer of a height field.
const MOST: usize = 240;

/// The polygon of a layer, anticlockwise; `None` if some view is cut off from its neighbours.
///
/// Neighbours are joined at the pair of samples that is closest, among pairs about as close the one where both are seen at
/// the same slant ([MPK, sec. 3.3]).
pub(super) fn polygon(
    height: f64,
    fields: &[ViewField],
    distance: &(dyn Fn(&Vector2<f64>) -> f64 + Sync),
    spacing: f64,
) -> Option<Vec<Vector2<f64>>> {
    let width = fields.first()?.field().domain()[0].length();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let count = (2.0 * width / spacing).clamp(40.0, MOST as f64) as usize;
    let curves: Vec<Vec<Option<Sample>>> = fields
        .iter()
        .map(|field| {
            let near = |s: Sample| (distance(&s.point) <= FAR * spacing).then_some(s);
            field.samples(height, count).into_iter().map(near).collect()
        })
        .collect();
    let n = fields.len();
    let half = TAU / n as f64 / 2.0;
    // ends[i]: where view i goes over into the next, and where the next begins.
    let ends: Vec<(usize, usize)> = (0..n)
        .map(|i| {
            let bisector = fields[i].angle() + FRAC_PI_2 + half;
            meeting(&curves[i], &curves[(i + 1) % n], bisector, spacing)
        })
        .collect::<Option<_>>()?;
    let mut polygon = Vec::new();
    for (i, curve) in curves.iter().enumerate() {
        let (first, last) = (ends[(i + n - 1) % n].1, ends[i].0);
        if first < last {
            polygon.extend(curve[first..=last].iter().flatten().map(|s| s.point));
        } else {
            // Nothing of this view is left but where its neighbours meet.
            polygon.extend(curve[first].or(curve[last]).map(|s| s.point));
        }
    }
    (polygon.len() >= 8).then_some(polygon)
}

fn meeting(
    one: &[Option<Sample>],
    next: &[Option<Sample>],
    bisector: f64,
    spacing: f64,
) -> Option<(usize, usize)> {
    let off = |s: &Sample| {
        let angle = (s.normal - bisector).rem_euclid(TAU);
        angle.min(TAU - angle).powi(2)
    };
    let mut best: Option<(f64, (usize, usize))> = None;
    for (i, a) in one.iter().enumerate().filter_map(|(i, s)| Some((i, s.as_ref()?))) {
        let cost_a = ANGLE_WEIGHT * off(a);
        if best.is_some_and(|(cost, _)| cost_a >= cost) {
            continue;
        }
        for (j, b) in next.iter().enumerate().filter_map(|(j, s)| Some((j, s.as_ref()?))) {
            let gap = (a.point - b.point).norm_squared() / (spacing * spacing);
            if gap > GAP * GAP {
                continue;
            }
            let cost = gap + cost_a + ANGLE_WEIGHT * off(b);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, (i, j)));
            }
        }
    }
    best.map(|(_, pair)| pair)
}
