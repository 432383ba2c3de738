//! What is counted of the points that belong to one surface.

use crate::{Class, Error, Histogram, Moments, Statistics, Tolerance};

/// Counts and sums; merging is exact, so the order and the parts do not matter.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Tally {
    pub(crate) under: u64,
    pub(crate) within: u64,
    pub(crate) over: u64,
    pub(crate) on_boundary: u64,
    moments: Moments,
}

/// How the points of one surface, or of all, deviate.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Deviations {
    /// Points that were measured.
    pub count: u64,
    /// Points below the lower limit.
    pub under: u64,
    /// Points within the tolerance.
    pub within: u64,
    /// Points above the upper limit.
    pub over: u64,
    /// `under` as a share of `count`; 0 without points, as the following two.
    pub share_under: f64,
    /// `within` as a share of `count`.
    pub share_within: f64,
    /// `over` as a share of `count`.
    pub share_over: f64,
    /// Points whose footpoint lies on the boundary of an open shape.
    pub on_boundary: u64,
    /// Statistics of the signed distances; `None` (JSON: `null`) without points.
    pub distance: Option<Statistics>,
    /// Their histogram.
    pub histogram: Option<Histogram>,
}

impl Tally {
    pub(crate) fn new(exact_limit: usize) -> Self {
        Self { under: 0, within: 0, over: 0, on_boundary: 0, moments: Moments::new(exact_limit) }
    }

    /// Adds measured distances, each with whether its footpoint lies on the boundary.
    pub(crate) fn extend(&mut self, measured: &[(f64, bool)], tolerance: &Tolerance) {
        for &(distance, on_boundary) in measured {
            match tolerance.class(distance) {
                Class::Under => self.under += 1,
                Class::Within => self.within += 1,
                Class::Over => self.over += 1,
            }
            self.on_boundary += u64::from(on_boundary);
        }
        self.moments.extend(measured.iter().map(|(distance, _)| *distance));
    }

    /// Points that were measured.
    pub(crate) fn count(&self) -> u64 {
        self.under.saturating_add(self.within).saturating_add(self.over)
    }

    /// Keeps the values no more, but how many fall into each of many cells.
    pub(crate) fn count_in_cells(&mut self) {
        self.moments.count_in_cells();
    }

    pub(crate) fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.under = self.under.saturating_add(other.under);
        self.within = self.within.saturating_add(other.within);
        self.over = self.over.saturating_add(other.over);
        self.on_boundary = self.on_boundary.saturating_add(other.on_boundary);
        self.moments.merge(&other.moments)
    }

    pub(crate) fn deviations(&self, tolerance: &Tolerance) -> Deviations {
        let count = self.count();
        let share = |part: u64| if count > 0 { part as f64 / count as f64 } else { 0.0 };
        Deviations {
            count,
            under: self.under,
            within: self.within,
            over: self.over,
            share_under: share(self.under),
            share_within: share(self.within),
            share_over: share(self.over),
            on_boundary: self.on_boundary,
            distance: self.moments.statistics(),
            histogram: Histogram::of(&self.moments.distribution, tolerance),
        }
    }
}
