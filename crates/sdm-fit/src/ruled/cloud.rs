//! Ruled surfaces through clouds of which nothing is known.

use super::Developability;
use super::fit::{RuledFit, RuledOptions, RuledReport, fit_ruled_within};
use super::start::initial_ruled;
use crate::cloud_kind::{CloudKind, cloud_kind, distance_of_far, measurable};
use crate::coverage_surface::noise_of;
use crate::iterate::{Progress, no_progress};
use crate::surface::apart::kept;
use crate::surface::{SurfaceOptions, cut_to_feet};
use crate::{BaseShape, Error, Folds, Status, SurfaceCoverage, Target};
use mesh_core::CloudIndex;
use nalgebra::{Point3, Vector3};
use nurbs_core::BsplineSurface;

/// Least share of the distance of an offset that its points keep from the cloud.
const GOUGE: f64 = 0.98;

/// How a cloud is made a ruled surface, or layers of them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RuledCloudOptions {
    /// What gives the first parameters: [`BaseShape::Cylinder`] for sections that are closed, with rulings along the axis,
    /// [`BaseShape::Plane`] for open ones, [`BaseShape::Auto`] (the default) for the one of these that describes the cloud better.
    pub base: BaseShape,
    /// Degree along the sections; default 3.
    pub degree: usize,
    /// Control points on each section, and sections; two sections are one ruled surface, more are layers. Default 16, 2; those to
    /// begin with, where there is a tolerance.
    pub controls: [usize; 2],
    /// Largest distance that is wanted (a length): sections or control points on them, whichever bring more, are added until it
    /// holds or the cap is met; default none.
    pub abs_tolerance: Option<f64>,
    /// Share of the points that must lie within the tolerance; default 1.
    pub share: f64,
    /// Most control points of all sections; default 2000.
    pub max_controls: usize,
    /// Whether sections stay in parallel planes; their normal is the mean ruling of the start, unless
    /// [`RuledOptions::section_normal`] is given. Default not.
    pub level: bool,
    /// The fit of each surface.
    pub ruled: RuledOptions,
}

impl Default for RuledCloudOptions {
    fn default() -> Self {
        Self {
            base: BaseShape::Auto,
            degree: 3,
            controls: [16, 2],
            abs_tolerance: None,
            share: 1.0,
            max_controls: 2000,
            level: false,
            ruled: RuledOptions::default(),
        }
    }
}

impl RuledCloudOptions {
    fn check(&self) -> Result<(), Error> {
        let limits = SurfaceOptions::default().with_abs_tolerance(self.abs_tolerance).with_share(self.share);
        limits.check()?;
        if matches!(self.base, BaseShape::Sphere | BaseShape::Torus) {
            return Err(Error::Degenerate { shape: "a ruled surface", what: "around a sphere or a torus" });
        }
        Ok(())
    }
}

/// A ruled surface through a cloud, and how it came about.
#[derive(Clone, Debug)]
pub struct RuledCloudFit {
    /// The surface and its report.
    pub fit: RuledFit,
    /// What gave the first parameters; `None` for a start that was given.
    pub base: Option<BaseShape>,
    /// Share of the points within the tolerance, if there is one.
    pub share_within: Option<f64>,
    /// Whether the tolerance holds; true without one.
    pub within_tolerance: bool,
    /// Surfaces that were fitted, of different sizes.
    pub runs: usize,
    /// Points left out because they are not finite.
    pub dropped: usize,
}

impl RuledCloudFit {
    /// The report of the surface.
    #[must_use]
    pub fn report(&self) -> &RuledReport {
        &self.fit.report
    }
}

/// Fits a ruled surface, or layers of them, to a cloud of which nothing is known (\[P05, sec. 4.5\]).
///
/// Points that are not finite are left out and counted.
///
/// ```
/// use nalgebra::Vector3;
/// use sdm_fit::ruled::{RuledCloudOptions, fit_ruled_cloud};
///
/// // A hyperboloid of one sheet is ruled, and not developable.
/// let at = |k: i32| (f64::from(k) * 2.399_963, f64::from(k) / 1000.0 - 1.0);
/// let point = |(a, z): (f64, f64)| Vector3::new(a.cos() - z * a.sin(), a.sin() + z * a.cos(), 2.0 * z);
/// let points: Vec<_> = (0..2000).map(at).map(point).collect();
/// let options = RuledCloudOptions { abs_tolerance: Some(0.02), ..RuledCloudOptions::default() };
/// let found = fit_ruled_cloud(&points, None, &options)?;
/// assert!(found.within_tolerance && found.report().fit.max < 0.02, "{}", found.report());
/// # Ok::<(), sdm_fit::Error>(())
/// ```
///
/// # Errors
/// Input that spans no surface, options out of range, and those of [`fit_ruled`](super::fit_ruled) for a start of another kind.
pub fn fit_ruled_cloud(
    points: &[Vector3<f64>],
    initial: Option<BsplineSurface>,
    options: &RuledCloudOptions,
) -> Result<RuledCloudFit, Error> {
    fit_ruled_cloud_with_progress(points, initial, options, &no_progress)
}

