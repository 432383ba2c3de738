//! A whole file: which entities are shapes of the model, and which are left out.

use super::curves::{self, is_curve};
use super::directory::Entry;
use super::fault::Fault;
use super::file::File;
use super::solids;
use super::surfaces::is_surface;
use super::trims;
use crate::{Error, Location, Place};
use brep_core::description::{
    FreeCurve, InstanceDescription, ModelDescription, PartDescription, Placement, ShellDescription, Unread,
};
use std::path::Path;

/// Reads an IGES file from bytes: 5.3 and older, fixed format ASCII.
///
/// Faces come from trimmed and bounded surfaces (types 144 and 143), planes with a boundary (108), whole surfaces (114, 118,
/// 120, 122, 128) and solids (186 with shells 514, whose faces share edges); free curves from 100, 102, 104, 106, 110,
/// 112 and 126. Transformation matrices (124) are applied. B-splines keep their numbers to the bit; planes, cylinders,
/// cones, spheres and tori that surfaces of revolution make become those. A boundary that the file gives in the parameters
/// of its surface only is lifted into space within a billionth of its size.
///
/// What holds geometry and is not read is listed in [`ModelDescription::unread`] with its type number: entities of other
/// types, hidden ones, free points. Groups (402) and colours (314) are ignored.
///
/// # Errors
/// [`Error::Malformed`] with line and entity for bytes that break the rules of the format, [`Error::Unsupported`] for the
/// binary and compressed forms and for a file without any face or curve.
pub fn read_iges(data: &[u8]) -> Result<ModelDescription, Error> {
    read(data).map_err(Error::from)
}

/// Reads an IGES file.
///
/// # Errors
/// [`Error::Io`], and as [`read_iges`]; the message names the file.
pub fn read_iges_file(path: &Path) -> Result<ModelDescription, Error> {
    let data =
        std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), action: "read", source })?;
    read_iges(&data).map_err(|error| error.in_file(path))
}

impl From<Fault> for Error {
    fn from(fault: Fault) -> Self {
        let place = match (fault.line, fault.entity) {
            (0, None) => Place::Whole,
            (line, None) => Place::Line(line),
            (line, Some(entity)) => Place::EntityAtLine { entity: u64::from(entity.sequence), line },
        };
        let what = match fault.entity {
            Some(entity) => format!("type {}: {}", entity.kind, fault.what),
            None => fault.what,
        };
        let location = Location { file: None, place };
        let advice = fault.advice.to_owned();
        if fault.unsupported {
            Self::Unsupported { location, what, advice }
        } else {
            Self::Malformed { location, what, advice }
        }
    }
}

/// Entities without geometry of their own, or whose geometry is read with others: groups and other associativities,
/// colours, line fonts, matrices, properties, attributes, units, notes of the file and drawings.
const WITHOUT_SHAPE: [u32; 12] = [0, 124, 302, 304, 310, 312, 314, 316, 322, 402, 406, 422];

fn read(data: &[u8]) -> Result<ModelDescription, Fault> {
    let file = File::new(data)?;
    let mut model = Reading { file: &file, part: PartDescription::default(), unread: Vec::new() };
    let stages: [fn(u32) -> bool; 6] = [
        |kind| kind == 186,
        |kind| kind == 514,
        |kind| matches!(kind, 143 | 144),
        is_surface,
        |kind| kind == 102,
        is_curve,
    ];
    let mut loose = ShellDescription::default();
    for is_of_stage in stages {
        for entry in file.entries.iter().filter(|entry| is_of_stage(entry.kind)) {
            model.root(entry, &mut loose)?;
        }
    }
    for entry in &file.entries {
        let is_read = stages.iter().any(|is_of_stage| is_of_stage(entry.kind));
        if !is_read && !WITHOUT_SHAPE.contains(&entry.kind) && !file.is_used(entry) && !entry.is_dependent {
            let why = match entry.kind {
                116 => "a free point",
                200..=299 => "an annotation",
                _ => "entities of this type are not read",
            };
            model.leave_out(entry, why.to_owned());
        }
    }
    model.sort(&loose);
    model.finish(loose)
}

/// What was read so far.
struct Reading<'f> {
    file: &'f File<'f>,
    part: PartDescription,
    unread: Vec<Unread>,
}

