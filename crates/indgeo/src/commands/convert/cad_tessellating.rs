//! CAD models as triangles, for programs that know no faces with loops.

use crate::commands::convert::ConvertResults;
use crate::commands::convert::cad::{read, warn_unread};
use crate::error::Error;
use crate::files;
use crate::report::wording::counted;
use crate::report::{Input, Outcome, Output, Report, Timings};
use industrial_geometry::brep::Model;
use industrial_geometry::io::{Content, WriteOptions};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::mesh::nalgebra::Point3;
use std::path::Path;

/// Chord tolerance where none is given, as a share of the diagonal of the box around the model.
const DEFAULT_CHORD: f64 = 1e-3;

/// Reads a CAD file and writes triangles that stay within `chord` of its faces, a thousandth of its size without.
pub(crate) fn run(
    input: &Path,
    bytes: &[u8],
    output: &Path,
    options: &WriteOptions,
    chord: Option<f64>,
    report: &mut Report,
) -> Result<Outcome, Error> {
    let (description, read_as) = Timings::measure(&mut report.timings.read, || read(bytes, input))?;
    let advice = "check it with `indgeo info`";
    let failed = |what: String| Error::content(input, what, advice);
    let model = Timings::measure(&mut report.timings.build, || Model::new(&description))
        .map_err(|error| failed(error.to_string()))?;
    let faces: usize = model.instances().iter().map(|i| model.parts()[i.part].faces().len()).sum();
    report.add_input(Input::of_shapes("file", input, read_as, faces));
    if faces == 0 {
        return Err(failed("the model has no faces, which triangles could show".to_owned()));
    }
    let chord = chord.unwrap_or_else(|| DEFAULT_CHORD * model.bounds().diagonal());
    let found = Timings::measure(&mut report.timings.compute, || model.tessellate(chord));
    let found = found.map_err(|error| failed(error.to_string()))?;
    let vertices: Vec<_> = found.vertices.into_iter().map(Point3::from).collect();
    let count = found.triangles.len();
    let mesh = TriangleMesh::new(vertices, found.triangles).map_err(|error| failed(error.to_string()))?;
    let content = Content::Mesh(mesh);
    let lost = warn_unread(input, model.unread(), report);
    let is_near = found.deviation <= chord;
    if !is_near {
        report.warnings.push(format!(
            "{}: the triangles are up to {:.3e} from the faces, more than the chord tolerance {chord} (exit status 1)",
            output.display(),
            found.deviation
        ));
    }
    if let Some(unit) = model.unit() {
        report.warnings.push(format!(
            "{}: the coordinates are in {}, which this format does not state",
            output.display(),
            unit.name
        ));
    }
    let written =
        Timings::measure(&mut report.timings.write, || files::write_content(output, &content, options))?;
    report.warnings.extend(written.warnings.iter().map(|warning| format!("{}: {warning}", output.display())));
    report.add_output(Output {
        path: output.to_path_buf(),
        bytes: written.bytes,
        content: content.describe(),
    });
    report.results = Some(Box::new(ConvertResults {
        format: written.format.extension(),
        points: written.points,
        triangles: written.triangles,
        shapes: 0,
        polylines: 0,
        chord: Some(chord),
    }));
    let summary = format!(
        "{}: {} over {} as {}, {}; within {:.3e} of them where it was measured{}",
        output.display(),
        counted(count, "triangle"),
        counted(faces, "face"),
        written.format.extension().to_ascii_uppercase(),
        counted(written.bytes, "byte"),
        found.deviation,
        if lost > 0 { format!("; not read: {}", counted(lost, "shape")) } else { String::new() }
    );
    let otherwise = if lost > 0 { "incomplete" } else { "not_converged" };
    Ok(Outcome { summary, converged: lost == 0 && is_near, otherwise })
}
