//! The polygon of a layer out of the distances from its middle.

use crate::section::Section;
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// Points per direction that are aimed at.
const PER_DIRECTION: f64 = 5.0;
/// Share of the directions that may be empty.
const MOST_EMPTY: f64 = 0.35;

/// The medians of the distances from the middle of the points' box, by direction; gaps are bridged linearly. Thin sections are
/// straightened for that, by the mean line of all points `around` the layer.
pub(super) fn polygon(
    slice: &[Vector2<f64>],
    around: &[Vector2<f64>],
    spacing: f64,
) -> Option<Vec<Vector2<f64>>> {
    let section = Section::of(around);
    let first = slice.first()?;
    let (low, high) = slice.iter().fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
    let middle = (low + high) / 2.0;
    let straight = |p: &Vector2<f64>| section.as_ref().map_or(p - middle, |s| s.straightened(p));
    let bent = |q: Vector2<f64>| section.as_ref().map_or(middle + q, |s| s.bent(&q));
    let length = TAU * 0.5 * (high - low).mean();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let bins = (slice.len() as f64 / PER_DIRECTION)
        .min(length / spacing.max(f64::MIN_POSITIVE))
        .clamp(8.0, 180.0) as usize;
    let mut distances = vec![Vec::new(); bins];
    for p in slice {
        let away = straight(p);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let bin = ((away.y.atan2(away.x).rem_euclid(TAU) / TAU * bins as f64) as usize).min(bins - 1);
        distances[bin].push(away.norm());
    }
    let medians: Vec<Option<f64>> = distances
        .iter_mut()
        .map(|d| {
            d.sort_by(f64::total_cmp);
            d.get(d.len() / 2).copied()
        })
        .collect();
    let known: Vec<usize> = (0..bins).filter(|&i| medians[i].is_some()).collect();
    if (known.len() as f64) < (1.0 - MOST_EMPTY) * bins as f64 {
        return None;
    }
    let at = |i: usize| -> f64 {
        let back = (0..bins).find(|k| medians[(i + bins - k) % bins].is_some()).unwrap_or(0);
        let on = (0..bins).find(|k| medians[(i + k) % bins].is_some()).unwrap_or(0);
        let (a, b) =
            (medians[(i + bins - back) % bins].unwrap_or(0.0), medians[(i + on) % bins].unwrap_or(0.0));
        if back + on == 0 { a } else { a + (b - a) * back as f64 / (back + on) as f64 }
    };
    let polygon = (0..bins).map(|i| {
        let (sin, cos) = (TAU * (i as f64 + 0.5) / bins as f64).sin_cos();
        bent(Vector2::new(cos, sin) * at(i))
    });
    Some(polygon.collect())
}
