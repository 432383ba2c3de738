//! The inspection of a cloud that may be larger than memory: read, measured and counted piece by piece.
//!
//! The result has the bits of an inspection in memory, since counts, sums and distributions are exact and the points keep their
//! numbers. Memory is bounded by the model and a piece. Files with a row or a mark per point (`-o`, `--report`) need all points.

use crate::error::Error;
use crate::inspecting::{self, Job};
use crate::inspection_results::conclude;
use crate::model::{Loaded, Model};
use crate::points;
use crate::progress::Progress;
use crate::report::{Input, Report, Timings};
use crate::transform::Transform;
use industrial_geometry::inspection::{Inspection, InspectionOptions, Nominal, Partial};
use industrial_geometry::io::{self, Piece, ReadOptions};
use industrial_geometry::mesh::BoundingBox;
use std::time::Instant;

/// Points of a piece.
const PIECE: usize = 1 << 18;

/// Whether a job can be done piece by piece: nothing is written per point, the model lies in space, and the file of points can be
/// read so.
pub(crate) fn fits(job: &Job<'_>, loaded: &Loaded) -> bool {
    job.out.is_none()
        && job.page.is_none()
        && !matches!(loaded.model, Model::Plane(_))
        && io::is_read_in_pieces(job.points, &read_options(job))
}

fn read_options(job: &Job<'_>) -> ReadOptions {
    let options = ReadOptions::default().with_drop_non_finite(job.drop_non_finite);
    options.with_scan(job.scan.map(str::to_owned))
}

/// What the pieces add up to.
struct Sum<'a> {
    job: &'a Job<'a>,
    options: &'a InspectionOptions,
    nominal: &'a Nominal,
    transform: Option<Transform>,
    partial: Partial,
    /// Points measured so far, which is the number of the next one.
    points: u64,
    bounds: Option<BoundingBox>,
    /// Seconds of measuring.
    compute: f64,
    progress: &'a Progress,
}

impl Sum<'_> {
    fn add(&mut self, mut piece: Piece) -> Result<(), Error> {
        inspecting::check_normals(self.job, &mut piece.normals)?;
        if let Some(transform) = &self.transform {
            transform.apply_to(&mut piece.positions, piece.normals.as_deref_mut());
        }
        if let Some(bounds) = BoundingBox::of(&piece.positions) {
            let all = self.bounds.get_or_insert(bounds);
            all.min = all.min.inf(&bounds.min);
            all.max = all.max.sup(&bounds.max);
        }
        let start = Instant::now();
        let (before, partial, positions) = (self.points, &mut self.partial, &piece.positions);
        let done = usize::try_from(before).unwrap_or(usize::MAX);
        // How many there are in all is known at the end only.
        let tell = |part: usize, total: usize| {
            self.progress.report(done.saturating_add(part), done.saturating_add(total))
        };
        let mut receive = |measured: &[(usize, _)]| partial.extend_with(before, positions, measured);
        self.nominal
            .measure_each(positions, piece.normals.as_deref(), self.options, &tell, &mut receive)
            .map_err(|error| inspecting::usage(&error))?;
        self.points += positions.len() as u64;
        self.compute += start.elapsed().as_secs_f64();
        Ok(())
    }
}

/// Does the job and fills in the report.
pub(crate) fn run(
    job: &Job<'_>,
    loaded: Loaded,
    transform: Option<Transform>,
    mut timings: Timings,
    report: &mut Report,
) -> Result<Inspection, Error> {
    let measured = inspecting::measured(&loaded.model);
    let units = match &loaded.model {
        Model::Cad(cad) => Some(cad.units()),
        _ => None,
    };
    let of_model = loaded.report.warnings.clone();
    let before = report.warnings.len();
    let nominal = Timings::measure(&mut timings.build, || inspecting::build(loaded, job, report))?;
    let of_build = report.warnings.split_off(before);
    let options = inspecting::options(job, &nominal);
    inspecting::describe(job, &nominal, measured, units.as_ref(), transform.as_ref(), report);
    let progress = Progress::new("measuring", job.quiet);
    let partial = Partial::new(&options).map_err(|error| inspecting::usage(&error))?;
    let mut sum = Sum {
        job,
        options: &options,
        nominal: &nominal,
        transform,
        partial,
        points: 0,
        bounds: None,
        compute: 0.0,
        progress: &progress,
    };
    let start = Instant::now();
    let read = io::read_pieces(job.points, &read_options(job), PIECE, |piece| sum.add(piece))?;
    let Some(read) = read else {
        let what = "the file has changed while the model was read";
        return Err(Error::content(job.points, what, "run the command again"));
    };
    timings.read += (start.elapsed().as_secs_f64() - sum.compute).max(0.0);
    timings.compute += sum.compute;
    points::check_counts(job.points, &read)?;
    report.add_input(Input::new("points", job.points, &read));
    inspecting::warn(report, job, &of_model, &read);
    let diagonal = sum.bounds.map_or(0.0, |bounds| bounds.diagonal());
    report.warnings.extend(units.and_then(|units| units.warning(diagonal)));
    report.warnings.extend(of_build);
    let (count, kept) = (sum.points, (read.points - read.dropped) as u64);
    let found = sum.partial.finish(&options, nominal.shapes()).map_err(|error| inspecting::usage(&error))?;
    drop(progress);
    // What was read is judged or refused, point by point; a verdict is not given on anything else.
    if count != kept || found.points != kept || found.outcomes.values().sum::<u64>() != kept {
        let what = format!("{kept} points were read, but {} are accounted for", found.points);
        return Err(Error::content(job.points, what, "run the command again"));
    }
    inspecting::warn_of_unproven(report, job, &found);
    report.points_per_second = (timings.compute > 0.0).then(|| count as f64 / timings.compute);
    report.timings = timings;
    conclude(&found, read.non_finite, report);
    Ok(found)
}
