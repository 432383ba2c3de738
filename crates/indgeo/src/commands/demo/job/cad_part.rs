//! The third part of the demonstration: a CAD part, and a scan of it whose errors are known.

use super::Data;
use super::alignment::{finish, json, write_text};
use crate::commands::inspect::job::{self as inspecting, Motion};
use crate::common::Common;
use crate::error::Error;
use crate::input::cad::{CadModel, Choice};
use crate::report::{Output, Report};
use industrial_geometry::brep::{Foot, Model, On};
use industrial_geometry::cad::description::Carrier;
use industrial_geometry::footpoint::ProjectionOptions;
use industrial_geometry::inspection::{Inspection, InspectionOptions, Tolerance};
use industrial_geometry::io::{self, Content, WriteOptions};
use industrial_geometry::mesh::PointCloud;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use std::path::{Path, PathBuf};

/// Points of the scan.
const POINTS: usize = 6000;
/// Height of the bump, and what the radius of the hole is too large by, in mm.
const BUMP: f64 = 0.2;
const HOLE: f64 = 0.08;
/// Distance in mm from the neighbouring faces within which nothing was scanned.
const MARGIN: f64 = 0.5;
/// Allowed deviation in mm.
const TOLERANCE: f64 = 0.05;
/// Names of the files: the scan, the page, the report.
pub(super) const NAMES: [&str; 3] = ["cad-scan.ply", "cad-report.html", "cad-inspection.json"];

/// A scan with what is wrong with it.
struct Scan {
    points: Vec<Point3<f64>>,
    /// The deviations that were put in.
    known: Vec<f64>,
    /// Index and number of the face that is the wall of the hole.
    hole: (usize, u64),
}

/// Makes the scan, inspects it, and adds the files to the report. Returns a text for a person, and whether what was found is what
/// was put in.
pub(crate) fn run(
    data: &Data,
    folder: &Path,
    options: &ProjectionOptions,
    common: &Common,
    report: &mut Report,
) -> Result<(String, bool), Error> {
    let [points, page, found]: [PathBuf; 3] = NAMES.map(|name| folder.join(name));
    let repository = "take the file from the repository";
    let cad = CadModel::read(&data.part, &Choice::default())?
        .ok_or_else(|| Error::content(&data.part, "this is no CAD file", repository))?;
    let scan = scan(&cad.model)
        .ok_or_else(|| Error::content(&data.part, "the part has no plane and no hole", repository))?;
    let content = Content::Cloud(PointCloud::new(scan.points.clone()));
    let written = io::write(&points, &content, &WriteOptions::default())?;
    let text = "a scan of the CAD part with a bump and a wrong hole".to_owned();
    report.add_output(Output { path: points.clone(), bytes: written.bytes, content: text });

    let tolerance = Tolerance::symmetric(TOLERANCE)
        .map_err(|error| Error::usage(error.to_string(), "see `indgeo inspect --help`"))?;
    let mut judged = Report::of_command("inspect");
    let job = inspecting::Job {
        model: &data.part,
        cad: &Choice::default(),
        points: std::slice::from_ref(&points),
        range: None,
        picture: inspecting::MOST_POINTS,
        scan: None,
        motion: Motion::None,
        page: Some(&page),
        out: None,
        format: None,
        options: InspectionOptions::new(tolerance).with_projection(*options),
        mode: "certified",
        drop_non_finite: false,
        threads: common.threads,
        quiet: common.quiet,
    };
    let inspection = inspecting::run(&job, &mut judged)?;
    finish(&mut judged, if inspection.verdict.pass { ("done", 0) } else { ("out_of_tolerance", 1) });
    let bytes = write_text(&found, &json(&judged, &found)?)?;
    report.outputs.append(&mut judged.outputs);
    report.add_output(Output { path: found, bytes, content: "report of the inspection".to_owned() });
    Ok(explain(data, &scan, &inspection, &points, &page))
}

