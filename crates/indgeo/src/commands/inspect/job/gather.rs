//! What a cloud adds up to: its points are read, moved, measured and counted, file by file and piece by piece.
//!
//! Counts, sums, distributions and the sample of the picture are exact and do not depend on pieces, tiles or their order, so that
//! all ways to gather a cloud end in the same bits. Memory is bounded by the model and a piece where the format of the file can be
//! read in pieces and nothing is written per point.

use super::identity::PointsHash;
use super::nominal::Setup;
use super::{Job, usage};
use crate::commands::register::step::StepSums;
use crate::error::Error;
use crate::files;
use crate::input::points::{self, Points};
use crate::output::{Measured, Sink};
use crate::report::Timings;
use crate::runtime::memory;
use crate::runtime::progress::Progress;
use industrial_geometry::inspection::{
    self, Along, Deviation, DeviationRecord, InspectionOptions, Outcome, Partial, Picture,
};
use industrial_geometry::io::{self, ReadOptions, ReadReport};
use industrial_geometry::mesh::BoundingBox;
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Points of a piece.
const PIECE: usize = 1 << 18;
/// Height over the plane, as a share of the distance from the origin, that rounding leaves.
const OFF_PLANE: f64 = 1e-12;

/// Numbers of points as typed: `A..B`, from A up to but not B.
pub(crate) fn parse_range(text: &str) -> Result<Range<u64>, String> {
    let ends = text.split_once("..").and_then(|(start, end)| Some((start.parse().ok()?, end.parse().ok()?)));
    let range = ends.map(|(start, end)| start..end).filter(|range: &Range<u64>| range.start < range.end);
    range.ok_or_else(|| {
        "give A..B, two whole numbers with A below B: the points from A (from 0) up to but not B".to_owned()
    })
}

/// How reading a file of points went.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct TileCounts {
    pub(super) format: String,
    /// Points in the file, or in the range that was read.
    pub(super) points: usize,
    pub(super) non_finite: usize,
    pub(super) dropped: usize,
    pub(super) triangles: usize,
    pub(super) shapes: usize,
    /// Points that were measured.
    pub(super) used: u64,
    pub(super) warnings: Vec<String>,
}

impl TileCounts {
    fn new(read: &ReadReport) -> Self {
        Self {
            format: read.format.extension().to_owned(),
            points: read.points,
            non_finite: read.non_finite,
            dropped: read.dropped,
            triangles: read.triangles,
            shapes: read.shapes,
            used: 0,
            warnings: read.warnings.clone(),
        }
    }

    /// Adds the counts of another range of the file.
    pub(super) fn add(&mut self, other: &Self) {
        self.points = self.points.saturating_add(other.points);
        self.non_finite = self.non_finite.saturating_add(other.non_finite);
        self.dropped = self.dropped.saturating_add(other.dropped);
        self.used = self.used.saturating_add(other.used);
        let new = other.warnings.iter().filter(|warning| !self.warnings.contains(warning));
        let new: Vec<String> = new.cloned().collect();
        self.warnings.extend(new);
    }

    /// Points that were measured or counted.
    pub(super) fn kept(&self) -> u64 {
        self.points.saturating_sub(self.dropped) as u64
    }
}

/// What the points of some files add up to.
#[derive(Debug)]
pub(super) struct Gathered {
    pub(super) found: Partial,
    /// The points of the picture, where there will be one.
    pub(super) picture: Option<Picture>,
    /// Box of the points, where they were moved to.
    pub(super) bounds: Option<BoundingBox>,
    /// Sums of a step of a registration, where they are asked for.
    pub(super) sums: Option<StepSums>,
    pub(super) tiles: Vec<(PathBuf, TileCounts)>,
    /// Names of the points that deviate most.
    pub(super) names: BTreeMap<u64, String>,
    /// Hash of the points as read, and how many there are in the file of which these are a part.
    pub(super) points_hash: Option<String>,
    pub(super) of_file: u64,
    /// What was said of the units before anything was measured.
    pub(super) told: Option<String>,
}

