//! Ruled surfaces fitted to points and models.

use super::{ActiveRuled, Developability};
use crate::coverage_surface::noise_of;
use crate::iterate::{Progress, fit_with_progress, no_progress};
use crate::polish::{nearly_exact, polished};
use crate::shape::ActiveShape;
use crate::surface::given::begun_at;
use crate::surface::residual_disagreement;
use crate::{
    Constraints, Error, FitOptions, FitReport, Fitted, Folds, Smoothing, Status, SurfaceCoverage, Target,
};
use distance_field::PrincipalFrame;
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;

/// Largest factor of an energy that only places rulings where there are no data.
const TRIFLE: f64 = 1e-8;

/// Largest share of the squared distances that the fairing is by default, and change of the cost in an iteration that does not matter: where
/// rulings slide along straight surfaces, the fairing would go on falling for very long.
const CAP: f64 = 0.1;
const CHANGE: f64 = 2e-3;
/// The change that does not matter while twists fall, which is slow.
const STEADY: f64 = 1e-4;
/// Most iterations by default.
const ITERATIONS: usize = 200;

/// How a ruled surface is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RuledOptions {
    /// Normal of parallel planes, one through the middle of each section of the start, in which the sections stay; default
    /// none.
    pub section_normal: Option<[f64; 3]>,
    /// Whether the first and the last ruling of a surface that is open in u stay where they are, as they must where they lie
    /// off the model; default not.
    pub fixed_ends: bool,
    /// The length that counts like an angle of one radian between the normals at the ends of a ruling, see
    /// [`ActiveRuled::with_abs_twist`]; default 0, no penalty.
    pub abs_twist: f64,
    /// The loop; the default takes second derivatives as energy, whose factor falls from 0.01 to a trifle that places rulings
    /// where there are no data, fairs parameter lines, and stops after 200 iterations or three that change the cost by less than
    /// 0.2 %.
    pub fit: FitOptions,
}

impl Default for RuledOptions {
    fn default() -> Self {
        let smoothing = Smoothing::Continuation { start: 1e-2, factor: 0.5, floor: 1e-8 };
        let fit = FitOptions::default()
            .with_energy([0.0, 1.0, 0.0])
            .with_smoothing(smoothing)
            .with_fairing(1e-4)
            .with_fairing_cap(Some(CAP))
            .with_cost_tolerance(CHANGE)
            .with_max_iterations(ITERATIONS);
        Self { section_normal: None, fixed_ends: false, abs_twist: 0.0, fit }
    }
}

impl RuledOptions {
    /// The same options with sections in parallel planes, or free.
    #[must_use]
    pub fn with_section_normal(self, section_normal: Option<[f64; 3]>) -> Self {
        Self { section_normal, ..self }
    }

    /// The same options with end rulings that stay or move.
    #[must_use]
    pub fn with_fixed_ends(self, fixed_ends: bool) -> Self {
        Self { fixed_ends, ..self }
    }

    /// The same options with another penalty on twisted rulings.
    #[must_use]
    pub fn with_abs_twist(self, abs_twist: f64) -> Self {
        Self { abs_twist, ..self }
    }

    /// The same options for the loop.
    #[must_use]
    pub fn with_fit(self, fit: FitOptions) -> Self {
        Self { fit, ..self }
    }
}

/// How the fit of a ruled surface went.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RuledReport {
    /// The loop.
    pub fit: FitReport,
    /// Control points along a section that are not repetitions, and sections.
    #[cfg_attr(feature = "serde", serde(rename = "control_points"))]
    pub controls: [usize; 2],
    /// How far the result is from being developable.
    pub developability: Developability,
    /// Cells in which the surface folds back on itself.
    pub folds: Folds,
    /// How near the parts of the surface are to the points; `None` for a model.
    pub coverage: Option<SurfaceCoverage>,
}

impl std::fmt::Display for RuledReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [along, sections] = self.controls;
        write!(
            f,
            "{}, {along} control points on each of {sections} sections; {}",
            self.fit, self.developability
        )
    }
}