impl<'f> Reading<'f> {
    fn leave_out(&mut self, entry: &Entry, why: String) {
        self.unread.push(Unread {
            source: u64::from(entry.sequence),
            kind: format!("type {}", entry.kind),
            why,
        });
    }

    /// Reads an entity unless it is part of another one.
    fn root(&mut self, entry: &'f Entry, loose: &mut ShellDescription) -> Result<(), Fault> {
        if self.file.is_used(entry) || entry.is_dependent {
            return Ok(());
        }
        let before = self.counts();
        let free = self.part.curves.len();
        match self.shape(entry, loose) {
            Ok(()) if entry.is_hidden => {
                // Read nevertheless, so that its parts are not taken for shapes of their own.
                self.forget(before, free, loose);
                self.leave_out(entry, "the file hides it".to_owned());
            }
            Ok(()) if matches!(entry.usage, 1 | 2 | 4 | 5) => {
                self.forget(before, free, loose);
                let use_of =
                    ["annotation", "a definition", "", "a logical relation", "a curve in parameters"];
                let place = usize::try_from(entry.usage).unwrap_or_default().saturating_sub(1);
                let use_of = use_of.get(place).unwrap_or(&"");
                self.leave_out(entry, format!("the file marks it as {use_of}"));
            }
            Ok(()) => {}
            Err(fault) if fault.unsupported => {
                self.forget(before, free, loose);
                self.leave_out(entry, fault.what);
            }
            Err(fault) => return Err(fault),
        }
        Ok(())
    }

    fn shape(&mut self, entry: &'f Entry, loose: &mut ShellDescription) -> Result<(), Fault> {
        match entry.kind {
            186 | 514 => solids::read(self.file, entry, &mut self.part),
            kind if is_curve(kind) => {
                let (pieces, name) = curves::read(self.file, entry, None, 0)?;
                let free = pieces.into_iter().map(|piece| FreeCurve {
                    name: name.clone(),
                    source: u64::from(entry.sequence),
                    curve: piece.curve,
                    range: piece.range,
                });
                self.part.curves.extend(free);
                Ok(())
            }
            _ => {
                let face = trims::face(self.file, entry, &mut self.part)?;
                loose.faces.push(self.part.faces.len());
                self.part.faces.push(face);
                Ok(())
            }
        }
    }

    fn counts(&self) -> [usize; 4] {
        let part = &self.part;
        [part.shells.len(), part.faces.len(), part.edges.len(), part.vertices.len()]
    }

    /// Takes back what an entity added.
    fn forget(&mut self, before: [usize; 4], free: usize, loose: &mut ShellDescription) {
        let [shells, faces, edges, vertices] = before;
        self.part.shells.truncate(shells);
        self.part.faces.truncate(faces);
        self.part.edges.truncate(edges);
        self.part.vertices.truncate(vertices);
        self.part.curves.truncate(free);
        loose.faces.retain(|&face| face < faces);
    }

    /// Puts faces without a solid and free curves into the order of the file; which of them others name is known only after
    /// some were read.
    fn sort(&mut self, loose: &ShellDescription) {
        let first = loose.faces.first().copied().unwrap_or(self.part.faces.len());
        self.part.faces[first..].sort_by_key(|face| face.source);
        self.part.curves.sort_by_key(|curve| curve.source);
    }

    fn finish(mut self, loose: ShellDescription) -> Result<ModelDescription, Fault> {
        if !loose.faces.is_empty() {
            self.part.shells.push(loose);
        }
        if self.part.faces.is_empty() && self.part.curves.is_empty() {
            let what = match &self.unread[..] {
                [] => "the file has no faces and no curves".to_owned(),
                [first, ..] => format!(
                    "the file has no faces and no curves that can be read; {} entities were left out, the first is {} ({}): {}",
                    self.unread.len(),
                    first.source,
                    first.kind,
                    first.why
                ),
            };
            return Err(
                Fault { line: 0, ..Fault::at_line(0, what) }.unsupported("give a file with faces or curves")
            );
        }
        let global = &self.file.global;
        self.part.name.clone_from(&global.name);
        Ok(ModelDescription {
            name: global.name.clone(),
            unit: global.unit.clone(),
            uncertainty: global.resolution,
            parts: vec![self.part],
            instances: vec![InstanceDescription {
                part: 0,
                name: String::new(),
                placement: Placement { scale: 1.0 / global.scale, ..Placement::IDENTITY },
            }],
            unread: self.unread,
            ..ModelDescription::default()
        })
    }
}
