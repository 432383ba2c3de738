//! Figs. 12 and 13 of \[P05\]: a ruled surface, and layers of ruled surfaces.

use super::shading::{DARK, GREY, SAND, SIZE, lines_of, mesh_of};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::picture::{MeshScene, Paint, Sheet, View};
use nalgebra::{Point3, Vector3};
use sdm_fit::BaseShape;
use sdm_fit::ruled::{RuledCloudOptions, fit_ruled_cloud, offset_points};
use std::error::Error;

/// A scan, the ruled surface of 2 × 10 control points, and both.
pub(super) fn one() -> Result<String, Box<dyn Error>> {
    let (model, normals) = saddle()?;
    let points: Vec<Vector3<f64>> = model.vertices().iter().map(|p| p.coords).collect();
    let options =
        RuledCloudOptions { base: BaseShape::Plane, controls: [10, 2], ..RuledCloudOptions::default() };
    let fitted = fit_ruled_cloud(&points, None, &options)?;
    let surface = &fitted.fit.surface;
    let rms = fitted.report().fit.rms;
    let (mesh, own) = mesh_of(surface, [120, 24])?;
    let view = View { turn: -0.7, height: 0.65 };
    let room = model.vertices();
    let scene =
        |mesh, paint, normals| MeshScene { normals, view, frame: Some(room), ..MeshScene::new(mesh, paint) };
    let shown = scene(&model, Paint::Plain(GREY), Some(normals.as_slice()));
    let mut ruled = scene(&mesh, Paint::Plain(SAND), Some(own.as_slice()));
    ruled.curves = lines_of(surface, [2, 24], DARK);
    let mut both = shown.clone();
    both.curves = lines_of(surface, [2, 24], [0.72, 0.33, 0.05]);
    let sheet = Sheet::new()
        .with("model, a mesh", shown.draw(SIZE))
        .with("ruled surface, 2 × 10 control points", ruled.draw(SIZE))
        .with("its rulings on the model", both.draw(SIZE))
        .with_caption(&format!(
            "A ruled B-spline surface of degrees 1 and 3 fitted to a mesh by squared distance minimisation; root mean square distance {rms:.1e}."
        ));
    Ok(sheet.to_svg()?)
}

/// Layers of ruled surfaces of a lobed vase, and of an offset of it.
pub(super) fn layers(points: &[Vector3<f64>]) -> Result<String, Box<dyn Error>> {
    let options = RuledCloudOptions {
        base: BaseShape::Cylinder,
        controls: [25, 7],
        level: true,
        ..RuledCloudOptions::default()
    };
    let view = View { turn: 0.5, height: 0.35 };
    let fitted = fit_ruled_cloud(points, None, &options)?;
    let normals: Vec<Vector3<f64>> = points.iter().map(outwards).collect();
    let away = offset_points(points, &normals, 8.0)?;
    let outer = fit_ruled_cloud(&away.points, None, &options)?;
    let corners: Vec<Point3<f64>> = away.points.iter().map(|p| Point3::from(*p)).collect();
    let room = Some(corners.as_slice());
    let draw = |surface: &nurbs_core::BsplineSurface| -> Result<_, Box<dyn Error>> {
        let (mesh, normals) = mesh_of(surface, [240, 120])?;
        let scene = MeshScene::new(&mesh, Paint::Plain(SAND));
        let mut scene = MeshScene { normals: Some(&normals), view, frame: room, ..scene };
        scene.curves = lines_of(surface, [7, 50], DARK);
        Ok(scene.draw(SIZE))
    };
    let dots: Vec<_> = points.iter().step_by(2).map(|p| (Point3::from(*p), DARK, 0.7)).collect();
    let nothing = TriangleMesh::new(Vec::new(), Vec::new())?;
    let mut cloud = MeshScene { view, frame: room, ..MeshScene::new(&nothing, Paint::Plain(GREY)) };
    cloud.points = dots;
    let sheet = Sheet::new()
        .with("cloud of 16,000 points", cloud.draw(SIZE))
        .with(&format!("layers: rms {:.2}", fitted.report().fit.rms), draw(&fitted.fit.surface)?)
        .with(&format!("layers of the offset by 8: rms {:.2}", outer.report().fit.rms), draw(&outer.fit.surface)?)
        .with_caption(
            "Six layers of ruled surfaces between parallel planes, 7 × 25 control points: the layers of a vase for rapid prototyping, and of an offset of it.",
        );
    Ok(sheet.to_svg()?)
}

/// The normal of the vase at a point, by its equation `r = 60 + 12 sin 5h + 9 cos(5a + 2h)`, `h = z / 240`.
fn outwards(p: &Vector3<f64>) -> Vector3<f64> {
    let (a, h, r) = (p.y.atan2(p.x), p.z / 240.0, p.xy().norm());
    let lobes = 9.0 * (5.0 * a + 2.0 * h).sin();
    let (by_angle, by_height) = (-5.0 * lobes, (60.0 * (5.0 * h).cos() - 2.0 * lobes) / 240.0);
    let (out, along) = (Vector3::new(a.cos(), a.sin(), 0.0), Vector3::new(-a.sin(), a.cos(), 0.0));
    (out - along * (by_angle / r) - Vector3::z() * by_height).normalize()
}

/// A twisted wall with a shallow bump, as a scan would show it.
fn saddle() -> Result<(TriangleMesh, Vec<Vector3<f64>>), Box<dyn Error>> {
    let (m, n) = (90, 45);
    let surface = |i: usize, j: usize| {
        let (u, v) = (i as f64 / m as f64, j as f64 / n as f64);
        let bow = 0.35 * (std::f64::consts::PI * u).sin()
            + 0.12 * (2.0 * std::f64::consts::TAU * u).sin() * (1.0 - v);
        let bump = 0.03 * (-((u - 0.62) / 0.12).powi(2) - ((v - 0.5) / 0.25).powi(2)).exp();
        Vector3::new(2.4 * u - 1.2, 0.6 * (u - 0.5) * (v - 0.5) + bow + bump, 1.1 * v - 0.55)
    };
    let points: Vec<Point3<f64>> =
        (0..=m).flat_map(|i| (0..=n).map(move |j| Point3::from(surface(i, j)))).collect();
    let mut triangles = Vec::new();
    for i in 0..m {
        for j in 0..n {
            let corner = u32::try_from(i * (n + 1) + j)?;
            let next = corner + u32::try_from(n + 1)?;
            triangles.extend([[corner, next, next + 1], [corner, next + 1, corner + 1]]);
        }
    }
    let mesh = TriangleMesh::new(points, triangles)?;
    let mut normals = vec![Vector3::zeros(); mesh.vertices().len()];
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|k| mesh.vertices()[k as usize]);
        let normal = (b - a).cross(&(c - a));
        for k in *t {
            normals[k as usize] += normal;
        }
    }
    let normals =
        normals.iter().map(|n: &Vector3<f64>| n.try_normalize(0.0).unwrap_or_else(Vector3::z)).collect();
    Ok((mesh, normals))
}
