//! Curves in files: NURBS, CAD, SVG and DXF.

use super::CurveResult;
use crate::error::Error;
use crate::files;
use crate::fits::input::put_model;
use crate::output::cad::{CadArgs, CadFormat};
use crate::report::wording::counted;
use crate::report::{Output, Report, Timings};
use industrial_geometry::distance_field::Grid;
use industrial_geometry::io::{Model, PolylineFormat, write_polylines};
use industrial_geometry::level_set::FittedContour;
use industrial_geometry::mesh::nalgebra::Vector2;
use industrial_geometry::nurbs::{BsplineCurve, TessellationOptions};
use std::fmt::Write;
use std::path::Path;

/// Share of the tolerance by which chords may leave a curve.
const CHORD: f64 = 0.1;

/// Makes sure that curves can be written to a path, before any work is done.
pub(super) fn check_plane(path: &Path, cad: &CadArgs) -> Result<(), Error> {
    let extension = files::extension(path);
    let is_cad = CadFormat::from_extension(&extension).is_some();
    let is_known = is_cad || matches!(extension.as_str(), "json" | "svg" | "dxf") || files::is_stream(path);
    if !is_known {
        let what = "the extension names no format of curves";
        return Err(Error::content(path, what, "choose .json, .svg, .dxf, .step or .igs"));
    }
    if cad.name.is_some() {
        let what = "--name has no effect: the contours have names of their own";
        return Err(Error::usage(what, "leave it out"));
    }
    cad.check_format(is_cad)
}

/// Writes the curves. In SVG y is `top − y`.
#[expect(
    clippy::too_many_arguments,
    reason = "what is written, what it is called, where it lies, and how exact it is"
)]
pub(super) fn write_plane(
    path: &Path,
    fitted: &[FittedContour],
    results: &[CurveResult],
    grid: &Grid<2>,
    top: f64,
    tolerance: f64,
    cad: &CadArgs,
    report: &mut Report,
) -> Result<(), Error> {
    let content = counted(fitted.len(), "B-spline curve");
    let mut timings = report.timings;
    let bytes = match files::extension(path).as_str() {
        "svg" => Timings::measure(&mut timings.write, || {
            let last = grid.position(grid.values().len() - 1);
            // Pixels reach half a cell further than their centres.
            let margin = if top > last.y { 0.5 } else { 0.0 };
            let low = Vector2::new(grid.origin().x - margin, 0.0);
            let size = last - grid.origin() + Vector2::repeat(2.0 * margin);
            let text = svg(fitted, low, size, top);
            files::write(path, |out| out.write_all(text.as_bytes()))
        })?,
        "dxf" => Timings::measure(&mut timings.write, || {
            let polylines = polylines(fitted, CHORD * tolerance, path)?;
            files::write(path, |out| write_polylines(out, &polylines, PolylineFormat::Dxf))
        })?,
        _ => {
            let mut model = Model::default();
            for (contour, result) in fitted.iter().zip(results) {
                model.push(contour.curve.clone(), Some(result.name.clone()));
            }
            return put_model(path, model, cad, content, report);
        }
    };
    report.timings = timings;
    report.add_output(Output { path: path.to_path_buf(), bytes, content });
    Ok(())
}

/// Curves as polylines in the plane z = 0; closed ones end with their first vertex.
fn polylines(fitted: &[FittedContour], chord: f64, path: &Path) -> Result<Vec<Vec<[f64; 3]>>, Error> {
    let options = TessellationOptions::new(chord);
    let polyline = |contour: &FittedContour| {
        let found = contour.curve.tessellate(&options);
        let found =
            found.map_err(|error| Error::content(path, error.to_string(), "choose another --tolerance"))?;
        let mut points: Vec<[f64; 3]> = found.points.iter().map(|p| [p.x, p.y, 0.0]).collect();
        if contour.is_closed
            && let (Some(first), Some(last)) = (points.first().copied(), points.last_mut())
        {
            *last = first;
        }
        Ok(points)
    };
    fitted.iter().map(polyline).collect()
}

/// The outline of a cubic curve as an SVG path, exact.
pub(super) fn path_of(
    curve: &BsplineCurve<2>,
    is_closed: bool,
    place: impl Fn(&Vector2<f64>) -> [f64; 2],
) -> String {
    let mut text = String::new();
    for (number, piece) in curve.bezier_curves().iter().enumerate() {
        // Writing to memory cannot fail.
        let mut put = |letter: &str, p: &Vector2<f64>| {
            let [x, y] = place(p);
            let _ = write!(text, "{letter}{x} {y}");
        };
        if number == 0 {
            put("M", &piece.control_points[0]);
        }
        for (k, p) in piece.control_points[1..].iter().enumerate() {
            put(if k == 0 { " C" } else { " " }, p);
        }
    }
    if is_closed {
        text += " Z";
    }
    text
}

fn svg(fitted: &[FittedContour], low: Vector2<f64>, size: Vector2<f64>, top: f64) -> String {
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{} 0 {} {}\">\n<title>Contours; y = {top} - y of the other files</title>\n\
         <g fill=\"none\" stroke=\"#c00000\" stroke-width=\"1.5\">\n",
        low.x, size.x, size.y
    );
    for contour in fitted {
        let path = path_of(&contour.curve, contour.is_closed, |p| [p.x, top - p.y]);
        let _ = writeln!(text, "<path vector-effect=\"non-scaling-stroke\" d=\"{path}\"/>");
    }
    text + "</g>\n</svg>\n"
}
