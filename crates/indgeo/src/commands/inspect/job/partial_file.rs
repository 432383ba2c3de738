//! The partial result of an inspection: of one file of points, or of some of its points.

use super::Job;
use super::gather::{Gathered, TileCounts};
use super::identity::FileIdentity;
use super::nominal::Setup;
use crate::commands::register::step::StepSums;
use crate::error::Error;
use crate::output::partials::{self, Kind, Opened};
use crate::report::Output;
use industrial_geometry::inspection::{Partial, Picture};
use industrial_geometry::mesh::BoundingBox;
use industrial_geometry::mesh::nalgebra::Point3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// What was measured and how: everything by which partial results are told apart, or found to belong together.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Head {
    pub(super) model: FileIdentity,
    /// The options as they are typed, with their values, the defaults included.
    pub(super) arguments: Vec<String>,
    /// Of the options.
    pub(super) options_sha256: String,
    /// The motion of the points, by rows.
    pub(super) pose: Option<[[f64; 4]; 4]>,
    /// Of the motion.
    pub(super) pose_sha256: Option<String>,
    /// The file of points, by its size and both ends.
    pub(super) tile: FileIdentity,
    /// The points that were measured, by their numbers in the file.
    pub(super) start: u64,
    pub(super) end: u64,
    /// Points of the file.
    pub(super) of: u64,
    /// Of the coordinates and normals that were read.
    pub(super) points_sha256: String,
    /// How reading went.
    pub(super) read: TileCounts,
}

impl Head {
    /// The points that were measured, by their numbers in the file.
    pub(super) fn range(&self) -> Range<u64> {
        self.start..self.end
    }
}

/// The whole partial result.
#[derive(Serialize, Deserialize)]
pub(super) struct Body<P, I> {
    pub(super) head: Head,
    /// Box of the points, where they were moved to, as bits of doubles.
    bounds: Option<[[u64; 3]; 2]>,
    pub(super) names: BTreeMap<u64, String>,
    pub(super) found: P,
    pub(super) picture: I,
    pub(super) sums: Option<StepSums>,
}

/// The head alone.
#[derive(Deserialize)]
struct OnlyHead {
    head: Head,
}

impl<P, I> Body<P, I> {
    /// Box of the points.
    pub(super) fn bounds(&self) -> Option<BoundingBox> {
        let point = |bits: [u64; 3]| Point3::from(bits.map(f64::from_bits));
        self.bounds.map(|[min, max]| BoundingBox { min: point(min), max: point(max) })
    }
}

/// What was asked for, known before the work begins.
#[derive(Debug)]
pub(super) struct Request<'a> {
    tile: &'a Path,
    model: FileIdentity,
    points: FileIdentity,
    arguments: Vec<String>,
    range: Option<Range<u64>>,
}

impl<'a> Request<'a> {
    /// A request for one file of points.
    pub(super) fn new(job: &Job<'a>, arguments: Vec<String>) -> Result<Self, Error> {
        let [tile] = job.points else {
            let what = format!("--partial takes one file of points, these are {}", job.points.len());
            return Err(Error::usage(what, "run the command once for each of them, and merge"));
        };
        let (model, points) = (FileIdentity::of(job.model)?, FileIdentity::of_ends(tile)?);
        Ok(Self { tile, model, points, arguments, range: job.range.clone() })
    }

    /// The file of points.
    pub(super) fn tile(&self) -> &'a Path {
        self.tile
    }

    /// Writes what was gathered.
    pub(super) fn write(self, out: &Path, setup: &Setup, gathered: &Gathered) -> Result<Output, Error> {
        let changed = |path: &Path| {
            Error::content(path, "the file has changed while it was read", "run the command again")
        };
        if FileIdentity::of_ends(self.tile)? != self.points {
            return Err(changed(self.tile));
        }
        let Some((_, read)) = gathered.tiles.first() else { return Err(changed(self.tile)) };
        let range = self.range.unwrap_or(0..gathered.of_file);
        let pose = setup.transform.as_ref().map(crate::input::transform::Transform::rows);
        let about = format!("partial result: points {}..{} of {}", range.start, range.end, gathered.of_file);
        let head = Head {
            model: self.model,
            options_sha256: partials::sha256(self.arguments.join("\n").as_bytes()),
            arguments: self.arguments,
            pose_sha256: pose.map(|rows| {
                let bytes = rows.iter().flatten().flat_map(|value| value.to_le_bytes());
                partials::sha256(&bytes.collect::<Vec<u8>>())
            }),
            pose,
            tile: self.points,
            start: range.start,
            end: range.end,
            of: gathered.of_file,
            points_sha256: gathered.points_hash.clone().unwrap_or_default(),
            read: read.clone(),
        };
        let bits = |point: &Point3<f64>| [point.x, point.y, point.z].map(f64::to_bits);
        let worst = gathered.found.worst_indices();
        let names = gathered.names.iter().filter(|(index, _)| worst.contains(index));
        let body = Body {
            head,
            bounds: gathered.bounds.map(|bounds| [bits(&bounds.min), bits(&bounds.max)]),
            names: names.map(|(index, name)| (*index, name.clone())).collect(),
            found: &gathered.found,
            picture: &gathered.picture,
            sums: gathered.sums.clone(),
        };
        let kind = if body.sums.is_some() { Kind::Registration } else { Kind::Inspection };
        partials::write(out, kind, &body, about)
    }
}

/// Reads what was measured and how, and in what kind of work.
pub(super) fn read_head(path: &Path) -> Result<(Kind, Head), Error> {
    let opened = Opened::read(path)?;
    Ok((opened.kind, opened.parse::<OnlyHead>(path)?.head))
}

/// Reads a partial result as a whole.
pub(super) fn read(path: &Path) -> Result<Body<Partial, Option<Picture>>, Error> {
    Opened::read(path)?.parse(path)
}
