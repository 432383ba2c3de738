//! Files in and out: point clouds, meshes and NURBS.
//!
//! | format | reading | writing |
//! |---|---|---|
//! | PLY | ascii and both byte orders, every type, lists, texts, unknown elements | binary little endian doubles, or ascii |
//! | XYZ, CSV, PTS | any separator and decimal sign, header or none, names of points, two or three coordinates | full precision |
//! | PTX | several scans with poses | no |
//! | OBJ | polygons, relative indices, colours; free-form curves and surfaces | with normals and colours |
//! | STL | ascii and binary, corners joined that differ by rounding | binary |
//! | OFF | with normals and colours, in free format | with normals and colours |
//! | PCD | 0.5 to 0.7, ascii, binary and compressed | binary |
//! | LAS, LAZ | 1.0 to 1.4 with extra bytes; COPC as LAZ (feature `las`) | 1.4 with extra bytes |
//! | E57 | several scans with poses (feature `e57`) | one scan of doubles |
//! | GLB | no | points and triangles with normals and colours |
//! | NURBS JSON | curves, surfaces, models; the JSON of geomdl | the same |
//!
//! [`write_polylines`] writes tessellated curves as OBJ, PLY, SVG or DXF.
//!
//! `docs/formats.md` says what is read, written and left out in detail.
//!
//! The format is recognised by the content first, by the extension second. Whatever the bytes are, reading ends in an
//! answer or in an [`Error`] that names the line or byte, and it never takes memory out of proportion to the file.
//!
//! ```
//! use pc_io::{Content, Format, ReadOptions, WriteOptions};
//!
//! let dir = tempfile::tempdir()?;
//! let text = dir.path().join("scan.txt");
//! std::fs::write(&text, "x;y;z;intensity\n0;0;1;17\n0;1;nan;18\n")?;
//!
//! let scan = pc_io::read(&text, &ReadOptions::default())?;
//! assert_eq!((scan.report.format, scan.report.points, scan.report.non_finite), (Format::Csv, 2, 1));
//! let Content::Cloud(cloud) = scan.content else { panic!("no triangles here") };
//! assert_eq!(cloud.attributes().scalar("intensity"), Some([17.0, 18.0].as_slice()));
//!
//! let written = pc_io::write_cloud(dir.path().join("scan.ply"), &cloud, &WriteOptions::default())?;
//! assert!(written.warnings.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod atomic;
mod cloud_pieces;
mod columns;
mod content;
#[cfg(feature = "e57")]
mod e57;
mod error;
#[cfg(any(feature = "las", feature = "e57"))]
mod foreign;
mod format;
mod glb;
mod json;
#[cfg(feature = "las")]
mod las;
mod model;
mod number;
mod number_type;
mod obj;
mod off;
mod parsed;
mod pcd;
mod piece;
mod pieces;
mod ply;
mod polylines;
mod ptx;
mod ptx_pieces;
mod read;
mod report;
mod sample;
mod scanner;
mod scans;
mod shape;
mod source;
mod stl;
mod text_lines;
mod unfinished;
mod wording;
mod write;
mod xyz;

pub use atomic::AtomicFile;
pub use cloud_pieces::read_cloud_pieces;
pub use content::{Content, Loaded};
pub use error::{Error, Location, Place};
pub use format::Format;
pub use mesh_core;
pub use model::{Model, Shape};
pub use number::write_number;
pub use nurbs_core;
pub use piece::Piece;
pub use pieces::{is_read_in_pieces, read_pieces, read_range};
pub use polylines::{PolylineFormat, write_polylines};
pub(crate) use read::not_points;
pub use read::{read, read_bytes, read_cloud, read_from, read_mesh, read_model};
pub use report::{ReadOptions, ReadReport, WriteOptions, WriteReport};
pub use sample::read_sample;
pub use scans::Scan;
pub use unfinished::{Unfinished, remove_unfinished};
pub use write::{
    is_written_in_pieces, write, write_cloud, write_cloud_pieces, write_mesh, write_model, write_to,
};
pub use xyz::write_text;

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
