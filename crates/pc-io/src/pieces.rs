//! Points of files that are larger than memory, piece by piece.

use std::fs::{self, File};
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use crate::format::recognise;
use crate::parsed::Parsed;
use crate::piece::{Piece, Taker};
use crate::ptx_pieces::Grids;
#[cfg(any(feature = "las", feature = "e57"))]
use crate::scanner;
use crate::source::Source;
use crate::xyz::pieces::Table;
use crate::{Error, Format, ReadOptions, ReadReport, ply};
use mesh_core::PointCloud;

/// Reads the points of a file in pieces of at most `limit` points, in memory for one piece, and hands them to `take`.
///
/// Files of LAS, LAZ and E57, binary PLY of points alone (without triangles and texts), PTX, and tables (XYZ, CSV, PTS) of three
/// coordinates without names or texts, can be read so; `None` for all others, and for texts in which anything is wrong, before `take`
/// was called: [`read`](crate::read) takes them. Coordinates and normals have the bits that [`read`](crate::read) gives them; what
/// else points carry is not looked at, and not warned about. Texts are gone through twice, first to see that all lines are alike.
///
/// ```
/// use pc_io::mesh_core::PointCloud;
/// use pc_io::nurbs_core::nalgebra::Point3;
/// use pc_io::{ReadOptions, WriteOptions, read_pieces, write_cloud};
///
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("scan.ply");
/// let positions = (0..10).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
/// let _ = write_cloud(&path, &PointCloud::new(positions), &WriteOptions::default())?;
/// let mut sizes = Vec::new();
/// let report = read_pieces(&path, &ReadOptions::default(), 4, |piece| {
///     sizes.push(piece.positions.len());
///     Ok::<(), pc_io::Error>(())
/// })?;
/// assert_eq!(sizes, [4, 4, 2]);
/// assert_eq!(report.map(|report| report.points), Some(10));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`read`](crate::read), and what `take` fails with.
pub fn read_pieces<E: From<Error>>(
    path: impl AsRef<Path>,
    options: &ReadOptions,
    limit: usize,
    take: impl FnMut(Piece) -> Result<(), E>,
) -> Result<Option<ReadReport>, E> {
    Ok(read_range(path, options, 0..u64::MAX, limit, take)?.map(|(report, _)| report))
}

/// As [`read_pieces`], of the points alone whose numbers in the file, from 0 on, are in `range`; the report counts these. Also
/// returned is the number of all points of the file, from which a range that reaches beyond them can be told.
///
/// Binary PLY, LAS and LAZ are read from the first point of the range on, E57 from the beginning to the end.
///
/// # Errors
/// As [`read_pieces`].
pub fn read_range<E: From<Error>>(
    path: impl AsRef<Path>,
    options: &ReadOptions,
    range: Range<u64>,
    limit: usize,
    mut take: impl FnMut(Piece) -> Result<(), E>,
) -> Result<Option<(ReadReport, u64)>, E> {
    let (path, limit) = (path.as_ref(), limit.max(1));
    let mut taker = Taker {
        take: &mut take,
        failed: None,
        drop_non_finite: options.drop_non_finite,
        range,
        next: 0,
        total: None,
        points: 0,
        non_finite: 0,
    };
    let found = read_into(path, options, limit, &mut taker);
    if let Some(error) = taker.failed {
        return Err(error);
    }
    let Some(parsed) = found.map_err(|error| error.in_file(path))? else { return Ok(None) };
    let (points, non_finite, total) = (taker.points, taker.non_finite, taker.total.unwrap_or(taker.next));
    let loaded =
        crate::read::load(parsed, Format::from_path(path), options).map_err(|error| error.in_file(path))?;
    let mut warnings = loaded.report.warnings;
    // The cloud of the report is empty because its points were handed over.
    warnings.retain(|warning| points == 0 || warning != crate::parsed::NO_POINTS);
    let dropped = if options.drop_non_finite { non_finite } else { 0 };
    let report =
        ReadReport { path: Some(path.to_path_buf()), points, non_finite, dropped, warnings, ..loaded.report };
    Ok(Some((report, total)))
}

