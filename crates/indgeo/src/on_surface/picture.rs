//! Pictures of meshes: smooth shading, isolines or regions, curves, and a scale.

use crate::error::Error;
use crate::files;
use crate::report::{Output, Report};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::picture::{Curve, MeshScene, Paint, Sheet};
use std::path::Path;

/// Pixels of the longer side.
const SIZE: usize = 900;
/// Isolines.
const LINES: usize = 16;
/// Colour and width of curves.
const CURVE: [f32; 3] = [0.85, 0.11, 0.38];
const WIDTH: f64 = 4.0;

/// Makes sure that the picture can have its format.
pub(crate) fn check(path: &Path) -> Result<(), Error> {
    if matches!(files::extension(path).as_str(), "svg" | "png") || files::is_stream(path) {
        return Ok(());
    }
    Err(Error::content(path, "pictures are SVG or PNG", "choose a name that ends in .svg or .png"))
}

/// What is shown on a mesh, one number per vertex.
pub(crate) enum Shown<'a> {
    /// Distances, with isolines and a scale.
    Values(&'a [f64]),
    /// Regions; negative labels are none.
    Labels(&'a [i64]),
}

/// Draws a mesh and writes the picture.
pub(crate) fn write(
    path: &Path,
    mesh: &TriangleMesh,
    shown: &Shown<'_>,
    curves: &[&[[f64; 3]]],
    content: &str,
    report: &mut Report,
) -> Result<(), Error> {
    let (paint, bar) = match shown {
        Shown::Labels(labels) => (Paint::Labels(labels), None),
        Shown::Values(values) => {
            let finite = values.iter().copied().filter(|value| value.is_finite());
            let (min, max) =
                finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            let range = if max > min { [min, max] } else { [min.min(0.0), min.min(0.0) + 1.0] };
            (Paint::Values { values, range, lines: LINES }, Some(range))
        }
    };
    let normals: Option<Vec<Vector3<f64>>> = mesh.attributes().normals().map(<[_]>::to_vec);
    let mut scene = MeshScene::new(mesh, paint);
    scene.normals = normals.as_deref();
    scene.curves = curves
        .iter()
        .map(|curve| Curve {
            points: curve.iter().map(|point| Point3::from(*point)).collect(),
            colour: CURVE,
            width: WIDTH,
        })
        .collect();
    let sheet = Sheet::new().with("", scene.draw(SIZE));
    let sheet = match bar {
        Some(range) => sheet.with_bar(range),
        None => sheet,
    };
    write_sheet(path, &sheet, content, report)
}

/// Writes a picture as its name says; SVG to a stream.
pub(crate) fn write_sheet(
    path: &Path,
    sheet: &Sheet,
    content: &str,
    report: &mut Report,
) -> Result<(), Error> {
    let is_png = files::extension(path) == "png";
    let made = if is_png { sheet.to_png() } else { sheet.to_svg().map(String::into_bytes) };
    let made = made.map_err(|what| Error::content(path, what, "leave out --picture"))?;
    let bytes = files::write(path, |out| out.write_all(&made))?;
    report.add_output(Output { path: path.to_path_buf(), bytes, content: content.to_owned() });
    Ok(())
}
