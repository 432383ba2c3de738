//! CAD models from one format to the other.

use crate::commands::convert::ConvertResults;
use crate::error::Error;
use crate::files;
use crate::output::cad::{self as cad_output, CadArgs, CadFormat, describe_counts};
use crate::report::wording::counted;
use crate::report::{Input, Outcome, Output, Report, Timings};
use industrial_geometry::cad::description::{ModelDescription, PartDescription, Unread};
use industrial_geometry::cad::{is_iges, read_iges};
#[cfg(feature = "step")]
use industrial_geometry::cad::{is_step, read_step};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

/// Bytes by which a CAD file is recognised.
const HEAD: u64 = 4096;

/// Whether bytes are those of a CAD file that is read.
pub(crate) fn is_cad(bytes: &[u8]) -> bool {
    #[cfg(feature = "step")]
    if is_step(bytes) {
        return true;
    }
    is_iges(bytes)
}

/// Whether the bytes of an input are to be read before its format is known: it begins like a CAD file, or is a stream, which
/// can be read only once.
pub(crate) fn is_read_as_bytes(path: &Path) -> bool {
    let is_pipe = std::fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir());
    if is_pipe || files::is_stream(path) {
        return true;
    }
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    read.is_ok() && is_cad(&head)
}

/// Reads a CAD file.
pub(crate) fn read(bytes: &[u8], path: &Path) -> Result<(ModelDescription, &'static str), Error> {
    #[cfg(feature = "step")]
    if is_step(bytes) {
        let model = read_step(bytes).map_err(|error| Error::cad(error, path))?;
        return Ok((model, "step"));
    }
    let model = read_iges(bytes).map_err(|error| Error::cad(error, path))?;
    Ok((model, "igs"))
}

/// Reads a CAD file and writes its faces and curves in another CAD format.
pub(crate) fn run(
    input: &Path,
    bytes: &[u8],
    output: &Path,
    format: CadFormat,
    cad: &CadArgs,
    report: &mut Report,
) -> Result<Outcome, Error> {
    let (mut model, read_as) = Timings::measure(&mut report.timings.read, || read(bytes, input))?;
    let count = |of: fn(&PartDescription) -> usize| model.parts.iter().map(of).sum::<usize>();
    let shapes = count(|part| part.faces.len()) + count(|part| part.curves.len());
    report.add_input(Input::of_shapes("file", input, read_as, shapes));
    match (&model.unit, &cad.unit) {
        (Some(stated), Some(_)) => {
            let what = format!("--unit is for files that state no unit; this one is in {}", stated.name);
            return Err(Error::content(input, what, "leave --unit out"));
        }
        (None, Some(unit)) => model.unit = Some(unit.clone()),
        (_, None) => {}
    }
    if let Some(name) = &cad.name {
        model.name.clone_from(name);
    }
    let lost = warn_unread(input, &model.unread, report);
    let content = describe_counts(&model);
    let mut warnings = Vec::new();
    let bytes = Timings::measure(&mut report.timings.write, || {
        cad_output::write(output, format, model, &mut warnings)
    })?;
    report.warnings.extend(warnings.iter().map(|warning| format!("{}: {warning}", output.display())));
    report.add_output(Output { path: output.to_path_buf(), bytes, content: content.clone() });
    report.results = Some(Box::new(ConvertResults {
        format: format.extension(),
        points: 0,
        triangles: 0,
        shapes,
        polylines: 0,
        chord: None,
    }));
    let summary = format!(
        "{}: {content} as {}, {}{}",
        output.display(),
        format.extension().to_ascii_uppercase(),
        counted(bytes, "byte"),
        if lost > 0 { format!("; not read: {}", counted(lost, "shape")) } else { String::new() }
    );
    Ok(Outcome { summary, converged: lost == 0, otherwise: "incomplete" })
}

/// Says what was not read, one line for each kind and reason; returns how many of it are shapes of the model. Hidden shapes,
/// free points and annotations are none.
pub(crate) fn warn_unread(path: &Path, unread: &[Unread], report: &mut Report) -> usize {
    let is_aside = |why: &str| ["the file hides it", "a free point", "an annotation"].contains(&why);
    let mut kinds: BTreeMap<(&str, &str), (usize, u64)> = BTreeMap::new();
    for one in unread {
        kinds.entry((&one.kind, &one.why)).or_insert((0, one.source)).0 += 1;
    }
    for ((kind, why), (count, first)) in &kinds {
        report.warnings.push(format!(
            "{}: {} left out, {kind}, the first is {first}: {why}",
            path.display(),
            counted(count, "entity").replace("entitys", "entities")
        ));
    }
    unread.iter().filter(|one| !is_aside(&one.why)).count()
}
