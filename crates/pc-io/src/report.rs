//! What was read and written.

use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};

use crate::wording::counted;
use crate::{Format, Scan};

/// How files are read.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ReadOptions {
    /// Whether points with a coordinate that is NaN or infinite are dropped, together with the triangles that use
    /// them. Default: no, they are counted and kept.
    pub drop_non_finite: bool,
    /// The format, if it is not to be recognised. Default: none.
    pub format: Option<Format>,
    /// Whether commas in the numbers of tables are decimal signs where the file leaves that open: between blanks, or
    /// before three digits everywhere. Default: no, such files are refused.
    pub decimal_comma: bool,
    /// The scan that is read of a file of several (E57, PTX): its name, or its number from 0 on; files of other formats are
    /// refused then. Default: none, all scans together.
    pub scan: Option<String>,
}

impl ReadOptions {
    /// Sets the scan to be read of a file of several: a name, a number from 0 on, or `all`.
    #[must_use]
    pub fn with_scan(mut self, scan: Option<String>) -> Self {
        self.scan = scan.filter(|scan| !scan.eq_ignore_ascii_case("all"));
        self
    }

    /// Sets whether commas in numbers are decimal signs where the file leaves that open.
    #[must_use]
    pub const fn with_decimal_comma(mut self, decimal_comma: bool) -> Self {
        self.decimal_comma = decimal_comma;
        self
    }

    /// Sets whether points that are not finite are dropped.
    #[must_use]
    pub const fn with_drop_non_finite(mut self, drop: bool) -> Self {
        self.drop_non_finite = drop;
        self
    }

    /// Sets the format instead of recognising it.
    #[must_use]
    pub const fn with_format(mut self, format: Format) -> Self {
        self.format = Some(format);
        self
    }
}

/// How files are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WriteOptions {
    /// Whether PLY is written as text. Default: no, as binary.
    pub ascii: bool,
    /// The format, if the extension does not tell. Default: none.
    pub format: Option<Format>,
}

impl WriteOptions {
    /// Sets whether PLY is written as text.
    #[must_use]
    pub const fn with_ascii(mut self, ascii: bool) -> Self {
        self.ascii = ascii;
        self
    }

    /// Sets the format, whatever the extension says.
    #[must_use]
    pub const fn with_format(mut self, format: Format) -> Self {
        self.format = Some(format);
        self
    }
}

/// Writes a path as text; what is not UTF-8 in it is replaced.
fn lossy<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

fn lossy_option<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    path.as_ref().map(|path| path.to_string_lossy()).serialize(serializer)
}

/// What a file was found to hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[must_use]
pub struct ReadReport {
    /// The file, where the bytes came from one.
    #[serde(serialize_with = "lossy_option")]
    pub path: Option<PathBuf>,
    /// Its format.
    pub format: Format,
    /// Points or vertices in the file.
    pub points: usize,
    /// Triangles in the file, polygons counting as the triangles they were split into.
    pub triangles: usize,
    /// NURBS curves and surfaces in the file.
    pub shapes: usize,
    /// The scans that were read, of a format that can hold several.
    pub scans: Vec<Scan>,
    /// Points with a coordinate that is NaN or infinite.
    pub non_finite: usize,
    /// How many of those were dropped: all or none.
    pub dropped: usize,
    /// What the reader had to decide, leave out or doubt.
    pub warnings: Vec<String>,
}

impl fmt::Display for ReadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}: ", path.display())?;
        }
        write_counts(f, self.format, self.points, self.triangles, self.shapes)?;
        if self.scans.len() > 1 {
            write!(f, ", {}", counted(self.scans.len(), "scan"))?;
        }
        if self.non_finite > 0 {
            let fate = if self.dropped > 0 { "dropped" } else { "kept" };
            let are = if self.non_finite == 1 { "is" } else { "are" };
            write!(f, ", {} {are} not finite ({fate})", counted(self.non_finite, "point"))?;
        }
        write_warnings(f, &self.warnings)
    }
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[must_use]
pub struct WriteReport {
    /// The file.
    #[serde(serialize_with = "lossy")]
    pub path: PathBuf,
    /// Its format.
    pub format: Format,
    /// Points or vertices written.
    pub points: usize,
    /// Triangles written.
    pub triangles: usize,
    /// NURBS curves and surfaces written.
    pub shapes: usize,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// What the format could not hold.
    pub warnings: Vec<String>,
}

impl fmt::Display for WriteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.path.display())?;
        write_counts(f, self.format, self.points, self.triangles, self.shapes)?;
        write!(f, ", {} bytes", self.bytes)?;
        write_warnings(f, &self.warnings)
    }
}

fn write_counts(
    f: &mut fmt::Formatter<'_>,
    format: Format,
    points: usize,
    triangles: usize,
    shapes: usize,
) -> fmt::Result {
    write!(f, "{format}")?;
    if shapes > 0 {
        return write!(f, ", {}", counted(shapes, "NURBS shape"));
    }
    write!(f, ", {}", counted(points, "point"))?;
    if triangles > 0 {
        write!(f, ", {}", counted(triangles, "triangle"))?;
    }
    Ok(())
}

fn write_warnings(f: &mut fmt::Formatter<'_>, warnings: &[String]) -> fmt::Result {
    match warnings {
        [] => Ok(()),
        [warning] => write!(f, "; warning: {warning}"),
        _ => write!(f, "; warnings: {}", warnings.join("; ")),
    }
}