/// [`fit_ruled_cloud`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As [`fit_ruled_cloud`].
pub fn fit_ruled_cloud_with_progress(
    points: &[Vector3<f64>],
    initial: Option<BsplineSurface>,
    options: &RuledCloudOptions,
    progress: Progress<'_>,
) -> Result<RuledCloudFit, Error> {
    options.check()?;
    let belongs = measurable(points)?;
    let finite = kept(points, &belongs);
    let what = match cloud_kind(&finite)? {
        CloudKind::Curve => Some("along a curve"),
        CloudKind::Volume => Some("all through a volume"),
        CloudKind::Surface => None,
    };
    if let Some(what) = what {
        return Err(Error::Degenerate { shape: "a ruled surface", what });
    }
    let dropped = points.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
    let count = points.len() - dropped;
    let (start, base) = match initial {
        Some(surface) => (surface, None),
        None => {
            let start = initial_ruled(&finite, options.base, options.degree, options.controls)?;
            (start.surface, Some(start.base))
        }
    };
    let run = |mut start: BsplineSurface| -> Result<RuledFit, Error> {
        let mut ruled = options.ruled;
        if options.level {
            let normal = ruled.section_normal.map_or_else(|| mean_ruling(&start), Vector3::from);
            ruled.section_normal = Some(normal.into());
            if base.is_some() {
                start = reaching_ends(start, &normal, &finite)?;
            }
        }
        let target = Target::Points { points: &finite, weights: None };
        fit_ruled_within(target, start, &ruled, options.abs_tolerance, progress)
    };
    // Points that cannot belong to the surface are outside of every tolerance.
    let share = |fit: &RuledFit| {
        let within = |t: f64| fit.frames.iter().filter(|f| f.distance.abs() <= t).count();
        options.abs_tolerance.map(|t| within(t) as f64 / count.max(1) as f64)
    };
    let good = |fit: &RuledFit| share(fit).is_none_or(|share| share >= options.share);
    let mut fit = run(start)?;
    let (mut runs, mut size) = (1, fit.report.controls);
    // A given start keeps its knots.
    while let Some(base) = base
        && !good(&fit)
        && fit.report.fit.status != Status::Cancelled
    {
        let [along, sections] = size;
        let mut best: Option<RuledFit> = None;
        for larger in [[along, 2 * sections - 1], [along + along.div_ceil(2), sections]] {
            if larger[0] * larger[1] > options.max_controls {
                continue;
            }
            let next = run(initial_ruled(&finite, base, options.degree, larger)?.surface)?;
            runs += 1;
            if best.as_ref().is_none_or(|best| next.report.fit.rms < best.report.fit.rms) {
                best = Some(next);
            }
        }
        let Some(next) = best else { break };
        // One that is no nearer may lead to one that is: its rulings have not found their places.
        size = next.report.controls;
        if good(&next) || next.report.fit.rms < fit.report.fit.rms {
            fit = next;
        }
    }
    let share_within = share(&fit);
    let within_tolerance = good(&fit);
    // Open ends stop where the points do; those that must keep their place stay.
    let free = base.is_some() && !options.level && !options.ruled.fixed_ends;
    if free && let Some(cut) = cut_to_feet(&fit.surface, &fit.frames)? {
        fit = judged_again(&finite, cut, fit, options)?;
    }
    count_apart(points, &belongs, &mut fit);
    Ok(RuledCloudFit { fit, base, share_within, within_tolerance, runs, dropped })
}

/// The fit with another surface that is a part of it.
fn judged_again(
    points: &[Vector3<f64>],
    surface: BsplineSurface,
    mut fit: RuledFit,
    options: &RuledCloudOptions,
) -> Result<RuledFit, Error> {
    fit.report.controls = [surface.knots_u().distinct_count(), surface.knots_v().distinct_count()];
    fit.report.developability = Developability::of(&surface)?;
    fit.report.folds = Folds::of(&surface);
    let distances = fit.frames.iter().map(|f| f.distance.abs()).collect();
    let noise = noise_of(distances);
    fit.report.coverage = Some(SurfaceCoverage::of_surface(&surface, points, noise, options.abs_tolerance)?);
    fit.surface = surface;
    Ok(fit)
}

