//! STEP files (ISO 10303-21) through the crate `step-io`.
//!
//! The crate reads the text into entities and drops what it cannot use, with reasons; here its entities become
//! descriptions. Elementary surfaces stay what they are, B-splines keep their numbers to the bit, extrusions and
//! revolutions become B-splines exactly, offsets of free-form surfaces within 1e-8 of their size.

mod assembly;
mod curve;
mod keys;
mod numbers;
mod offset;
mod pmi;
mod reader;
mod records;
mod surface;
mod undefined;

use crate::{Error, Location, Place};
use assembly::Assembly;
use brep_core::description::{LengthUnit, ModelDescription, Unread};
use numbers::EntityNumbers;
use reader::Reader;
use std::cell::RefCell;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use step_io::scene::Unit;

/// Parts of the names of types whose loss is told.
const SHAPE_TYPES: [&str; 16] = [
    "FACE",
    "EDGE",
    "SURFACE",
    "CURVE",
    "SHELL",
    "BREP",
    "LOOP",
    "VERTEX",
    "LINE",
    "CIRCLE",
    "ELLIPSE",
    "PLANE",
    "PARABOLA",
    "HYPERBOLA",
    "MAPPED_ITEM",
    "ASSEMBLY_USAGE",
];

/// Whether bytes look like a STEP file.
#[must_use]
pub fn is_step(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1024)];
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
    start.starts_with(b"ISO-10303-21")
}

/// Reads a STEP file from bytes.
///
/// Assemblies come out as parts with instances. What holds geometry and cannot be used is listed in
/// [`ModelDescription::unread`].
///
/// # Errors
/// [`Error::Malformed`] for bytes that are no STEP file, [`Error::Unsupported`] for a file without any shape.
pub fn read_step(bytes: &[u8]) -> Result<ModelDescription, Error> {
    // Damaged files must not end the program, whatever they meet in the library.
    catch_unwind(AssertUnwindSafe(|| read(bytes))).unwrap_or_else(|_| {
        Err(malformed(
            Place::Whole,
            "the STEP library failed on this file".to_owned(),
            "the file is damaged, export it again",
        ))
    })
}

/// Reads a STEP file.
///
/// # Errors
/// [`Error::Io`], and as [`read_step`]; the message names the file.
pub fn read_step_file(path: &Path) -> Result<ModelDescription, Error> {
    let bytes =
        std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), action: "read", source })?;
    read_step(&bytes).map_err(|error| error.in_file(path))
}

fn read(bytes: &[u8]) -> Result<ModelDescription, Error> {
    if !is_step(bytes) {
        let what = "the file does not begin with ISO-10303-21, as STEP files do".to_owned();
        return Err(malformed(Place::Whole, what, "give a STEP file"));
    }
    let (model, report) = step_io::read(bytes).map_err(|error| parse_error(bytes, &error))?;
    let dropped: HashSet<u64> = report.dropped.iter().map(|(number, _)| *number).collect();
    let numbers = EntityNumbers::scan(bytes, &dropped);
    let scene = model.scene();
    let units = scene.units();
    let angle = units.angle.as_ref().map_or(1.0, |unit| unit.to_si);
    let reader = Reader {
        scene: &scene,
        model: &model,
        angle,
        numbers: &numbers,
        unread: RefCell::new(Vec::new()),
        converted: RefCell::new(Vec::new()),
    };
    let assembly = Assembly::of(&reader).map_err(|what| Error::Unsupported {
        location: Location { file: None, place: Place::Whole },
        what,
        advice: "export the part alone".to_owned(),
    })?;
    let mut unread = reader.unread.take();
    for (number, reason) in &report.dropped {
        let kind = numbers.dropped_kind(*number);
        if SHAPE_TYPES.iter().any(|part| kind.contains(part)) && !kind.contains("STYLE") {
            unread.push(Unread { source: *number, kind: kind.to_owned(), why: reason.to_string() });
        }
    }
    // What was dropped only because of something else comes after that.
    let is_cascade = |one: &Unread| one.why.starts_with("cascade");
    if unread.iter().any(is_cascade) {
        let all: Vec<u64> = report.dropped.iter().map(|(number, _)| *number).collect();
        let roots = undefined::find(bytes, &numbers, &all);
        unread.retain(|one| roots.iter().all(|root| root.source != one.source));
        unread.extend(roots);
    }
    unread.sort_by_key(is_cascade);
    if assembly.parts.is_empty() {
        return Err(empty(&unread));
    }
    let name = model.header().file_name.clone();
    let unit = units.length.as_ref().and_then(length_unit);
    let faces = assembly.parts.iter().flat_map(|part| &part.faces).map(|face| face.source).collect();
    let tolerances = pmi::read(bytes, unit.as_ref(), &faces);
    Ok(ModelDescription {
        name,
        unit,
        uncertainty: units.precision.filter(|p| *p > 0.0 && p.is_finite()),
        parts: assembly.parts,
        instances: assembly.instances,
        unread,
        converted: reader.converted.take(),
        tolerances,
    })
}

fn length_unit(unit: &Unit) -> Option<LengthUnit> {
    let metres = unit.to_si;
    if !(metres > 0.0 && metres.is_finite()) {
        return None;
    }
    let known = [LengthUnit::millimetre(), LengthUnit::metre(), LengthUnit::inch()];
    let same = |k: &LengthUnit| (metres / k.metres - 1.0).abs() < 1e-12;
    // The known value: 25.4 · 0.001 is not the nearest number to 0.0254.
    Some(
        known.into_iter().find(same).unwrap_or_else(|| LengthUnit { name: unit.name.to_lowercase(), metres }),
    )
}

fn malformed(place: Place, what: String, advice: &str) -> Error {
    Error::Malformed { location: Location { file: None, place }, what, advice: advice.to_owned() }
}

fn parse_error(bytes: &[u8], error: &step_io::Error) -> Error {
    if matches!(error, step_io::Error::UnexpectedEof { .. }) {
        let last = 1 + bytes.trim_ascii_end().iter().filter(|byte| **byte == b'\n').count();
        let what = "the file ends in the middle of its data".to_owned();
        return malformed(Place::Line(last), what, "the file is truncated: export or copy it again");
    }
    let line = |line: u32| Place::Line(line as usize);
    let place = match error {
        step_io::Error::Lex(e) => line(e.span.line),
        step_io::Error::UnexpectedToken { span, .. }
        | step_io::Error::MalformedFileSchema { span }
        | step_io::Error::InvalidAttributePosition { span, .. }
        | step_io::Error::NestingTooDeep { span }
        | step_io::Error::TooLarge { span } => line(span.line),
        step_io::Error::DuplicateEntityId { line: at, .. } => line(*at),
        _ => Place::Whole,
    };
    malformed(place, error.to_string(), "the file is damaged, export it again")
}

fn empty(unread: &[Unread]) -> Error {
    let what = match unread.first() {
        None => "the file holds no solids, surfaces or curves".to_owned(),
        Some(first) => format!(
            "nothing of the file can be used: {} entities were left out, the first is #{} ({}): {}",
            unread.len(),
            first.source,
            first.kind,
            first.why
        ),
    };
    Error::Unsupported {
        location: Location {
            file: None,
            place: unread.first().map_or(Place::Whole, |first| Place::Entity(first.source)),
        },
        what,
        advice: "export the part as solids or surfaces".to_owned(),
    }
}
