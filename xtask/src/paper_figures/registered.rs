//! Fig. 14 of \[P05\]: the registration of a cloud to a model.

use super::shading::{GREY, RED, SIZE, mesh_of};
use distance_field::SurfaceField;
use industrial_geometry::picture::{MeshScene, Paint, Sheet, View};
use nalgebra::{Point3, Vector3};
use nurbs_core::BsplineSurface;
use sdm_register::{Pose, RegisterOptions, Source, register};
use std::error::Error;

/// A cloud with noise in its first and in its final position.
pub(super) fn cloud() -> Result<String, Box<dyn Error>> {
    let folder = crate::workspace::root().join("fixtures/register-cases");
    let surface: BsplineSurface = serde_json::from_slice(&std::fs::read(folder.join("cad.json"))?)?;
    let content =
        pc_io::read(folder.join("cad_noise1e-3/source.ply"), &pc_io::ReadOptions::default())?.content;
    let pc_io::Content::Cloud(cloud) = content else { return Err("the scan is no cloud".into()) };
    let points: Vec<Vector3<f64>> = cloud.positions().iter().map(|p| p.coords).collect();
    let starts: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("cad_noise1e-3/inits.json"))?)?;
    // The first of the starts that are 20 degrees off.
    let off = |start: &&serde_json::Value| start["angle_deg"].as_f64() == Some(20.0);
    let start = starts.as_array().into_iter().flatten().find(off).ok_or("there is no such start")?;
    let entry = |i: usize, j: usize| start["T"][i][j].as_f64().unwrap_or(f64::NAN);
    let linear = nalgebra::Matrix3::from_fn(entry);
    let pose = Pose::<3>::from_linear(&linear, &Vector3::from_fn(|i, _| entry(i, 3)))?;
    let field = SurfaceField::new(&surface)?;
    let found = register(&field, &Source::new(&points), &pose, &RegisterOptions::default())?;
    let (mesh, normals) = mesh_of(&surface, [160, 100])?;
    let view = View { turn: -0.5, height: 0.6 };
    let moved = |pose: &Pose<3>| -> Vec<(Point3<f64>, [f32; 3], f64)> {
        points.iter().step_by(2).map(|p| (Point3::from(pose.apply(p)), RED, 1.5)).collect()
    };
    let (first, last) = (moved(&pose), moved(&found.pose));
    let room: Vec<Point3<f64>> = mesh.vertices().iter().copied().chain(first.iter().map(|p| p.0)).collect();
    let frame = Some(room.as_slice());
    let draw = |points| {
        let scene = MeshScene::new(&mesh, Paint::Plain(GREY));
        MeshScene { normals: Some(&normals), view, frame, points, ..scene }.draw(SIZE + 120)
    };
    let sheet = Sheet::new()
        .with(&format!("start: rms {:.3}", found.initial_rms), draw(first))
        .with(&format!("after {} iterations: rms {:.4}", found.iterations, found.rms), draw(last))
        .with_caption("Registration of a cloud with noise to a surface by squared distance minimisation.");
    Ok(sheet.to_svg()?)
}
