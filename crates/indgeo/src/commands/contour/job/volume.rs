//! Level sets of volumes.

use super::level_function::{level_function, without_effect};
use super::{ContourResults, Job, MeshResult, Method, Region, surface};
use crate::error::Error;
use crate::files;
use crate::input::image_or_grid::{Source, refused};
use crate::report::wording::counted;
use crate::report::{Output, Report, Timings};
use industrial_geometry::distance_field::LevelSetField;
use industrial_geometry::io::{Content, Format, WriteOptions};
use industrial_geometry::level_set::Error as LevelSetError;
use industrial_geometry::level_set::region::topology;
use industrial_geometry::level_set::surface::{dual_contour, of_field, surface_gap};

/// Tolerance where none is given, in cells.
const TOLERANCE: f64 = 0.1;

pub(super) fn run(job: &Job<'_>, source: &Source, report: &mut Report) -> Result<ContourResults, Error> {
    let Source::Grid(grid) = source else {
        return Err(Error::content(job.input, "this is no volume", "give a grid of three axes"));
    };
    let surface_file = job.out.filter(|path| surface::is_surface(path));
    let is_surface = surface_file.is_some();
    let options = [
        (job.method != Method::Threshold, "--method chan-vese or edges"),
        (job.smooth.is_some(), "--smooth"),
        (job.controls.is_some() && !is_surface, "--control-points"),
        (job.min_area.is_some(), "--min-area"),
        (job.is_held, "--topology fixed"),
        (!job.start.is_empty(), "--start"),
        (job.length_weight.is_some(), "--length-weight"),
        (job.balloon.is_some(), "--balloon"),
        (job.picture.is_some(), "--picture"),
        (job.cad.unit.is_some() && !is_surface, "--unit"),
        (job.cad.name.is_some() && !is_surface, "--name"),
    ];
    without_effect(&options, if is_surface { "the surface of a volume" } else { "the mesh of a volume" })?;
    if let Some(path) = job.out.filter(|_| !is_surface) {
        let format = Format::from_extension(&files::extension(path));
        let is_mesh = matches!(format, Some(Format::Stl | Format::Ply | Format::Obj | Format::Off));
        if !is_mesh && !files::is_stream(path) {
            let what = "a volume becomes a mesh or a surface, which this format does not hold";
            let advice = "choose .stl, .ply, .obj or .off for a mesh, .json, .step or .igs for a surface";
            return Err(Error::content(path, what, advice));
        }
    }
    let failed = |error: LevelSetError| refused(job.input, &error);
    let level = job.level.unwrap_or(0.0);
    let mut timings = report.timings;
    let (function, field) = Timings::measure(&mut timings.build, || -> Result<_, Error> {
        let mut function = level_function::<3>(job, grid, level)?;
        if job.inside == Region::Bright {
            let values = function.values().iter().map(|value| -value).collect();
            function = function.with_values(values).map_err(|error| failed(error.into()))?;
        }
        let field = LevelSetField::<3>::new(&function).map_err(|error| failed(error.into()))?;
        Ok((function, field))
    })?;
    let (mesh, gap) = Timings::measure(&mut timings.compute, || {
        let mesh = dual_contour(&function, of_field(&field))?;
        let gap = surface_gap(&field, &mesh)?;
        Ok((mesh, gap))
    })
    .map_err(failed)?;
    let cell = function.spacing().min();
    let tolerance = job.tolerance.unwrap_or(TOLERANCE * cell);
    report.timings = timings;
    let fitted =
        surface_file.map(|path| surface::run(job, path, &field, &mesh, tolerance, report)).transpose()?;
    let mut timings = report.timings;
    let region = topology(&function.counts(), function.values());
    let max = match &fitted {
        Some(fitted) => fitted.max_of_surface.max(fitted.max_of_level_set),
        None => gap.forth.max(gap.back),
    };
    let is_whole = fitted.as_ref().is_none_or(|fitted| fitted.folds == 0);
    let result = MeshResult {
        vertices: mesh.vertices().len(),
        triangles: mesh.triangles().len(),
        closed: mesh.topology().is_closed(),
        max_of_mesh: gap.forth,
        max_of_level_set: gap.back,
    };
    if let Some(path) = job.out.filter(|_| !is_surface) {
        let content = counted(mesh.triangles().len(), "triangle");
        let written = Timings::measure(&mut timings.write, || {
            files::write_content(path, &Content::Mesh(mesh), &WriteOptions::default())
        })?;
        report.timings = timings;
        report.add_output(Output { path: path.to_path_buf(), bytes: written.bytes, content });
    }
    report.timings = timings;
    Ok(ContourResults {
        method: job.method.name(),
        size: grid.counts.clone(),
        level: Some(level),
        inside: Some(if job.inside == Region::Bright { "bright" } else { "dark" }),
        smoothing: 0.0,
        tolerance,
        max: Some(max),
        within_tolerance: max <= tolerance && is_whole,
        components: region.components,
        holes: region.holes,
        left_out: 0,
        evolution: None,
        contours: Vec::new(),
        mesh: Some(result),
        surface: fitted,
    })
}
