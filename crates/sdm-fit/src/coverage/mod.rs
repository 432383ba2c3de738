//! How well a fitted shape and its data cover each other, seen from both sides.
//!
//! Distances of the points from the shape say nothing about parts of the shape that are far from all points. [`Coverage`] holds the other side:
//! distances of places of the shape from the points, and the parts of it that no point supports.

mod curve;
mod gaps;
mod surface;

pub(crate) use curve::{Limits, of_curve};
pub(crate) use gaps::{gap_limit, usual_gap};
pub use surface::SurfaceCoverage;
pub(crate) use surface::noise_of;

/// A shape seen from its data, and the data from the shape.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Coverage {
    /// Root mean square over the shape (by length or area) of the distance to the nearest point.
    pub rms: f64,
    /// The largest such distance.
    pub max: f64,
    /// Parameters and place on the shape that have it.
    pub max_parameter: Vec<f64>,
    /// See [`Coverage::max_parameter`].
    pub max_place: Vec<f64>,
    /// Mean distance of neighbouring points along the shape.
    pub spacing: f64,
    /// Standard deviation of the points across the shape, from the differences of neighbours.
    pub noise: f64,
    /// Length or area of the shape.
    pub size: f64,
    /// That divided by the length or area of the polygon or mesh through the feet of the points, where these are neighbours.
    pub size_ratio: f64,
    /// Length or area of the parts of the shape without points.
    pub without_data: f64,
    /// That as a share of the shape.
    pub share_without_data: f64,
    /// Length up to which a part between neighbours counts as supported.
    pub gap_limit: f64,
    /// The parts without points, the largest first.
    pub bare: Vec<Bare>,
    /// Distance up to which a point counts as near.
    pub distance_limit: f64,
    /// Number of points that are further away.
    pub far: usize,
    /// Whether the points spread so widely about the shape that they are no shape of its dimension.
    pub spread_out: bool,
}

/// A part of a shape without points.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bare {
    /// Parameters at its beginning.
    pub from: Vec<f64>,
    /// And at its end; less than at the beginning where it goes through the seam of a closed shape.
    pub to: Vec<f64>,
    /// Its length or area.
    pub size: f64,
    /// A place in its middle.
    pub place: Vec<f64>,
}

impl Coverage {
    /// Whether every part of the shape is near to points, and every point near to the shape.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.bare.is_empty() && self.far == 0 && !self.spread_out
    }

    /// Several shapes together: sums, the largest spacing, noise and limits, and the places of the shape on which they are.
    pub(crate) fn together(all: &[&Self]) -> Self {
        let size: f64 = all.iter().map(|c| c.size).sum();
        let without_data = all.iter().map(|c| c.without_data).fold(0.0, |sum, part| sum + part);
        let largest = |f: fn(&Self) -> f64| all.iter().map(|c| f(c)).fold(0.0, f64::max);
        let furthest = all.iter().max_by(|a, b| a.max.total_cmp(&b.max));
        let share = |part: f64| if size > 0.0 { part / size } else { 0.0 };
        let polygon: f64 = all.iter().filter(|c| c.size_ratio > 0.0).map(|c| c.size / c.size_ratio).sum();
        let mut bare: Vec<Bare> = all.iter().flat_map(|c| c.bare.clone()).collect();
        bare.sort_by(|a, b| b.size.total_cmp(&a.size));
        Self {
            rms: share(all.iter().map(|c| c.rms * c.rms * c.size).sum()).sqrt(),
            max: largest(|c| c.max),
            max_parameter: furthest.map(|c| c.max_parameter.clone()).unwrap_or_default(),
            max_place: furthest.map(|c| c.max_place.clone()).unwrap_or_default(),
            spacing: largest(|c| c.spacing),
            noise: largest(|c| c.noise),
            size,
            size_ratio: if polygon > 0.0 { size / polygon } else { 0.0 },
            without_data,
            share_without_data: share(without_data),
            gap_limit: largest(|c| c.gap_limit),
            bare,
            distance_limit: largest(|c| c.distance_limit),
            far: all.iter().map(|c| c.far).sum(),
            spread_out: all.iter().any(|c| c.spread_out),
        }
    }

    /// Lengths in units of the spacing of the points.
    #[must_use]
    pub fn in_spacings(&self, length: f64) -> f64 {
        if self.spacing > 0.0 { length / self.spacing } else { 0.0 }
    }

    /// The same in coordinates whose origin was elsewhere.
    pub(crate) fn moved(&mut self, by: &[f64]) {
        let places = self.bare.iter_mut().map(|b| &mut b.place).chain(std::iter::once(&mut self.max_place));
        places.for_each(|place| place.iter_mut().zip(by).for_each(|(x, d)| *x += d));
    }

    /// One number to compare fits by: the share of the shape without points, of points that are far away, and 1 for points that spread.
    pub(crate) fn badness(&self, points: usize) -> f64 {
        let far = self.far as f64 / points.max(1) as f64;
        self.share_without_data + far + if self.spread_out { 1.0 } else { 0.0 }
    }
}
