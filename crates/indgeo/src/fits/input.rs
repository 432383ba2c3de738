//! What fits have in common besides the fit: paths, points, starts, results.

use crate::error::Error;
use crate::files;
use crate::input::field_model::{self, LevelSet};
use crate::input::{cad_shapes, sampling};
use crate::output::cad::{self as cad_output, CadArgs, CadFormat};
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, Output, Report, Timings};
use industrial_geometry::fit::SurfaceCoverage;
use industrial_geometry::io::{Content, Model, Shape, WriteOptions};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::nurbs::nalgebra::Vector3;
use industrial_geometry::nurbs::{BsplineSurface, ParametricSurface};
use std::path::Path;

/// Points per direction that are taken from a NURBS surface, and at most from all surfaces of a file.
const SAMPLES: usize = 120;
const MOST_SAMPLES: usize = 300_000;

/// Points to be fitted, in space.
#[derive(Debug)]
pub(crate) struct Scan {
    /// Positions, finite or not.
    pub(crate) points: Vec<Vector3<f64>>,
    /// Normals, if there are any.
    pub(crate) normals: Option<Vec<Vector3<f64>>>,
    /// The mesh, if the file holds one.
    pub(crate) mesh: Option<TriangleMesh>,
}

impl Scan {
    /// Reads a cloud, a mesh or the level set of a field, or, if `shapes` says so, takes points from NURBS surfaces and the faces of CAD models.
    ///
    /// Of a file with more than `most` points an even sample is read, where its format allows that.
    pub(crate) fn read(path: &Path, shapes: bool, most: u32, report: &mut Report) -> Result<Self, Error> {
        if shapes && let Some(cad) = cad_shapes::read_model(path, "points", report)? {
            let samples = cad.model.samples(SAMPLES * SAMPLES);
            let (points, normals) = samples.into_iter().map(|sample| (sample.point, sample.normal)).unzip();
            return Ok(Self { points, normals: Some(normals), mesh: None });
        }
        if field_model::is_grid(path) {
            return Self::of_grid(path, report);
        }
        let mut seconds = report.timings.read;
        let loaded = Timings::measure(&mut seconds, || sampling::read(path, most, report))?;
        report.timings.read = seconds;
        report.add_input(Input::new("points", path, &loaded.report));
        let coordinates = |mesh: &TriangleMesh| mesh.vertices().iter().map(|p| p.coords).collect();
        match loaded.content {
            Content::Mesh(mesh) => {
                let given = mesh.cloud().attributes().normals().map(<[_]>::to_vec);
                let normals = given.unwrap_or_else(|| mesh.vertex_normals().normals);
                Ok(Self { points: coordinates(&mesh), normals: Some(normals), mesh: Some(mesh) })
            }
            Content::Cloud(cloud) if cloud.dimension() == 2 => {
                let what = "the points have two columns only";
                Err(Error::content(path, what, "give points of three columns, x, y and z"))
            }
            Content::Cloud(cloud) => Ok(Self {
                points: cloud.positions().iter().map(|p| p.coords).collect(),
                normals: cloud.attributes().normals().map(<[_]>::to_vec),
                mesh: None,
            }),
            Content::Nurbs(model) if shapes => Self::sampled(model, path),
            Content::Nurbs(_) => {
                let what = "points are needed, but this file holds NURBS shapes";
                Err(Error::content(path, what, "give a cloud or a mesh"))
            }
        }
    }

    /// The crossings of the grid lines with the level set of a field, and the normals there.
    fn of_grid(path: &Path, report: &mut Report) -> Result<Self, Error> {
        let (found, read) = field_model::read(path)?;
        let mut input = Input::new("points", path, &read);
        input.read.format = files::extension(path);
        report.add_input(input);
        let LevelSet::Space(field) = found else {
            return Err(Error::content(path, "the field lies in the plane", "give one in space"));
        };
        let points: Vec<Vector3<f64>> = field.crossings().collect();
        let normals = points.iter().map(|point| field.taylor(point).1).collect();
        Ok(Self { points, normals: Some(normals), mesh: None })
    }

