//! `indgeo info`: what a file holds.

use crate::commands::convert::pieces;
use crate::common::Common;
use crate::error::Error;
use crate::files;
use crate::input::cad::{CadModel, Choice};
use crate::input::field_model;
use crate::input::image_or_grid::refused;
use crate::input::model::{Loaded, kind};
use crate::report::write::print;
use crate::report::{Input, Outcome, Report, Results, Timings};
use industrial_geometry::io::{Content, ReadOptions, ReadReport, Scan, Shape};
use industrial_geometry::level_set::grid_file::GridFile;
use industrial_geometry::mesh::nalgebra::Point3;
use industrial_geometry::mesh::{Attributes, BoundingBox, MeshTopology, TriangleMesh};
use industrial_geometry::nurbs::{BsplineCurve, BsplineSurface, KnotVector};
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Say what files hold: points, attributes, triangles, curves and surfaces
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Exit status 0: all files were read; 2: one was not, the others are reported nevertheless; 130: interrupted.

Examples:
  indgeo info scan.ply
  indgeo info model.json --json -
  indgeo info *.ply")]
pub(crate) struct Args {
    /// Files of any format that is read; `-` is standard input
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Take commas in the numbers of tables as decimal signs, where the file leaves that open
    #[arg(long)]
    decimal_comma: bool,
    /// The scan to read of a file of several (E57, PTX): its name, its number from 0 on, or `all`
    #[arg(long, value_name = "SCAN", default_value = "all")]
    scan: String,
}

/// The facts of each file.
impl Results for Vec<Value> {}