/// Reads the points; what is left for the report.
fn read_into<E>(
    path: &Path,
    options: &ReadOptions,
    limit: usize,
    taker: &mut Taker<'_, E>,
) -> Result<Option<Parsed>, Error> {
    #[cfg(any(feature = "las", feature = "e57"))]
    if let Some((format, input)) = crate::read::open_of_scanner(path, options)? {
        return scanner::read_pieces(format, input, options, limit, taker).map(Some);
    }
    let failed = |source| Error::Io { path: path.to_path_buf(), action: "read", source };
    let Some((mut file, rows)) = open_ply(path, options).map_err(failed)? else {
        return read_text(path, options, limit, taker).map_err(failed);
    };
    let range = taker.begin(rows.count);
    file.seek(SeekFrom::Start(rows.start + range.start * rows.stride as u64)).map_err(failed)?;
    let mut left = range.end - range.start;
    let mut bytes = Vec::new();
    while left > 0 {
        let count = usize::try_from(left).unwrap_or(usize::MAX).min(limit);
        bytes.resize(count * rows.stride, 0);
        file.read_exact(&mut bytes).map_err(failed)?;
        left -= count as u64;
        if !taker.give(rows.piece(&bytes)) {
            break;
        }
    }
    Ok(Some(Parsed::cloud(Format::Ply, PointCloud::new(Vec::new()), Vec::new())))
}

/// A text file that can be read piece by piece, and what its survey told.
pub(crate) enum Text {
    Table(Box<Table>),
    Grids(Grids),
}

/// Opens a table or the grids of PTX, and looks through it.
pub(crate) fn open_text(path: &Path, options: &ReadOptions) -> std::io::Result<Option<(File, Text)>> {
    if !fs::metadata(path)?.is_file() {
        return Ok(None);
    }
    let mut file = File::open(path)?;
    let head = crate::xyz::pieces::head(&mut file)?;
    // Letters of two bytes, and whatever is no text.
    if head.contains(&0) || head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
        return Ok(None);
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head);
    let format = options.format.or_else(|| recognise(Source { data: text }, Format::from_path(path)).ok());
    let opened = match format {
        Some(format) if format.is_table() => {
            Table::survey(&mut file, &head, options)?.map(|table| Text::Table(Box::new(table)))
        }
        // A mark of the encoding stands before the first count.
        Some(Format::Ptx) if text.len() == head.len() => Grids::survey(&file, options)?.map(Text::Grids),
        _ => None,
    };
    Ok(opened.map(|text| (file, text)))
}

fn read_text<E>(
    path: &Path,
    options: &ReadOptions,
    limit: usize,
    taker: &mut Taker<'_, E>,
) -> std::io::Result<Option<Parsed>> {
    let Some((mut file, text)) = open_text(path, options)? else { return Ok(None) };
    let nothing = || PointCloud::new(Vec::new());
    Ok(Some(match text {
        Text::Table(table) => {
            table.read(&mut file, limit, taker)?;
            Parsed::cloud(table.format(), nothing(), table.warnings().to_vec())
        }
        Text::Grids(grids) => {
            grids.read(&file, options, limit, taker)?;
            let scans = grids.scans;
            Parsed { scans, ..Parsed::cloud(Format::Ptx, nothing(), grids.warnings) }
        }
    }))
}

/// Opens a binary PLY file of points alone.
pub(crate) fn open_ply(
    path: &Path,
    options: &ReadOptions,
) -> std::io::Result<Option<(BufReader<File>, ply::PointRows)>> {
    let is_other = options.format.is_some_and(|format| format != Format::Ply);
    if !fs::metadata(path)?.is_file() || is_other {
        return Ok(None);
    }
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut file = BufReader::with_capacity(1 << 16, file);
    let mut head = Vec::new();
    file.by_ref().take(ply::HEAD).read_to_end(&mut head)?;
    Ok(ply::PointRows::of(&head, length).map(|rows| (file, rows)))
}

/// Whether [`read_pieces`] reads a file. Files that cannot be opened are none of these.
#[must_use]
pub fn is_read_in_pieces(path: impl AsRef<Path>, options: &ReadOptions) -> bool {
    let path = path.as_ref();
    #[cfg(any(feature = "las", feature = "e57"))]
    if crate::read::open_of_scanner(path, options).is_ok_and(|opened| opened.is_some()) {
        return true;
    }
    open_ply(path, options).is_ok_and(|opened| opened.is_some())
        || open_text(path, options).is_ok_and(|opened| opened.is_some())
}
