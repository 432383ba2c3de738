//! Figs. 7 to 9 of \[MPK\]: a cloud, its base surface and the surfaces fitted with the parameters that this gives.

use super::drawing::{BLACK, Camera, Drawing, bounds};
use cloud_param::{
    FitOptions, ParameteriseOptions, finish_fit, finish_options, fit_parameters, parameterise,
};
use nalgebra::{Vector2, Vector3};
use std::error::Error;

/// Cloud, base surface, least squares and finish side by side.
pub(super) fn steps(
    title: &str,
    points: &[Vector3<f64>],
    control_points: [usize; 2],
) -> Result<String, Box<dyn Error>> {
    let found = parameterise(points, &ParameteriseOptions::default())?;
    let options = FitOptions { control_points, ..FitOptions::default() };
    let fit = fit_parameters(points, &found.base, &found.feet, &found.counts, &options)?;
    let (least_squares, rms) = (fit.surface.clone(), fit.rms);
    let (finished, _) = finish_fit(points, &found.counts, fit, &finish_options(points.len()))?;
    let axis = found.report.axis.direction;
    let camera = Camera::new(&axis, &Vector3::ith(axis.iamin(), 1.0).cross(&axis).normalize());
    let cloud: Vec<Vector2<f64>> = points.iter().map(|p| camera.seen(p).xy()).collect();
    let [low, high] = bounds(&cloud);
    let [grid_u, grid_v] = found.report.grid;
    let [n_u, n_v] = control_points;
    // Fine along the axis where the net is.
    let cells = [if n_v > 40 { 36 } else { 56 }, 2 * n_v];
    let mut drawing = Drawing::new(
        380.0,
        &format!(
            "{title}; points are {:.2} apart. Root mean square orthogonal distances; the finish is squared distance minimisation of the same control points.",
            found.report.spacing
        ),
    );
    drawing.panel("(a) cloud", low, high).points(cloud.iter().step_by(2), 0.5, BLACK);
    for (label, surface, rms) in [
        (format!("(b) base {grid_u} × {grid_v}"), &found.base, found.report.rms),
        (format!("(c) least squares {n_u} × {n_v}"), &least_squares, rms),
        (format!("(d) finished {n_u} × {n_v}"), &finished.surface, finished.rms),
    ] {
        drawing.panel(&format!("{label}: rms {rms:.3}"), low, high).surface(surface, &camera, cells);
    }
    Ok(drawing.finish())
}
