//! Figs. 10 and 11 of \[MPK\]: one directed projection with each of the weights, from a rough start.

use super::drawing::{BLACK, Drawing, GREY, RED, bounds};
use cloud_param::{
    AxisChoice, BaseCurveOptions, ClosedCurve, CurveOptions, DirectedOptions, DirectedWeight, LayerCurve,
    Neighbourhood, Turntable, base_curves, estimate_axis, project_curves,
};
use nalgebra::{Vector2, Vector3};
use std::error::Error;

/// Samples by which the start follows the curve, and samples of it.
const ROUGH: usize = 9;
const SAMPLES: usize = 70;
const LAYERS: usize = 24;
const SHOWN: usize = 15;

/// Samples before and after one projection.
pub(super) fn one_projection(points: &[Vector3<f64>]) -> Result<String, Box<dyn Error>> {
    let cloud = Neighbourhood::new(points)?;
    let table = Turntable::new(points, &estimate_axis(points, AxisChoice::Automatic)?.direction)?;
    let options =
        BaseCurveOptions { layers: Some(LAYERS), samples: Some(SAMPLES), ..BaseCurveOptions::default() };
    let layer = base_curves(&table, &cloud, &options)?.curves.swap_remove(SHOWN);
    let rough = ClosedCurve::through(&layer.curve.resampled(ROUGH, 0.0)).ok_or("a layer is a point")?;
    let start = LayerCurve { curve: rough, ..layer };
    let near: Vec<Vector2<f64>> = points
        .iter()
        .map(|p| table.frame.to_local(p))
        .filter(|p| (p.z - start.height).abs() < 1.5 * cloud.pitch())
        .map(|p| p.xy())
        .collect();
    let [low, high] = bounds(&near);
    let room = (high - low) * 0.06;
    let mut drawing = Drawing::new(
        360.0,
        "Samples of a rough curve (black), the curve after one directed projection (red), and the points near the layer (grey). Rms: samples to their nearest points.",
    );
    for (label, weight) in [
        ("(a) eq. (15)", DirectedWeight::Near),
        ("(b) eq. (16)", DirectedWeight::Axis),
        ("(c) eq. (19)", DirectedWeight::NearAxis),
    ] {
        let options = CurveOptions {
            directed: DirectedOptions::default().with_weight(weight),
            max_iterations: 1,
            threshold: 0.0,
            samples: Some(SAMPLES),
        };
        let mut curves = [start.clone()];
        let report = project_curves(&table.frame, &cloud, &mut curves, &options)?;
        let title = format!("{label}: rms {:.2} → {:.2}", report.history[0].rms, report.history[1].rms);
        let mut panel = drawing.panel(&title, low - room, high + room);
        panel.points(&near, 1.2, GREY);
        panel.points(&start.curve.resampled(SAMPLES, 0.0), 1.6, BLACK);
        panel.line(&curves[0].curve.polygon(6), true, 1.0, RED);
        panel.points(&curves[0].curve.resampled(SAMPLES, 0.0), 1.8, RED);
    }
    Ok(drawing.finish())
}
