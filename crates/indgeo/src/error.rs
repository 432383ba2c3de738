//! What ends a command with exit status 2.

use industrial_geometry::{cad, footpoint, io, mesh};
use std::fmt;
use std::path::{Path, PathBuf};

/// Bad input or usage; the message says where, what and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// A file cannot be read or written.
    #[error("{source}{}", advice(source))]
    File {
        /// What the reader or writer says.
        #[from]
        source: io::Error,
    },
    /// A CAD file cannot be read.
    #[error("{source}")]
    Cad {
        /// What the reader says.
        #[from]
        source: cad::Error,
    },
    /// A file was read, but its content does not serve.
    #[error("{}: {what}; {advice}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
        /// What to do.
        advice: &'static str,
    },
    /// The model of a file cannot be projected onto.
    #[error("{}: {source}; check the model with `indgeo info`", path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: footpoint::Error,
    },
    /// The mesh of a file cannot be projected onto.
    #[error("{}: {source}; check the mesh with `indgeo info`", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: mesh::Error,
    },
    /// Several files cannot be read; each says why.
    #[error("{}", errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\nerror: "))]
    Files {
        /// One per file.
        errors: Vec<Self>,
    },
    /// Options that cannot be used.
    #[error("{what}; {advice}")]
    Usage {
        /// What is wrong.
        what: String,
        /// What to do.
        advice: &'static str,
    },
}

impl Error {
    /// A file whose content does not serve.
    pub(crate) fn content(path: &Path, what: impl Into<String>, advice: &'static str) -> Self {
        Self::Content { path: path.to_path_buf(), what: what.into(), advice }
    }

    /// A CAD file that cannot be read.
    pub(crate) fn cad(error: cad::Error, path: &Path) -> Self {
        Self::Cad { source: error.in_file(path) }
    }

    /// Options that cannot be used.
    pub(crate) fn usage(what: impl Into<String>, advice: &'static str) -> Self {
        Self::Usage { what: what.into(), advice }
    }

    /// An option that the library refuses, named as it is typed.
    pub(crate) fn option(name: &str, value: f64, allowed: &str, advice: &'static str) -> Self {
        // Hundreds of digits tell nobody anything.
        let value = if value.abs() < 1e12 { value.to_string() } else { format!("{value:e}") };
        Self::usage(format!("{} is {value}, it must be {allowed}", typed(name)), advice)
    }

    /// Whether the operating system refused to read or write a file.
    pub(crate) fn is_of_system(&self) -> bool {
        match self {
            Self::File { source } => matches!(source, io::Error::Io { .. }),
            Self::Files { errors } => errors.iter().all(Self::is_of_system),
            _ => false,
        }
    }

    /// A failed write to `path`.
    pub(crate) fn write(path: &Path, source: std::io::Error) -> Self {
        Self::File { source: io::Error::Io { path: path.to_path_buf(), action: "write", source } }
    }
}

/// The option that is typed for one of the library.
fn typed(name: &str) -> String {
    let option = match name {
        "controls" | "control_points" => "control-points",
        "max_controls" => "max-control-points",
        "abs_tolerance" => "tolerance",
        "section_normal" => "level",
        "abs_twist" => "developable",
        "abs_distance" => "offset",
        "lambda" | "start" | "floor" | "factor" => "smoothing",
        "size" => "grid",
        other => return format!("--{}", other.replace('_', "-")),
    };
    format!("--{option}")
}

/// What to do about an answer of the operating system, which does not say.
fn advice(error: &io::Error) -> impl fmt::Display + use<> {
    use std::io::ErrorKind as Kind;
    let io::Error::Io { source, action, .. } = error else { return "" };
    match (source.kind(), *action) {
        (Kind::NotFound, "read") => "; check the path",
        (Kind::NotFound, _) => "; create the folder first",
        (Kind::PermissionDenied, "read") => "; you may not read this file",
        (Kind::PermissionDenied | Kind::ReadOnlyFilesystem, _) => "; choose a folder you may write to",
        (Kind::IsADirectory, "read") => "; this is a folder, name a file in it",
        (Kind::IsADirectory, _) => "; this is a folder, name a file",
        (Kind::NotADirectory, _) => "; a part of the path is not a folder",
        (Kind::StorageFull | Kind::QuotaExceeded, _) => "; free some space",
        _ => "; see the message of the operating system",
    }
}
