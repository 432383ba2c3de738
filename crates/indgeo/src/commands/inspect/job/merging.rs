//! Partial results of tiles become the result of the cloud: the same to the byte as one run over all tiles.

use super::gather::{Gathered, TileCounts, union};
use super::identity::FileIdentity;
use super::nominal::Setup;
use super::outputs::RowsOut;
use super::partial_file::{self, Head};
use super::{Job, check_extension, outputs};
use crate::commands::register::step::{Step, StepSums};
use crate::error::Error;
use crate::files;
use crate::input::transform::Transform;
use crate::output::partials::Kind;
use crate::report::{Output, Report, Timings};
use industrial_geometry::inspection::{Inspection, Picture};
use std::path::{Path, PathBuf};

/// Partial results that belong together.
#[derive(Debug)]
pub(crate) struct Parts {
    kind: Kind,
    /// Files of the partial results with what they say of themselves, in the order of the points.
    parts: Vec<(PathBuf, Head)>,
}

impl Parts {
    /// Reads what partial results say of themselves, and makes sure that they belong together, and are complete: each point of
    /// each file once, and all of `tiles`, if there are any.
    pub(crate) fn read(paths: &[PathBuf], tiles: &[PathBuf]) -> Result<Self, Error> {
        let mut parts = Vec::new();
        let mut kind = None;
        for path in paths {
            let (own, head) = partial_file::read_head(path)?;
            if *kind.get_or_insert(own) != own {
                let what = "one partial result is of an inspection, another of a registration";
                return Err(Error::content(path, what, "merge results of one kind"));
            }
            parts.push((path.clone(), head));
        }
        let kind = kind.unwrap_or(Kind::Inspection);
        let Some(first) = parts.first() else {
            return Err(Error::usage("there are no partial results", "name at least one"));
        };
        for other in &parts[1..] {
            check_same(first, other)?;
        }
        parts.sort_by(|(_, a), (_, b)| {
            (Path::new(&a.tile.path), a.start).cmp(&(Path::new(&b.tile.path), b.start))
        });
        check_once(&parts)?;
        check_complete(&parts)?;
        for tile in tiles {
            if !parts.iter().any(|(_, head)| Path::new(&head.tile.path) == tile) {
                let advice = "make it by `indgeo inspect` with --partial, or leave the file out of --tiles";
                return Err(Error::content(tile, "there is no partial result of this file", advice));
            }
        }
        if let Some((path, head)) = parts
            .iter()
            .find(|(_, head)| !tiles.is_empty() && !tiles.iter().any(|t| t == Path::new(&head.tile.path)))
        {
            let what = format!("the partial result is of {}, which --tiles does not name", head.tile.path);
            return Err(Error::content(path, what, "leave it out, or add the file to --tiles"));
        }
        Ok(Self { kind, parts })
    }

    /// What kind of work they are of.
    pub(crate) fn kind(&self) -> Kind {
        self.kind
    }

    /// Files of the partial results.
    fn paths(&self) -> Vec<&Path> {
        self.parts.iter().map(|(path, _)| path.as_path()).collect()
    }

    /// The model that all were measured from.
    pub(crate) fn model(&self) -> &Path {
        self.parts.first().map_or(Path::new(""), |(_, head)| Path::new(&head.model.path))
    }

    /// The options of all, as they are typed.
    pub(crate) fn arguments(&self) -> &[String] {
        self.parts.first().map_or(&[], |(_, head)| &head.arguments)
    }

    /// The motion of all.
    pub(crate) fn pose(&self) -> Option<[[f64; 4]; 4]> {
        self.parts.first().and_then(|(_, head)| head.pose)
    }

    /// The files of the points, each once.
    pub(crate) fn tiles(&self) -> Vec<PathBuf> {
        let mut tiles: Vec<PathBuf> = self.parts.iter().map(|(_, head)| (&head.tile.path).into()).collect();
        tiles.dedup();
        tiles
    }

    /// Makes sure that a file is the model of all.
    fn check_model(&self, path: &Path) -> Result<(), Error> {
        let found = FileIdentity::of(path)?;
        match self.parts.first() {
            Some((part, head)) if !head.model.has_content_of(&found) => {
                let what = format!("this is not the model that {} was measured from", part.display());
                Err(Error::content(path, what, "give the file as it was then, with --model"))
            }
            _ => Ok(()),
        }
    }
}

