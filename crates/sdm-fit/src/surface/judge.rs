//! Surfaces compared and judged by the same measure: what a fit minimises, with the same weights of the points.

use super::ActiveSurface;
use super::given::bending;
use crate::cloud_kind::{distance_of_far, measurable};
use crate::target::{Feet, Samples};
use crate::weights::{measure, weights};
use crate::{Error, FitOptions, parallel};
use distance_field::{DistanceField, PrincipalFrame, Search, SurfaceField};
use footpoint::Status as FootStatus;
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};
use nurbs_core::{BsplineSurface, Direction, Interval, ParametricSurface};
use sdm_core::Robust;

/// What a surface costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCost {
    /// Mean squared distance with the weights of the points, plus `λ` times the energy.
    pub cost: f64,
    /// Root mean square distance with these weights.
    pub rms: f64,
}

/// The frames of points at their nearest places on a surface.
///
/// # Errors
/// [`Error::Field`] and [`Error::Shape`] for surfaces that cannot be projected onto.
pub fn surface_frames(
    surface: &BsplineSurface,
    points: &[Vector3<f64>],
) -> Result<Vec<PrincipalFrame<3>>, Error> {
    Ok(SurfaceField::new(surface)?.frames(points, Search::Global, &[]))
}

/// The costs of two surfaces with the same knots, given with the frames of the points, by the same measure: what points count is told by
/// their distances from the second (see [`FitOptions::robust`]), and `lambda` is the factor of the energy. Surfaces that were smoothed, or
/// fitted with weights, are not nearer to all points than others, but cost less.
///
/// # Errors
/// [`Error::Length`] unless there is a frame for each point; [`Error::Rational`] for a surface with weights and an energy.
pub fn surface_costs(
    points: &[Vector3<f64>],
    surfaces: [(&BsplineSurface, &[PrincipalFrame<3>]); 2],
    options: &FitOptions,
    lambda: f64,
) -> Result<[SurfaceCost; 2], Error> {
    for (_, frames) in surfaces {
        if frames.len() != points.len() {
            return Err(Error::Length { what: "frames", found: frames.len(), points: points.len() });
        }
    }
    let feet = surfaces.map(|(_, frames)| Feet { frames: frames.to_vec() });
    let samples = Samples::of_points(points)?;
    let weights = weights(&samples, &feet[1], options.robust);
    let cost = |k: usize| -> Result<SurfaceCost, Error> {
        let (sum, ..) = measure(&feet[k], &weights);
        let bend = if lambda > 0.0 {
            bending(&ActiveSurface::new(surfaces[k].0.clone())?, options.energy)
        } else {
            0.0
        };
        Ok(SurfaceCost { cost: sum + lambda * bend, rms: sum.sqrt() })
    };
    Ok([cost(0)?, cost(1)?])
}

/// How much the residuals of points differ from those of the points with the nearest feet: 1 where they have nothing to do with each other,
/// as noise, and near 0 where neighbours are off alike, since the surface does not follow the points (\[Ne41\], for surfaces). 1 where
/// there are no residuals.
///
/// # Errors
/// [`Error::Length`] unless there is a frame for each point.
pub fn residual_disagreement(points: &[Vector3<f64>], frames: &[PrincipalFrame<3>]) -> Result<f64, Error> {
    /// Points that are asked.
    const ASKED: usize = 4000;
    if frames.len() != points.len() {
        return Err(Error::Length { what: "frames", found: frames.len(), points: points.len() });
    }
    let used: Vec<usize> = (0..points.len()).filter(|&i| frames[i].is_finite()).collect();
    let places: Vec<Point3<f64>> = used.iter().map(|&i| frames[i].foot.into()).collect();
    let index = CloudIndex::new(&places)?;
    let residual = |k: usize| points[used[k]] - frames[used[k]].foot;
    let step = used.len().div_ceil(ASKED).max(1);
    let asked: Vec<usize> = (0..used.len()).step_by(step).collect();
    let parts = parallel::tasks(asked.len(), |a| {
        let k = asked[a];
        let other = index.nearest_n(&places[k], 2).into_iter().map(|n| n.index).find(|&other| other != k)?;
        let (here, there) = (residual(k), residual(other));
        Some(((here - there).norm_squared(), here.norm_squared() + there.norm_squared()))
    });
    let (change, sum) = parts.iter().flatten().fold((0.0, 0.0), |(a, b), part| (a + part.0, b + part.1));
    Ok(if sum > 0.0 { change / sum } else { 1.0 })
}

