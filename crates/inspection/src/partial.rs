//! Results of a part of a cloud, which can be stored, sent and merged.

use crate::inspection::{Inspection, PartDeviations, ShapeDeviations, Verdict};
use crate::tally::Tally;
use crate::worst::WorstPoints;
use crate::{Deviation, Error, InspectionOptions, Outcome, ShapeInfo};
use nalgebra::Point3;
use std::collections::BTreeMap;

/// The result of inspecting a part of a cloud.
///
/// Tiles of a huge cloud can be measured on many machines, each with the index of its first point (or [`shift`](Self::shift)ed
/// later), and their results merged: in any grouping and order the outcome has the same bits as that of one run over the whole cloud, because
/// counts, sums ([`ExactSum`](crate::ExactSum)) and distributions ([`Distribution`](crate::Distribution)) are exact.
/// Doubles are written to files as integers, so that no reader or writer of decimals can change a bit.
///
/// ```
/// use inspection::{InspectionOptions, Nominal, Partial, Tolerance};
/// use nalgebra::Point3;
/// # use nurbs_core::{Frame, Sphere};
/// # use nalgebra::Vector3;
///
/// let sphere = Sphere::new(Frame::new(Vector3::zeros(), Vector3::z(), Vector3::x())?, 2.0)?;
/// let nominal = Nominal::from_analytic(&[sphere.into()])?;
/// let options = InspectionOptions::new(Tolerance::symmetric(0.1)?);
/// let points: Vec<_> = (0..100).map(|i| Point3::new(2.0 + 0.0021 * f64::from(i), 0.0, 0.0)).collect();
///
/// let mut whole = Partial::new(&options)?;
/// for (tile, first) in points.chunks(30).zip((0..).step_by(30)) {
///     let deviations = nominal.measure(tile, None, &options, &inspection::no_progress)?;
///     let mut part = Partial::new(&options)?;
///     part.extend(first, tile, &deviations);
///     whole.merge(&part)?;
/// }
/// let inspection = whole.finish(&options, nominal.shapes())?;
/// assert_eq!(inspection.total.within, 48);
/// assert!(!inspection.verdict.pass);
/// assert_eq!(inspection.worst[0].index, 99);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Partial {
    /// Bits of the options on which counts depend.
    key: [u64; 4],
    points: u64,
    outcomes: BTreeMap<Outcome, u64>,
    shapes: BTreeMap<u32, Tally>,
    worst: WorstPoints,
    /// Bits of the largest gap.
    largest_gap: u64,
    #[cfg_attr(feature = "serde", serde(default))]
    restricted: u64,
}

impl Partial {
    /// Nothing inspected yet.
    ///
    /// # Errors
    /// As [`InspectionOptions::validate`].
    pub fn new(options: &InspectionOptions) -> Result<Self, Error> {
        options.validate()?;
        Ok(Self {
            key: key(options),
            points: 0,
            outcomes: BTreeMap::new(),
            shapes: BTreeMap::new(),
            worst: WorstPoints::new(options),
            largest_gap: 0,
            restricted: 0,
        })
    }

    /// Adds the points of a tile with their deviations; `first` is the index of its first point in the whole cloud.
    pub fn extend(&mut self, first: u64, points: &[Point3<f64>], deviations: &[Deviation]) {
        let indexed = || points.iter().zip(deviations).zip(first..);
        self.add(|| indexed().map(|((point, deviation), index)| (index, point, deviation)));
    }

    /// Adds some of the points of a tile, with their indices in it, as [`Nominal::measure_each`](crate::Nominal::measure_each)
    /// hands them over; `first` is the index of the first point of the tile in the whole cloud. Indices beyond the tile are
    /// left out.
    pub fn extend_with(&mut self, first: u64, points: &[Point3<f64>], measured: &[(usize, Deviation)]) {
        self.add(|| {
            measured.iter().filter_map(move |(index, deviation)| {
                Some((first + *index as u64, points.get(*index)?, deviation))
            })
        });
    }

