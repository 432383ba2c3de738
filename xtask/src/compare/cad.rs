//! `cargo xtask compare cad`: STEP and IGES files that are written here, as OpenCASCADE reads them.
//!
//! The script `xtask/compare/cad.py` reads the files; `PYTHON` names the interpreter, in which cadquery-ocp must be installed. It fails if a
//! shape is not valid, a name or the unit is lost, a number of a B-spline differs, or an area differs by more than 1e-9 of it.

use crate::{Failure, workspace};
use cad_io::description::{
    Carrier, EdgeCurve, EdgeDescription, EdgeUse, LengthUnit, LoopDescription, ModelDescription,
    VertexDescription,
};
use cad_io::{ModelBuilder, read_iges_file, to_iges, to_step};
use nalgebra::Vector3;
use nurbs_core::{
    AnalyticSurface, BsplineSurface, Cone, Cylinder, Direction, Frame, Interval, KnotVector, ParametricCurve,
    Plane, Sphere, Torus, area,
};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

const INSTALL: &str =
    "install it (`python3 -m venv venv && venv/bin/pip install cadquery-ocp`) and set PYTHON=venv/bin/python";
/// Largest relative difference of areas.
const AREA: f64 = 1e-9;

/// A file, and what must be found in it.
struct Case {
    path: PathBuf,
    model: ModelDescription,
    /// Area of its only face in mm², where it is known.
    area: Option<f64>,
    /// OpenCASCADE keeps the numbers of STEP files; of IGES files it makes surfaces of its own.
    exact: bool,
}

/// Runs the command.
pub(crate) fn run() -> Result<(), Failure> {
    let out = std::env::temp_dir().join(format!("compare-cad-{}", std::process::id()));
    let failed = |error: std::io::Error| Failure::Failed(format!("{}: {error}", out.display()));
    std::fs::create_dir_all(&out).map_err(failed)?;
    let result = cases(&out).and_then(|cases| compare(&cases));
    std::fs::remove_dir_all(&out).map_err(failed)?;
    result
}

fn failure(error: &dyn std::fmt::Display) -> Failure {
    Failure::Failed(error.to_string())
}

fn cases(out: &Path) -> Result<Vec<Case>, Failure> {
    let mut cases = Vec::new();
    let mut add = |name: &str, model: ModelDescription, area: Option<f64>| -> Result<(), Failure> {
        for extension in ["step", "igs"] {
            let path = out.join(format!("{name}.{extension}"));
            let exact = extension == "step";
            let bytes =
                if exact { to_step(&model) } else { to_iges(&model) }.map_err(|error| failure(&error))?;
            std::fs::write(&path, bytes).map_err(|error| failure(&error))?;
            cases.push(Case { path, model: model.clone(), area, exact });
        }
        Ok(())
    };
    for unit in [LengthUnit::millimetre(), LengthUnit::metre(), LengthUnit::inch()] {
        let name = format!("vane_{}", unit.name);
        let scale = (unit.metres * 1e3).powi(2);
        let (model, area) = vane(unit).map_err(|error| failure(&error))?;
        add(&name, model, Some(area * scale))?;
    }
    for (name, surface) in primitives().map_err(|error| failure(&error))? {
        let area = area(&surface, 1e-12).value;
        let mut model = ModelBuilder::new(name, Some(LengthUnit::millimetre()));
        model.analytic(format!("exact {name}"), &surface).map_err(|error| failure(&error))?;
        add(name, model.finish(), Some(area))?;
        let spline = surface.to_nurbs().map_err(|error| failure(&error))?;
        let mut model = ModelBuilder::new(name, Some(LengthUnit::millimetre()));
        model.surface(format!("spline {name}"), spline);
        add(&format!("{name}_spline"), model.finish(), Some(area))?;
    }
    let impeller = workspace::root().join("fixtures/cad/impeller.igs");
    add("impeller", read_iges_file(&impeller).map_err(|error| failure(&error))?, None)?;
    Ok(cases)
}

