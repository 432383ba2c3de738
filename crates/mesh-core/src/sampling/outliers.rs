//! Points of a cloud that stand apart.

use nalgebra::Point3;

use crate::bounds::is_finite;
use crate::{CloudIndex, Error};

/// Which points of a cloud stand apart, and by what measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Outliers {
    /// Whether each point is kept. Points that are not finite are not.
    pub keep: Vec<bool>,
    /// The measure of each point; NaN for points that are not finite.
    ///
    /// The mean distance to the nearest neighbours, or the number of neighbours within the radius.
    pub measures: Vec<f64>,
    /// Mean of the measures of the finite points.
    pub mean: f64,
    /// Standard deviation of these measures (n − 1 in the denominator).
    pub deviation: f64,
    /// The measure of the last point that is kept: the largest distance, or the smallest number.
    pub threshold: f64,
    /// Number of finite points that are not kept.
    pub removed: usize,
    /// Number of points that are not finite.
    pub non_finite: usize,
}

impl Outliers {
    fn new(
        points: &[Point3<f64>],
        measures: Vec<f64>,
        limit: impl FnOnce(f64, f64) -> f64,
        far_is_out: bool,
    ) -> Self {
        let finite: Vec<f64> = (points.iter().zip(&measures))
            .filter(|(point, _)| is_finite(point))
            .map(|(_, &measure)| measure)
            .collect();
        let count = finite.len();
        let mean = if count > 0 { finite.iter().sum::<f64>() / count as f64 } else { 0.0 };
        let squares: f64 = finite.iter().map(|measure| (measure - mean) * (measure - mean)).sum();
        let deviation = if count > 1 { (squares / (count - 1) as f64).sqrt() } else { 0.0 };
        let threshold = limit(mean, deviation);
        let keep: Vec<bool> = (measures.iter())
            .map(|&measure| if far_is_out { measure <= threshold } else { measure >= threshold })
            .collect();
        let removed = count - keep.iter().filter(|&&keep| keep).count();
        Self { keep, measures, mean, deviation, threshold, removed, non_finite: points.len() - count }
    }
}

/// Points whose mean distance to their `neighbours` nearest neighbours exceeds the mean of all points by more than
/// `ratio` standard deviations stand apart (\[RMBDB08\]).
///
/// Common values are 8 to 50 neighbours and a ratio of 1 to 3. A point without neighbours has the distance 0.
///
/// # Errors
/// [`Error::TooFew`] if `neighbours` is 0, [`Error::OutOfRange`] if the ratio is negative or not finite,
/// [`Error::TooMany`] beyond 32-bit indices.
pub fn statistical_outliers(
    points: &[Point3<f64>],
    neighbours: usize,
    ratio: f64,
) -> Result<Outliers, Error> {
    if neighbours == 0 {
        return Err(Error::TooFew { what: "neighbours", count: 0, least: 1 });
    }
    if !(ratio >= 0.0 && ratio.is_finite()) {
        return Err(Error::OutOfRange { what: "ratio", value: ratio, least: 0.0 });
    }
    let index = CloudIndex::new(points)?;
    let measures = index.map_nearest_n(points, neighbours.saturating_add(1), |i, near| {
        if !is_finite(&points[i]) {
            return f64::NAN;
        }
        let (mut sum, mut count) = (0.0, 0u32);
        for other in near.iter().filter(|other| other.index != i).take(neighbours) {
            sum += other.distance();
            count += 1;
        }
        sum / f64::from(count.max(1))
    });
    // Where all distances are equal, rounding must not tell points apart.
    let slack = |mean: f64| 1e-12 * mean;
    Ok(Outliers::new(points, measures, |mean, deviation| mean + ratio * deviation + slack(mean), true))
}

/// Points with fewer than `least` other points within the radius stand apart.
///
/// # Errors
/// [`Error::OutOfRange`] if the radius is negative or NaN, [`Error::TooMany`] beyond 32-bit indices.
pub fn radius_outliers(points: &[Point3<f64>], radius: f64, least: usize) -> Result<Outliers, Error> {
    if radius.is_nan() || radius < 0.0 {
        return Err(Error::OutOfRange { what: "radius", value: radius, least: 0.0 });
    }
    let index = CloudIndex::new(points)?;
    let measures = index.map_within(points, radius, |i, near| {
        if is_finite(&points[i]) { near.len().saturating_sub(1) as f64 } else { f64::NAN }
    });
    Ok(Outliers::new(points, measures, |_, _| least as f64, false))
}
