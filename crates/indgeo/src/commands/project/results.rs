//! What a projection found, added up point by point.

use crate::commands::project::request::Job;
use crate::commands::project::search::SearchMode;
use crate::input::points::Points;
use crate::input::target::{Foot, Target};
use industrial_geometry::footpoint::{Multiplicity, Status};
use industrial_geometry::inspection::{Moments, Statistics};
use industrial_geometry::io::ReadReport;
use serde::Serialize;
use std::collections::BTreeMap;

/// Up to how many distances, of all shapes, quantiles come from the distances themselves.
const EXACT_LIMIT: usize = 1 << 22;

/// Share of the diagonal of a CAD model above which gaps are counted.
const WIDE_GAP: f64 = 1e-7;

/// Counts and distances of a projection.
#[derive(Debug, Serialize)]
pub(crate) struct ProjectionResults {
    /// Number of rows of the result.
    pub(crate) points: usize,
    /// Points without a footpoint because they are not finite.
    pub(crate) points_dropped: usize,
    /// Points with a footpoint.
    pub(crate) points_used: usize,
    /// Root mean square distance.
    pub(crate) rms: Option<f64>,
    /// Largest distance, without its sign.
    pub(crate) max: Option<f64>,
    /// The point that has it, from 0.
    pub(crate) max_index: Option<usize>,
    /// Columns of the result.
    pub(crate) columns: Vec<&'static str>,
    /// Number of points per status.
    pub(crate) status: BTreeMap<&'static str, usize>,
    /// Number of points per location of the footpoint.
    pub(crate) location: BTreeMap<&'static str, usize>,
    /// Number of points per multiplicity of the footpoint.
    pub(crate) multiplicity: BTreeMap<String, usize>,
    /// Distribution of the distances, as signed as the model gives them.
    pub(crate) distance: Option<Statistics>,
    /// The point with the largest absolute distance.
    pub(crate) worst: Option<Worst>,
    /// Largest certified gap between a distance and its lower bound; `null` in uncertified modes.
    pub(crate) largest_gap: Option<f64>,
    /// Points whose gap is more than 1e-7 of the diagonal of a CAD model: their feet are next to edges that lie beside their faces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) wide_gaps: Option<usize>,
    /// Points of which it is not known on which side of a CAD model they lie; their distances have no sign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) undecided_sides: Option<usize>,
    /// Curves and surfaces that are nearest to at least one point.
    pub(crate) shapes: Vec<ShapeResults>,
}

/// The point that is farthest from the model.
#[derive(Debug, Serialize)]
pub(crate) struct Worst {
    /// Index of the row, from 0.
    pub(crate) index: usize,
    /// The point.
    pub(crate) point: [f64; 3],
    /// Its distance.
    pub(crate) distance: f64,
    /// Its name, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) name: Option<String>,
}

/// The points whose footpoints lie on one shape.
#[derive(Debug, Serialize)]
pub(crate) struct ShapeResults {
    /// Index of the shape in the model.
    pub(crate) index: u32,
    /// `surface`, `curve` or `mesh`.
    pub(crate) kind: &'static str,
    /// Its name, if it has one.
    pub(crate) name: Option<String>,
    /// Points that lie beyond its boundary: their footpoints are on it.
    pub(crate) on_boundary: usize,
    /// Distances of all points with a footpoint here.
    pub(crate) distance: Statistics,
}

/// Counts and exact sums; the pieces in which points come do not matter.
#[derive(Debug, Default)]
pub(crate) struct ResultsSum {
    points: usize,
    status: BTreeMap<&'static str, usize>,
    location: BTreeMap<&'static str, usize>,
    multiplicity: BTreeMap<String, usize>,
    worst: Option<Worst>,
    largest_gap: Option<f64>,
    /// Points on the boundary of a shape, and distances of all its points.
    shapes: BTreeMap<u32, (usize, Moments)>,
    /// Of a CAD model: above what gaps are counted, how many are, and how many sides are not known.
    cad: Option<CadCounts>,
}