/// A ruled surface and how it came about.
#[derive(Clone, Debug)]
pub struct RuledFit {
    /// The surface, of degree 1 in v.
    pub surface: BsplineSurface,
    /// How it came about.
    pub report: RuledReport,
    /// The frames of the samples, see [`Fitted`](crate::Fitted).
    pub frames: Vec<PrincipalFrame<3>>,
}

/// Fits a ruled surface, or layers of them, to points or a model from where it is (\[P05, sec. 4.5\]).
///
/// The start is of degree 1 in v, as from [`construct::ruled`](nurbs_core::construct::ruled) or
/// [`construct::skin`](nurbs_core::construct::skin) through more sections. For a model ([`Target::Model`]), the start of
/// a closed surface should lie around it, since sensor points are drawn to the model only and the surface would shrink
/// otherwise; that of an open surface should reach beyond the model on all sides, with
/// [`fixed_ends`](RuledOptions::fixed_ends) and sensor points not counted whose feet are on the boundary of the model. For a cutter
/// of radius `r`, fit to an [`OffsetField`](distance_field::OffsetField) of the model.
///
/// ```
/// use nalgebra::Vector3;
/// use nurbs_core::{Interval, KnotVector, BsplineSurface};
/// use sdm_fit::ruled::{RuledOptions, fit_ruled};
/// use sdm_fit::Target;
///
/// // A hyperbolic paraboloid from a plane: its rulings are straight, but not one plane holds them.
/// let knots = KnotVector::bezier(1, Interval::UNIT)?;
/// let plane = [[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.]].map(Vector3::from).to_vec();
/// let start = BsplineSurface::new(knots.clone(), knots, plane, None)?;
/// let point = |k: i32| (f64::from(k / 20) / 19.0, f64::from(k % 20) / 19.0);
/// let points: Vec<_> = (0..400).map(point).map(|(u, v)| Vector3::new(u, v, 0.5 * u * v)).collect();
/// let target = Target::Points { points: &points, weights: None };
/// let found = fit_ruled(target, start, &RuledOptions::default())?;
/// assert!(found.report.fit.rms < 2e-3 && found.report.developability.max_angle > 0.4, "{}", found.report);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`fit`](crate::fit()); [`Error::NotRuled`] and [`Error::Rational`] for a start of another kind.
pub fn fit_ruled(
    target: Target<'_, 3>,
    initial: BsplineSurface,
    options: &RuledOptions,
) -> Result<RuledFit, Error> {
    fit_ruled_with_progress(target, initial, options, &no_progress)
}

/// [`fit_ruled`] with a callback after each iteration, which may cancel.
///
/// # Errors
/// As [`fit_ruled`].
pub fn fit_ruled_with_progress(
    target: Target<'_, 3>,
    initial: BsplineSurface,
    options: &RuledOptions,
    progress: Progress<'_>,
) -> Result<RuledFit, Error> {
    fit_ruled_within(target, initial, options, None, progress)
}

