//! `indgeo convert`: the same points, triangles or shapes in another format.

pub(crate) mod cad;
pub(crate) mod cad_tessellating;
pub(crate) mod pieces;
pub(crate) mod tessellating;

use self::tessellating::Tessellated;
use crate::error::Error;
use crate::files;
use crate::input::image_or_grid::refused;
use crate::output::cad::{self as cad_output, CadArgs, CadFormat};
use crate::report::wording::{counted, not_finite};
use crate::report::{Input, Outcome, Output, Report, Results, Timings};
use industrial_geometry::distance_field::MlsField;
use industrial_geometry::io::{
    Content, Format, Model, PolylineFormat, ReadOptions, ReadReport, WriteOptions, WriteReport,
    write_polylines,
};
use industrial_geometry::level_set::surface::{mesh_of_cloud, remesh};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Write points, triangles, NURBS or CAD models in another format
///
/// Normals, colours, intensity, names and other values per point are kept where the format can hold them; what it cannot
/// hold is told. Surfaces become triangles, and curves polylines, where OUTPUT is no NURBS or CAD file. CAD models (STEP, IGES) become
/// CAD models (faces with their loops, free curves, names and the unit are kept) or triangles that end at the edges.
#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub(crate) struct Args {
    /// File to read, its format recognised by content first; `-` is standard input
    pub(crate) input: PathBuf,
    /// File to write: .ply, .xyz, .csv, .pts, .obj, .stl, .off, .pcd, .las, .laz, .e57, .glb, or .json, .step and .igs for NURBS; curves also .svg and .dxf; `-` is standard
    /// output (CSV, OBJ for triangles, JSON for NURBS)
    pub(crate) output: PathBuf,
    /// Format of OUTPUT, whatever its extension: ply, xyz, csv, pts, obj, stl, off, pcd, las, laz, e57, glb, json, step or igs, for curves svg or dxf as well
    #[arg(long, value_name = "FORMAT", value_parser = parse_form)]
    format: Option<Form>,
    /// Largest distance between a curve or surface and its chords or triangles [default: a thousandth of the diagonal of the model]
    #[arg(long, value_name = "T", value_parser = super::numbers::length)]
    chord: Option<f64>,
    /// Make a mesh anew, by way of its signed distance on a grid with N nodes along its longest side: closed and even, with its
    /// sharp edges; parts thinner than a cell are lost. Of a cloud: the mesh of its moving least squares surface, which ends where the
    /// points end
    #[arg(long, value_name = "N")]
    grid: Option<usize>,
    /// Leave out points with a coordinate that is NaN or infinite, and the triangles that use them
    #[arg(long)]
    drop_non_finite: bool,
    /// Take commas in the numbers of tables as decimal signs, where the file leaves that open
    #[arg(long)]
    decimal_comma: bool,
    /// The scan to read of a file of several (E57, PTX): its name, its number from 0 on, or `all`, which moves them by their poses
    /// and puts them together
    #[arg(long, value_name = "SCAN", default_value = "all")]
    scan: String,
    /// Write PLY as text instead of binary
    #[arg(long)]
    ascii: bool,
    #[command(flatten)]
    cad: CadArgs,
}

const AFTER_HELP: &str = "\
Doubles are written with full precision in every format but binary STL, GLB and PCD colours, which are single by definition, and
LAS and LAZ, whose coordinates are integer steps: exact where the input has such steps, else rounded, which is told.

Exit status 0: written; 2: bad input or usage; 130: interrupted (nothing half-written stays).

Examples:
  indgeo convert scan.pcd scan.ply
  indgeo convert scan.ply scan.csv --drop-non-finite
  indgeo convert part.stl part.off
  indgeo convert scan.stl closed.stl --grid 200
  indgeo convert cloud.ply surface.ply --grid 200
  indgeo convert surface.json surface.stl --chord 0.01
  indgeo convert section.json section.dxf
  indgeo convert surface.json surface.step --unit mm --name blade-3
  indgeo convert part.igs part.step
  indgeo convert part.step part.stl --chord 0.01
  indgeo convert scans.e57 front.las --scan front
  gzip -dc scan.ply.gz | indgeo convert - - --format xyz | head";

impl Results for ConvertResults {}

