//! A drawing of how a curve came about.

use crate::commands::demo::job::svg::Svg;
use industrial_geometry::nurbs::nalgebra::SVector;
use industrial_geometry::nurbs::{BsplineCurve, ParametricCurve};

/// Width of the drawing, and its margin.
const WIDTH: f64 = 900.0;
const MARGIN: f64 = 20.0;
/// Points of a curve, data points and curves that are drawn at most.
const SAMPLES: usize = 400;
const DATA: usize = 5000;
const CURVES: usize = 40;

/// The data, the curve in the course of the iteration from light to dark, and the results.
pub(crate) fn drawing<const D: usize>(
    points: &[SVector<f64, D>],
    evolution: &[BsplineCurve<D>],
    results: &[&BsplineCurve<D>],
) -> String {
    let sample = |curve: &BsplineCurve<D>| -> Vec<[f64; 2]> {
        let at = |k: usize| curve.point(curve.domain().lerp(k as f64 / SAMPLES as f64));
        (0..=SAMPLES).map(at).map(|p| [p[0], p[1]]).collect()
    };
    let last: Vec<_> = results.iter().map(|curve| sample(curve)).collect();
    let finite = points.iter().map(|p| [p[0], p[1]]).filter(|p| p.iter().all(|c| c.is_finite()));
    let data: Vec<[f64; 2]> = finite.collect();
    let data: Vec<_> = data.iter().step_by(data.len().div_ceil(DATA).max(1)).copied().collect();
    let curves: Vec<_> =
        evolution.iter().step_by(evolution.len().div_ceil(CURVES).max(1)).map(sample).collect();
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in data.iter().chain(last.iter().flatten()).chain(curves.iter().flatten()) {
        for c in 0..2 {
            (low[c], high[c]) = (low[c].min(p[c]), high[c].max(p[c]));
        }
    }
    let size = (high[0] - low[0]).max(high[1] - low[1]).max(f64::MIN_POSITIVE);
    let scale = (WIDTH - 2.0 * MARGIN) / size;
    let place =
        |p: &[f64; 2]| -> [f64; 2] { [MARGIN + (p[0] - low[0]) * scale, MARGIN + (high[1] - p[1]) * scale] };
    let height = 2.0 * MARGIN + (high[1] - low[1]) * scale;
    let mut svg = Svg::new(WIDTH, height, "Evolution of the fitted curve");
    let placed = |points: &[[f64; 2]]| points.iter().map(place).collect::<Vec<_>>();
    svg.dots(&placed(&data), 3.0, [0x99; 3]);
    let count = curves.len().max(2) - 1;
    for (k, curve) in curves.iter().enumerate() {
        let share = k as f64 / count as f64;
        // From light to dark blue.
        let colour = format!("hsl(215, 70%, {:.0}%)", 85.0 - 40.0 * share);
        svg.polyline(&placed(curve), &colour, 0.8);
    }
    for curve in &last {
        svg.polyline(&placed(curve), "#c00000", 2.0);
    }
    svg.finish()
}