/// How often each of a few names occurs.
#[derive(Default)]
struct Tally(Vec<(&'static str, usize)>);

impl Tally {
    fn count(&mut self, name: &'static str) {
        match self.0.iter_mut().find(|(other, _)| *other == name) {
            Some((_, count)) => *count += 1,
            None => self.0.push((name, 1)),
        }
    }
}

/// The feet on each shape.
#[derive(Default)]
struct Parts {
    list: Vec<Part>,
    places: BTreeMap<u32, usize>,
    /// Place of the last one: neighbours mostly have their feet on one shape.
    last: usize,
}

struct Part {
    shape: u32,
    on_boundary: usize,
    distances: Vec<f64>,
}

impl Parts {
    fn of(&mut self, shape: u32) -> &mut Part {
        if self.list.get(self.last).is_none_or(|part| part.shape != shape) {
            let next = self.list.len();
            self.last = *self.places.entry(shape).or_insert(next);
            if self.last == next {
                self.list.push(Part { shape, on_boundary: 0, distances: Vec::new() });
            }
        }
        &mut self.list[self.last]
    }
}

/// What is counted of points beside a CAD model.
#[derive(Debug)]
struct CadCounts {
    wide: f64,
    wide_gaps: usize,
    undecided_sides: usize,
}

impl ResultsSum {
    /// Nothing yet, of projections onto a model.
    pub(crate) fn of(target: &Target) -> Self {
        let cad = match target {
            Target::Cad(cad) => {
                let wide = WIDE_GAP * cad.model.bounds().diagonal();
                Some(CadCounts { wide, wide_gaps: 0, undecided_sides: 0 })
            }
            _ => None,
        };
        Self { cad, ..Self::default() }
    }

    /// Adds the next points with their feet.
    pub(crate) fn add(&mut self, points: &Points, feet: &[Foot]) {
        let (mut status, mut location, mut multiplicity) =
            (Tally::default(), Tally::default(), Tally::default());
        let mut parts = Parts::default();
        for (place, foot) in feet.iter().enumerate() {
            status.count(foot.status.name());
            if !foot.exists() {
                continue;
            }
            location.count(foot.location);
            multiplicity.count(multiplicity_name(foot.multiplicity));
            self.largest_gap = Some(self.largest_gap.map_or(foot.gap(), |gap| gap.max(foot.gap())));
            if let Some(cad) = &mut self.cad {
                cad.wide_gaps += usize::from(foot.gap() > cad.wide);
                cad.undecided_sides += usize::from(foot.side == "undecided");
            }
            let part = parts.of(foot.shape);
            part.on_boundary += usize::from(foot.status == Status::OnBoundary);
            part.distances.push(foot.distance);
            if self.worst.as_ref().is_none_or(|worst| foot.distance.abs() > worst.distance.abs()) {
                let point = points.positions[place].into();
                let name = points.name(place).map(str::to_owned);
                self.worst = Some(Worst { index: self.points + place, point, distance: foot.distance, name });
            }
        }
        status.0.iter().for_each(|&(name, count)| *self.status.entry(name).or_default() += count);
        location.0.iter().for_each(|&(name, count)| *self.location.entry(name).or_default() += count);
        for (name, count) in multiplicity.0 {
            *self.multiplicity.entry(name.to_owned()).or_default() += count;
        }
        for part in parts.list {
            let (on_boundary, sums) =
                self.shapes.entry(part.shape).or_insert_with(|| (0, Moments::new(EXACT_LIMIT)));
            *on_boundary += part.on_boundary;
            sums.extend(part.distances);
        }
        if self.shapes.values().map(|(_, sums)| sums.count()).sum::<u64>() > EXACT_LIMIT as u64 {
            self.shapes.values_mut().for_each(|(_, sums)| sums.count_in_cells());
        }
        self.points += feet.len();
    }

    /// Number of points that were added.
    pub(crate) fn points(&self) -> usize {
        self.points
    }

    /// The results.
    pub(crate) fn finish(
        self,
        job: &Job<'_>,
        read: &ReadReport,
        columns: Vec<&'static str>,
        shapes: &[(&'static str, Option<String>)],
    ) -> ProjectionResults {
        let of_shapes: Vec<_> = self.shapes.values().map(|(_, sums)| sums.statistics()).collect();
        let distance = if let [only] = &of_shapes[..] {
            only.clone()
        } else {
            let mut all = Moments::new(EXACT_LIMIT);
            for (_, sums) in self.shapes.values() {
                // The limits are the same.
                let _ = all.merge(sums);
            }
            all.statistics()
        };
        let per_shape =
            self.shapes.iter().zip(of_shapes).filter_map(|((&index, (on_boundary, _)), distance)| {
                let (kind, name) = shapes.get(index as usize)?.clone();
                Some(ShapeResults { index, kind, name, on_boundary: *on_boundary, distance: distance? })
            });
        let dropped = self.status.get(Status::InvalidPoint.name()).copied().unwrap_or(0);
        ProjectionResults {
            points: self.points,
            points_dropped: read.non_finite,
            points_used: self.points - dropped,
            rms: distance.as_ref().map(|distance| distance.rms),
            max: self.worst.as_ref().map(|worst| worst.distance.abs()),
            max_index: self.worst.as_ref().map(|worst| worst.index),
            columns,
            location: self.location,
            multiplicity: self.multiplicity,
            distance,
            largest_gap: self.largest_gap.filter(|gap| job.mode == SearchMode::Certified && !gap.is_nan()),
            wide_gaps: self.cad.as_ref().map(|cad| cad.wide_gaps),
            undecided_sides: self.cad.as_ref().map(|cad| cad.undecided_sides),
            shapes: per_shape.collect(),
            worst: self.worst,
            status: self.status,
        }
    }
}

fn multiplicity_name(multiplicity: Multiplicity) -> &'static str {
    match multiplicity {
        Multiplicity::Unknown => "unknown",
        Multiplicity::Unique => "unique",
        Multiplicity::Tied => "tied",
        Multiplicity::Continuum => "continuum",
    }
}
