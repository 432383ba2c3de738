//! The inspection of a cloud: read, measure, judge, write. `inspect` and `demo` both run this.

use crate::cad::{Choice, Units};
use crate::error::Error;
use crate::files;
use crate::inspecting_pieces;
use crate::inspection_results::conclude;
use crate::model::{Loaded, Model};
use crate::output::{self, DeviationTable, Format, Measured, NAME, Rows};
use crate::points::Points;
use crate::progress::Progress;
use crate::report::{Input, ModelSummary, Options, Output, Report, Timings};
use crate::transform::Transform;
use crate::wording::{counted, not_finite};
use industrial_geometry::inspection::html::{self, Page};
use industrial_geometry::inspection::{
    self, Along, Deviation, DeviationRecord, Inspection, InspectionOptions, Nominal, Outcome, Partial,
};
use industrial_geometry::io::ReadReport;
use industrial_geometry::mesh::nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;
use std::io::BufWriter;
use std::path::Path;

/// Height over the plane, as a share of the distance from the origin, that rounding leaves.
const OFF_PLANE: f64 = 1e-12;
/// Most points in the picture of a report.
const MOST_POINTS: usize = 1_000_000;

/// How points are moved before they are measured.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Motion<'a> {
    /// Not at all.
    None,
    /// By the motion of a file.
    File(&'a Path),
    /// By a motion that is known.
    Known(Transform),
}

impl Motion<'_> {
    /// The file of the motion.
    fn file(&self) -> Option<&Path> {
        if let Self::File(path) = self { Some(path) } else { None }
    }

    /// The motion itself.
    fn transform(&self) -> Result<Option<Transform>, Error> {
        match self {
            Self::None => Ok(None),
            Self::File(path) => Transform::read(path).map(Some),
            Self::Known(transform) => Ok(Some(*transform)),
        }
    }
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the model.
    pub(crate) model: &'a Path,
    /// What is chosen of a CAD model.
    pub(crate) cad: &'a Choice,
    /// File of the points.
    pub(crate) points: &'a Path,
    /// How the points are moved first.
    pub(crate) motion: Motion<'a>,
    /// File of the page.
    pub(crate) page: Option<&'a Path>,
    /// File of the deviations per point.
    pub(crate) out: Option<&'a Path>,
    /// Their format, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// Options of the library.
    pub(crate) options: InspectionOptions,
    /// The mode of the search, by its name on the command line.
    pub(crate) mode: &'static str,
    /// Whether points that are not finite are left out.
    pub(crate) drop_non_finite: bool,
    /// The scan that is read of a file of several.
    pub(crate) scan: Option<&'a str>,
    /// Number of threads asked for.
    pub(crate) threads: Option<u16>,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

