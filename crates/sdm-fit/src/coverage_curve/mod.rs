//! How near the parts of a curve are to the data: the other side of the distances of a fit.

mod gaps;
mod measure;
mod spread;
mod stop;

pub(crate) use gaps::{PRESUMED, gap_limits, gap_limits_of, usual_gap};
pub(crate) use measure::{Limits, of_curve};

/// Share of the points that counts as far away from a curve that does not follow them.
const LOOSE: f64 = 0.02;

/// How near a curve is to data points, and they to it: every part of it, and every point.
///
/// The feet of the points divide the curve. Where the stretch between two that are next to each other is longer than the spacing of the points, or their
/// noise, explains, the curve is without data: a hook, a bridge, an end that runs on, or a hole of the data that the curve spans. Beside
/// this the distance of the curve from the nearest data point is measured all along it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CurveCoverage {
    /// Root mean square distance of the curve from the nearest data point, by length.
    pub rms: f64,
    /// The largest distance.
    pub max: f64,
    /// The parameter where it is.
    pub max_parameter: f64,
    /// The largest distance in spacings of the data.
    pub max_in_spacings: f64,
    /// Spacing of the data: mean distance of neighbouring points along the curve.
    pub spacing: f64,
    /// Standard deviation of the points across the curve, from the differences of neighbours.
    pub noise: f64,
    /// Length between the feet of neighbours beyond which the curve is without data (where points lie wider apart, accordingly more).
    pub limit: f64,
    /// Length of the curve.
    pub length: f64,
    /// Length of the parts without data.
    pub length_without_data: f64,
    /// The same in spacings.
    pub length_without_data_in_spacings: f64,
    /// Length of the curve divided by that of the polygon through the feet of neighbours; near 1 where there are no parts without data.
    pub length_ratio: f64,
    /// The parts without data, the longest first.
    pub without_data: Vec<Stretch>,
    /// Distance from the curve up to which a point is near: two and a half spacings, or what noise or a tolerance explain.
    pub distance_limit: f64,
    /// Number of points that are further away.
    pub points_far: usize,
    /// Whether the points are further from the curve than noise and a share of their spacing explain: it does not follow them.
    pub unresolved: bool,
    /// Whether the points spread so widely about the curve that they do not lie on a curve.
    pub spread_out: bool,
    /// Places of the curve whose distance was measured.
    pub samples: usize,
    /// Largest distance of neighbouring samples.
    pub resolution: f64,
}

/// A part of a curve without data.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Stretch {
    /// Parameter at its beginning.
    pub from: f64,
    /// And at its end; less than at the beginning where it goes through the seam of a closed curve.
    pub to: f64,
    /// Its length.
    pub length: f64,
    /// A place in its middle.
    pub place: Vec<f64>,
}

impl CurveCoverage {
    /// Whether every part of the curve is near data points.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.without_data.is_empty() && self.length > 0.0
    }

    /// Whether every part of the curve is near data points, and every point near the curve.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.is_complete() && self.points_far == 0 && !self.spread_out && !self.unresolved
    }

    /// Several curves together: sums, the largest spacing, noise, limits and distances.
    pub(crate) fn together(all: &[&Self]) -> Self {
        let sum = |f: fn(&Self) -> f64| all.iter().map(|c| f(c)).fold(0.0, |sum, part| sum + part);
        let largest = |f: fn(&Self) -> f64| all.iter().map(|c| f(c)).fold(0.0, f64::max);
        let furthest = all.iter().max_by(|a, b| a.max.total_cmp(&b.max));
        let length = sum(|c| c.length);
        let polygon: f64 =
            all.iter().filter(|c| c.length_ratio > 0.0).map(|c| c.length / c.length_ratio).sum();
        let mut without_data: Vec<Stretch> = all.iter().flat_map(|c| c.without_data.clone()).collect();
        without_data.sort_by(|a, b| b.length.total_cmp(&a.length));
        let squares: f64 = all.iter().map(|c| c.rms * c.rms * c.length).sum();
        Self {
            rms: if length > 0.0 { (squares / length).sqrt() } else { 0.0 },
            max: largest(|c| c.max),
            max_parameter: furthest.map_or(0.0, |c| c.max_parameter),
            max_in_spacings: largest(|c| c.max_in_spacings),
            spacing: largest(|c| c.spacing),
            noise: largest(|c| c.noise),
            limit: largest(|c| c.limit),
            length,
            length_without_data: sum(|c| c.length_without_data),
            length_without_data_in_spacings: sum(|c| c.length_without_data_in_spacings),
            length_ratio: if polygon > 0.0 { length / polygon } else { 0.0 },
            without_data,
            distance_limit: largest(|c| c.distance_limit),
            points_far: all.iter().map(|c| c.points_far).sum(),
            unresolved: all.iter().any(|c| c.unresolved),
            spread_out: all.iter().any(|c| c.spread_out),
            samples: all.iter().map(|c| c.samples).sum(),
            resolution: largest(|c| c.resolution),
        }
    }

    /// The same in coordinates whose origin was elsewhere.
    pub(crate) fn moved(&mut self, by: &[f64]) {
        for stretch in &mut self.without_data {
            stretch.place.iter_mut().zip(by).for_each(|(x, d)| *x += d);
        }
    }

    /// Length of the parts without data as a share of the whole.
    pub(crate) fn share_without_data(&self) -> f64 {
        if self.length > 0.0 { self.length_without_data / self.length } else { 1.0 }
    }

    /// One number to compare fits by: the share of the curve without data, of points that are far away, a little where it does not follow them, and 1 for
    /// points that spread.
    pub(crate) fn badness(&self, points: usize) -> f64 {
        let far = self.points_far as f64 / points.max(1) as f64;
        let loose = if self.unresolved { LOOSE } else { 0.0 };
        self.share_without_data() + far + loose + if self.spread_out { 1.0 } else { 0.0 }
    }
}

impl std::fmt::Display for CurveCoverage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "curve to data rms {:.4e}, max {:.4e} ({:.1} spacings); length {:.4e}, without data {:.4e}",
            self.rms, self.max, self.max_in_spacings, self.length, self.length_without_data
        )
    }
}