fn primitives() -> Result<Vec<(&'static str, AnalyticSurface)>, nurbs_core::Error> {
    let frame = Frame::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(1.0, 1.0, 0.5), Vector3::x())?;
    Ok(vec![
        ("plane", Plane::new(frame, Interval::new(-1.0, 2.0)?, Interval::new(0.5, 3.0)?).into()),
        ("cylinder", Cylinder::new(frame, 1.5, Interval::new(-1.0, 4.0)?)?.into()),
        ("frustum", Cone::new(frame, 2.0, 1.0, 3.0)?.into()),
        ("cone", Cone::new(frame, 2.0, 0.0, 3.0)?.into()),
        ("sphere", Sphere::new(frame, 2.0)?.into()),
        ("torus", Torus::new(frame, 5.0, 1.0)?.into()),
        ("quarter", Cylinder::new(frame, 1.5, Interval::UNIT)?.with_angles(Interval::new(0.5, 2.0)?)?.into()),
    ])
}

/// A rational surface with a hole along lines of its parameters, and its area.
fn vane(unit: LengthUnit) -> Result<(ModelDescription, f64), nurbs_core::Error> {
    let knots = || KnotVector::new(3, vec![0.1, 0.1, 0.1, 0.1, 0.37, 1.3, 1.3, 1.3, 1.3]);
    let point = |k: usize| {
        let (x, y) = ((k / 5) as f64 * 10.0 / 3.0 + 0.1, (k % 5) as f64 * 7.0 / 3.0 - 0.2);
        Vector3::new(x, y, (0.7 * x).sin() + 0.1 * y * y)
    };
    let weights = (0..25).map(|k| 1.0 + 0.3 * ((k / 5) * (k % 5)) as f64 / 7.0).collect();
    let surface = BsplineSurface::new(knots()?, knots()?, (0..25).map(point).collect(), Some(weights))?;
    let inner = Interval::new(0.4, 0.9)?;
    let hole = surface.trimmed(Direction::U, inner)?.trimmed(Direction::V, inner)?;
    let size = area(&surface, 1e-12).value - area(&hole, 1e-12).value;
    let mut model = ModelBuilder::new("Vane-1", Some(unit));
    model.surface("pressure side", surface.clone());
    let mut model = model.finish();
    let part = &mut model.parts[0];
    for interval in [Interval::new(0.1, 1.3)?, inner] {
        let first = part.vertices.len();
        let (a, b) = (interval.start(), interval.end());
        for (u, v) in [(a, a), (b, a), (b, b), (a, b)] {
            let point = nurbs_core::ParametricSurface::point(&surface, u, v);
            part.vertices.push(VertexDescription { source: 0, point });
        }
        let sides = [
            (Direction::V, a, 0, 1, true),
            (Direction::U, b, 1, 2, true),
            (Direction::V, b, 3, 2, false),
            (Direction::U, a, 0, 3, false),
        ];
        let mut uses = Vec::new();
        for (held, at, start, end, forward) in sides {
            let curve = surface.iso_curve(held, at)?.trimmed(interval)?;
            let domain = curve.domain();
            part.edges.push(EdgeDescription {
                source: 0,
                curve: EdgeCurve::Nurbs(Arc::new(curve)),
                range: [domain.start(), domain.end()],
                start: Some(first + start),
                end: Some(first + end),
            });
            uses.push(EdgeUse { edge: part.edges.len() - 1, forward, pcurve: None });
        }
        part.faces[0].loops.push(LoopDescription::Edges(uses));
    }
    Ok((model, size))
}

/// What the script prints for one file.
struct Theirs {
    about: Value,
    faces: Vec<Value>,
}

fn theirs(cases: &[Case]) -> Result<Vec<Theirs>, Failure> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut command = Command::new(&python);
    command.arg(workspace::root().join("xtask/compare/cad.py")).args(cases.iter().map(|case| &case.path));
    let output = command.output().map_err(|error| {
        Failure::Failed(format!("{} did not start: {error}; {INSTALL}", python.to_string_lossy()))
    })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.trim_end().lines().last().unwrap_or_default();
        return Err(Failure::Failed(format!("the script failed: {last}; {INSTALL}")));
    }
    let mut found: Vec<Theirs> = Vec::new();
    // OpenCASCADE prints remarks of its own in between.
    for line in String::from_utf8_lossy(&output.stdout).lines().filter(|line| line.starts_with('{')) {
        let value: Value = serde_json::from_str(line).map_err(|error| failure(&error))?;
        match found.last_mut() {
            Some(last) if value["path"].is_null() => last.faces.push(value),
            _ => found.push(Theirs { about: value, faces: Vec::new() }),
        }
    }
    Ok(found)
}