/// Does the job and fills in the report.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<Inspection, Error> {
    let format = job.out.map(|out| Format::of(out, job.format)).transpose()?;
    if let Some(page) = job.page {
        check_extension(page)?;
    }
    let inputs: Vec<&Path> = [job.model, job.points].into_iter().chain(job.motion.file()).collect();
    for path in [job.out, job.page].into_iter().flatten() {
        files::check_writable(path, &inputs)?;
    }
    let mut timings = Timings::default();
    let loaded = Timings::measure(&mut timings.read, || Loaded::read(job.model, job.cad))?;
    report.add_input(loaded.input(job.model));
    let transform = job.motion.transform()?;
    if inspecting_pieces::fits(job, &loaded) {
        return inspecting_pieces::run(job, loaded, transform, timings, report);
    }
    let mut points =
        Timings::measure(&mut timings.read, || Points::read(job.points, job.drop_non_finite, job.scan))?;
    report.add_input(Input::new("points", job.points, &points.report));
    let measured = measured(&loaded.model);
    if measured == Measured::Profile {
        points.check_plane(job.points)?;
    } else {
        points.check_space(job.points)?;
    }
    check_normals(job, &mut points.normals)?;
    report.timings = timings;
    warn(report, job, &loaded.report.warnings, &points.report);
    if let Some(transform) = &transform {
        transform.apply(&mut points);
        if measured == Measured::Profile
            && points.positions.iter().any(|point| point.z.abs() > OFF_PLANE * point.coords.norm())
        {
            let what = "the motion takes the points out of the plane of the model";
            return Err(Error::content(
                job.motion.file().unwrap_or(job.points),
                what,
                "give a turn about z and a shift in x and y",
            ));
        }
    }

    let units = match &loaded.model {
        Model::Cad(cad) => Some(cad.units()),
        _ => None,
    };
    report.warn_now(units.as_ref().and_then(|units| units.warning(points.diagonal())), job.quiet);
    let nominal = Timings::measure(&mut timings.build, || build(loaded, job, report))?;
    let options = options(job, &nominal);
    describe(job, &nominal, measured, units.as_ref(), transform.as_ref(), report);
    let progress = Progress::new("measuring", job.quiet);
    // Deviations are kept only for files, and without what can be computed again: clouds are large.
    let kept = if job.out.is_some() || job.page.is_some() { points.positions.len() } else { 0 };
    let found = Timings::measure(&mut timings.compute, || -> Result<_, inspection::Error> {
        let tell = |done: usize, total: usize| progress.report(done, total);
        let mut records = Vec::new();
        let mut partial = Partial::new(&options)?;
        let mut receive = |measured: &[(usize, Deviation)]| {
            partial.extend_with(0, &points.positions, measured);
            // Not before what sorts the points has given back its memory.
            records.resize(kept, DeviationRecord::none(Outcome::Cancelled));
            for (index, deviation) in measured {
                if let Some(record) = records.get_mut(*index) {
                    *record = deviation.into();
                }
            }
        };
        nominal.measure_each(&points.positions, points.normals.as_deref(), &options, &tell, &mut receive)?;
        Ok((partial.finish(&options, nominal.shapes())?, records))
    });
    let (mut found, records) = found.map_err(|error| usage(&error))?;
    for worst in &mut found.worst {
        worst.name =
            usize::try_from(worst.index).ok().and_then(|index| points.name(index)).map(str::to_owned);
    }
    drop(progress);
    warn_of_unproven(report, job, &found);
    report.points_per_second =
        (timings.compute > 0.0).then(|| points.positions.len() as f64 / timings.compute);
    report.timings = timings;
    write(job, format, &points, &records, &found, &nominal, measured, report)?;
    conclude(&found, points.report.non_finite, report);
    Ok(found)
}

/// The options of the library, with what follows from the model.
pub(crate) fn options(job: &Job<'_>, nominal: &Nominal) -> InspectionOptions {
    let options = job.options;
    if options.along == Along::Normal && options.max_angle.is_none() && nominal.is_signed() {
        return options.with_max_angle(FRAC_PI_2);
    }
    options
}

/// Describes model and options in the report.
pub(crate) fn describe(
    job: &Job<'_>,
    nominal: &Nominal,
    measured: Measured,
    units: Option<&Units>,
    transform: Option<&Transform>,
    report: &mut Report,
) {
    report.model = Some(ModelSummary {
        kind: match measured {
            Measured::Mesh => "mesh",
            _ if units.is_some() => "cad",
            _ => "nurbs",
        },
        unit: units.map(|units| units.name.clone()),
        points_unit: units.map(Units::of_points),
        dimension: if measured == Measured::Profile { 2 } else { 3 },
        shapes: nominal.shapes().len(),
        patches: nominal.piece_count(),
        signed: nominal.is_signed(),
    });
    report.options = Some(Options {
        mode: job.mode,
        relative_gap: job.options.projection.relative_gap,
        threads: job.threads,
        transform: transform.map(Transform::rows),
    });
}

