//! Points with all that they carry, piece by piece, in and out.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use mesh_core::PointCloud;

use crate::content::{Content, Loaded};
use crate::parsed::{NO_POINTS, Parsed};
use crate::pieces::{Text, open_ply, open_text};
use crate::source::Source;
use crate::{Error, Format, ReadOptions, ReadReport, ply};

/// What the pieces add up to.
struct Sum<'a, E> {
    path: &'a Path,
    options: &'a ReadOptions,
    take: &'a mut dyn FnMut(PointCloud) -> Result<(), E>,
    failed: Option<E>,
    report: Option<ReadReport>,
}

impl<E> Sum<'_, E> {
    /// Hands a piece over; false if no more are wanted.
    fn add(&mut self, parsed: Parsed) -> Result<bool, Error> {
        let hint = Format::from_path(self.path);
        let Loaded { content, report } = crate::read::load(parsed, hint, self.options)?;
        match &mut self.report {
            Some(all) => {
                all.points += report.points;
                all.non_finite += report.non_finite;
                all.dropped += report.dropped;
            }
            None => self.report = Some(ReadReport { path: Some(self.path.to_path_buf()), ..report }),
        }
        let Content::Cloud(cloud) = content else { return Ok(true) };
        self.failed = (self.take)(cloud).err();
        Ok(self.failed.is_none())
    }
}

impl<E> Sum<'_, E> {
    /// Takes over what is known at the end only.
    #[cfg(feature = "e57")]
    fn tell(&mut self, rest: Parsed) -> Result<(), Error> {
        let hint = Format::from_path(self.path);
        let rest = crate::read::load(rest, hint, self.options)?.report;
        if let Some(report) = &mut self.report {
            (report.warnings, report.scans) = (rest.warnings, rest.scans);
        }
        Ok(())
    }
}

/// Reads points with all their attributes in pieces of at most `limit` points, in memory for one piece, and hands them to `take`;
/// together they have the bits that [`read`](crate::read) gives them. A piece may be empty where points are dropped.
///
/// Files of LAS and LAZ, E57 whose scans carry the same, binary PLY of points alone, tables (XYZ, CSV, PTS) of three coordinates without
/// names or texts, and PTX, can be read so; `None` for all others, before `take` was called. LAS, LAZ, tables and PTX are gone through twice.
///
/// # Errors
/// As [`read`](crate::read), and what `take` fails with.
pub fn read_cloud_pieces<E: From<Error>>(
    path: impl AsRef<Path>,
    options: &ReadOptions,
    limit: usize,
    mut take: impl FnMut(PointCloud) -> Result<(), E>,
) -> Result<Option<ReadReport>, E> {
    let (path, limit) = (path.as_ref(), limit.max(1));
    let mut sum = Sum { path, options, take: &mut take, failed: None, report: None };
    let is_read = read_into(limit, &mut sum);
    if let Some(error) = sum.failed {
        return Err(error);
    }
    let is_read = is_read.map_err(|error| error.in_file(path))?;
    // An empty file has something to be said about, as a whole.
    let mut report = sum.report.filter(|report| is_read && report.points > 0);
    if let Some(report) = &mut report {
        report.warnings.retain(|warning| warning != NO_POINTS);
    }
    Ok(report)
}

fn read_into<E>(limit: usize, sum: &mut Sum<'_, E>) -> Result<bool, Error> {
    let (path, options) = (sum.path, sum.options);
    let failed = |source| Error::Io { path: path.to_path_buf(), action: "read", source };
    #[cfg(any(feature = "las", feature = "e57"))]
    if let Some((format, _)) = crate::read::open_of_scanner(path, options)? {
        return of_scanner(format, limit, sum);
    }
    if let Some((mut file, rows)) = open_ply(path, options).map_err(failed)? {
        file.seek(SeekFrom::Start(rows.start)).map_err(failed)?;
        let (mut left, mut bytes) = (rows.count, Vec::new());
        while left > 0 {
            let count = usize::try_from(left).unwrap_or(usize::MAX).min(limit);
            bytes.resize(count * rows.stride, 0);
            file.read_exact(&mut bytes).map_err(failed)?;
            left -= count as u64;
            if !sum.add(ply::read(Source { data: &rows.file_of(&bytes) })?)? {
                break;
            }
        }
        return Ok(true);
    }
    match open_text(path, options).map_err(failed)? {
        Some((file, Text::Table(table))) => read_table(file, *table, limit, sum).map(|()| true),
        Some((file, Text::Grids(grids))) => {
            let read = grids.read_clouds(&file, options, limit, &mut |parsed| sum.add(parsed));
            read.map_err(failed)?.map(|()| true)
        }
        None => Ok(false),
    }
}

fn read_table<E>(
    mut file: File,
    table: crate::xyz::pieces::Table,
    limit: usize,
    sum: &mut Sum<'_, E>,
) -> Result<(), Error> {
    let path = sum.path;
    let failed = |source| Error::Io { path: path.to_path_buf(), action: "read", source };
    let (format, warnings) = (table.format(), table.warnings().to_vec());
    let mut take = |cloud| sum.add(Parsed::cloud(format, cloud, warnings.clone()));
    table.read_clouds(&mut file, limit, &mut take).map_err(failed)?
}

#[cfg(any(feature = "las", feature = "e57"))]
fn of_scanner<E>(format: Format, limit: usize, sum: &mut Sum<'_, E>) -> Result<bool, Error> {
    match format {
        #[cfg(feature = "las")]
        Format::Las | Format::Laz => {
            let (path, options) = (sum.path, sum.options);
            let open = || match crate::read::open_of_scanner(path, options)? {
                Some((_, input)) => Ok(input),
                None => Err(crate::scanner::not_built(format)),
            };
            crate::las::read_clouds(open, limit, &mut |parsed| sum.add(parsed))
        }
        #[cfg(feature = "e57")]
        Format::E57 => {
            let (path, options) = (sum.path, sum.options);
            let Some((_, input)) = crate::read::open_of_scanner(path, options)? else { return Ok(false) };
            let rest = crate::e57::read_clouds(input, options, limit, &mut |parsed| sum.add(parsed))?;
            rest.map_or(Ok(false), |rest| sum.tell(rest).map(|()| true))
        }
        _ => {
            let _ = (limit, sum);
            Ok(false)
        }
    }
}
