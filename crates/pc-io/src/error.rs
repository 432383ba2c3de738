//! What can be wrong with a file, and where.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use crate::Format;

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line of a text file, counted from 1.
    Line(usize),
    /// A byte of a binary file, counted from 0.
    Byte(usize),
}

/// A place in a named file, or in bytes without a name.
#[derive(Debug, Clone, PartialEq, Eq)]
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
            (Some(file), Place::Byte(byte)) => write!(f, "{}: byte {byte}", file.display()),
            (None, Place::Whole) => f.write_str("input"),
            (None, Place::Line(line)) => write!(f, "line {line}"),
            (None, Place::Byte(byte)) => write!(f, "byte {byte}"),
        }
    }
}

/// Why a file cannot be read or written. The message says where, what, and what to do.
///
/// ```
/// use pc_io::{ReadOptions, read_bytes};
///
/// let text = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nend_header\n1 two\n";
/// let error = read_bytes(text, None, &ReadOptions::default()).unwrap_err();
/// assert!(error.to_string().starts_with("line 7: \"two\" where the number y is expected; "), "{error}");
/// ```
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
    /// The header promises more than the file holds.
    #[error(
        "{location}: {promised} {what} are promised, which take {needed} bytes or more, but only {left} bytes are \
         left; the file is truncated or its header damaged, export it again"
    )]
    Truncated {
        /// Where the data begin.
        location: Location,
        /// What is promised, such as `vertices`.
        what: String,
        /// How many of them.
        promised: u64,
        /// Bytes they take at least.
        needed: u64,
        /// Bytes from there to the end of the file.
        left: u64,
    },
    /// The format is known but cannot be read or written here.
    #[error("{location}: {what}; {advice}")]
    Unsupported {
        /// Where.
        location: Location,
        /// What is not supported.
        what: String,
        /// What to do.
        advice: String,
    },
    /// The file holds something else than was asked for.
    #[error("{location}: {wanted} is needed, but this file holds {found}; {advice}")]
    WrongContent {
        /// The file.
        location: Location,
        /// What was asked for.
        wanted: &'static str,
        /// What there is.
        found: String,
        /// What to do.
        advice: &'static str,
    },
    /// A format cannot hold what is to be written at all.
    #[error("{}: a {format} file cannot hold {what}; {advice}", path.display())]
    CannotHold {
        /// The file to write.
        path: PathBuf,
        /// Its format.
        format: Format,
        /// What it cannot hold.
        what: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// The points and triangles of the file contradict each other.
    #[error("{location}: {source}")]
    Shape {
        /// The file.
        location: Location,
        /// What is wrong.
        source: mesh_core::Error,
    },
}

impl Error {
    /// Names the file that the bytes came from.
    #[must_use]
    pub(crate) fn in_file(mut self, path: &Path) -> Self {
        match &mut self {
            Self::Malformed { location, .. }
            | Self::Truncated { location, .. }
            | Self::Unsupported { location, .. }
            | Self::WrongContent { location, .. }
            | Self::Shape { location, .. } => location.file = Some(path.to_path_buf()),
            Self::Io { .. } | Self::CannotHold { .. } => {}
        }
        self
    }

    /// Where in the file, if the error has a place there.
    #[must_use]
    pub const fn location(&self) -> Option<&Location> {
        match self {
            Self::Malformed { location, .. }
            | Self::Truncated { location, .. }
            | Self::Unsupported { location, .. }
            | Self::WrongContent { location, .. }
            | Self::Shape { location, .. } => Some(location),
            Self::Io { .. } | Self::CannotHold { .. } => None,
        }
    }

    pub(crate) fn malformed(place: Place, what: impl Into<String>, advice: impl Into<String>) -> Self {
        Self::Malformed { location: Location { file: None, place }, what: what.into(), advice: advice.into() }
    }

    pub(crate) fn unsupported(place: Place, what: impl Into<String>, advice: impl Into<String>) -> Self {
        Self::Unsupported {
            location: Location { file: None, place },
            what: what.into(),
            advice: advice.into(),
        }
    }

    pub(crate) const fn shape(source: mesh_core::Error) -> Self {
        Self::Shape { location: Location { file: None, place: Place::Whole }, source }
    }
}
