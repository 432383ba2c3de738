//! How near the parts of a surface are to the data: the other side of the distances of a fit.

mod contour;
mod outline;
mod samples;

use crate::spacing::{LocalSpacing, distinct};
use crate::{Error, parallel};
use mesh_core::LoopSurface;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, TrimLoops};
use samples::{Samples, samples_of_subdivision, samples_of_surface};

pub use outline::data_outline;

/// Distance from the nearest point, in spacings of the data and in standard deviations of its noise, or tolerances, beyond which a part of a surface
/// is without data. Among a million evenly scattered points a place is 2.4 spacings from all of them once in a hundred times.
const WITHOUT_DATA: f64 = 2.5;
const UNEXPLAINED: f64 = 3.0;
/// Distance between samples of the surface, in spacings.
const STEP: f64 = 0.5;
/// Share of the samples that are nearest to the data, and the distance of the farthest of these, in spacings, where points are
/// scattered evenly. Points in rows that are far apart are not as near to the parts between them.
const NEAR_SHARE: f64 = 0.3;
const NEAR: f64 = 0.337;
/// How much larger than the one that neighbours tell the spacing may be by this.
const IN_ROWS: f64 = 4.0;

/// How near a surface is to data points: every part of it, while the report of a fit tells how near every point is to the surface.
///
/// The surface is sampled evenly, and the distance of each sample from the nearest data point is weighed by the area that the sample
/// stands for. Parts farther from all points than two and a half times their spacing, and three times the noise or the tolerance, are without data: a flap, a
/// bridge, an end that runs on, or a hole of the data that the surface spans.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SurfaceCoverage {
    /// Root mean square distance of the surface from the nearest data point, by area.
    pub rms: f64,
    /// The largest distance.
    pub max: f64,
    /// Where it is: parameters in u and v; of a subdivision surface twice the number of the control triangle plus the first
    /// barycentric coordinate, and the second one.
    pub max_parameter: [f64; 2],
    /// The largest distance in spacings of the data.
    pub max_in_spacings: f64,
    /// Spacing of the data: side of the square that a point has to itself; of points in rows, the larger of the two distances.
    pub spacing: f64,
    /// Distance from the nearest point beyond which a part is without data (where points lie wider apart, accordingly more).
    pub limit: f64,
    /// Area of the surface.
    pub area: f64,
    /// Area of the parts without data.
    pub area_without_data: f64,
    /// The same in squares of the spacing.
    pub area_without_data_in_spacings: f64,
    /// Area of the surface divided by that of its parts with data; 1 where there are no others.
    pub area_ratio: f64,
    /// Samples of the surface.
    pub samples: usize,
    /// Largest distance of neighbouring samples: what is smaller may be missed.
    pub resolution: f64,
}

/// What of a surface is near data points; see [`SurfaceCoverage::up_to_data`].
#[derive(Clone, Debug, PartialEq)]
pub struct PieceWithData {
    /// How near it is.
    pub coverage: SurfaceCoverage,
    /// The loops that bound it; `None` if it is the whole surface.
    pub trim: Option<TrimLoops>,
    /// The surface that the loops are on, if it is not the same: opened where it closed.
    pub opened: Option<BsplineSurface>,
}

impl SurfaceCoverage {
    /// Of a B-spline or NURBS surface; `noise` is the standard deviation of the distances of the points, `abs_tolerance` a distance
    /// that was asked for.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for fewer than two different points.
    pub fn of_surface(
        surface: &BsplineSurface,
        points: &[Vector3<f64>],
        noise: f64,
        abs_tolerance: Option<f64>,
    ) -> Result<Self, Error> {
        let data = Data::new(points, noise, abs_tolerance)?;
        data.measure(&samples_of_surface(surface, None, STEP * data.spacing.typical()))
    }

    /// Of what loops in its parameters bound of a surface, as [`of_surface`](Self::of_surface).
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for fewer than two different points.
    pub fn of_trimmed(
        surface: &BsplineSurface,
        trim: &TrimLoops,
        points: &[Vector3<f64>],
        noise: f64,
        abs_tolerance: Option<f64>,
    ) -> Result<Self, Error> {
        let data = Data::new(points, noise, abs_tolerance)?;
        data.measure(&samples_of_surface(surface, Some(trim), STEP * data.spacing.typical()))
    }

