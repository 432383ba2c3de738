//! What can be wrong with a file, and where.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A place in a CAD file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line, counted from 1.
    Line(usize),
    /// An entity: `#n` of STEP, directory entry `n` of IGES.
    Entity(u64),
    /// An entity of IGES, and a line of it.
    EntityAtLine {
        /// Number of its directory entry.
        entity: u64,
        /// Line of the file, counted from 1.
        line: usize,
    },
}

/// A place in a named file, or in bytes without a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file, where the bytes came from one.
    pub file: Option<PathBuf>,
    /// The place in it.
    pub place: Place,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.file, self.place) {
            (Some(file), Place::Whole) => write!(f, "{}", file.display()),
            (Some(file), Place::Line(line)) => write!(f, "{}:{line}", file.display()),
            (Some(file), Place::Entity(number)) => write!(f, "{}: entity {number}", file.display()),
            (Some(file), Place::EntityAtLine { entity, line }) => {
                write!(f, "{}:{line}: entity {entity}", file.display())
            }
            (None, Place::Whole) => f.write_str("input"),
            (None, Place::Line(line)) => write!(f, "line {line}"),
            (None, Place::Entity(number)) => write!(f, "entity {number}"),
            (None, Place::EntityAtLine { entity, line }) => write!(f, "line {line}, entity {entity}"),
        }
    }
}

/// Why a CAD file cannot be read or written. The message says where, what, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refuses.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: `read`, `create`, `write` or `replace`.
        action: &'static str,
        /// What the operating system says.
        source: io::Error,
    },
    /// The content breaks the rules of its format.
    #[error("{location}: {what}; {advice}")]
    Malformed {
        /// Where.
        location: Location,
        /// What was found and what was expected.
        what: String,
        /// What to do.
        advice: String,
    },
    /// The file is sound but holds nothing that can be used, or a feature of the program is missing.
    #[error("{location}: {what}; {advice}")]
    Unsupported {
        /// Where.
        location: Location,
        /// What was found.
        what: String,
        /// What to do.
        advice: String,
    },
    /// What was to be written cannot be expressed in the format, or is not sound.
    #[error("cannot write {what}: {why}")]
    Unwritable {
        /// What was to be written (`face "top"`, `edge 3`).
        what: String,
        /// Why not.
        why: String,
    },
}

impl Error {
    /// The same error, with the name of the file.
    #[must_use]
    pub fn in_file(mut self, path: &Path) -> Self {
        if let Self::Malformed { location, .. } | Self::Unsupported { location, .. } = &mut self {
            location.file = Some(path.to_owned());
        }
        self
    }
}