/// Runs the command.
pub(crate) fn run(args: &Args, common: &Common, report: &mut Report) -> Result<Outcome, Error> {
    files::check_inputs(&args.files.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    let mut timings = Timings::default();
    let mut facts = Vec::new();
    let mut errors = Vec::new();
    let mut summary = String::new();
    let options =
        ReadOptions::default().with_decimal_comma(args.decimal_comma).with_scan(Some(args.scan.clone()));
    for path in &args.files {
        match facts_of(path, &options, &mut timings, report) {
            Ok(fact) => {
                // Writing to memory cannot fail.
                let _ = write_text(&mut summary, &fact);
                facts.push(fact);
            }
            Err(error) => {
                // The other files are told about nevertheless.
                facts.push(json!({ "path": path.to_string_lossy(), "error": error.to_string() }));
                errors.push(error);
            }
        }
    }
    report.timings = timings;
    report.results = Some(Box::new(facts));
    let outcome = Outcome::new(summary, true);
    if errors.is_empty() {
        return Ok(outcome);
    }
    if errors.len() < args.files.len() {
        print(common, false, &outcome, &report.warnings)?;
    }
    Err(Error::Files { errors })
}

/// The facts about a file, as the report has them: a CAD model, a cloud that is read piece by piece, or what is read as a whole.
fn facts_of(
    path: &Path,
    options: &ReadOptions,
    timings: &mut Timings,
    report: &mut Report,
) -> Result<Value, Error> {
    if let Some(cad) = Timings::measure(&mut timings.read, || CadModel::read(path, &Choice::default()))? {
        let more = cad.describe();
        let mut input = Loaded::of_cad(cad, path).input(path);
        input.role = "file";
        report.add_input(input);
        return Ok(with_path(path, json!({}), more));
    }
    if field_model::is_grid(path) {
        let grid = Timings::measure(&mut timings.read, || grid_file(path))?;
        report.add_input(Input::of_shapes("file", path, "grid", 0));
        return Ok(with_path(path, json!({ "format": files::extension(path) }), describe_grid(&grid)));
    }
    if let Some(found) = Timings::measure(&mut timings.read, || pieces::describe(path, options))? {
        told(path, &found.read, report);
        let more = describe_cloud(3, &found.read, found.read.points, &found.attributes, found.bounds);
        return Ok(with_reading(path, &found.read, more));
    }
    let loaded = Timings::measure(&mut timings.read, || files::read(path, options))?;
    told(path, &loaded.report, report);
    Ok(describe(path, &loaded.content, &loaded.report))
}

/// A grid, whatever its values are.
fn grid_file(path: &Path) -> Result<GridFile, Error> {
    GridFile::as_it_is(&files::read_bytes(path)?).map_err(|error| refused(path, &error))
}

fn describe_grid(grid: &GridFile) -> Value {
    let finite = || grid.values.iter().copied().filter(|value| value.is_finite());
    let count = finite().count();
    let [least, most] =
        finite().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
    let place = grid.place.as_ref().map(|[first, spacing]| {
        let last = grid.counts.iter().zip(first).zip(spacing);
        let last: Vec<f64> = last.map(|((n, low), step)| low + step * n.saturating_sub(1) as f64).collect();
        json!({ "min": first, "max": last })
    });
    json!({
        "kind": "grid",
        "dimension": grid.counts.len(),
        "nodes": grid.counts,
        "spacing": grid.place.as_ref().map(|[_, spacing]| spacing),
        "box": place,
        "values": (count > 0).then(|| json!({ "min": least, "max": most })),
        "non_finite": grid.values.len() - count,
        "negative": finite().filter(|value| *value < 0.0).count(),
    })
}

/// Facts behind the path of the file, and some more that come first.
fn with_path(path: &Path, first: Value, more: Value) -> Value {
    let mut fact = json!({ "path": path.to_string_lossy() });
    if let Value::Object(fact) = &mut fact {
        for part in [first, more] {
            if let Value::Object(part) = part {
                fact.extend(part);
            }
        }
    }
    fact
}

/// The same with the format, and the scans of a file of several.
fn with_reading(path: &Path, read: &ReadReport, more: Value) -> Value {
    let mut fact = with_path(path, json!({ "format": read.format.extension() }), more);
    if let Value::Object(fact) = &mut fact {
        insert_scans(fact, read);
    }
    fact
}

fn describe_cloud(
    dimension: usize,
    read: &ReadReport,
    points: usize,
    of_points: &Attributes,
    bounding_box: Option<BoundingBox>,
) -> Value {
    json!({
        "kind": "cloud",
        "dimension": dimension,
        "points": points,
        "non_finite": read.non_finite,
        "attributes": attributes(of_points),
        "bounding_box": bounds(bounding_box),
    })
}

/// Adds a file that was read, and what the reader said.
fn told(path: &Path, read: &ReadReport, report: &mut Report) {
    report.add_input(Input::new("file", path, read));
    report.warnings.extend(read.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
}

/// The facts about a file that was read as a whole.
fn describe(path: &Path, content: &Content, report: &ReadReport) -> Value {
    let more = match content {
        Content::Cloud(cloud) => {
            describe_cloud(cloud.dimension(), report, cloud.len(), cloud.attributes(), cloud.bounding_box())
        }
        Content::Mesh(mesh) => describe_mesh(mesh, report),
        Content::Nurbs(model) => {
            let shapes = model.shapes().iter().enumerate();
            let shapes: Vec<Value> =
                shapes.map(|(index, shape)| describe_shape(index, shape, model.name(index))).collect();
            json!({ "kind": "nurbs", "shapes": shapes })
        }
    };
    with_reading(path, report, more)
}

/// Adds the scans of a file of several.
fn insert_scans(fact: &mut Map<String, Value>, report: &ReadReport) {
    if !report.scans.is_empty() {
        let scan = |scan: &Scan| json!({ "index": scan.number, "name": scan.name, "points": scan.points, "pose": scan.pose });
        fact.insert("scans".to_owned(), report.scans.iter().map(scan).collect());
    }
}

fn describe_mesh(mesh: &TriangleMesh, report: &ReadReport) -> Value {
    let weld = mesh.weld();
    let corners = mesh.triangles().iter().map(|corners| corners.map(|index| weld.first[index as usize]));
    let topology = MeshTopology::of(&corners.collect::<Vec<_>>());
    json!({
        "kind": "mesh",
        "dimension": 3,
        "points": mesh.vertices().len(),
        "triangles": mesh.triangles().len(),
        "non_finite": report.non_finite,
        "attributes": attributes(mesh.attributes()),
        "bounding_box": bounds(mesh.bounding_box()),
        "area": mesh.area(),
        "is_closed": topology.is_closed(),
        "is_solid": topology.is_solid(),
        "volume": topology.is_solid().then(|| mesh.signed_volume()),
        "boundary_edges": topology.boundary_edges,
        "non_manifold_edges": topology.non_manifold_edges,
        "inconsistent_edges": topology.inconsistent_edges,
        "degenerate_triangles": topology.degenerate_triangles,
        "joined_corners": weld.joined,
    })
}

fn describe_shape(index: usize, shape: &Shape, name: Option<&str>) -> Value {
    let mut fact = json!({ "index": index, "name": name, "kind": kind(shape) });
    let more = match shape {
        Shape::Curve2(curve) => describe_curve(curve),
        Shape::Curve3(curve) => describe_curve(curve),
        Shape::Surface(surface) => describe_surface(surface),
    };
    if let (Value::Object(fact), Value::Object(more)) = (&mut fact, more) {
        fact.extend(more);
    }
    fact
}

fn describe_curve<const D: usize>(curve: &BsplineCurve<D>) -> Value {
    let points = curve.control_points().iter();
    let points = points.map(|p| Point3::from_slice(&[p[0], p[1], if D > 2 { p[D - 1] } else { 0.0 }]));
    json!({
        "dimension": D,
        "degree": [curve.degree()],
        "control_points": [curve.control_points().len()],
        "patches": curve.bezier_curves().len(),
        "domain": [interval(curve.knots())],
        "periodic": [curve.knots().is_periodic()],
        "rational": curve.weights().is_some(),
        "control_box": bounds(BoundingBox::of(&points.collect::<Vec<_>>())),
    })
}

fn describe_surface(surface: &BsplineSurface) -> Value {
    let points: Vec<Point3<f64>> = surface.control_points().iter().map(|p| Point3::from(*p)).collect();
    let directions = [surface.knots_u(), surface.knots_v()];
    json!({
        "dimension": 3,
        "degree": directions.map(KnotVector::degree),
        "control_points": [surface.n_u(), surface.n_v()],
        "patches": surface.bezier_patches().len(),
        "domain": directions.map(interval),
        "periodic": directions.map(KnotVector::is_periodic),
        "rational": surface.weights().is_some(),
        "control_box": bounds(BoundingBox::of(&points)),
    })
}

fn interval(knots: &KnotVector) -> [f64; 2] {
    [knots.domain().start(), knots.domain().end()]
}

fn attributes(attributes: &Attributes) -> Vec<String> {
    let mut names = Vec::new();
    if attributes.normals().is_some() {
        names.push("normals".to_owned());
    }
    if attributes.colours().is_some() {
        names.push("colours".to_owned());
    }
    names.extend(attributes.scalars().iter().map(|field| field.name.clone()));
    names.extend(attributes.names().map(|_| "names".to_owned()));
    names.extend(attributes.texts().iter().map(|field| field.name().to_owned()));
    names
}

fn bounds(bounds: Option<BoundingBox>) -> Value {
    match bounds {
        None => Value::Null,
        Some(bounds) => {
            let (min, max): ([f64; 3], [f64; 3]) = (bounds.min.into(), bounds.max.into());
            json!({ "min": min, "max": max, "diagonal": bounds.diagonal() })
        }
    }
}

/// The same facts for a person: one line per fact, indented below its file or shape.
fn write_text(text: &mut String, fact: &Value) -> std::fmt::Result {
    let Value::Object(fields) = fact else { return Ok(()) };
    writeln!(text, "{}", plain(&fact["path"]))?;
    let mut ordered: Vec<_> = fields.iter().filter(|(name, _)| *name != "path").collect();
    ordered.sort_by_key(|(name, _)| place(name));
    for (name, value) in ordered {
        if name == "tolerances" || name == "part_list" || name == "not_read" {
            write_list(text, name, value)?;
            continue;
        }
        if name != "shapes" && name != "scans" {
            writeln!(text, "  {:<21} {}", name.replace('_', " "), plain(value))?;
            continue;
        }
        let part = name.trim_end_matches('s');
        for shape in value.as_array().into_iter().flatten() {
            let name = shape["name"].as_str().map(|name| format!(" \"{name}\"")).unwrap_or_default();
            writeln!(text, "  {part} {}{name}", plain(&shape["index"]))?;
            let mut ordered: Vec<_> = shape.as_object().into_iter().flatten().collect();
            ordered.sort_by_key(|(name, _)| place(name));
            for (name, value) in ordered {
                if name != "index" && name != "name" {
                    writeln!(text, "    {:<19} {}", name.replace('_', " "), plain(value))?;
                }
            }
        }
    }
    Ok(())
}

/// The entries of a list, one line each; nothing of an empty one but of what was not read.
fn write_list(text: &mut String, name: &str, list: &Value) -> std::fmt::Result {
    let entries = list.as_array().map_or(&[][..], Vec::as_slice);
    if entries.is_empty() {
        return if name == "not_read" { writeln!(text, "  {:<21} none", "not read") } else { Ok(()) };
    }
    let said = |value: &Value| match value {
        Value::Null => String::new(),
        other => plain(other),
    };
    for entry in entries {
        let of = |field: &str| said(&entry[field]);
        let line = match name {
            "not_read" => format!("#{} {}: {}", of("entity"), of("type"), of("reason")),
            "part_list" => format!(
                "\"{}\": {} x, {} faces, {} closed shells",
                of("name"),
                of("instances"),
                of("faces"),
                of("closed_shells")
            ),
            _ => tolerance_line(entry),
        };
        let label = match name {
            "not_read" => "not read",
            "part_list" => "part",
            _ => "tolerance",
        };
        writeln!(text, "  {label:<21} {line}")?;
    }
    Ok(())
}

/// A tolerance or dimension: what it is, its size, datums, and where it is stated.
fn tolerance_line(entry: &Value) -> String {
    let list =
        |field: &str| entry[field].as_array().filter(|list| !list.is_empty()).map(|_| plain(&entry[field]));
    let mut line = format!("#{} {}", plain(&entry["entity"]), plain(&entry["kind"]));
    let mut add = |what: Option<String>| {
        if let Some(what) = what.filter(|what| !what.is_empty()) {
            line.push(' ');
            line.push_str(&what);
        }
    };
    add(entry["name"].as_str().filter(|name| !name.is_empty()).map(|name| format!("\"{name}\"")));
    add(entry["value"].as_f64().map(|value| value.to_string()));
    add(entry["lower"].as_f64().map(|value| format!("{value:+}")));
    add(entry["upper"].as_f64().map(|value| format!("{value:+}")));
    add(entry["fit"].as_str().map(str::to_owned));
    add(list("datums").map(|datums| format!("to {datums}")));
    add(list("modifiers").map(|modifiers| format!("({modifiers})")));
    let others = list("other_entities").map(|others| format!("entities {others}"));
    match (list("faces"), others) {
        (Some(faces), None) => format!("{line}: {faces}"),
        (Some(faces), Some(others)) => format!("{line}: {faces}; {others}"),
        (None, Some(others)) => format!("{line}: {others}"),
        (None, None) => format!("{line}: no face of its own"),
    }
}

/// The order in which a person wants to read the facts.
fn place(name: &str) -> usize {
    const ORDER: [&str; 19] = [
        "format",
        "kind",
        "dimension",
        "points",
        "nodes",
        "spacing",
        "box",
        "values",
        "triangles",
        "degree",
        "control_points",
        "patches",
        "rational",
        "periodic",
        "domain",
        "bounding_box",
        "control_box",
        "min",
        "max",
    ];
    ORDER.iter().position(|&other| other == name).unwrap_or(ORDER.len())
}

/// A value as a person writes it.
fn plain(value: &Value) -> String {
    match value {
        Value::Null => "none".to_owned(),
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(number) => number.to_string(),
        Value::Array(values) if values.is_empty() => "none".to_owned(),
        Value::Array(values) if values.iter().any(Value::is_array) => {
            values.iter().map(|value| format!("[{}]", plain(value))).collect::<Vec<_>>().join(" × ")
        }
        Value::Array(values) => values.iter().map(plain).collect::<Vec<_>>().join(", "),
        Value::Object(fields) => {
            let mut ordered: Vec<_> = fields.iter().collect();
            ordered.sort_by_key(|(name, _)| place(name));
            let parts = ordered.iter().map(|(name, value)| format!("{name} {}", plain(value)));
            parts.collect::<Vec<_>>().join("; ")
        }
    }
}
