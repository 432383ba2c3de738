//! The formats and how they are recognised.

use std::fmt;
use std::path::Path;

use serde::Serialize;

use crate::source::{Lines, Source};
use crate::{Error, Place};
use crate::{number, scanner};

/// A file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Format {
    /// Polygon File Format (Stanford): ascii and both byte orders.
    Ply,
    /// Rows of numbers separated by blanks: `.xyz`, `.txt`, `.asc` and other extensions.
    Xyz,
    /// Rows of numbers separated by commas, semicolons or tabs, as a rule under a line of names.
    Csv,
    /// Rows of numbers under a line with their count (Leica).
    Pts,
    /// Grids of a scanner with their poses (Leica); read only.
    Ptx,
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography: ascii and binary.
    Stl,
    /// Object File Format (Geomview).
    Off,
    /// Point Cloud Data (PCL): ascii, binary, compressed.
    Pcd,
    /// Lidar points (ASPRS).
    Las,
    /// LAS, compressed.
    Laz,
    /// Scans with their poses (ASTM E2807).
    E57,
    /// Binary glTF; write only.
    Glb,
    /// NURBS curves and surfaces as JSON.
    Json,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 14] = [
        Self::Ply,
        Self::Xyz,
        Self::Csv,
        Self::Pts,
        Self::Ptx,
        Self::Obj,
        Self::Stl,
        Self::Off,
        Self::Pcd,
        Self::Las,
        Self::Laz,
        Self::E57,
        Self::Glb,
        Self::Json,
    ];

    /// The format with a file name extension (without dot, in upper or lower case).
    #[must_use]
    pub fn from_extension(extension: &str) -> Option<Self> {
        Some(match extension.to_ascii_lowercase().as_str() {
            "ply" => Self::Ply,
            "xyz" | "txt" | "asc" | "xy" => Self::Xyz,
            "csv" | "tsv" => Self::Csv,
            "pts" => Self::Pts,
            "ptx" => Self::Ptx,
            "obj" => Self::Obj,
            "stl" => Self::Stl,
            "off" | "coff" | "noff" => Self::Off,
            "pcd" => Self::Pcd,
            "las" => Self::Las,
            "laz" => Self::Laz,
            "e57" => Self::E57,
            "glb" => Self::Glb,
            "json" => Self::Json,
            _ => return None,
        })
    }

    /// The format that the extension of a path names.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<Self> {
        Self::from_extension(path.extension()?.to_str()?)
    }

    /// The usual extension, without dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Ply => "ply",
            Self::Xyz => "xyz",
            Self::Csv => "csv",
            Self::Pts => "pts",
            Self::Ptx => "ptx",
            Self::Obj => "obj",
            Self::Stl => "stl",
            Self::Off => "off",
            Self::Pcd => "pcd",
            Self::Las => "las",
            Self::Laz => "laz",
            Self::E57 => "e57",
            Self::Glb => "glb",
            Self::Json => "json",
        }
    }

    /// Whether the file tells the format by its first bytes and is decoded piece by piece: LAS, LAZ, E57.
    #[must_use]
    pub const fn is_of_scanner(self) -> bool {
        matches!(self, Self::Las | Self::Laz | Self::E57)
    }

    /// Whether a file can hold several scans, of which one can be chosen.
    #[must_use]
    pub const fn has_scans(self) -> bool {
        matches!(self, Self::Ptx | Self::E57)
    }

    /// Whether the format is one of the tables of numbers, which share a reader.
    #[must_use]
    pub const fn is_table(self) -> bool {
        matches!(self, Self::Xyz | Self::Csv | Self::Pts)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ply => "PLY",
            Self::Xyz => "XYZ",
            Self::Csv => "CSV",
            Self::Pts => "PTS",
            Self::Ptx => "PTX",
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Off => "OFF",
            Self::Pcd => "PCD",
            Self::Las => "LAS",
            Self::Laz => "LAZ",
            Self::E57 => "E57",
            Self::Glb => "GLB",
            Self::Json => "NURBS JSON",
        })
    }
}

/// How many bytes and lines are looked at to recognise a format.
const HEAD_BYTES: usize = 64 * 1024;
const HEAD_LINES: usize = 200;

