//! Writing files of any format.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use mesh_core::{PointCloud, TriangleMesh};

use crate::content::Content;
use crate::error::Location;
use crate::shape::Shape;
use crate::{
    AtomicFile, Error, Format, Model, Place, WriteOptions, WriteReport, glb, json, obj, off, pcd, ply,
    scanner, stl, xyz,
};

/// Writes what was read, in the format of the extension. The file appears whole or not at all.
///
/// What the format cannot hold is told in the report.
///
/// # Errors
/// [`Error::Unsupported`] for an unknown extension, [`Error::CannotHold`] if nothing of the content fits the format,
/// [`Error::Io`] if the file cannot be written.
pub fn write(
    path: impl AsRef<Path>,
    content: &Content,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    write_content(Target::file(path.as_ref()), content, options)
}

/// Writes what was read to a stream, in the format of `options`; `name` stands for the file in messages and in the report, and
/// its extension for the format where the options name none.
///
/// ```
/// use pc_io::{Format, ReadOptions, WriteOptions, read_from, write_to};
///
/// let scan = read_from("1 2 3\n4 5 6\n".as_bytes(), "standard input", &ReadOptions::default())?;
/// let mut text = Vec::new();
/// let options = WriteOptions::default().with_format(Format::Csv);
/// let written = write_to(&mut text, "standard output", &scan.content, &options)?;
/// assert_eq!(text, b"x,y,z\n1,2,3\n4,5,6\n");
/// assert_eq!((written.points, written.bytes), (2, 18));
/// # Ok::<(), pc_io::Error>(())
/// ```
///
/// # Errors
/// As [`write()`].
pub fn write_to(
    mut stream: impl Write,
    name: impl AsRef<Path>,
    content: &Content,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    write_content(Target { path: name.as_ref(), stream: Some(&mut stream) }, content, options)
}

fn write_content(
    target: Target<'_>,
    content: &Content,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    match content {
        Content::Cloud(cloud) => write_shape(target, Shape { cloud, triangles: &[] }, options),
        Content::Mesh(mesh) => {
            write_shape(target, Shape { cloud: mesh.cloud(), triangles: mesh.triangles() }, options)
        }
        Content::Nurbs(model) => write_nurbs(target, model, options),
    }
}

/// Where something is written: a file, or a stream with a name.
struct Target<'a> {
    path: &'a Path,
    stream: Option<&'a mut dyn Write>,
}

impl<'a> Target<'a> {
    fn file(path: &'a Path) -> Self {
        Self { path, stream: None }
    }