/// The surface without the parts of its domain, at open ends, that are beyond the parameters of all feet; `None` if there are none.
///
/// # Errors
/// [`Error::Shape`] never, but that surfaces are checked when they are made.
pub fn cut_to_feet(
    surface: &BsplineSurface,
    frames: &[PrincipalFrame<3>],
) -> Result<Option<BsplineSurface>, Error> {
    /// Share of the domain that is worth a cut.
    const WORTH: f64 = 1e-3;
    let mut found = None;
    for (d, direction) in [Direction::U, Direction::V].into_iter().enumerate() {
        let knots = [surface.knots_u(), surface.knots_v()][d];
        if knots.is_periodic() {
            continue;
        }
        let feet = frames.iter().filter(|f| f.is_finite()).map(|f| f.hint.parameter[d]);
        let (low, high) = feet.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (domain, least) = (knots.domain(), WORTH * knots.domain().length());
        // Poles are ends without a length: they stay.
        let is_pole = |at: f64| {
            let other = [surface.knots_u(), surface.knots_v()][1 - d].domain();
            let place = |k: u32| {
                let t = other.lerp(f64::from(k) / 8.0);
                if d == 0 { surface.point(at, t) } else { surface.point(t, at) }
            };
            (1..=8)
                .all(|k| (place(k) - place(0)).norm() <= 1e-9 * surface.control_points()[0].norm().max(1.0))
        };
        let from =
            if low > domain.start() + least && !is_pole(domain.start()) { low } else { domain.start() };
        let to = if high < domain.end() - least && !is_pole(domain.end()) { high } else { domain.end() };
        if (from > domain.start() || to < domain.end()) && to - from > 0.5 * domain.length() {
            let current = found.as_ref().unwrap_or(surface);
            found = Some(current.trimmed(direction, Interval::new(from, to)?)?);
        }
    }
    Ok(found)
}

/// Where the points of a cloud are from a surface: all of them, whether they were used to make it or not.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceDistances {
    /// The distance of each point; NaN of points that are not finite.
    pub distances: Vec<f64>,
    /// What each point counts; 0 for outliers, and points that are not finite.
    pub weights: Vec<f64>,
    /// How much residuals of neighbours differ, see [`residual_disagreement`].
    pub disagreement: f64,
    /// Root mean square distance with these weights.
    pub rms: f64,
    /// Largest distance of a point that counts.
    pub max: f64,
    /// That point.
    pub max_index: usize,
    /// Number of points that count.
    pub used: usize,
}

impl SurfaceDistances {
    /// Of points, finite or not. Points that cannot belong to a surface ([`measurable`]) count unless outliers are
    /// expected.
    ///
    /// # Errors
    /// Those of [`measurable`], and for surfaces that cannot be projected onto.
    pub fn of(surface: &BsplineSurface, points: &[Vector3<f64>], robust: Robust) -> Result<Self, Error> {
        let belongs = measurable(points)?;
        let numbers: Vec<usize> = (0..points.len()).filter(|&i| belongs[i]).collect();
        let kept: Vec<Vector3<f64>> = numbers.iter().map(|&i| points[i]).collect();
        let frames = surface_frames(surface, &kept)?;
        let feet = Feet { frames };
        let found = weights(&Samples::of_points(&kept)?, &feet, robust);
        let (sum, max, place) = measure(&feet, &found);
        let (mut distances, mut all) = (vec![f64::NAN; points.len()], vec![0.0; points.len()]);
        for (k, &i) in numbers.iter().enumerate() {
            let frame = &feet.frames[k];
            let usable = frame.is_finite() && frame.status != FootStatus::InvalidPoint;
            distances[i] = if usable { frame.distance.abs() } else { f64::INFINITY };
            all[i] = found[k];
        }
        let (mut max, mut max_index) = (max, numbers.get(place).copied().unwrap_or(0));
        let middle = surface.control_points().first().copied().unwrap_or_else(Vector3::zeros);
        for (i, point) in points.iter().enumerate() {
            if belongs[i] || !point.iter().all(|c| c.is_finite()) {
                continue;
            }
            distances[i] = distance_of_far(point, &middle);
            if robust == Robust::None && distances[i] > max {
                (max, max_index) = (distances[i], i);
            }
        }
        let used = all.iter().filter(|w| **w > 0.0).count();
        let disagreement = residual_disagreement(&kept, &feet.frames)?;
        Ok(Self { disagreement, distances, weights: all, rms: sum.sqrt(), max, max_index, used })
    }

    /// Number of finite points.
    #[must_use]
    pub fn finite(&self) -> usize {
        self.distances.iter().filter(|d| !d.is_nan()).count()
    }

    /// Share of the finite points within a distance.
    #[must_use]
    pub fn share_within(&self, tolerance: f64) -> f64 {
        let within = self.distances.iter().filter(|d| **d <= tolerance).count();
        within as f64 / self.finite().max(1) as f64
    }
}