/// Makes sure that two partial results are of the same model, motion and options.
fn check_same((path, head): &(PathBuf, Head), (other_path, other): &(PathBuf, Head)) -> Result<(), Error> {
    let differ = |what: String| {
        let what = format!("{what} than {}", path.display());
        Err(Error::content(other_path, what, "merge partial results of the same model, options and motion"))
    };
    if !head.model.has_content_of(&other.model) {
        return differ(format!("the partial result is of another model ({})", other.model.path));
    }
    if head.arguments != other.arguments {
        let mut own = other.arguments.iter().filter(|argument| !head.arguments.contains(argument));
        let mut theirs = head.arguments.iter().filter(|argument| !other.arguments.contains(argument));
        let option = own.next().map(|option| format!("with {option}"));
        let option = option.or_else(|| theirs.next().map(|option| format!("without {option}")));
        return differ(format!("the partial result was made {}, otherwise", option.unwrap_or_default()));
    }
    let bits = |pose: Option<[[f64; 4]; 4]>| pose.map(|rows| rows.map(|row| row.map(f64::to_bits)));
    if bits(head.pose) != bits(other.pose) {
        return differ("the points were moved by another motion (--transform)".to_owned());
    }
    Ok(())
}

/// Makes sure that no points were measured twice; `parts` are in order.
fn check_once(parts: &[(PathBuf, Head)]) -> Result<(), Error> {
    let twice = |path: &Path, other: &Path, what: &str| {
        let what = format!("{what} are in {} already", other.display());
        Err(Error::content(path, what, "merge each partial result once"))
    };
    for (place, (path, head)) in parts.iter().enumerate() {
        // A copy under another name; ranges of a file may well be equal, such as rows of zeros.
        let is_copy = |(_, other): &&(PathBuf, Head)| {
            head.tile.path != other.tile.path
                && head.tile.has_content_of(&other.tile)
                && head.range() == other.range()
                && head.points_sha256 == other.points_sha256
        };
        if let Some((other, _)) = parts[..place].iter().find(is_copy) {
            return twice(path, other, "these points");
        }
    }
    for pair in parts.windows(2) {
        let [(path, head), (other_path, other)] = pair else { continue };
        if head.tile.path != other.tile.path {
            continue;
        }
        if !head.tile.has_content_of(&other.tile) || head.of != other.of {
            let what = format!("{} has changed since {} was made", other.tile.path, path.display());
            return Err(Error::content(other_path, what, "make all partial results of the file again"));
        }
        if other.start < head.end {
            let what = format!("points {}..{} of {}", other.start, head.end.min(other.end), head.tile.path);
            return twice(other_path, path, &what);
        }
    }
    Ok(())
}

/// Makes sure that there is no gap in a file; `parts` are in order.
fn check_complete(parts: &[(PathBuf, Head)]) -> Result<(), Error> {
    let gap = |path: &Path, tile: &str, start: u64, end: u64| {
        let what = format!("points {start}..{end} of {tile} are in no partial result");
        Err(Error::content(path, what, "make it with --points, and merge it too"))
    };
    for (place, (path, head)) in parts.iter().enumerate() {
        let before = place.checked_sub(1).and_then(|before| parts.get(before));
        let before = before.filter(|(_, other)| other.tile.path == head.tile.path);
        let expected = before.map_or(0, |(_, other)| other.end);
        if head.start > expected {
            return gap(path, &head.tile.path, expected, head.start);
        }
        let is_last = parts.get(place + 1).is_none_or(|(_, next)| next.tile.path != head.tile.path);
        if is_last && head.end < head.of {
            return gap(path, &head.tile.path, head.end, head.of);
        }
    }
    Ok(())
}

/// Adds partial results up, judges them and writes the files of `job`, which has the options of all.
pub(crate) fn merge(job: &Job<'_>, parts: &Parts, report: &mut Report) -> Result<Inspection, Error> {
    if let Some(page) = job.page {
        check_extension(page)?;
        files::check_writable(page, &[job.inputs(), parts.paths()].concat())?;
    }
    let mut timings = Timings::default();
    let (setup, gathered) = fold(job, parts, &mut timings, report)?;
    outputs::conclude(job, setup, gathered, RowsOut::None, timings, report)
}