/// Counts the finite points that cannot belong to the surface, and their distances, in the report.
fn count_apart(points: &[Vector3<f64>], belongs: &[bool], fit: &mut RuledFit) {
    let place = fit.surface.control_points().first().copied().unwrap_or_else(Vector3::zeros);
    let report = &mut fit.report.fit;
    let finite: Vec<(&Vector3<f64>, bool)> = points
        .iter()
        .zip(belongs)
        .filter(|(p, _)| p.iter().all(|c| c.is_finite()))
        .map(|(p, b)| (p, *b))
        .collect();
    let numbers: Vec<usize> = (0..finite.len()).filter(|&k| finite[k].1).collect();
    report.max_index = numbers.get(report.max_index).copied().unwrap_or(0);
    report.samples = finite.len();
    for (index, (point, _)) in finite.iter().enumerate().filter(|(_, (_, belongs))| !belongs) {
        let distance = distance_of_far(point, &place);
        if distance > report.max {
            (report.max, report.max_index) = (distance, index);
        }
    }
}

/// The sum of the rulings through the control points, from the first section to the last.
fn mean_ruling(surface: &BsplineSurface) -> Vector3<f64> {
    surface
        .control_points()
        .chunks(surface.n_v().max(1))
        .filter_map(|row| Some(row.last()? - row.first()?))
        .sum()
}

/// The surface with its first and last section in the planes of a normal that touch the cloud, so that no points lie beyond them;
/// their control points move along the rulings.
fn reaching_ends(
    surface: BsplineSurface,
    normal: &Vector3<f64>,
    points: &[Vector3<f64>],
) -> Result<BsplineSurface, Error> {
    let heights = points.iter().map(|p| p.dot(normal));
    let (low, high) =
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    let along = normal.dot(&mean_ruling(&surface));
    let (ends, columns) = (if along > 0.0 { [low, high] } else { [high, low] }, surface.n_v());
    let (u, v, mut net, _) = surface.into_parts();
    for row in net.chunks_mut(columns.max(2)) {
        for (end, inner, height) in [(0, 1, ends[0]), (columns - 1, columns - 2, ends[1])] {
            let ruling = row[end] - row[inner];
            let rise = ruling.dot(normal);
            // Rulings along the planes reach none of them.
            if rise.abs() > 0.1 * ruling.norm() * normal.norm() {
                row[end] += ruling * ((height - row[end].dot(normal)) / rise);
            }
        }
    }
    Ok(BsplineSurface::new(u, v, net, None)?)
}

/// Points of an offset, see [`offset_points`].
#[derive(Clone, Debug, PartialEq)]
pub struct OffsetPoints {
    /// The points.
    pub points: Vec<Vector3<f64>>,
    /// Points without a normal.
    pub without_normal: usize,
    /// Points left out because a cutter of this radius at their place would cut into the cloud somewhere else.
    pub gouging: usize,
}

/// The points of a cloud moved by a distance along their normals: where the axis of a cutter of this radius runs that mills the
/// shape (\[P05, sec. 4.5\]). A negative distance goes to the other side.
///
/// # Errors
/// [`Error::Option`] for a distance that is not finite; [`Error::Length`] unless there is a normal for each point.
pub fn offset_points(
    points: &[Vector3<f64>],
    normals: &[Vector3<f64>],
    abs_distance: f64,
) -> Result<OffsetPoints, Error> {
    if !abs_distance.is_finite() {
        return Err(Error::Option { name: "abs_distance", value: abs_distance, allowed: "a length" });
    }
    if normals.len() != points.len() {
        return Err(Error::Length { what: "normals", found: normals.len(), points: points.len() });
    }
    let index = CloudIndex::new(&points.iter().map(|p| Point3::from(*p)).collect::<Vec<_>>())?;
    let mut out = OffsetPoints { points: Vec::with_capacity(points.len()), without_normal: 0, gouging: 0 };
    for (point, normal) in points.iter().zip(normals) {
        let Some(unit) = normal.try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite())) else {
            out.without_normal += 1;
            continue;
        };
        let moved = point + unit * abs_distance;
        let nearest = index.nearest(&Point3::from(moved)).map_or(f64::INFINITY, |n| n.distance());
        if nearest < GOUGE * abs_distance.abs() {
            out.gouging += 1;
        } else {
            out.points.push(moved);
        }
    }
    Ok(out)
}
