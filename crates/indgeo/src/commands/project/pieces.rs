//! The projection of a cloud that may be larger than memory: read, projected and written piece by piece.
//!
//! The file is read twice: first to count its points, which stand before the rows in some formats, and then to project them.

use crate::commands::project::job::{self as projection, Prepared};
use crate::commands::project::request::Job;
use crate::commands::project::results::ResultsSum;
use crate::error::Error;
use crate::input::points::{self, Points};
use crate::output::{self, Format, Table};
use crate::report::wording::counted;
use crate::report::{Output, Report, Timings};
use crate::runtime::memory;
use crate::runtime::progress::Progress;
use industrial_geometry::io::{self, Piece, ReadOptions, ReadReport};
use industrial_geometry::mesh::BoundingBox;
use std::time::Instant;

/// Points of a piece.
const PIECE: usize = 1 << 17;

/// What the first reading tells.
pub(crate) struct Survey {
    read: ReadReport,
    /// Diagonal of the box of the points.
    diagonal: f64,
    /// Number of rows of the result.
    rows: usize,
    /// Seconds.
    seconds: f64,
}

fn options(job: &Job<'_>) -> ReadOptions {
    let options = ReadOptions::default().with_drop_non_finite(job.drop_non_finite);
    options.with_scan(job.scan.map(str::to_owned))
}

/// Counts the points; `None` where they have to be read as a whole.
pub(crate) fn survey(job: &Job<'_>, prepared: &Prepared) -> Result<Option<Survey>, Error> {
    // Points in the plane are not read in pieces.
    if prepared.target.is_planar() {
        return Ok(None);
    }
    let began = Instant::now();
    let (mut bounds, mut rows): (Option<BoundingBox>, usize) = (None, 0);
    let read = io::read_pieces(job.points, &options(job), PIECE, |piece| {
        if job.max_angle.is_some() && piece.normals.is_none() {
            return Err(projection::no_normals(job.points));
        }
        rows += piece.positions.len();
        if let Some(more) = BoundingBox::of(&piece.positions) {
            let all = bounds.get_or_insert(more);
            (all.min, all.max) = (all.min.inf(&more.min), all.max.sup(&more.max));
        }
        Ok(())
    })?;
    let Some(read) = read else { return Ok(None) };
    points::check_counts(job.points, &read)?;
    let diagonal = bounds.map_or(0.0, |bounds| bounds.diagonal());
    Ok(Some(Survey { read, diagonal, rows, seconds: began.elapsed().as_secs_f64() }))
}

/// Projects and writes the points, and fills in the report.
pub(crate) fn run(
    job: &Job<'_>,
    prepared: Prepared,
    survey: &Survey,
    format: Format,
    report: &mut Report,
) -> Result<(), Error> {
    prepared.describe(job, &survey.read, survey.diagonal, report);
    let progress = Progress::new("projecting", job.quiet);
    let mut sum = ResultsSum::of(&prepared.target);
    let (began, mut compute, mut write) = (Instant::now(), 0.0, 0.0);
    let written = output::write_in_pieces(job.out, format, survey.rows, |sink| {
        let take = |piece: Piece| -> Result<(), Error> {
            if memory::is_cancelled() {
                return Err(Error::usage("cancelled", "nothing was written"));
            }
            let points = Points::of_piece(piece, job.max_angle.is_some(), &survey.read);
            let done = sum.points();
            let tell = |part: usize, _: usize| progress.report(done + part, survey.rows);
            let feet = Timings::measure(&mut compute, || {
                prepared.target.project(&points, job.points, &job.options, job.max_angle, &tell)
            })?;
            Timings::measure(&mut compute, || sum.add(&points, &feet));
            let table = Table {
                layout: &prepared.layout,
                points: &points.positions,
                point_names: None,
                feet: &feet,
                triangles: &[],
            };
            Timings::measure(&mut write, || sink(&table))
        };
        let read = io::read_pieces(job.points, &options(job), PIECE, take)?;
        let is_same = read.is_some_and(|read| read.points == survey.read.points);
        if !is_same || sum.points() != survey.rows {
            let what = "the file has changed while it was read";
            return Err(Error::content(job.points, what, "run the command again"));
        }
        Ok(())
    })?;
    drop(progress);
    let mut timings = prepared.timings;
    timings.read += survey.seconds + (began.elapsed().as_secs_f64() - compute - write).max(0.0);
    timings.compute += compute;
    timings.write += write;
    report.points_per_second = (compute > 0.0).then(|| survey.rows as f64 / compute);
    report.timings = timings;
    let columns = prepared.layout.names();
    let content = format!("{}: {}", counted(survey.rows, "row"), columns.join(","));
    report.warnings.extend(written.warnings);
    report.add_output(Output { path: job.out.to_path_buf(), bytes: written.bytes, content });
    projection::conclude(job, sum.finish(job, &survey.read, columns, &prepared.shapes), report);
    Ok(())
}
