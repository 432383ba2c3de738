//! What a projection found, added up point by point.

use crate::commands::project::SearchMode;
use crate::points::Points;
use crate::projection::Job;
use crate::report::{ProjectionResults, ShapeResults, Worst};
use crate::target::{Foot, Target};
use industrial_geometry::footpoint::{Multiplicity, Status};
use industrial_geometry::inspection::Moments;
use industrial_geometry::io::ReadReport;
use std::collections::BTreeMap;

/// Up to how many distances, of all shapes, quantiles come from the distances themselves.
const EXACT_LIMIT: usize = 1 << 22;

/// Share of the diagonal of a CAD model above which gaps are counted.
const WIDE_GAP: f64 = 1e-7;

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
        let mut distances: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        for (place, foot) in feet.iter().enumerate() {
            *self.status.entry(foot.status.name()).or_default() += 1;
            if !foot.exists() {
                continue;
            }
            *self.location.entry(foot.location).or_default() += 1;
            *self.multiplicity.entry(multiplicity_name(foot.multiplicity).to_owned()).or_default() += 1;
            self.largest_gap = Some(self.largest_gap.map_or(foot.gap(), |gap| gap.max(foot.gap())));
            if let Some(cad) = &mut self.cad {
                cad.wide_gaps += usize::from(foot.gap() > cad.wide);
                cad.undecided_sides += usize::from(foot.side == "undecided");
            }
            let (on_boundary, _) =
                self.shapes.entry(foot.shape).or_insert_with(|| (0, Moments::new(EXACT_LIMIT)));
            *on_boundary += usize::from(foot.status == Status::OnBoundary);
            distances.entry(foot.shape).or_default().push(foot.distance);
            if self.worst.as_ref().is_none_or(|worst| foot.distance.abs() > worst.distance.abs()) {
                let point = points.positions[place].into();
                let name = points.name(place).map(str::to_owned);
                self.worst = Some(Worst { index: self.points + place, point, distance: foot.distance, name });
            }
        }
        for (shape, distances) in distances {
            if let Some((_, sums)) = self.shapes.get_mut(&shape) {
                sums.extend(distances);
            }
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
        let mut all = Moments::new(EXACT_LIMIT);
        for (_, sums) in self.shapes.values() {
            // The limits are the same.
            let _ = all.merge(sums);
        }
        let distance = all.statistics();
        let per_shape = self.shapes.iter().filter_map(|(&index, (on_boundary, sums))| {
            let (kind, name) = shapes.get(index as usize)?.clone();
            let distance = sums.statistics()?;
            Some(ShapeResults { index, kind, name, on_boundary: *on_boundary, distance })
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