impl Gathered {
    /// No points yet, and neither a picture nor sums.
    pub(super) fn none(options: &InspectionOptions) -> Result<Self, Error> {
        Ok(Self {
            found: Partial::new(options).map_err(|error| usage(&error))?,
            picture: None,
            bounds: None,
            sums: None,
            tiles: Vec::new(),
            names: BTreeMap::new(),
            points_hash: None,
            of_file: 0,
            told: None,
        })
    }
}

/// Points of a file, with all that is written per point.
pub(super) struct Kept {
    pub(super) points: Points,
    pub(super) records: Vec<DeviationRecord>,
}

/// Gathers points.
pub(super) struct Gathering<'a> {
    job: &'a Job<'a>,
    setup: &'a Setup,
    progress: &'a Progress,
    gathered: Gathered,
    hash: Option<PointsHash>,
    /// Points measured so far, which is the number of the next one.
    next: u64,
    /// Seconds of reading and of measuring.
    read: f64,
    compute: f64,
}

impl<'a> Gathering<'a> {
    /// No points yet.
    pub(super) fn new(
        job: &'a Job<'a>,
        setup: &'a Setup,
        progress: &'a Progress,
        with_picture: bool,
    ) -> Result<Self, Error> {
        let gathered = Gathered {
            picture: with_picture.then(|| Picture::new(job.picture as usize)),
            ..Gathered::none(&setup.options)?
        };
        Ok(Self { job, setup, progress, gathered, hash: None, next: 0, read: 0.0, compute: 0.0 })
    }

    /// Takes a hash of the points as they are read.
    pub(super) fn hash_points(&mut self) {
        self.hash = Some(PointsHash::default());
    }

    /// Takes the sums of a step of a registration.
    pub(super) fn sum_step(&mut self, sums: StepSums) {
        self.gathered.sums = Some(sums);
    }

    /// What was gathered.
    pub(super) fn finish(mut self, timings: &mut Timings) -> Gathered {
        timings.read += self.read;
        timings.compute += self.compute;
        self.gathered.points_hash = self.hash.map(PointsHash::finish);
        self.gathered
    }

    /// Adds the points of a file, or those of a range; returns them where something is written per point.
    pub(super) fn add_tile(
        &mut self,
        path: &Path,
        range: Option<&Range<u64>>,
        sink: Option<&mut Sink<'_>>,
    ) -> Result<Option<Kept>, Error> {
        let (start, compute, first) = (Instant::now(), self.compute, self.next);
        let before = self.gathered.found.count(Outcome::Measured);
        let keeps_rows = self.job.out.is_some() && sink.is_none();
        let options = self.job.read_options();
        let mut found = None;
        if !keeps_rows && self.setup.measured != Measured::Profile && !is_in_memory(path) {
            found = self.add_pieces(path, range, &options, sink)?.map(|counts| (counts, None));
        }
        let (mut counts, kept) = match found {
            Some(found) => found,
            None => self.add_in_memory(path, range, keeps_rows)?,
        };
        counts.used = self.gathered.found.count(Outcome::Measured) - before;
        // What was read is judged or refused, point by point; a verdict is not given on anything else.
        if self.next - first != counts.kept() || self.gathered.found.points() != self.next {
            let what =
                format!("{} points were read, but {} are accounted for", counts.kept(), self.next - first);
            return Err(Error::content(path, what, "run the command again"));
        }
        self.gathered.tiles.push((path.to_path_buf(), counts));
        self.read += (start.elapsed().as_secs_f64() - (self.compute - compute)).max(0.0);
        Ok(kept)
    }

    /// Reads piece by piece; `None`, before anything was added, for files that have to be read as a whole.
    fn add_pieces(
        &mut self,
        path: &Path,
        range: Option<&Range<u64>>,
        options: &ReadOptions,
        mut sink: Option<&mut Sink<'_>>,
    ) -> Result<Option<TileCounts>, Error> {
        let wanted = range.cloned().unwrap_or(0..u64::MAX);
        let read = io::read_range(path, options, wanted, PIECE, |mut piece| -> Result<(), Error> {
            let rows = if sink.is_some() { piece.positions.len() } else { 0 };
            let mut records = vec![DeviationRecord::none(Outcome::Cancelled); rows];
            self.add(path, &mut piece.positions, &mut piece.normals, &mut |measured| {
                keep(&mut records, measured);
            })?;
            match &mut sink {
                Some(sink) => sink(&self.setup.table(&piece.positions, piece.normals.as_deref(), &records)),
                None => Ok(()),
            }
        })?;
        let Some((read, total)) = read else { return Ok(None) };
        check_range(path, range, total)?;
        self.gathered.of_file = total;
        Ok(Some(TileCounts::new(&read)))
    }