/// The fit, with a tolerance by which the parts of the surface are judged.
pub(super) fn fit_ruled_within(
    target: Target<'_, 3>,
    initial: BsplineSurface,
    options: &RuledOptions,
    abs_tolerance: Option<f64>,
    progress: Progress<'_>,
) -> Result<RuledFit, Error> {
    // Points are moved to the middle of the start, so that large coordinates lose nothing; the field of a model stays.
    let net = initial.control_points();
    let middle = match target {
        Target::Points { .. } => net.iter().sum::<Vector3<f64>>() / net.len().max(1) as f64,
        Target::Model { .. } => Vector3::zeros(),
    };
    let shape = ActiveRuled::new(initial.translated(&-middle)?)?.with_abs_twist(options.abs_twist)?;
    let constraints = constraints(&shape, options)?;
    let (mut fitted, mut coverage) = (None, None);
    if let Target::Points { points, weights } = target {
        let local: Vec<Vector3<f64>> = points.iter().map(|p| p - middle).collect();
        let found = fit_to_points(shape.clone(), (&local, weights), &constraints, options, progress)?;
        let distances = found.frames.iter().map(|f| f.distance.abs()).collect();
        let surface = found.shape.surface();
        coverage = Some(SurfaceCoverage::of_surface(surface, &local, noise_of(distances), abs_tolerance)?);
        fitted = Some(found);
    }
    let mut fitted = match fitted {
        Some(fitted) => fitted,
        None => fit_with_progress(shape, target, &constraints, &options.fit, progress)?,
    };
    fitted.frames.iter_mut().for_each(|frame| frame.foot += middle);
    let surface = fitted.shape.into_surface().translated(&middle)?;
    let report = RuledReport {
        fit: fitted.report,
        controls: [surface.knots_u().distinct_count(), surface.knots_v().distinct_count()],
        developability: Developability::of(&surface)?,
        folds: Folds::of(&surface),
        coverage,
    };
    Ok(RuledFit { surface, report, frames: fitted.frames })
}

/// The fit to points, without energy at the end where these lie on the surface exactly.
fn fit_to_points(
    shape: ActiveRuled,
    (points, weights): (&[Vector3<f64>], Option<&[f64]>),
    constraints: &Constraints<3>,
    options: &RuledOptions,
    progress: Progress<'_>,
) -> Result<Fitted<ActiveRuled, 3>, Error> {
    let target = Target::Points { points, weights };
    // Twists are to fall while the energy is large: later they lead to surfaces whose normals turn over.
    let begun = if options.abs_twist > 0.0 {
        options.fit.with_fairing_cap(None).with_cost_tolerance(options.fit.cost_tolerance.min(STEADY))
    } else {
        options.fit.with_smoothing(begun_at(points, &shape, &options.fit)?)
    };
    let fitted = fit_with_progress(shape, target, constraints, &begun, progress)?;
    let is_trifle = match options.fit.smoothing {
        Smoothing::Fixed { lambda } => lambda <= TRIFLE,
        Smoothing::Continuation { floor, .. } => floor <= TRIFLE,
        Smoothing::Automatic { .. } => true,
    };
    if !is_trifle || options.abs_twist > 0.0 || fitted.report.status == Status::Cancelled {
        return Ok(fitted);
    }
    let size = points.iter().map(|p| p.amax()).fold(0.0, f64::max);
    let nearly = nearly_exact(residual_disagreement(points, &fitted.frames)?);
    let found = polished(&fitted, target, constraints, &options.fit, (size, nearly), progress)?;
    let folds = |fitted: &Fitted<ActiveRuled, 3>| Folds::of(fitted.shape.surface()).count();
    Ok(found.filter(|found| folds(found) <= folds(&fitted)).unwrap_or(fitted))
}

fn constraints(shape: &ActiveRuled, options: &RuledOptions) -> Result<Constraints<3>, Error> {
    let mut constraints = Constraints::none();
    if options.fixed_ends {
        for k in shape.end_rulings() {
            constraints = constraints.with_held(k, shape.coefficients()[k]);
        }
    }
    if let Some(normal) = options.section_normal.map(Vector3::from) {
        let Some(unit) = normal.try_normalize(0.0).filter(|n| n.iter().all(|c| c.is_finite())) else {
            let value = normal.norm();
            return Err(Error::Option { name: "section_normal", value, allowed: "a direction" });
        };
        for j in 0..shape.surface().n_v() {
            let section = shape.section(j);
            let height = section.iter().map(|&k| shape.coefficients()[k].dot(&unit)).sum::<f64>();
            let height = height / section.len().max(1) as f64;
            for &k in &section {
                // Rulings that stay have their own place.
                if !constraints.held.contains_key(&k) {
                    constraints = constraints.with_plane(k, unit, height);
                }
            }
        }
    }
    Ok(constraints)
}