/// What was written.
#[derive(Debug, Serialize)]
pub(crate) struct ConvertResults {
    /// Its format, by its usual extension.
    pub(crate) format: &'static str,
    /// Points or vertices.
    pub(crate) points: usize,
    /// Triangles.
    pub(crate) triangles: usize,
    /// Curves and surfaces.
    pub(crate) shapes: usize,
    /// Polylines.
    pub(crate) polylines: usize,
    /// Largest distance of the shapes from their chords and triangles, where they were tessellated; of a mesh that was made anew from the
    /// input, at vertices and middles of triangles.
    pub(crate) chord: Option<f64>,
}

/// A format that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Of points, triangles or shapes.
    Content(Format),
    /// Of polylines only.
    Polylines(PolylineFormat),
    /// Of CAD models.
    Cad(CadFormat),
}

fn form_of(extension: &str) -> Option<Form> {
    let content = Format::from_extension(extension).map(Form::Content);
    let polylines = || PolylineFormat::from_extension(extension).map(Form::Polylines);
    content.or_else(polylines).or_else(|| CadFormat::from_extension(extension).map(Form::Cad))
}

fn parse_form(text: &str) -> Result<Form, String> {
    form_of(text).ok_or_else(|| {
        "choose ply, xyz, csv, pts, obj, stl, off, pcd, las, laz, e57, glb, json, step or igs, for curves svg or dxf as well"
            .to_owned()
    })
}

/// What is written.
enum Converted {
    Content(Box<Content>),
    Polylines(Vec<Vec<[f64; 3]>>, PolylineFormat),
}

impl Converted {
    fn describe(&self) -> String {
        match self {
            Self::Content(content) => content.describe(),
            Self::Polylines(polylines, _) => counted(polylines.len(), "polyline"),
        }
    }
}

/// How writing went.
#[derive(Default)]
struct Written {
    format: &'static str,
    points: usize,
    triangles: usize,
    shapes: usize,
    polylines: usize,
    bytes: u64,
    warnings: Vec<String>,
}

impl From<WriteReport> for Written {
    fn from(report: WriteReport) -> Self {
        Self {
            format: report.format.extension(),
            points: report.points,
            triangles: report.triangles,
            shapes: report.shapes,
            polylines: 0,
            bytes: report.bytes,
            warnings: report.warnings,
        }
    }
}

impl Args {
    /// The format that is asked for; `None` where nothing says.
    fn form(&self) -> Option<Form> {
        self.format.or_else(|| form_of(&files::extension(&self.output)))
    }

    /// Converts a CAD model: into another one, or into triangles.
    fn convert_cad(&self, bytes: &[u8], form: Option<Form>, report: &mut Report) -> Result<Outcome, Error> {
        match form {
            Some(Form::Cad(_)) if self.chord.is_some() => {
                let advice = "leave it out, or choose stl, obj, ply or off for OUTPUT";
                Err(Error::usage("--chord has no effect from one CAD format to another", advice))
            }
            Some(Form::Cad(format)) => cad::run(&self.input, bytes, &self.output, format, &self.cad, report),
            Some(Form::Content(format)) if format != Format::Json => {
                let options = WriteOptions { format: Some(format), ascii: self.ascii };
                cad_tessellating::run(&self.input, bytes, &self.output, &options, self.chord, report)
            }
            _ => {
                let what = "this is a CAD model, whose faces are bounded by loops";
                let advice = "choose step, igs, or stl, obj, ply or off for OUTPUT";
                Err(Error::content(&self.input, what, advice))
            }
        }
    }

    /// What of a tessellated model the format holds.
    fn tessellated(&self, model: &Model, found: Tessellated) -> Result<Converted, Error> {
        let lines = match self.form() {
            Some(Form::Polylines(format)) => Some(format),
            Some(Form::Content(Format::Obj)) => Some(PolylineFormat::Obj),
            Some(Form::Content(Format::Ply)) => Some(PolylineFormat::Ply),
            _ => None,
        };
        let count = model.shapes().len();
        match (found.mesh, found.polylines, lines) {
            (Some(_), _, Some(PolylineFormat::Svg | PolylineFormat::Dxf)) => {
                let what = "the model has surfaces, which are no polylines";
                Err(Error::content(&self.input, what, "choose stl, obj, ply or off for OUTPUT"))
            }
            (Some(mesh), polylines, _) if polylines.is_empty() => {
                Ok(Converted::Content(Box::new(Content::Mesh(mesh))))
            }
            (None, polylines, Some(PolylineFormat::Svg)) if !is_flat(&polylines) => {
                let what = "the curves leave the planes z = constant, and have no true shape in a picture";
                Err(Error::content(&self.input, what, "choose dxf, obj or ply for OUTPUT"))
            }
            (None, polylines, Some(format)) if !polylines.is_empty() => {
                Ok(Converted::Polylines(polylines, format))
            }
            (Some(_), ..) => {
                let what = format!(
                    "the model has surfaces and curves ({count} shapes), which go into no file together"
                );
                Err(Error::content(
                    &self.input,
                    what,
                    "put the curves and the surfaces into files of their own",
                ))
            }
            (None, ..) => {
                let what = "the model has curves, which are no triangles and no points";
                Err(Error::content(&self.input, what, "choose svg, dxf, obj or ply for OUTPUT"))
            }
        }
    }

