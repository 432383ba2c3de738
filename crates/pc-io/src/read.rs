//! Reading files of any format.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use mesh_core::{PointCloud, TriangleMesh};

use crate::columns::NotPoints;
use crate::content::{Content, Loaded};
#[cfg(any(feature = "las", feature = "e57"))]
use crate::foreign::Input;
use crate::format::recognise;
use crate::parsed::Parsed;
use crate::source::{Source, decode_text};
use crate::{Error, Format, Model, Place, ReadOptions, json, obj, off, pcd, ply, ptx, scanner, stl, xyz};

/// Reads a file, its format recognised by the content first and the extension second.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; otherwise whatever is wrong with its content, with line or byte.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded<Content>, Error> {
    read_as(path.as_ref(), options, Ok)
}

/// Reads points; of a mesh its vertices.
///
/// # Errors
/// As [`read`], and [`Error::WrongContent`] for NURBS.
pub fn read_cloud(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded<PointCloud>, Error> {
    read_as(path.as_ref(), options, Content::into_cloud)
}

/// Reads a triangle mesh.
///
/// # Errors
/// As [`read`], and [`Error::WrongContent`] for files without triangles.
pub fn read_mesh(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded<TriangleMesh>, Error> {
    read_as(path.as_ref(), options, Content::into_mesh)
}

/// Reads NURBS curves and surfaces.
///
/// # Errors
/// As [`read`], and [`Error::WrongContent`] for clouds and meshes.
pub fn read_model(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded<Model>, Error> {
    read_as(path.as_ref(), options, Content::into_model)
}

/// Reads a stream to its end, such as standard input; `name` stands for it in messages and in the report, and
/// its extension counts as that of a file.
///
/// ```
/// use pc_io::{ReadOptions, read_from};
///
/// let scan = read_from("1 2 3\n4 5 6\n".as_bytes(), "standard input", &ReadOptions::default())?;
/// assert_eq!(scan.report.points, 2);
/// let error = read_from("1 2 3\n4 5\n".as_bytes(), "standard input", &ReadOptions::default()).unwrap_err();
/// assert!(error.to_string().starts_with("standard input:2: "));
/// # Ok::<(), pc_io::Error>(())
/// ```
///
/// # Errors
/// As [`read`].
pub fn read_from(
    mut stream: impl Read,
    name: impl AsRef<Path>,
    options: &ReadOptions,
) -> Result<Loaded<Content>, Error> {
    let mut data = Vec::new();
    let ended = stream.read_to_end(&mut data).map(|_| data);
    read_named(ended, name.as_ref(), options, Ok)
}

fn read_as<T>(
    path: &Path,
    options: &ReadOptions,
    take: fn(Content) -> Result<T, Error>,
) -> Result<Loaded<T>, Error> {
    #[cfg(any(feature = "las", feature = "e57"))]
    if let Some((format, input)) = open_of_scanner(path, options)? {
        let hint = Format::from_path(path);
        let loaded = scanner::read(format, input, options).and_then(|parsed| load(parsed, hint, options));
        return name(loaded, path, take);
    }
    read_named(read_file(path), path, options, take)
}

/// Opens a file of a scanner, which may be larger than what is kept of it, so that it is decoded while it is read.
#[cfg(any(feature = "las", feature = "e57"))]
pub(crate) fn open_of_scanner(path: &Path, options: &ReadOptions) -> Result<Option<(Format, Input)>, Error> {
    use std::io::{Seek, SeekFrom};
    let opened = || {
        if !fs::metadata(path)?.is_file() {
            return Ok(None);
        }
        let mut file = File::open(path)?;
        let mut head = Vec::new();
        Read::by_ref(&mut file).take(scanner::MAGIC as u64).read_to_end(&mut head)?;
        let format = match options.format {
            Some(format) => Some(format).filter(|format| scanner::is_built(*format)),
            None => scanner::by_magic(&head),
        };
        file.seek(SeekFrom::Start(0))?;
        format.map(|format| Ok((format, Input::of_file(file)?))).transpose()
    };
    opened().map_err(|source| Error::Io { path: path.to_path_buf(), action: "read", source })
}

fn read_named<T>(
    data: std::io::Result<Vec<u8>>,
    path: &Path,
    options: &ReadOptions,
    take: fn(Content) -> Result<T, Error>,
) -> Result<Loaded<T>, Error> {
    let data = data.map_err(|source| Error::Io { path: path.to_path_buf(), action: "read", source })?;
    name(read_bytes(&data, Format::from_path(path), options), path, take)
}

/// Names the file in what was read of it, or in the error.
fn name<T>(
    loaded: Result<Loaded<Content>, Error>,
    path: &Path,
    take: fn(Content) -> Result<T, Error>,
) -> Result<Loaded<T>, Error> {
    let Loaded { content, mut report } = loaded.map_err(|error| error.in_file(path))?;
    report.path = Some(path.to_path_buf());
    Ok(Loaded { content: take(content).map_err(|error| error.in_file(path))?, report })
}

fn read_file(path: &Path) -> std::io::Result<Vec<u8>> {
    // A folder can be opened on some systems, and the message about reading it is odd.
    if fs::metadata(path)?.is_dir() {
        return Err(std::io::ErrorKind::IsADirectory.into());
    }
    let mut file = File::open(path)?;
    let mut data = Vec::new();
    file.read_to_end(&mut data)?;
    Ok(data)
}

/// Reads bytes; `hint` is the format that a file name would suggest.
///
/// # Errors
/// Whatever is wrong with the content, with line or byte but without a file.
pub fn read_bytes(
    data: &[u8],
    hint: Option<Format>,
    options: &ReadOptions,
) -> Result<Loaded<Content>, Error> {
    #[cfg(any(feature = "las", feature = "e57"))]
    if let Some(format) = options.format.map_or_else(
        || scanner::by_magic(data),
        |format| Some(format).filter(|format| scanner::is_built(*format)),
    ) {
        return load(scanner::read(format, Input::of_bytes(data), options)?, hint, options);
    }
    let data = if stl::is_binary(data) { Cow::Borrowed(data) } else { decode_text(data) };
    let source = Source { data: &data };
    let format = match options.format {
        Some(format) => format,
        None => recognise(source, hint)?,
    };
    let parsed = match format {
        Format::Ply => ply::read(source)?,
        Format::Xyz | Format::Csv | Format::Pts => xyz::read(source, options)?,
        Format::Ptx => ptx::read(source, options)?,
        Format::Obj => obj::read(source)?,
        Format::Stl => stl::read(source)?,
        Format::Off => off::read(source)?,
        Format::Pcd => pcd::read(source)?,
        Format::Json => json::read(source)?,
        Format::Glb => {
            let advice = "convert it to PLY, OBJ or STL first";
            return Err(Error::unsupported(Place::Whole, "binary glTF is written, but not read", advice));
        }
        Format::Las | Format::Laz | Format::E57 => return Err(scanner::not_built(format)),
    };
    load(parsed, hint, options)
}

/// What the reader of a format found, with the report.
pub(crate) fn load(
    parsed: Parsed,
    hint: Option<Format>,
    options: &ReadOptions,
) -> Result<Loaded<Content>, Error> {
    let (content, format, mut warnings, scans) = parsed.into_content()?;
    if let Some(scan) = options.scan.as_ref().filter(|_| !format.has_scans()) {
        let what = format!("the scan {scan:?} is asked for, but a {format} file does not tell scans apart");
        return Err(Error::unsupported(
            Place::Whole,
            what,
            "give an E57 or PTX file, or do not choose a scan",
        ));
    }
    if let Some(hint) = hint.filter(|hint| *hint != format && !(hint.is_table() && format.is_table())) {
        warnings.push(format!("the name suggests {hint}, but the content is {format}"));
    }
    Ok(content.into_loaded(format, warnings, scans, options.drop_non_finite))
}

/// Says that columns are no points.
pub(crate) fn not_points(reason: NotPoints) -> Error {
    let advice = "name the columns of the coordinates x, y and z, each once";
    match reason {
        NotPoints::Missing(name) => {
            Error::malformed(Place::Whole, format!("no column is named {name}"), advice)
        }
        NotPoints::Twice(name) => {
            Error::malformed(Place::Whole, format!("several columns are named {name}"), advice)
        }
        NotPoints::Shape(error) => Error::shape(error),
    }
}
