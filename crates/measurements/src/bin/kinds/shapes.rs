//! The shapes that have no closed form.

use crate::Outcome;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, KnotVector};

/// Example 2 of [HW05].
pub(crate) fn cubic() -> Outcome<BsplineCurve<2>> {
    let points = [[100., 100.], [140., 196.], [200., 240.], [260., 164.], [340., 164.], [400., 240.]];
    let points = points.into_iter().chain([[460., 196.], [500., 100.]]).map(Vector2::from).collect();
    Ok(BsplineCurve::new(KnotVector::uniform_clamped(3, 8)?, points, None)?)
}

pub(crate) fn helix() -> Outcome<BsplineCurve<3>> {
    let point = |k: i32| {
        let angle = 0.6 * f64::from(k);
        Vector3::new(2.0 * angle.cos(), 2.0 * angle.sin(), 0.15 * f64::from(k))
    };
    Ok(BsplineCurve::new(KnotVector::uniform_clamped(3, 40)?, (0..40).map(point).collect(), None)?)
}

/// A bicubic surface over a grid of control points.
fn grid(n: [i32; 2], point: impl Fn(i32, i32) -> Vector3<f64>) -> Outcome<BsplineSurface> {
    let points = (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| (i, j))).map(|(i, j)| point(i, j)).collect();
    let knots = |n: i32| KnotVector::uniform_clamped(3, usize::try_from(n).unwrap_or(4));
    Ok(BsplineSurface::new(knots(n[0])?, knots(n[1])?, points, None)?)
}

/// A bicubic surface of the size and liveliness of Example 3 of [HW05].
pub(crate) fn paper() -> Outcome<BsplineSurface> {
    let heights = [
        [-22., -22., 8., -22.],
        [8., 38., 126., 8.],
        [8., -146., -60., 8.],
        [-22., -33., 95., 8.],
        [8., 147., 105., 8.],
        [8., 63., 154., 8.],
        [-22., 8., 8., -22.],
    ];
    grid([7, 4], |i, j| {
        let height = heights[usize::try_from(i).unwrap_or(0)][usize::try_from(j).unwrap_or(0)];
        Vector3::new(-240.0 + 80.0 * f64::from(i), -190.0 + 95.0 * f64::from(j), height)
    })
}

pub(crate) fn wavy() -> Outcome<BsplineSurface> {
    grid([50, 50], |i, j| {
        let (x, y) = (f64::from(i), f64::from(j));
        Vector3::new(x, y, 2.0 * (0.5 * x).sin() * (0.4 * y).cos() + 0.7 * (1.1 * x + 0.3 * y).sin())
    })
}

/// A fan over a full turn less a bit, whose edge `v = 0` is one point.
pub(crate) fn fan() -> Outcome<BsplineSurface> {
    grid([8, 8], |i, j| {
        let (angle, radius) = (0.75 * f64::from(i), f64::from(j));
        let height = if j == 0 { 2.0 } else { 2.0 + 0.9 * (1.3 * radius + 0.8 * f64::from(i)).sin() };
        Vector3::new(1.5 * radius * angle.cos(), 1.5 * radius * angle.sin(), height)
    })
}
