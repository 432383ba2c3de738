//! The inspection of a cloud: read, measure, judge, write. `inspect`, `merge`, `register` and `demo` run this.
//!
//! Whether a cloud is read as a whole or piece by piece, as one file, as tiles, or as parts that other runs have left behind: it is
//! gathered in the same exact sums ([`gather`]), and judged and written by the same code ([`outputs`]).

mod gather;
mod identity;
mod merging;
mod nominal;
mod outputs;
mod partial_file;
mod results;
mod warnings;

pub(crate) use gather::parse_range;
pub(crate) use merging::{Parts, merge, merge_step};
pub(crate) use results::InspectionResults;

use crate::commands::register::step::StepSums;
use crate::error::Error;
use crate::files;
use crate::input::cad::Choice;
use crate::input::transform::Transform;
use crate::output::{self, Format};
use crate::report::{Report, Timings};
use crate::runtime::progress::Progress;
use gather::{Gathered, Gathering};
use industrial_geometry::inspection::{self, Inspection, InspectionOptions};
use industrial_geometry::io::ReadOptions;
use nominal::Setup;
use outputs::RowsOut;
use partial_file::Request;
use std::collections::BTreeSet;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Most points in the picture of a report.
pub(crate) const MOST_POINTS: u32 = 1_000_000;

/// How points are moved before they are measured.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Motion<'a> {
    /// Not at all.
    None,
    /// By the motion of a file.
    File(&'a Path),
    /// By a motion that is known.
    Known(Transform),
}

impl Motion<'_> {
    /// The file of the motion.
    fn file(&self) -> Option<&Path> {
        if let Self::File(path) = self { Some(path) } else { None }
    }

    /// The motion itself.
    fn transform(&self) -> Result<Option<Transform>, Error> {
        match self {
            Self::None => Ok(None),
            Self::File(path) => Transform::read(path).map(Some),
            Self::Known(transform) => Ok(Some(*transform)),
        }
    }
}

/// What is to be done.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// File of the model.
    pub(crate) model: &'a Path,
    /// What is chosen of a CAD model.
    pub(crate) cad: &'a Choice,
    /// Files of the points, which together are one cloud.
    pub(crate) points: &'a [PathBuf],
    /// The points that count of a single file, by their numbers from 0 on.
    pub(crate) range: Option<Range<u64>>,
    /// How the points are moved first.
    pub(crate) motion: Motion<'a>,
    /// File of the page.
    pub(crate) page: Option<&'a Path>,
    /// Most points in its picture.
    pub(crate) picture: u32,
    /// File of the deviations per point.
    pub(crate) out: Option<&'a Path>,
    /// Their format, if not that of the extension.
    pub(crate) format: Option<Format>,
    /// Options of the library.
    pub(crate) options: InspectionOptions,
    /// The mode of the search, by its name on the command line.
    pub(crate) mode: &'static str,
    /// Whether points that are not finite are left out.
    pub(crate) drop_non_finite: bool,
    /// The scan that is read of a file of several.
    pub(crate) scan: Option<&'a str>,
    /// Number of threads asked for.
    pub(crate) threads: Option<u16>,
    /// Whether nobody wants to watch.
    pub(crate) quiet: bool,
}

impl Job<'_> {
    /// The files of the points in the order in which they count, whatever that of the command line: by their paths.
    fn tiles(&self) -> Result<Vec<&Path>, Error> {
        let mut tiles: Vec<&Path> = self.points.iter().map(PathBuf::as_path).collect();
        tiles.sort_unstable();
        let mut places = BTreeSet::new();
        for tile in &tiles {
            let place = fs::canonicalize(tile).unwrap_or_else(|_| tile.to_path_buf());
            if !places.insert(place) {
                return Err(Error::content(
                    tile,
                    "the file is named twice",
                    "name every file of points once",
                ));
            }
        }
        Ok(tiles)
    }

    /// How the files of the points are read.
    fn read_options(&self) -> ReadOptions {
        let options = ReadOptions::default().with_drop_non_finite(self.drop_non_finite);
        options.with_scan(self.scan.map(str::to_owned))
    }

    /// The files that are read.
    fn inputs(&self) -> Vec<&Path> {
        let points = self.points.iter().map(PathBuf::as_path);
        std::iter::once(self.model).chain(points).chain(self.motion.file()).collect()
    }
}