fn compare(cases: &[Case]) -> Result<(), Failure> {
    let all = theirs(cases)?;
    let mut faults = Vec::new();
    println!(
        "| file | faces | valid | splines | largest difference | area difference |\n|---|---|---|---|---|---|"
    );
    for (case, theirs) in cases.iter().zip(&all) {
        let name = case.path.file_name().unwrap_or_default().to_string_lossy();
        let mut fault = |what: String| faults.push(format!("{name}: {what}"));
        let part = &case.model.parts[0];
        let valid = theirs.about["valid"].as_bool() == Some(true);
        if theirs.faces.len() != part.faces.len() {
            fault(format!("{} faces, not {}", theirs.faces.len(), part.faces.len()));
        }
        let unit = case.model.unit.clone().unwrap_or_else(LengthUnit::millimetre);
        if case.exact {
            let told = theirs.about["unit"].as_str().unwrap_or_default().to_lowercase();
            let wanted = match unit.name.as_str() {
                "mm" => "millimetre",
                "m" => "metre",
                other => other,
            };
            if told != wanted {
                fault(format!("the unit is {told}, not {wanted}"));
            }
            if theirs.about["product"][0].as_str() != Some(&case.model.name) {
                fault(format!("the product is {}", theirs.about["product"]));
            }
        }
        let scale = unit.metres * 1e3;
        let (mut splines, mut largest): (usize, f64) = (0, 0.0);
        for (ours, face) in part.faces.iter().zip(&theirs.faces) {
            if case.exact && face["name"].as_str() != Some(&ours.name) {
                fault(format!("face \"{}\" is called {}", ours.name, face["name"]));
            }
            // OpenCASCADE makes closed surfaces periodic, with other knots and control points.
            let Carrier::Nurbs(surface) = &ours.carrier else { continue };
            let closed = |direction| surface.is_closed(direction, 1e-9).unwrap_or(false);
            if case.exact && !closed(Direction::U) && !closed(Direction::V) {
                splines += 1;
                largest = largest.max(difference(surface, &face["spline"], scale));
            }
        }
        let found: f64 = theirs.faces.iter().filter_map(|face| face["area"].as_f64()).sum();
        let off = case.area.map(|area| (found / area - 1.0).abs());
        // Whole models of other programs have gaps that OpenCASCADE may refuse.
        if !valid && case.area.is_some() {
            fault("the shape is not valid".to_owned());
        }
        if largest > 0.0 && scale == 1.0 {
            fault(format!("numbers of B-splines differ by {largest}"));
        }
        if off.is_some_and(|off| off > AREA) {
            fault(format!("the area is {found}, not {:?}", case.area));
        }
        let off = off.map_or_else(|| format!("{found}"), |off| format!("{off:.1e}"));
        println!("| {name} | {} | {valid} | {splines} | {largest:e} | {off} |", theirs.faces.len());
    }
    if all.len() != cases.len() {
        faults.push(format!("{} files were read of {}", all.len(), cases.len()));
    }
    if faults.is_empty() { Ok(()) } else { Err(Failure::Failed(faults.join("\n"))) }
}

/// Largest difference of control points, weights and knots; infinite where their numbers differ.
fn difference(surface: &BsplineSurface, theirs: &Value, scale: f64) -> f64 {
    let points =
        surface.control_points().iter().flat_map(|p| [p.x * scale, p.y * scale, p.z * scale]).collect();
    let weights =
        (0..surface.control_points().len()).map(|k| surface.weights().map_or(1.0, |w| w[k])).collect();
    let ours: [(&str, Vec<f64>); 4] = [
        ("points", points),
        ("weights", weights),
        ("knots_u", surface.knots_u().as_slice().to_vec()),
        ("knots_v", surface.knots_v().as_slice().to_vec()),
    ];
    let mut largest: f64 = 0.0;
    for (field, ours) in ours {
        let theirs: Vec<f64> = theirs[field]
            .as_array()
            .map_or_else(Vec::new, |list| list.iter().filter_map(Value::as_f64).collect());
        if theirs.len() != ours.len() {
            return f64::INFINITY;
        }
        largest = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(largest, f64::max);
    }
    largest
}