    /// Writes curves and surfaces as a CAD model.
    fn write_cad(&self, content: &Content, format: CadFormat) -> Result<Written, Error> {
        let Content::Nurbs(model) = content else {
            let what =
                format!("a CAD file holds surfaces and curves, the input holds {}", content.describe());
            let advice = "fit a surface first (`indgeo fit-surface`), or choose ply, obj or stl for OUTPUT";
            return Err(Error::content(&self.input, what, advice));
        };
        let described = self.cad.describe(model, &self.output)?;
        let mut warnings = Vec::new();
        let bytes = cad_output::write(&self.output, format, described, &mut warnings)?;
        let shapes = model.shapes().len();
        Ok(Written { format: format.extension(), shapes, bytes, warnings, ..Written::default() })
    }

    fn write(&self, content: &Converted) -> Result<Written, Error> {
        match content {
            Converted::Content(content) => {
                let format = match self.form() {
                    Some(Form::Content(format)) => Some(format),
                    Some(Form::Polylines(format)) => {
                        let what = format!("{format} holds curves only");
                        return Err(Error::content(
                            &self.output,
                            what,
                            "choose ply, xyz, csv, pts, obj, stl, off, pcd, las, laz, e57 or glb",
                        ));
                    }
                    Some(Form::Cad(format)) => return self.write_cad(content, format),
                    None => None,
                };
                let options = WriteOptions { format, ascii: self.ascii };
                Ok(files::write_content(&self.output, content, &options)?.into())
            }
            Converted::Polylines(polylines, format) => {
                let bytes = files::write(&self.output, |out| write_polylines(out, polylines, *format))?;
                Ok(Written {
                    format: format.extension(),
                    points: polylines.iter().map(Vec::len).sum(),
                    triangles: 0,
                    shapes: 0,
                    polylines: polylines.len(),
                    bytes,
                    warnings: Vec::new(),
                })
            }
        }
    }