    /// Of a surface as far as the data go: where parts of it are without data, which [`data_outline`] leaves out, of the piece that this
    /// bounds. With `outliers` some of the points may belong to nothing.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for fewer than two different points.
    pub fn up_to_data(
        surface: &BsplineSurface,
        points: &[Vector3<f64>],
        noise: f64,
        abs_tolerance: Option<f64>,
        outliers: bool,
    ) -> Result<PieceWithData, Error> {
        let coverage = Self::of_surface(surface, points, noise, abs_tolerance)?;
        let whole = PieceWithData { coverage, trim: None, opened: None };
        let (opened, trim) = match data_outline(surface, points, &coverage, outliers)? {
            Some(trim) => (None, trim),
            None => match outline::opened_with_outline(surface, points, &coverage, outliers)? {
                Some((opened, trim)) => (Some(opened), trim),
                None => return Ok(whole),
            },
        };
        let on = opened.as_ref().unwrap_or(surface);
        let coverage = Self::of_trimmed(on, &trim, points, noise, abs_tolerance)?;
        Ok(if coverage.is_complete() { PieceWithData { coverage, trim: Some(trim), opened } } else { whole })
    }

    /// Of a subdivision surface, as [`of_surface`](Self::of_surface).
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for fewer than two different points.
    pub fn of_subdivision(
        surface: &LoopSurface,
        points: &[Vector3<f64>],
        noise: f64,
        abs_tolerance: Option<f64>,
    ) -> Result<Self, Error> {
        let data = Data::new(points, noise, abs_tolerance)?;
        data.measure(&samples_of_subdivision(surface, STEP * data.spacing.typical()))
    }

    /// The standard deviation of noise that leaves distances, by their median.
    #[must_use]
    pub fn noise_of(distances: &[f64]) -> f64 {
        noise_of(distances.iter().map(|d| d.abs()).collect())
    }

    /// Whether every part of the surface is near data points.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.max.is_finite() && self.area.is_finite() && self.area_without_data == 0.0
    }
}

impl std::fmt::Display for SurfaceCoverage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "surface to data rms {:.4e}, max {:.4e} ({:.1} spacings); area {:.4e}, without data {:.4e}",
            self.rms, self.max, self.max_in_spacings, self.area, self.area_without_data
        )
    }
}

/// Standard deviation of noise that leaves distances: by their median, so that outliers and parts that a shape does not follow do not matter.
pub(crate) fn noise_of(mut distances: Vec<f64>) -> f64 {
    /// Median of the absolute value of a normal distribution.
    const MEDIAN: f64 = 0.674_489_75;
    distances.retain(|d| d.is_finite());
    if distances.is_empty() {
        return 0.0;
    }
    let middle = distances.len() / 2;
    *distances.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN
}

/// Points to which parts of a surface should be near.
struct Data {
    spacing: LocalSpacing,
    /// Distance that noise or a tolerance explain.
    explained: f64,
}

impl Data {
    fn new(points: &[Vector3<f64>], noise: f64, abs_tolerance: Option<f64>) -> Result<Self, Error> {
        let spacing = LocalSpacing::new(&distinct(points))?;
        Ok(Self { spacing, explained: noise.max(abs_tolerance.unwrap_or(0.0)).max(0.0) })
    }

    fn measure(&self, samples: &Samples) -> Result<SurfaceCoverage, Error> {
        let index = self.spacing.index();
        let nearest = index.nearest_many(&samples.places);
        let distance = |k: usize| nearest[k].map_or(f64::INFINITY, |n| n.distance());
        let spacing = self.spacing.typical().max(self.between_rows(samples, &distance));
        let limit = (WITHOUT_DATA * spacing).max(UNEXPLAINED * self.explained);
        // Only few samples are so far away that the spacing in their place matters.
        let is_without = |k: usize| {
            distance(k) > limit
                && nearest[k].is_none_or(|n| {
                    let local = self.spacing.around(n.index).min(IN_ROWS * spacing);
                    distance(k) > WITHOUT_DATA * local
                })
        };
        let without = parallel::map(samples.places.len(), is_without);
        let (mut area, mut far, mut square) = (0.0, 0.0, 0.0);
        let (mut max, mut max_parameter) = (0.0, [0.0; 2]);
        for (k, (&part, &without)) in samples.areas.iter().zip(&without).enumerate() {
            let d = distance(k);
            area += part;
            square += part * d * d;
            if without {
                // A part without area counts nevertheless.
                far += part.max(f64::MIN_POSITIVE);
            }
            if d > max {
                (max, max_parameter) = (d, samples.parameters[k]);
            }
        }
        Ok(SurfaceCoverage {
            rms: (square / area.max(f64::MIN_POSITIVE)).sqrt(),
            max,
            max_parameter,
            max_in_spacings: max / spacing,
            spacing,
            limit,
            area,
            area_without_data: far,
            area_without_data_in_spacings: far / (spacing * spacing),
            area_ratio: area / (area - far).max(f64::MIN_POSITIVE),
            samples: samples.places.len(),
            resolution: samples.resolution,
        })
    }