    fn sampled(model: Model, path: &Path) -> Result<Self, Error> {
        let (mut points, mut normals) = (Vec::new(), Vec::new());
        let surfaces: Vec<BsplineSurface> = surfaces(model).collect();
        let most = (MOST_SAMPLES / surfaces.len().max(1)).isqrt();
        if !surfaces.is_empty() && most == 0 {
            let what =
                format!("{} are more than points can be taken from", counted(surfaces.len(), "surface"));
            return Err(Error::content(path, what, "give a part of them"));
        }
        let samples = SAMPLES.min(most);
        for surface in surfaces {
            let [u, v] = surface.domain();
            let share = |k: usize| (k as f64 + 0.5) / samples as f64;
            for k in 0..samples * samples {
                let jet = surface.jet(u.lerp(share(k / samples)), v.lerp(share(k % samples)));
                points.push(jet.point);
                normals.push(jet.du.cross(&jet.dv));
            }
        }
        if points.is_empty() {
            let what = "a surface is needed, but this file holds none";
            return Err(Error::content(path, what, "give a NURBS surface, a mesh or a cloud"));
        }
        Ok(Self { points, normals: Some(normals), mesh: None })
    }
}

fn surfaces(model: Model) -> impl Iterator<Item = BsplineSurface> {
    model.into_shapes().into_iter().filter_map(|shape| match shape {
        Shape::Surface(surface) => Some(surface),
        _ => None,
    })
}

/// The first B-spline surface of a NURBS or CAD file, to start from.
pub(crate) fn start_surface(path: &Path, report: &mut Report) -> Result<BsplineSurface, Error> {
    let found = match cad_shapes::read(path, "init", report)? {
        Content::Nurbs(model) => surfaces(model).next(),
        _ => None,
    };
    found.ok_or_else(|| {
        Error::content(
            path,
            "a surface is needed, but this file holds none",
            "give a B-spline surface (JSON, STEP, IGES)",
        )
    })
}

/// Makes sure that all files can be read and written, and that no two results go to the same place.
pub(crate) fn check_paths(inputs: &[&Path], outputs: &[&Path]) -> Result<(), Error> {
    files::check_inputs(inputs)?;
    for (index, path) in outputs.iter().enumerate() {
        files::check_writable(path, inputs)?;
        if outputs[..index].iter().any(|other| files::is_same(path, other)) {
            return Err(Error::content(path, "two results would be written here", "choose another name"));
        }
    }
    Ok(())
}

/// Says how many points do not count because they are not finite.
pub(crate) fn warn_dropped(path: &Path, dropped: usize, points: usize, report: &mut Report) {
    if dropped > 0 {
        report.warnings.push(not_finite(path, dropped, points, "left out"));
    }
}

/// Says when there are fewer points than control points.
pub(crate) fn warn_undetermined(path: &Path, points: usize, [u, v]: [usize; 2], report: &mut Report) {
    if points < u * v {
        report.warnings.push(format!(
            "{}: {} for {u} x {v} control points: the smoothing decides what the points leave open; take fewer \
             (--control-points)",
            path.display(),
            counted(points, "point")
        ));
    }
}

/// Says when parts of a surface are without data; returns whether there are any.
pub(crate) fn warn_incomplete(coverage: Option<&SurfaceCoverage>, report: &mut Report) -> bool {
    let Some(found) = coverage.filter(|coverage| !coverage.is_complete()) else { return false };
    report.warnings.push(format!(
        "parts of the surface are without data: {:.3e} of its area {:.3e}, up to {:.3e} ({:.1} spacings of the points) from the nearest \
         point; scan what is missing, or give another start (--init), --shape or fewer control points",
        found.area_without_data, found.area, found.max, found.max_in_spacings
    ));
    true
}

/// Writes a curve or surface: as STEP or IGES where the extension says so, else as NURBS JSON.
pub(crate) fn put_model(
    path: &Path,
    shape: impl Into<Model>,
    cad: &CadArgs,
    content: String,
    report: &mut Report,
) -> Result<(), Error> {
    let model = shape.into();
    if let Some(format) = CadFormat::of(path) {
        let described = cad.describe(&model, path)?;
        let mut warnings = Vec::new();
        let bytes = Timings::measure(&mut report.timings.write, || {
            cad_output::write(path, format, described, &mut warnings)
        })?;
        report.warnings.extend(warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
        report.add_output(Output { path: path.to_path_buf(), bytes, content });
        return Ok(());
    }
    let model = cad.named(model);
    let written = Timings::measure(&mut report.timings.write, || {
        files::write_content(path, &Content::Nurbs(model), &WriteOptions::default())
    })?;
    report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content });
    Ok(())
}