    /// Writes what `fill` says; a file appears whole or not at all. Returns the number of bytes.
    fn fill(self, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<u64, Error> {
        let path = self.path;
        let failed = |source| Error::Io { path: path.to_path_buf(), action: "write", source };
        let Some(stream) = self.stream else {
            let mut file = AtomicFile::create(path)?;
            fill(&mut file).map_err(failed)?;
            return file.commit();
        };
        let mut out = BufWriter::new(Counted { out: stream, bytes: 0 });
        fill(&mut out).and_then(|()| out.flush()).map_err(failed)?;
        Ok(out.get_ref().bytes)
    }
}

/// A writer that counts.
struct Counted<W> {
    out: W,
    bytes: u64,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Writes a point cloud.
///
/// # Errors
/// As [`write()`].
pub fn write_cloud(
    path: impl AsRef<Path>,
    cloud: &PointCloud,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    write_shape(Target::file(path.as_ref()), Shape { cloud, triangles: &[] }, options)
}

/// Writes a triangle mesh.
///
/// # Errors
/// As [`write()`].
pub fn write_mesh(
    path: impl AsRef<Path>,
    mesh: &TriangleMesh,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    write_shape(
        Target::file(path.as_ref()),
        Shape { cloud: mesh.cloud(), triangles: mesh.triangles() },
        options,
    )
}

/// Writes NURBS curves and surfaces.
///
/// # Errors
/// As [`write()`].
pub fn write_model(
    path: impl AsRef<Path>,
    model: &Model,
    options: &WriteOptions,
) -> Result<WriteReport, Error> {
    write_nurbs(Target::file(path.as_ref()), model, options)
}

fn write_nurbs(target: Target<'_>, model: &Model, options: &WriteOptions) -> Result<WriteReport, Error> {
    let path = target.path;
    let format = format_of(path, options)?;
    if format != Format::Json {
        let (what, advice) = ("NURBS curves and surfaces", "choose the extension json");
        return Err(Error::CannotHold { path: path.to_path_buf(), format, what, advice });
    }
    let bytes = target.fill(|out| json::write(out, model))?;
    let shapes = model.shapes().len();
    Ok(WriteReport {
        path: path.to_path_buf(),
        format,
        points: 0,
        triangles: 0,
        shapes,
        bytes,
        warnings: Vec::new(),
    })
}

fn write_shape(target: Target<'_>, shape: Shape<'_>, options: &WriteOptions) -> Result<WriteReport, Error> {
    let path = target.path;
    let format = format_of(path, options)?;
    let refuse = |what, advice| Err(Error::CannotHold { path: path.to_path_buf(), format, what, advice });
    if format == Format::Stl && shape.triangles.is_empty() && !shape.positions().is_empty() {
        return refuse("points without triangles", "choose ply, pcd, las, e57, csv or xyz");
    }
    if format == Format::Json {
        return refuse("points and triangles", "choose ply, stl, obj, off or glb");
    }
    if format == Format::Ptx {
        return refuse("points that are not on the grid of a scanner", "choose pts, ply, csv or xyz");
    }
    if format.is_of_scanner() && !scanner::is_built(format) {
        return Err(scanner::not_built(format).in_file(path));
    }
    let mut warnings = Vec::new();
    let bytes = target.fill(|out| match format {
        Format::Ply => ply::write(out, shape, options.ascii, &mut warnings),
        Format::Xyz => xyz::write_xyz(out, shape, &mut warnings),
        Format::Csv => xyz::write_csv(out, shape, &mut warnings),
        Format::Pts => xyz::write_pts(out, shape, shape.positions().len(), &mut warnings),
        Format::Obj => obj::write(out, shape, &mut warnings),
        Format::Stl => stl::write(out, shape, &mut warnings),
        Format::Off => off::write(out, shape, &mut warnings),
        Format::Pcd => pcd::write(out, shape, &mut warnings),
        Format::Las | Format::Laz | Format::E57 => scanner::write(out, format, shape, &mut warnings),
        Format::Glb => glb::write(out, shape, &mut warnings),
        // Refused above.
        Format::Json | Format::Ptx => Err(io::ErrorKind::Unsupported.into()),
    })?;
    let keeps_triangles =
        matches!(format, Format::Ply | Format::Obj | Format::Stl | Format::Off | Format::Glb);
    Ok(WriteReport {
        path: path.to_path_buf(),
        format,
        points: shape.positions().len(),
        triangles: if keeps_triangles { shape.triangles.len() } else { 0 },
        shapes: 0,
        bytes,
        warnings,
    })
}

/// Whether [`write_cloud_pieces`] writes a format.
#[must_use]
pub fn is_written_in_pieces(path: impl AsRef<Path>, options: &WriteOptions) -> bool {
    let format = options.format.or_else(|| Format::from_path(path.as_ref()));
    matches!(format, Some(Format::Ply | Format::Xyz | Format::Csv | Format::Pts))
}

/// Writes `count` points piece by piece, as `fill` hands them over: the same bytes as those of all points together. The pieces carry
/// the same attributes, and no texts. The file appears whole or not at all.
///
/// # Errors
/// As [`write()`], [`Error::Unsupported`] for formats other than PLY, XYZ, CSV and PTS, and what `fill` fails with.
pub fn write_cloud_pieces<E: From<Error>>(
    path: impl AsRef<Path>,
    options: &WriteOptions,
    count: usize,
    fill: impl FnOnce(&mut dyn FnMut(&PointCloud) -> Result<(), E>) -> Result<(), E>,
) -> Result<WriteReport, E> {
    let path = path.as_ref();
    let format = format_of(path, options)?;
    if !is_written_in_pieces(path, options) {
        let what = format!("{format} is not written piece by piece");
        return Err(Error::unsupported(Place::Whole, what, "choose ply, xyz, csv or pts")
            .in_file(path)
            .into());
    }
    let failed = |source| Error::Io { path: path.to_path_buf(), action: "write", source };
    let mut file = AtomicFile::create(path)?;
    let (mut warnings, mut is_first, ascii) = (Vec::new(), true, options.ascii);
    let mut write = |cloud: &PointCloud| -> Result<(), E> {
        let (out, shape): (&mut dyn Write, _) = (&mut file, Shape { cloud, triangles: &[] });
        let written = match (format, is_first) {
            (Format::Ply, true) => ply::write_first(out, shape, count, ascii, &mut warnings),
            (Format::Ply, false) => ply::write_more(out, shape, ascii),
            (Format::Pts, true) => xyz::write_pts(out, shape, count, &mut warnings),
            (Format::Pts, false) => xyz::write_more_pts(out, shape),
            (Format::Csv, true) => xyz::write_csv(out, shape, &mut warnings),
            (_, true) => xyz::write_xyz(out, shape, &mut warnings),
            (_, false) => xyz::write_more(out, shape, format == Format::Csv),
        };
        is_first = false;
        Ok(written.map_err(failed)?)
    };
    let mut empty = None;
    fill(&mut |cloud| {
        if cloud.is_empty() {
            empty.get_or_insert_with(|| cloud.clone());
            return Ok(());
        }
        write(cloud)
    })?;
    if let Some(cloud) = empty.filter(|_| count == 0) {
        write(&cloud)?;
    }
    let bytes = file.commit()?;
    let path = path.to_path_buf();
    Ok(WriteReport { path, format, points: count, triangles: 0, shapes: 0, bytes, warnings })
}

fn format_of(path: &Path, options: &WriteOptions) -> Result<Format, Error> {
    options.format.or_else(|| Format::from_path(path)).ok_or_else(|| Error::Unsupported {
        location: Location { file: Some(path.to_path_buf()), place: Place::Whole },
        what: "the extension names no format that can be written".to_owned(),
        advice: "choose ply, xyz, csv, pts, obj, stl, off, pcd, las, laz, e57, glb or json".to_owned(),
    })
}