/// Does the job and fills in the report.
pub(crate) fn run(job: &Job<'_>, report: &mut Report) -> Result<Inspection, Error> {
    let format = job.out.map(|out| Format::of(out, job.format)).transpose()?;
    if let Some(page) = job.page {
        check_extension(page)?;
    }
    for path in [job.out, job.page].into_iter().flatten() {
        files::check_writable(path, &job.inputs())?;
    }
    let tiles = job.tiles()?;
    let mut timings = Timings::default();
    let setup = Setup::read(job, &mut timings, report)?;
    let mut streamed = None;
    if let Some((out, format)) = job.out.zip(format) {
        if output::is_written_in_pieces(format) {
            let rows = Timings::measure(&mut timings.read, || gather::survey(job, &setup, &tiles))?;
            streamed = rows.map(|rows| (out, format, rows));
        }
        if streamed.is_none() && tiles.len() > 1 {
            let what = "deviations per point of several files are written as CSV or PLY, of files that are read in pieces";
            return Err(Error::content(out, what, "give one file of points, or leave out --out"));
        }
    }
    let progress = Progress::new("measuring", job.quiet);
    let mut gathering = Gathering::new(job, &setup, &progress, job.page.is_some())?;
    let range = job.range.as_ref();
    let rows = if let Some((out, format, rows)) = streamed {
        let written = output::write_in_pieces(out, format, rows, |sink| {
            tiles.iter().try_for_each(|tile| gathering.add_tile(tile, range, Some(sink)).map(|_| ()))
        })?;
        RowsOut::Written(out, written.bytes, rows)
    } else {
        let mut kept = None;
        for tile in tiles {
            kept = gathering.add_tile(tile, range, None)?;
        }
        kept.zip(format).map_or(RowsOut::None, |(kept, format)| RowsOut::Kept(Box::new(kept), format))
    };
    let gathered = gathering.finish(&mut timings);
    drop(progress);
    outputs::conclude(job, setup, gathered, rows, timings, report)
}

/// Measures one file of points, or some of its points, and leaves behind what [`merge`] makes a report of; `arguments` are the
/// options of the job as typed.
pub(crate) fn run_partial(
    job: &Job<'_>,
    arguments: Vec<String>,
    out: &Path,
    report: &mut Report,
) -> Result<Inspection, Error> {
    let (setup, gathered, timings) = measure_part(job, arguments, out, false, report)?;
    outputs::conclude(job, setup, gathered, RowsOut::None, timings, report)
}

/// The same for the sums of a step of a registration, which [`merge_step`] makes a step of.
pub(crate) fn run_partial_step(
    job: &Job<'_>,
    arguments: Vec<String>,
    out: &Path,
    report: &mut Report,
) -> Result<(), Error> {
    let (setup, gathered, timings) = measure_part(job, arguments, out, true, report)?;
    report.timings = timings;
    outputs::add_inputs(job, &setup, &gathered, report)
}

fn measure_part(
    job: &Job<'_>,
    arguments: Vec<String>,
    out: &Path,
    is_step: bool,
    report: &mut Report,
) -> Result<(Setup, Gathered, Timings), Error> {
    files::check_writable(out, &job.inputs())?;
    let request = Request::new(job, arguments)?;
    let mut timings = Timings::default();
    let setup = Setup::read(job, &mut timings, report)?;
    let progress = Progress::new("measuring", job.quiet);
    let mut gathering = Gathering::new(job, &setup, &progress, !is_step)?;
    gathering.hash_points();
    if is_step {
        gathering.sum_step(StepSums::new(&setup.nominal).ok_or_else(|| {
            Error::content(job.model, "the sums of a step take surfaces or a mesh", "leave out --partial")
        })?);
    }
    gathering.add_tile(request.tile(), job.range.as_ref(), None)?;
    let gathered = gathering.finish(&mut timings);
    drop(progress);
    // What cannot be used leaves no file behind.
    if job.range.is_none() {
        gathered.tiles.iter().try_for_each(|(path, counts)| gather::check_counts(path, counts))?;
    }
    let output = Timings::measure(&mut timings.write, || request.write(out, &setup, &gathered))?;
    report.add_output(output);
    Ok((setup, gathered, timings))
}

fn check_extension(page: &Path) -> Result<(), Error> {
    match files::extension(page).as_str() {
        "html" | "htm" => Ok(()),
        _ if files::is_stream(page) => Ok(()),
        _ => Err(Error::content(page, "the report is a page", "choose a name that ends in .html")),
    }
}

/// The error of the library, with the option as it is typed.
pub(crate) fn usage(error: &inspection::Error) -> Error {
    let help = "see `indgeo inspect --help`";
    match error {
        inspection::Error::Option { option, value, what } => {
            Error::usage(format!("--{} is {value}: {what}", option.replace('_', "-")), help)
        }
        _ => Error::usage(error.to_string(), help),
    }
}