    fn add<'a, I: Iterator<Item = (u64, &'a Point3<f64>, &'a Deviation)>>(&mut self, all: impl Fn() -> I) {
        let mut measured: BTreeMap<u32, Vec<(f64, bool)>> = BTreeMap::new();
        let mut gap = f64::from_bits(self.largest_gap);
        for (_, _, deviation) in all() {
            self.points += 1;
            *self.outcomes.entry(deviation.outcome).or_default() += 1;
            if deviation.outcome == Outcome::Measured {
                let list = measured.entry(deviation.shape).or_default();
                list.push((deviation.distance, deviation.on_boundary));
                gap = gap.max(deviation.gap);
                self.restricted += u64::from(deviation.is_restricted);
            }
        }
        self.largest_gap = gap.to_bits();
        let (tolerance, limit) = (self.tolerance(), usize::try_from(self.key[2]).unwrap_or(usize::MAX));
        for (shape, list) in measured {
            self.shapes.entry(shape).or_insert_with(|| Tally::new(limit)).extend(&list, &tolerance);
        }
        self.keep_to_limit();
        self.worst.extend(all());
    }

    /// Counts in cells where the points of all surfaces together are more than the limit, so that memory is bounded.
    fn keep_to_limit(&mut self) {
        if self.shapes.values().map(Tally::count).fold(0, u64::saturating_add) > self.key[2] {
            self.shapes.values_mut().for_each(Tally::count_in_cells);
        }
    }

    /// Number of points that were added.
    #[must_use]
    pub fn points(&self) -> u64 {
        self.points
    }

    /// Number of points with this outcome.
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> u64 {
        self.outcomes.get(&outcome).copied().unwrap_or(0)
    }

    /// Indices of the points that deviate most, the largest deviation first.
    #[must_use]
    pub fn worst_indices(&self) -> Vec<u64> {
        self.worst.indices()
    }

    /// Gives the points indices that are larger by `first`: those in the cloud of which the part begins there.
    pub fn shift(&mut self, first: u64) {
        self.worst.shift(first);
    }

    /// Adds the result of another part.
    ///
    /// # Errors
    /// [`Error::DifferentOptions`] if it was made with another tolerance, limit of exact values or number of worst points.
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        if self.key != other.key {
            return Err(Error::DifferentOptions);
        }
        self.points = self.points.saturating_add(other.points);
        for (outcome, count) in &other.outcomes {
            let own = self.outcomes.entry(*outcome).or_default();
            *own = own.saturating_add(*count);
        }
        for (shape, tally) in &other.shapes {
            match self.shapes.get_mut(shape) {
                Some(mine) => mine.merge(tally)?,
                None => {
                    self.shapes.insert(*shape, tally.clone());
                }
            }
        }
        self.keep_to_limit();
        self.worst.merge(&other.worst);
        self.restricted = self.restricted.saturating_add(other.restricted);
        let gap = f64::from_bits(self.largest_gap).max(f64::from_bits(other.largest_gap));
        self.largest_gap = gap.to_bits();
        Ok(())
    }

    /// Statistics and verdict; `shapes` tells the kinds and names of the surfaces ([`Nominal::shapes`](crate::Nominal::shapes)).
    ///
    /// # Errors
    /// [`Error::DifferentOptions`] if the part was made with other options.
    pub fn finish(&self, options: &InspectionOptions, shapes: &[ShapeInfo]) -> Result<Inspection, Error> {
        if self.key != key(options) {
            return Err(Error::DifferentOptions);
        }
        let mut total = Tally::new(options.exact_limit);
        let mut parts: BTreeMap<&(u32, String), Tally> = BTreeMap::new();
        for (shape, tally) in &self.shapes {
            total.merge(tally)?;
            if let Some(part) = shapes.get(*shape as usize).and_then(|shape| shape.part.as_ref()) {
                parts.entry(part).or_insert_with(|| Tally::new(options.exact_limit)).merge(tally)?;
            }
        }
        let parts = parts.into_iter().map(|((index, name), tally)| PartDeviations {
            index: *index,
            name: name.clone(),
            deviations: tally.deviations(&options.tolerance),
        });
        let parts = parts.collect();
        let total = total.deviations(&options.tolerance);
        let count = |outcome| self.count(outcome);
        let per_shape = self.shapes.iter().map(|(&index, tally)| ShapeDeviations {
            index,
            info: shapes.get(index as usize).cloned().unwrap_or_default(),
            deviations: tally.deviations(&options.tolerance),
        });
        // All measured points are counted in `total`.
        let unmeasured = Outcome::ALL.iter().filter(|o| o.is_judged() && **o != Outcome::Measured);
        let judged = total.count + unmeasured.map(|outcome| count(*outcome)).sum::<u64>();
        Ok(Inspection {
            verdict: Verdict::new(total.within, judged, options.min_share),
            options: *options,
            points: self.points,
            outcomes: Outcome::ALL.iter().map(|outcome| (outcome.name(), count(*outcome))).collect(),
            total,
            shapes: per_shape.collect(),
            parts,
            worst: self.worst.list(),
            restricted: self.restricted,
            largest_gap: f64::from_bits(self.largest_gap),
        })
    }

    fn tolerance(&self) -> crate::Tolerance {
        crate::Tolerance { lower: f64::from_bits(self.key[0]), upper: f64::from_bits(self.key[1]) }
    }
}

fn key(options: &InspectionOptions) -> [u64; 4] {
    let tolerance = &options.tolerance;
    [tolerance.lower.to_bits(), tolerance.upper.to_bits(), options.exact_limit as u64, options.worst as u64]
}
