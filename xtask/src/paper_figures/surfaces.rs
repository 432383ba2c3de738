//! Figs. 7 to 9 of \[MPK\]: a cloud, its base surface and the surfaces fitted with the parameters that this gives.

use super::shading::{DARK, GREY, SAND, SIZE, mesh_of};
use cloud_param::{
    FitOptions, ParameteriseOptions, finish_fit, finish_options, fit_parameters, parameterise,
};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::picture::{MeshScene, Paint, Sheet, View};
use nalgebra::{Point3, Rotation3, Vector3};
use nurbs_core::BsplineSurface;
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
    // The axis upwards.
    let axis = found.report.axis.direction;
    let upright = Rotation3::rotation_between(&axis, &Vector3::z())
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let turned = |p: &Vector3<f64>| Point3::from(upright * p);
    let room: Vec<Point3<f64>> = points.iter().map(turned).collect();
    let view = View { turn: -0.6, height: 0.35 };
    let nothing = TriangleMesh::new(Vec::new(), Vec::new())?;
    let mut cloud = MeshScene { view, frame: Some(&room), ..MeshScene::new(&nothing, Paint::Plain(GREY)) };
    cloud.points = room.iter().step_by(2).map(|p| (*p, DARK, 0.7)).collect();
    let draw = |surface: &BsplineSurface| -> Result<_, Box<dyn Error>> {
        let (mesh, normals) = mesh_of(surface, [240, 480])?;
        let vertices = mesh.vertices().iter().map(|p| turned(&p.coords)).collect();
        let mesh = TriangleMesh::new(vertices, mesh.triangles().to_vec())?;
        let normals: Vec<Vector3<f64>> = normals.iter().map(|n| upright * n).collect();
        let scene = MeshScene::new(&mesh, Paint::Plain(SAND));
        Ok(MeshScene { normals: Some(&normals), view, frame: Some(&room), ..scene }.draw(SIZE))
    };
    let [grid_u, grid_v] = found.report.grid;
    let [n_u, n_v] = control_points;
    let sheet = Sheet::new()
        .with("cloud", cloud.draw(SIZE))
        .with("base", draw(&found.base)?)
        .with("least squares", draw(&least_squares)?)
        .with("finished", draw(&finished.surface)?)
        .with_caption(&format!(
            "{title}, {:.2} apart. Root mean square distances: base of {grid_u} × {grid_v} {:.3}, least squares of {n_u} × {n_v} {rms:.3}, finished {:.3}.",
            found.report.spacing, found.report.rms, finished.rms
        ));
    Ok(sheet.to_svg()?)
}