    /// Tells what was read and written; `within` is how far the result is from what.
    fn conclude(
        &self,
        read: &ReadReport,
        written: &Written,
        described: &str,
        within: Option<(f64, &str)>,
        report: &mut Report,
    ) -> Outcome {
        let all = [(&self.input, &read.warnings), (&self.output, &written.warnings)];
        for (path, warnings) in all {
            report.warnings.extend(warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
        }
        if read.non_finite > 0 {
            let fate = if read.dropped > 0 { "left out" } else { "kept (--drop-non-finite leaves them out)" };
            report.warnings.push(not_finite(&self.input, read.non_finite, read.points, fate));
        }
        report.results = Some(Box::new(ConvertResults {
            format: written.format,
            points: written.points,
            triangles: written.triangles,
            shapes: written.shapes,
            polylines: written.polylines,
            chord: within.map(|(chord, _)| chord),
        }));
        report.add_output(Output {
            path: self.output.clone(),
            bytes: written.bytes,
            content: described.to_owned(),
        });
        let summary = format!(
            "{}: {described} as {}, {}{}",
            self.output.display(),
            written.format.to_ascii_uppercase(),
            counted(written.bytes, "byte"),
            within.map_or_else(String::new, |(chord, what)| format!(", within {chord} of the {what}"))
        );
        Outcome::new(summary, true)
    }
}

/// Whether each polyline lies in a plane of constant z.
fn is_flat(polylines: &[Vec<[f64; 3]>]) -> bool {
    polylines.iter().all(|polyline| polyline.iter().all(|vertex| vertex[2] == polyline[0][2]))
}

/// Runs the command.
pub(crate) fn run(args: &Args, report: &mut Report) -> Result<Outcome, Error> {
    files::check_writable(&args.output, &[&args.input])?;
    let form = args.form();
    let cad_format = match form {
        Some(Form::Cad(format)) => Some(format),
        _ => None,
    };
    args.cad.check_format(cad_format.is_some())?;
    if args.cad.name.is_some() && cad_format.is_none() {
        let what = "--name has no effect: only STEP and IGES files take another name";
        return Err(Error::usage(what, "leave it out, or call OUTPUT .step or .igs"));
    }
    let mut timings = Timings::default();
    let options = ReadOptions::default()
        .with_drop_non_finite(args.drop_non_finite)
        .with_decimal_comma(args.decimal_comma)
        .with_scan(Some(args.scan.clone()));
    if let (Some(Form::Content(format)), None, None) = (form, args.grid, args.chord) {
        let options_out = WriteOptions { format: Some(format), ascii: args.ascii };
        let began = Instant::now();
        if let Some((read, written)) = pieces::convert(&args.input, &args.output, &options, &options_out)? {
            timings.write = began.elapsed().as_secs_f64();
            report.timings = timings;
            report.add_input(Input::new("file", &args.input, &read));
            let described = format!("a cloud of {}", counted(written.points, "point"));
            return Ok(args.conclude(&read, &written.into(), &described, None, report));
        }
    }
    let loaded = if cad::is_read_as_bytes(&args.input) {
        let bytes = Timings::measure(&mut timings.read, || files::read_bytes(&args.input))?;
        if cad::is_cad(&bytes) {
            report.timings = timings;
            return args.convert_cad(&bytes, form, report);
        }
        Timings::measure(&mut timings.read, || files::read_from_bytes(&bytes, &args.input, &options))?
    } else {
        Timings::measure(&mut timings.read, || files::read(&args.input, &options))?
    };
    report.add_input(Input::new("file", &args.input, &loaded.report));
    let is_model = matches!(form, Some(Form::Content(Format::Json) | Form::Cad(_)))
        || (form.is_none() && files::is_stream(&args.output));
    let mut is_made_anew = false;
    let (content, chord) = match loaded.content {
        Content::Nurbs(model) if !is_model => {
            let found = Timings::measure(&mut timings.compute, || {
                tessellating::tessellate(&model, args.chord, &args.input)
            })?;
            let chord = Some(found.chord);
            (args.tessellated(&model, found)?, chord)
        }
        Content::Mesh(mesh) if args.grid.is_some() => {
            let nodes = args.grid.unwrap_or_default();
            let found = Timings::measure(&mut timings.compute, || remesh(&mesh, nodes))
                .map_err(|error| refused(&args.input, &error))?;
            is_made_anew = true;
            let gap = found.forth.max(found.back);
            (Converted::Content(Box::new(Content::Mesh(found.mesh))), Some(gap))
        }
        Content::Cloud(cloud) if args.grid.is_some() && cloud.dimension() == 3 => {
            let nodes = args.grid.unwrap_or_default();
            let found = Timings::measure(&mut timings.compute, || {
                let field = MlsField::new(cloud.positions(), cloud.attributes().normals())?;
                mesh_of_cloud(cloud.positions(), &field, nodes)
            })
            .map_err(|error| refused(&args.input, &error))?;
            is_made_anew = true;
            let gap = found.forth.max(found.back);
            (Converted::Content(Box::new(Content::Mesh(found.mesh))), Some(gap))
        }
        content => (Converted::Content(Box::new(content)), None),
    };
    if args.grid.is_some() && !is_made_anew {
        return Err(Error::usage(
            "--grid has no effect: it makes meshes of clouds, and meshes anew",
            "leave it out, or give a mesh or points in space",
        ));
    }
    if args.chord.is_some() && (chord.is_none() || is_made_anew) {
        return Err(Error::usage(
            "--chord has no effect",
            "leave it out, or give NURBS and an OUTPUT of triangles or polylines",
        ));
    }
    let written = Timings::measure(&mut timings.write, || args.write(&content))?;
    report.timings = timings;
    let within = chord.map(|chord| (chord, if is_made_anew { "input" } else { "shapes" }));
    Ok(args.conclude(&loaded.report, &written, &content.describe(), within, report))
}