/// Points on the part, on the wall of its largest hole and on its largest plane moved along the normal.
fn scan(model: &Model) -> Option<Scan> {
    let samples = model.samples(POINTS);
    let feet: Vec<(Foot, usize)> = samples
        .iter()
        .filter_map(|sample| match model.nearest(&sample.point)? {
            foot @ Foot { on: On::Face { face, .. }, .. } => Some((foot, face)),
            _ => None,
        })
        .collect();
    let part = model.parts().first()?;
    let area = |face: &usize| part.area(*face);
    let faces = || 0..part.faces().len();
    let plane = faces()
        .filter(|face| matches!(part.faces()[*face].carrier(), Carrier::Plane { .. }))
        .max_by(|a, b| area(a).total_cmp(&area(b)))?;
    let is_hole = |face: &usize| match part.faces()[*face].carrier() {
        Carrier::Cylinder { frame, .. } => {
            feet.iter().find(|foot| foot.1 == *face).is_some_and(|(foot, _)| {
                let away = foot.point - frame.origin();
                (away - frame.z() * away.dot(&frame.z())).dot(&foot.normal) < 0.0
            })
        }
        _ => false,
    };
    let hole = faces().filter(is_hole).max_by(|a, b| area(a).total_cmp(&area(b)))?;
    // How far each point is from the other faces.
    let margin = |of: &(Foot, usize)| {
        let others = feet.iter().filter(|foot| foot.1 != of.1);
        others.map(|foot| (foot.0.point - of.0.point).norm()).fold(f64::INFINITY, f64::min)
    };
    let margins: Vec<f64> = feet.iter().map(margin).collect();
    let on_plane = feet.iter().zip(&margins).filter(|(foot, _)| foot.1 == plane);
    let (centre, reach) =
        on_plane.max_by(|a, b| a.1.total_cmp(b.1)).map(|(foot, reach)| (foot.0.point, 0.8 * reach))?;
    let mut out = Scan { points: Vec::new(), known: Vec::new(), hole: (hole, part.faces()[hole].source()) };
    for ((foot, face), margin) in feet.iter().zip(&margins) {
        if *margin < MARGIN {
            continue;
        }
        let known = if *face == hole {
            // The wall lies deeper in the material.
            -HOLE
        } else if *face == plane {
            bump(&(foot.point - centre), reach)
        } else {
            0.0
        };
        out.points.push(Point3::from(foot.point + foot.normal * known));
        out.known.push(known);
    }
    Some(out)
}

/// A smooth bump of the given radius.
fn bump(away: &Vector3<f64>, reach: f64) -> f64 {
    let share = away.norm_squared() / (reach * reach);
    if share < 1.0 { BUMP * (1.0 - share) * (1.0 - share) } else { 0.0 }
}

/// What was put in beside what was found, and whether they are the same.
fn explain(data: &Data, scan: &Scan, inspection: &Inspection, points: &Path, page: &Path) -> (String, bool) {
    let known = |wanted: fn(f64, f64) -> f64| scan.known.iter().copied().fold(0.0, wanted);
    let (low, high) = (known(f64::min), known(f64::max));
    let over = scan.known.iter().filter(|known| known.abs() > TOLERANCE).count();
    let hole = inspection.shapes.iter().find(|shape| shape.index as usize == scan.hole.0);
    let on_hole = hole.and_then(|shape| shape.deviations.distance.as_ref());
    let mean = on_hole.map_or(f64::NAN, |distance| distance.mean);
    let total = inspection.total.distance.as_ref();
    let (min, max) = total.map_or((f64::NAN, f64::NAN), |distance| (distance.min, distance.max));
    let outside = inspection.verdict.judged - inspection.verdict.within;
    let same = |a: f64, b: f64| (a - b).abs() < 1e-9;
    let is_found = same(mean, low) && same(min, low) && same(max, high) && outside == over as u64;
    let text = format!(
        "Then a CAD part (STEP, {} with holes and fillets) and a scan of it whose errors are known, {} points:\n  \
         {:<44}{:>10}{:>12}\n  {:<44}{:>10.4}{:>12.4}\n  {:<44}{:>10.4}{:>12.4}\n  {:<44}{:>10}{:>12}\n\
         Open {}: the bump and the wall of the hole stand out on the shaded part.\n\n\
         The same by hand:\n  indgeo inspect {} {} --tolerance {TOLERANCE} --report report.html\n",
        "a bracket",
        scan.points.len(),
        "",
        "put in",
        "found",
        "height of the bump, mm",
        high,
        max,
        format!("deviation of the hole (face #{}), mm", scan.hole.1),
        low,
        mean,
        format!("points beyond ±{TOLERANCE} mm"),
        over,
        outside,
        page.display(),
        data.part.display(),
        points.display(),
    );
    (text, is_found)
}