/// Makes sure that there are normals where they are needed, and drops them where they are not.
pub(crate) fn check_normals(job: &Job<'_>, normals: &mut Option<Vec<Vector3<f64>>>) -> Result<(), Error> {
    let angle = job.options.max_angle;
    if job.options.along != Along::Normal && angle.is_none() {
        *normals = None;
    } else if normals.is_none() {
        let advice = match (job.options.along, angle) {
            (Along::Normal, _) => "use --along shortest, or a file with normals (nx, ny, nz)",
            _ => "leave out --max-angle, or give a file with normals (nx, ny, nz)",
        };
        return Err(Error::content(job.points, "the points have no normals", advice));
    }
    Ok(())
}

/// Says what a verdict rests on where that is less than a measured deviation per point.
pub(crate) fn warn_of_unproven(report: &mut Report, job: &Job<'_>, found: &Inspection) {
    let count = |outcome: Outcome| found.outcomes.get(outcome.name()).copied().unwrap_or(0);
    let (points, path) = (found.points, job.points.display());
    let mut warn = |count: u64, text: &str| {
        if count > 0 {
            report.warnings.push(format!("{path}: {count} of {points} points {text}"));
        }
    };
    warn(
        count(Outcome::NoNormal),
        "have a normal that is zero or not finite (no_normal); they are counted, not judged",
    );
    warn(
        count(Outcome::NoMatchingFoot),
        "have no foot on the model with a normal that agrees (no_matching_foot); they count as out of tolerance",
    );
    warn(
        count(Outcome::Undecided),
        "are undecided: what is proven about their deviations reaches across a limit; they count as not within",
    );
    warn(count(Outcome::NotConverged), "have no footpoint (not_converged); they count as out of tolerance");
    let turned = found.restricted + count(Outcome::NoMatchingFoot);
    if 2 * turned > found.verdict.judged {
        warn(
            turned,
            "have normals that point away from that of the nearest place of the model; turn them if they point inwards, or \
             give --max-angle 180 if their sides mean nothing",
        );
    }
}

fn check_extension(page: &Path) -> Result<(), Error> {
    match files::extension(page).as_str() {
        "html" | "htm" => Ok(()),
        _ if files::is_stream(page) => Ok(()),
        _ => Err(Error::content(page, "the report is a page", "choose a name that ends in .html")),
    }
}

/// The error of the library, with the option as it is typed.
pub(crate) fn usage(error: &inspection::Error) -> Error {
    let help = "see `indgeo inspect --help`";
    match error {
        inspection::Error::Option { option, value, what } => {
            Error::usage(format!("--{} is {value}: {what}", option.replace('_', "-")), help)
        }
        _ => Error::usage(error.to_string(), help),
    }
}

/// What the deviations from a model are measured from: its surfaces if it has some, otherwise its curves.
pub(crate) fn measured(model: &Model) -> Measured {
    match model {
        Model::Plane(_) => Measured::Profile,
        Model::Space { surfaces, .. } if surfaces.shapes.is_empty() => Measured::Curves,
        Model::Space { .. } | Model::Cad(_) => Measured::Surfaces,
        Model::Mesh(_) => Measured::Mesh,
    }
}