    fn add_in_memory(
        &mut self,
        path: &Path,
        range: Option<&Range<u64>>,
        keeps_rows: bool,
    ) -> Result<(TileCounts, Option<Kept>), Error> {
        let drop = self.job.drop_non_finite;
        let mut points = Points::read(path, drop && range.is_none(), self.job.scan)?;
        let is_profile = self.setup.measured == Measured::Profile;
        if is_profile {
            points.check_plane(path)?;
        } else {
            points.check_space(path)?;
        }
        self.gathered.of_file = points.report.points as u64;
        check_range(path, range, self.gathered.of_file)?;
        if let Some(range) = range {
            points.cut(range, drop);
        }
        let rows = if keeps_rows { points.positions.len() } else { 0 };
        let mut records = Vec::new();
        let (mut positions, mut normals) = (std::mem::take(&mut points.positions), points.normals.take());
        let first = self.next;
        self.add(path, &mut positions, &mut normals, &mut |measured| {
            // Not before what sorts the points has given back its memory.
            records.resize(rows, DeviationRecord::none(Outcome::Cancelled));
            keep(&mut records, measured);
        })?;
        (points.positions, points.normals) = (positions, normals);
        for index in self.gathered.found.worst_indices() {
            let name = index.checked_sub(first).and_then(|own| points.name(usize::try_from(own).ok()?));
            if let Some(name) = name {
                self.gathered.names.insert(index, name.to_owned());
            }
        }
        let counts = TileCounts::new(&points.report);
        Ok((counts, keeps_rows.then_some(Kept { points, records })))
    }

