//! Figs. 3 to 6 of \[MPK\]: the turntable, what its views show, and the curves of a layer.

use super::drawing::{BLACK, BLUE, Drawing, GREY, RED, bounds};
use cloud_param::{
    AxisChoice, BaseCurveOptions, CurveOptions, Neighbourhood, Sharpness, Turntable, ViewField, base_curves,
    estimate_axis, project_curves,
};
use nalgebra::{Vector2, Vector3};
use std::error::Error;
use std::f64::consts::TAU;

const VIEWS: usize = 4;
const COLOURS: [&str; VIEWS] = [RED, BLUE, "#2b8a3e", "#c27c0e"];
/// Layers, and the one that is shown.
const LAYERS: usize = 24;
const SHOWN: usize = 15;
/// Share of the cloud that is drawn.
const STEP: usize = 4;

/// The bounding circle with the directions of view, and the visible points of each view.
pub(super) fn views(points: &[Vector3<f64>]) -> Result<String, Box<dyn Error>> {
    let table = Turntable::new(points, &estimate_axis(points, AxisChoice::Automatic)?.direction)?;
    let views = table.views(points, VIEWS, Sharpness::default())?;
    let mut drawing = Drawing::new(
        360.0,
        "The cloud on a turntable, seen along its axis within its bounding circle, and from four sides: what is visible (red) and what is hidden (grey).",
    );
    let above: Vec<Vector2<f64>> =
        points.iter().step_by(STEP).map(|p| table.frame.to_local(p).xy()).collect();
    let reach = Vector2::repeat(1.25 * table.radius);
    let mut panel = drawing.panel("along the axis", -reach, reach);
    panel.points(&above, 0.7, GREY);
    let circle: Vec<Vector2<f64>> = (0..120)
        .map(|k| TAU * f64::from(k) / 120.0)
        .map(|a| Vector2::new(a.cos(), a.sin()) * table.radius)
        .collect();
    panel.line(&circle, true, 1.2, BLACK);
    for view in &views {
        // The eye is where the second axis of the turned table points to.
        let eye = Vector2::new(-view.angle.sin(), view.angle.cos()) * table.radius;
        panel.line(&[eye * 1.12, eye * 0.85], false, 2.0, RED);
        panel.label(&(eye * 1.18), &format!("{:.0}°", view.angle.to_degrees()), RED);
    }
    for view in &views {
        let turned = |p: &Vector3<f64>| table.turned(p, view.angle);
        let parts = [false, true].map(|wanted| -> Vec<Vector2<f64>> {
            let of = points.iter().zip(&view.visible).filter(|&(_, &visible)| visible == wanted);
            of.step_by(STEP).map(|(p, _)| turned(p)).map(|p| Vector2::new(p.x, p.z)).collect()
        });
        let reach = Vector2::new(table.radius, table.heights[1]);
        let title = format!("from {:.0}°", view.angle.to_degrees());
        let mut panel = drawing.panel(&title, Vector2::new(-reach.x, table.heights[0]), reach);
        panel.points(&parts[0], 0.8, GREY);
        panel.points(&parts[1], 1.1, RED);
    }
    Ok(drawing.finish())
}

/// A layer: the height fields of the views, the curve that comes of them, and the curve after projection.
pub(super) fn layers(points: &[Vector3<f64>]) -> Result<String, Box<dyn Error>> {
    let cloud = Neighbourhood::new(points)?;
    let table = Turntable::new(points, &estimate_axis(points, AxisChoice::Automatic)?.direction)?;
    let options =
        BaseCurveOptions { views: Some(VIEWS), layers: Some(LAYERS), ..BaseCurveOptions::default() };
    let mut curves = base_curves(&table, &cloud, &options)?.curves;
    let (height, before) = (curves[SHOWN].height, curves[SHOWN].curve.polygon(6));
    let samples = curves[SHOWN].curve.resampled(curves[SHOWN].curve.points(), 0.0);
    project_curves(&table.frame, &cloud, &mut curves, &CurveOptions::default())?;
    let after = curves[SHOWN].curve.polygon(6);
    let near: Vec<Vector2<f64>> = points
        .iter()
        .map(|p| table.frame.to_local(p))
        .filter(|p| (p.z - height).abs() < 1.5 * cloud.pitch())
        .map(|p| p.xy())
        .collect();
    let [low, high] = bounds(&near);
    let room = (high - low) * 0.12;
    let [low, high] = [low - room, high + room];
    let mut drawing = Drawing::new(
        360.0,
        "One layer across the axis: (a) the height fields of four views cut at this height; (b) the closed curve through what is left of them where they meet; (c) the same drawn to the points; (d) the curves of all layers.",
    );
    let mut panel = drawing.panel("(a) height fields", low, high);
    panel.points(&near, 1.2, GREY);
    for (view, colour) in table.views(points, VIEWS, Sharpness::default())?.iter().zip(COLOURS) {
        let field = ViewField::new(&table, points, view)?;
        let (sin, cos) = view.angle.sin_cos();
        let inside = |p: &Vector2<f64>| (0..2).all(|k| (low[k]..=high[k]).contains(&p[k]));
        let cut: Vec<Vector2<f64>> = (0..=300)
            .map(|k| table.radius * (f64::from(k) / 150.0 - 1.0))
            .map(|x| (x, field.field().value(x, height)))
            .map(|(x, depth)| Vector2::new(x * cos - depth * sin, x * sin + depth * cos))
            .filter(inside)
            .collect();
        panel.line(&cut, false, 1.6, colour);
    }
    let mut panel = drawing.panel("(b) base curve", low, high);
    panel.points(&near, 1.2, GREY);
    panel.line(&before, true, 1.2, BLUE);
    panel.points(&samples, 2.0, BLUE);
    let mut panel = drawing.panel("(c) projected", low, high);
    panel.points(&near, 1.2, GREY);
    panel.line(&after, true, 1.6, RED);
    // All of them, seen from the side and a little from above.
    let slant = |p: &Vector2<f64>, height: f64| Vector2::new(p.x, 0.94 * height + 0.34 * p.y);
    let lines: Vec<Vec<Vector2<f64>>> = curves
        .iter()
        .map(|layer| layer.curve.polygon(4).iter().map(|p| slant(p, layer.height)).collect())
        .collect();
    let [low, high] = bounds(lines.iter().flatten());
    let mut panel = drawing.panel("(d) all layers", low, high);
    for (k, line) in lines.iter().enumerate() {
        panel.line(line, true, 1.0, if k == SHOWN { RED } else { BLUE });
    }
    Ok(drawing.finish())
}