/// The format of the content; where the content does not tell, that of the extension.
pub(crate) fn recognise(source: Source<'_>, hint: Option<Format>) -> Result<Format, Error> {
    let data = source.data;
    if data.iter().all(u8::is_ascii_whitespace) {
        return Err(Error::malformed(Place::Whole, "the file is empty", "export it again"));
    }
    if let Some(format) = scanner::by_magic(data) {
        return Ok(format);
    }
    if let Some((name, advice)) = known_but_unreadable(data) {
        return Err(Error::unsupported(Place::Whole, format!("this is {name}, which is not read"), advice));
    }
    by_content(data).or(hint).ok_or_else(|| {
        Error::unsupported(
            Place::Whole,
            "the format is recognised neither by the content nor by the extension",
            "give points as PLY, XYZ, CSV, PTS, PTX, PCD, LAS, LAZ or E57, triangles as PLY, OBJ, STL or OFF, \
             shapes as NURBS JSON, STEP or IGES",
        )
    })
}

fn by_content(data: &[u8]) -> Option<Format> {
    let head = &data[..data.len().min(HEAD_BYTES)];
    let text = head.trim_ascii_start();
    if text.starts_with(b"ply") && text.get(3).is_none_or(u8::is_ascii_whitespace) {
        return Some(Format::Ply);
    }
    if crate::stl::is_binary(data) {
        return Some(Format::Stl);
    }
    if text.starts_with(b"{") {
        return Some(Format::Json);
    }
    if crate::off::header(crate::off::without_comments(text)).is_some() {
        return Some(Format::Off);
    }
    if crate::stl::looks_like_text(head) {
        return Some(Format::Stl);
    }
    if crate::ptx::looks_like(head) {
        return Some(Format::Ptx);
    }
    by_lines(head)
}

/// PCD, OBJ or a table, by the first lines that are neither blank nor comments.
fn by_lines(head: &[u8]) -> Option<Format> {
    let mut first_row = None;
    let mut described = false;
    for (place, (_, line)) in Lines::new(head).take(HEAD_LINES).enumerate() {
        let line = line.trim_ascii();
        if line.is_empty() || line.starts_with(b"#") || line.starts_with(b"//") || line.starts_with(b"%") {
            described |= crate::xyz::looks_like_header(line);
            continue;
        }
        if crate::xyz::looks_like_header(line) {
            return Some(crate::xyz::format_of_row(line));
        }
        let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        if matches!(word, b"VERSION" | b"FIELDS" | b"COLUMNS") {
            return Some(Format::Pcd);
        }
        let rest = line[word.len()..].trim_ascii_start();
        match word.to_ascii_lowercase().as_slice() {
            b"v" | b"vn" | b"vt" | b"vp" | b"f" if number::starts_with_number(rest) => {
                return Some(Format::Obj);
            }
            b"cstype" => return Some(Format::Obj),
            // Such a line may also be the header of a table; what follows decides.
            b"mtllib" | b"usemtl" | b"o" | b"g" | b"s" if mentions(head, &[b"\nv ", b"\rv ", b"\nv\t"]) => {
                return Some(Format::Obj);
            }
            _ => {}
        }
        // At most one line, the header, comes before rows of numbers; names of columns may come later.
        if crate::xyz::looks_like_row(line) && first_row.is_none_or(|row| row + 1 == place) {
            return Some(crate::xyz::format_of_row(line));
        }
        first_row.get_or_insert(place);
    }
    (described && first_row.is_none()).then_some(Format::Xyz)
}

fn mentions(head: &[u8], words: &[&[u8]]) -> bool {
    words.iter().any(|word| head.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word)))
}

fn known_but_unreadable(data: &[u8]) -> Option<(&'static str, &'static str)> {
    const CONVERT: &str =
        "convert it to PLY, PCD or XYZ first, or build this program with the feature for it";
    const KNOWN: [(&[u8], &str, &str); 10] = [
        (b"\x1f\x8b", "a gzip archive", "unpack it first"),
        (b"PK\x03\x04", "a zip archive", "unpack it first"),
        (b"\x28\xb5\x2f\xfd", "a zstd archive", "unpack it first"),
        (b"LASF", "a LAS or LAZ file", CONVERT),
        (b"ASTM-E57", "an E57 file", CONVERT),
        (
            b"ISO-10303-21",
            "a STEP file",
            "give it as a model, or convert it to NURBS JSON or to a mesh first",
        ),
        (b"3D Geometry File Format", "a Rhino 3DM file", "convert it to NURBS JSON or to a mesh first"),
        (b"glTF", "a binary glTF file", "convert it to PLY, OBJ or STL first"),
        (b"# vtk DataFile", "a VTK file", "convert it to PLY, OBJ or STL first"),
        (b"<?xml", "an XML file", "convert it to PLY, OBJ or STL first"),
    ];
    KNOWN.iter().find(|(magic, ..)| data.starts_with(magic)).map(|&(_, name, advice)| (name, advice))
}