/// Adds up the partial results of a step of a registration; `out` is the file of the pose that follows.
pub(crate) fn merge_step(
    job: &Job<'_>,
    parts: &Parts,
    out: Option<&Path>,
    report: &mut Report,
) -> Result<Step, Error> {
    if let Some(out) = out {
        files::check_writable(out, &[job.inputs(), parts.paths()].concat())?;
    }
    let mut timings = Timings::default();
    let (setup, gathered) = fold(job, parts, &mut timings, report)?;
    outputs::add_inputs(job, &setup, &gathered, report)?;
    let pose = setup.transform.as_ref().map(Transform::rows);
    let step = gathered.sums.and_then(|sums| sums.step(pose)).ok_or_else(|| {
        let what = "no point of the scans lies on the model, so that there is no step";
        Error::content(job.model, what, "start nearer (--init), or leave out --max-distance")
    })?;
    if let Some(out) = out {
        let mut text =
            serde_json::to_string_pretty(&step).map_err(|error| Error::write(out, error.into()))?;
        text.push('\n');
        let bytes = files::write(out, |file| file.write_all(text.as_bytes()))?;
        report.add_output(Output {
            path: out.to_path_buf(),
            bytes,
            content: "pose after the step".to_owned(),
        });
    }
    report.timings = timings;
    Ok(step)
}

/// Adds up partial results.
fn fold(
    job: &Job<'_>,
    parts: &Parts,
    timings: &mut Timings,
    report: &mut Report,
) -> Result<(Setup, Gathered), Error> {
    parts.check_model(job.model)?;
    let setup = Setup::read(job, timings, report)?;
    let mut gathered = Gathered::none(&setup.options)?;
    gathered.picture = job.page.is_some().then(|| Picture::new(job.picture as usize));
    if parts.kind == Kind::Registration {
        gathered.sums = StepSums::new(&setup.nominal);
    }
    Timings::measure(&mut timings.read, || {
        parts.parts.iter().try_for_each(|(path, head)| add(&mut gathered, path, head))
    })?;
    Ok((setup, gathered))
}

/// Adds a partial result behind those that are there.
fn add(gathered: &mut Gathered, path: &Path, head: &Head) -> Result<(), Error> {
    let body = partial_file::read(path)?;
    let damaged = |what: &str| Error::content(path, what, "make the partial result again");
    let first = gathered.found.points();
    let bounds = body.bounds();
    let (mut found, picture) = (body.found, body.picture);
    if body.head.points_sha256 != head.points_sha256 || found.points() != head.read.kept() {
        return Err(damaged("the partial result does not hold the points it tells of"));
    }
    found.shift(first);
    gathered.found.merge(&found).map_err(|error| damaged(&error.to_string()))?;
    if let Some(own) = &mut gathered.picture {
        let mut picture = picture.ok_or_else(|| damaged("the partial result has no points for a page"))?;
        picture.shift(first);
        own.merge(&picture).map_err(|error| damaged(&error.to_string()))?;
    }
    if let Some(own) = &mut gathered.sums {
        let sums = body.sums.ok_or_else(|| damaged("the partial result has no sums of a step"))?;
        if !own.merge(&sums) {
            return Err(damaged("the sums of the step are about another origin"));
        }
    }
    if let Some(bounds) = bounds {
        gathered.bounds = Some(gathered.bounds.map_or(bounds, |own| union(&own, &bounds)));
    }
    gathered.names.extend(body.names.into_iter().map(|(index, name)| (first.saturating_add(index), name)));
    add_counts(&mut gathered.tiles, head, &head.read);
    Ok(())
}

/// Counts a range of a file to the ranges before.
fn add_counts(tiles: &mut Vec<(PathBuf, TileCounts)>, head: &Head, counts: &TileCounts) {
    let path = PathBuf::from(&head.tile.path);
    match tiles.last_mut() {
        Some((last, sums)) if *last == path => sums.add(counts),
        _ => tiles.push((path, counts.clone())),
    }
}
