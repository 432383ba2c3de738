//! CAD models as the shapes that fits start from and go to: B-spline surfaces of faces, curves that bound no face.

use crate::error::Error;
use crate::files;
use crate::input::cad::{CadModel, Choice};
use crate::input::model::Loaded;
use crate::report::{Input, Report, Timings};
use industrial_geometry::brep::description::{Carrier, EdgeCurve};
use industrial_geometry::io::{Content, Model, ReadOptions};
use industrial_geometry::nurbs::{Interval, ParametricCurve};
use std::path::Path;

/// Reads a CAD file as the model that it is; `None` for files of other kinds.
pub(crate) fn read_model(
    path: &Path,
    role: &'static str,
    report: &mut Report,
) -> Result<Option<CadModel>, Error> {
    let read = Timings::measure(&mut report.timings.read, || CadModel::read(path, &Choice::default()))?;
    let Some(cad) = read else { return Ok(None) };
    report.warnings.extend(cad.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
    let mut input = Loaded::of_cad(cad.clone(), path).input(path);
    input.role = role;
    report.add_input(input);
    Ok(Some(cad))
}

/// Reads a file; of a CAD file the B-splines: surfaces of faces as wholes, and curves that bound no face.
pub(crate) fn read(path: &Path, role: &'static str, report: &mut Report) -> Result<Content, Error> {
    if let Some(cad) = read_model(path, role, report)? {
        return Ok(Content::Nurbs(shapes(&cad)));
    }
    let loaded = Timings::measure(&mut report.timings.read, || files::read(path, &ReadOptions::default()))?;
    report.add_input(Input::new(role, path, &loaded.report));
    Ok(loaded.content)
}

fn shapes(cad: &CadModel) -> Model {
    let mut shapes = Vec::new();
    // Only what stands where it is: files with curves and surfaces alone have no instances elsewhere.
    for instance in cad.model.instances() {
        let (part, placement) = (&cad.model.parts()[instance.part], &instance.placement);
        let linear = placement.rotation * placement.scale;
        for face in part.faces() {
            if let Carrier::Nurbs(surface) = face.carrier()
                && let Ok(placed) = surface.transformed(&linear, &placement.translation)
            {
                shapes.push(placed.into());
            }
        }
        for edge in part.edges().iter().filter(|edge| edge.faces().next().is_none()) {
            let EdgeCurve::Nurbs(curve) = edge.curve() else { continue };
            let domain = curve.domain();
            let piece = match Interval::new(edge.range()[0], edge.range()[1]) {
                Ok(range) if range != domain => curve.trimmed(range),
                _ => Ok((**curve).clone()),
            };
            if let Ok(placed) = piece.and_then(|piece| piece.transformed(&linear, &placement.translation)) {
                shapes.push(placed.into());
            }
        }
    }
    Model::new(shapes)
}