    /// The spacing that the distances of the nearest samples tell.
    fn between_rows(&self, samples: &Samples, distance: &dyn Fn(usize) -> f64) -> f64 {
        let mut order: Vec<(f64, f64)> =
            samples.areas.iter().enumerate().map(|(k, a)| (distance(k), *a)).collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let wanted = NEAR_SHARE * samples.areas.iter().sum::<f64>();
        let mut sum = 0.0;
        let quantile = order.iter().find(|(_, area)| {
            sum += area;
            sum >= wanted
        });
        let found = quantile.map_or(0.0, |(distance, _)| (distance - self.explained).max(0.0) / NEAR);
        found.min(IN_ROWS * self.spacing.typical())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;
    use nurbs_core::KnotVector;

    /// The square [0, 2] × [0, 1] in the plane z = 0.
    fn rectangle() -> BsplineSurface {
        let knots = KnotVector::uniform_clamped(2, 5).unwrap();
        let place = |k: usize| {
            let at = [0.0, 1.0 / 6.0, 0.5, 5.0 / 6.0, 1.0];
            Vector3::new(2.0 * at[k / 5], at[k % 5], 0.0)
        };
        BsplineSurface::new(knots.clone(), knots, (0..25).map(place).collect(), None).unwrap()
    }

    fn grid(width: f64) -> Vec<Vector3<f64>> {
        let n = 41;
        let at = |k: usize| Vector3::new((k / n) as f64 * width / 40.0, (k % n) as f64 / 40.0, 0.0);
        (0..n * n).map(at).collect()
    }

    #[test]
    fn a_surface_on_its_data_is_complete() {
        let found = SurfaceCoverage::of_surface(&rectangle(), &grid(2.0), 0.0, None).unwrap();
        assert!(found.is_complete(), "{found}");
        assert!((found.area - 2.0).abs() < 1e-9 && found.area_ratio == 1.0, "{found}");
        // Points are .05 and .025 apart.
        assert!((0.025..0.06).contains(&found.spacing), "{found:?}");
        assert!(found.max <= 0.5 * 0.05f64.hypot(0.025) + 1e-12 && found.rms < found.max, "{found}");
    }

    #[test]
    fn a_half_without_data_is_told() {
        let found = SurfaceCoverage::of_surface(&rectangle(), &grid(1.0), 0.0, None).unwrap();
        assert!(!found.is_complete());
        // The far edge is 1 away from the points; what is farther than the limit from them begins there.
        assert!((found.max - 1.0).abs() < 0.02, "{found}");
        let expected = 1.0 - found.limit;
        assert!((found.area_without_data - expected).abs() < 0.05, "{found:?}");
        assert!((found.area_ratio - 2.0 / (2.0 - expected)).abs() < 0.1);
        assert!(found.max_parameter[0] > 0.9);
        // A tolerance, or noise, of that size explains it.
        assert!(SurfaceCoverage::of_surface(&rectangle(), &grid(1.0), 0.0, Some(0.4)).unwrap().is_complete());
        assert!(SurfaceCoverage::of_surface(&rectangle(), &grid(1.0), 0.4, None).unwrap().is_complete());
    }

    #[test]
    fn rows_of_points_are_as_far_apart_as_they_are() {
        // Rows .1 apart, with points .02 apart in them.
        let rows: Vec<_> = (0..21 * 51)
            .map(|k: i32| Vector3::new(f64::from(k / 51) / 10.0, f64::from(k % 51) / 50.0, 0.0))
            .collect();
        let found = SurfaceCoverage::of_surface(&rectangle(), &rows, 0.0, None).unwrap();
        assert!(found.is_complete() && (0.05..0.15).contains(&found.spacing), "{found:?}");
    }

    #[test]
    fn triangles_are_sampled_all_over() {
        let corners =
            [[0., 0., 0.], [4., 0., 0.], [4., 4., 0.], [0., 4., 0.], [2., 2., 0.]].map(Point3::from);
        let triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let mesh = mesh_core::TriangleMesh::new(corners.to_vec(), triangles).unwrap();
        let surface = LoopSurface::new(&mesh).unwrap();
        let samples = samples_of_subdivision(&surface, 0.1);
        // Boundary curves are B-splines through no corner: the area is that of a rounded square.
        let area: f64 = samples.areas.iter().sum();
        assert!(area > 8.0 && area < 16.0, "{area}");
        assert!(samples.resolution <= 0.1 + 1e-12);
    }
}