    /// Adds points, which are moved first.
    fn add(
        &mut self,
        path: &Path,
        positions: &mut [Point3<f64>],
        normals: &mut Option<Vec<Vector3<f64>>>,
        receive: &mut dyn FnMut(&[(usize, Deviation)]),
    ) -> Result<(), Error> {
        if memory::is_cancelled() {
            return Err(Error::usage("cancelled", "nothing was written"));
        }
        if let Some(hash) = &mut self.hash {
            hash.add(positions, normals.as_deref());
        }
        self.check_normals(path, normals)?;
        if let Some(transform) = &self.setup.transform {
            transform.apply_to(positions, normals.as_deref_mut());
            self.check_in_plane(path, positions)?;
        }
        if let Some(bounds) = BoundingBox::of(positions) {
            let all = self.gathered.bounds.get_or_insert(bounds);
            *all = union(all, &bounds);
        }
        if self.next == 0 && !self.job.quiet {
            self.tell_units(path, positions.len());
        }
        let start = Instant::now();
        let first = self.next;
        let done = usize::try_from(first).unwrap_or(usize::MAX);
        // How many there are in all is known at the end only.
        let tell = |part: usize, total: usize| {
            self.progress.report(done.saturating_add(part), done.saturating_add(total))
        };
        let Gathered { found, picture, sums, .. } = &mut self.gathered;
        let mut receive = |measured: &[(usize, Deviation)]| {
            found.extend_with(first, positions, measured);
            if let Some(picture) = picture {
                picture.extend_with(first, positions, measured);
            }
            if let Some(sums) = sums {
                sums.extend(positions, measured);
            }
            receive(measured);
        };
        let options = &self.setup.options;
        (self.setup.nominal)
            .measure_each(positions, normals.as_deref(), options, &tell, &mut receive)
            .map_err(|error: inspection::Error| usage(&error))?;
        self.next += positions.len() as u64;
        self.compute += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Says before anything is measured that the sizes of model and scan look like those of different units; a file that is larger than
    /// a piece is gone through for its extent.
    fn tell_units(&mut self, path: &Path, points: usize) {
        let Some((units, first)) = self.setup.units.as_ref().zip(self.gathered.bounds) else { return };
        let whole = if points == PIECE { self.extent(path) } else { None };
        if let Some(warning) = units.warning(whole.unwrap_or(first).diagonal()) {
            let _ = writeln!(std::io::stderr(), "warning: {warning}");
            self.gathered.told = Some(warning);
        }
    }

    /// The box of the points of a file; `None` where it cannot be read, which is said when its points are.
    fn extent(&self, path: &Path) -> Option<BoundingBox> {
        let mut all: Option<BoundingBox> = None;
        let take = |piece: io::Piece| -> Result<(), Error> {
            if memory::is_cancelled() {
                return Err(Error::usage("cancelled", "nothing was written"));
            }
            if let Some(more) = BoundingBox::of(&piece.positions) {
                all = Some(all.map_or(more, |all| union(&all, &more)));
            }
            Ok(())
        };
        let _report = io::read_pieces(path, &self.job.read_options(), PIECE, take).ok().flatten()?;
        all
    }

    /// Makes sure that there are normals where they are needed, and drops them where they are not.
    fn check_normals(&self, path: &Path, normals: &mut Option<Vec<Vector3<f64>>>) -> Result<(), Error> {
        let options = &self.job.options;
        if options.along != Along::Normal && options.max_angle.is_none() {
            *normals = None;
        } else if normals.is_none() {
            let advice = match options.along {
                Along::Normal => "use --along shortest, or a file with normals (nx, ny, nz)",
                _ => "leave out --max-angle, or give a file with normals (nx, ny, nz)",
            };
            return Err(Error::content(path, "the points have no normals", advice));
        }
        Ok(())
    }

    /// Makes sure that points which were moved are still in the plane of the model, if it has one.
    fn check_in_plane(&self, path: &Path, positions: &[Point3<f64>]) -> Result<(), Error> {
        let is_off = |point: &Point3<f64>| point.z.abs() > OFF_PLANE * point.coords.norm();
        if self.setup.measured == Measured::Profile && positions.iter().any(is_off) {
            let what = "the motion takes the points out of the plane of the model";
            let path = self.job.motion.file().unwrap_or(path);
            return Err(Error::content(path, what, "give a turn about z and a shift in x and y"));
        }
        Ok(())
    }
}

/// Takes the records of points that were measured.
fn keep(records: &mut [DeviationRecord], measured: &[(usize, Deviation)]) {
    for (index, deviation) in measured {
        if let Some(record) = records.get_mut(*index) {
            *record = deviation.into();
        }
    }
}

/// Counts the points of files, if all of them can be read piece by piece.
pub(super) fn survey(job: &Job<'_>, setup: &Setup, tiles: &[&Path]) -> Result<Option<usize>, Error> {
    let mut rows = 0;
    for path in tiles {
        if setup.measured == Measured::Profile || is_in_memory(path) {
            return Ok(None);
        }
        let wanted = job.range.clone().unwrap_or(0..u64::MAX);
        let read = io::read_range(path, &job.read_options(), wanted, PIECE, |_| Ok::<(), Error>(()))?;
        let Some((read, total)) = read else { return Ok(None) };
        check_range(path, job.range.as_ref(), total)?;
        points::check_counts(path, &read)?;
        rows += read.points - read.dropped;
    }
    Ok(Some(rows))
}

/// Whether the points are in memory already, or come through a pipe.
fn is_in_memory(path: &Path) -> bool {
    files::is_stream(path) || memory::is_memory(path)
}

/// The box around both.
pub(super) fn union(a: &BoundingBox, b: &BoundingBox) -> BoundingBox {
    BoundingBox { min: a.min.inf(&b.min), max: a.max.sup(&b.max) }
}

/// Makes sure that a file holds the points that were asked for.
fn check_range(path: &Path, range: Option<&Range<u64>>, total: u64) -> Result<(), Error> {
    match range {
        Some(range) if range.end > total => {
            let what =
                format!("the file holds {total} points, --points asks for {}..{}", range.start, range.end);
            Err(Error::content(path, what, "give numbers from 0 up to the number of points"))
        }
        _ => Ok(()),
    }
}

/// Makes sure that there was a point that is finite in a file of which these are the counts.
pub(super) fn check_counts(path: &Path, counts: &TileCounts) -> Result<(), Error> {
    points::check_numbers(path, counts.points, counts.non_finite)
}
