//! Writing files of any format.

use std::io::{self, Write};
use std::path::Path;

use mesh_core::{PointCloud, TriangleMesh};

use crate::content::Content;
use crate::error::Location;
use crate::shape::Shape;
use crate::{
    AtomicFile, Error, Format, Model, Place, WriteOptions, WriteReport, json, obj, off, pcd, ply, stl, xyz,
};

/// Writes what was read, in the format of the extension. The file appears whole or not at all.
///
/// What the format cannot hold is told in the report.
///
/// # Errors
/// [`Error::Unsupported`] for an unknown extension, [`Error::CannotHold`] if nothing of the content fits the format,
/// [`Error::Io`] if the file cannot be written.
pub fn write(
    path: impl AsRef<Path>,
    content: &Content,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    match content {
        Content::Cloud(cloud) => write_cloud(path, cloud, options),
        Content::Mesh(mesh) => write_mesh(path, mesh, options),
        Content::Nurbs(model) => write_model(path, model, options),
    }
}

/// Writes a point cloud.
///
/// # Errors
/// As [`write()`].
pub fn write_cloud(
    path: impl AsRef<Path>,
    cloud: &PointCloud,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    write_shape(path.as_ref(), Shape { cloud, triangles: &[] }, options)
}

/// Writes a triangle mesh.
///
/// # Errors
/// As [`write()`].
pub fn write_mesh(
    path: impl AsRef<Path>,
    mesh: &TriangleMesh,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    write_shape(path.as_ref(), Shape { cloud: mesh.cloud(), triangles: mesh.triangles() }, options)
}

/// Writes NURBS curves and surfaces.
///
/// # Errors
/// As [`write()`].
pub fn write_model(
    path: impl AsRef<Path>,
    model: &Model,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    let path = path.as_ref();
    let format = format_of(path, options)?;
    if format != Format::Json {
        let (what, advice) = ("NURBS curves and surfaces", "choose the extension json");
        return Err(Error::CannotHold { path: path.to_path_buf(), format, what, advice });
    }
    let bytes = write_atomically(path, |out| json::write(out, model))?;
    let shapes = model.shapes().len();
    Ok(WriteReport {
        path: path.to_path_buf(),
        format,
        points: 0,
        triangles: 0,
        shapes,
        bytes,
        warnings: Vec::new(),
    })
}

fn write_shape(path: &Path, shape: Shape<'_>, options: &WriteOptions) -> Result<WriteReport, Error> {
    let format = format_of(path, options)?;
    let refuse = |what, advice| Err(Error::CannotHold { path: path.to_path_buf(), format, what, advice });
    if format == Format::Stl && shape.triangles.is_empty() && !shape.positions().is_empty() {
        return refuse("points without triangles", "choose ply, pcd, csv or xyz");
    }
    if format == Format::Json {
        return refuse("points and triangles", "choose ply, stl, obj or off");
    }
    if format == Format::Ptx {
        return refuse("points that are not on the grid of a scanner", "choose pts, ply, csv or xyz");
    }
    let mut warnings = Vec::new();
    let bytes = write_atomically(path, |out| match format {
        Format::Ply => ply::write(out, shape, options.ascii, &mut warnings),
        Format::Xyz => xyz::write_xyz(out, shape, &mut warnings),
        Format::Csv => xyz::write_csv(out, shape, &mut warnings),
        Format::Pts => xyz::write_pts(out, shape, &mut warnings),
        Format::Obj => obj::write(out, shape, &mut warnings),
        Format::Stl => stl::write(out, shape, &mut warnings),
        Format::Off => off::write(out, shape, &mut warnings),
        Format::Pcd => pcd::write(out, shape, &mut warnings),
        // Refused above.
        Format::Json | Format::Ptx => Err(io::ErrorKind::Unsupported.into()),
    })?;
    let keeps_triangles = matches!(format, Format::Ply | Format::Obj | Format::Stl | Format::Off);
    Ok(WriteReport {
        path: path.to_path_buf(),
        format,
        points: shape.positions().len(),
        triangles: if keeps_triangles { shape.triangles.len() } else { 0 },
        shapes: 0,
        bytes,
        warnings,
    })
}

fn format_of(path: &Path, options: &WriteOptions) -> Result<Format, Error> {
    options.format.or_else(|| Format::from_path(path)).ok_or_else(|| Error::Unsupported {
        location: Location { file: Some(path.to_path_buf()), place: Place::Whole },
        what: "the extension names no format that can be written".to_owned(),
        advice: "choose ply, xyz, csv, pts, obj, stl, off, pcd or json".to_owned(),
    })
}

fn write_atomically(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<u64, Error> {
    let mut file = AtomicFile::create(path)?;
    fill(&mut file).map_err(|source| Error::Io { path: path.to_path_buf(), action: "write", source })?;
    file.commit()
}