/// The nominal shape; curves beside surfaces are left out with a warning.
pub(crate) fn build(loaded: Loaded, job: &Job<'_>, report: &mut Report) -> Result<Nominal, Error> {
    let name = |index: usize| loaded.shapes.get(index).and_then(|shape| shape.1.clone());
    let names =
        |indices: &[u32]| indices.iter().map(|&index| name(index as usize)).collect::<Vec<Option<String>>>();
    let nominal = match loaded.model {
        Model::Plane(curves) => {
            let names: Vec<_> = (0..curves.len()).map(name).collect();
            Nominal::from_profile(curves).map(|nominal| nominal.with_names(names))
        }
        Model::Space { surfaces, curves } if surfaces.shapes.is_empty() => {
            let names = names(&curves.indices);
            Nominal::from_curves(curves.shapes).map(|nominal| nominal.with_names(names))
        }
        Model::Space { surfaces, curves } => {
            if !curves.shapes.is_empty() {
                report.warnings.push(format!(
                    "{}: {} left out, deviations are measured from surfaces; surfaces are numbered without curves",
                    job.model.display(),
                    counted(curves.shapes.len(), "curve")
                ));
            }
            let names = names(&surfaces.indices);
            Nominal::from_surfaces(surfaces.shapes).map(|nominal| nominal.with_names(names))
        }
        Model::Mesh(mesh) => Nominal::from_mesh(&mesh),
        Model::Cad(cad) => Nominal::from_brep(cad.model),
    };
    let nominal = nominal
        .map_err(|error| Error::content(job.model, error.to_string(), "check it with `indgeo info`"))?;
    if !nominal.is_signed() && nominal.shapes().iter().all(|shape| shape.kind == "mesh") {
        report.warnings.push(format!(
            "{}: neighbouring triangles disagree on the side of their normals, so distances have no sign",
            job.model.display()
        ));
    }
    Ok(nominal)
}

/// Passes on what the readers said of the model and the points.
pub(crate) fn warn(report: &mut Report, job: &Job<'_>, of_model: &[String], read: &ReadReport) {
    for (path, warnings) in [(job.model, of_model), (job.points, &read.warnings)] {
        report.warnings.extend(warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
    }
    if read.non_finite > 0 {
        report.warnings.push(not_finite(job.points, read.non_finite, read.points, "counted, not used"));
    }
}

#[expect(clippy::too_many_arguments, reason = "everything that was found goes into the files")]
fn write(
    job: &Job<'_>,
    format: Option<Format>,
    points: &Points,
    records: &[DeviationRecord],
    found: &Inspection,
    nominal: &Nominal,
    measured: Measured,
    report: &mut Report,
) -> Result<(), Error> {
    let mut outputs = Vec::new();
    let mut seconds = report.timings.write;
    let alignment = report.options.as_ref().and_then(|options| options.transform);
    Timings::measure(&mut seconds, || -> Result<(), Error> {
        if let (Some(path), Some(format)) = (job.out, format) {
            let table = DeviationTable {
                points: &points.positions,
                normals: points.normals.as_deref(),
                point_names: points.names.as_ref(),
                records,
                triangles: &points.triangles,
                nominal,
                options: &found.options,
                model: measured,
                coloured: format.has_colours(),
            };
            let written = output::write(path, format, &table)?;
            report.warnings.extend(written.warnings);
            let columns: Vec<&str> =
                table.names().into_iter().chain(points.names.as_ref().map(|_| NAME)).collect();
            let content = format!("{}: {}", counted(records.len(), "row"), columns.join(","));
            outputs.push(Output { path: path.to_path_buf(), bytes: written.bytes, content });
        }
        if let Some(path) = job.page {
            let name =
                |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            // Which units the lengths of the page have.
            let unit = report.model.as_ref().and_then(|model| model.unit.clone());
            let in_unit = |name: String, how: &str| match &unit {
                Some(unit) => format!("{name} ({how}{unit})"),
                None => name,
            };
            let model = in_unit(name(job.model), "unit: ");
            let cloud = in_unit(name(job.points), "states no unit, taken as ");
            let page = Page {
                title: &format!("Inspection of {}", name(job.points)),
                model: &model,
                cloud: &cloud,
                program: concat!("indgeo ", env!("CARGO_PKG_VERSION")),
                inspection: found,
                points: &points.positions,
                records,
                backdrop: &nominal.backdrop(),
                alignment,
                most_points: MOST_POINTS,
            };
            let bytes = files::write(path, |out| html::write(&mut BufWriter::new(out), &page))?;
            let content = "page: map of the deviations, histogram, tables".to_owned();
            outputs.push(Output { path: path.to_path_buf(), bytes, content });
        }
        Ok(())
    })?;
    report.timings.write = seconds;
    outputs.into_iter().for_each(|output| report.add_output(output));
    Ok(())
}
