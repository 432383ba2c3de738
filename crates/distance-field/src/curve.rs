//! The distance from B-spline and NURBS curves.

use crate::curve_ends::CurveEnds;
use crate::{DistanceField, Error, Hint, PrincipalFrame, Search, parallel};
use footpoint::local::newton_curve;
use footpoint::{CurveFootpoint, CurveProjector, ProjectionOptions, Status, no_progress};
use nalgebra::SVector;
use nurbs_core::{Aabb, BsplineCurve, CurveJet, ParametricCurve};

/// Sine of the angle between residual and normal up to which a foot counts as found, and the same as a share of the
/// size where there is no residual.
const ORTHOGONAL: (f64, f64) = (1e-6, 1e-11);

/// The distance from one or several B-spline or NURBS curves of `R^D`.
///
/// In the plane it is signed, positive on the left of the nearest curve. In space it has no sign: the last axis points
/// from the foot to the query, the one before is normal to it and to the tangent. At the ends of open curves and at
/// kinks the foot cannot move.
///
/// ```
/// use distance_field::{CurveField, DistanceField, Hint, Search};
/// use nalgebra::Vector2;
/// use nurbs_core::Circle;
///
/// let circle = Circle::<2>::new(Vector2::zeros(), 2.0)?.to_nurbs()?;
/// let frame = CurveField::new(&circle)?.frame(&Vector2::new(0.0, 0.5), Search::Global, &Hint::NONE);
/// // The circle runs counter-clockwise: its inside is on the left, where it bends to.
/// assert!((frame.distance - 1.5).abs() < 1e-12 && (frame.curvatures[0] - 0.5).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CurveField<const D: usize> {
    projector: CurveProjector<D>,
    /// Relative to `centre`, so that derivatives do not drown in large coordinates.
    curves: Vec<BsplineCurve<D>>,
    ends: Vec<CurveEnds>,
    centre: SVector<f64, D>,
    size: f64,
    bounds: Aabb<D>,
    options: ProjectionOptions,
}

impl<const D: usize> CurveField<D> {
    /// The distance from one curve.
    ///
    /// # Errors
    /// [`Error::Shape`] when the coordinates are too large to compute with.
    pub fn new(curve: &BsplineCurve<D>) -> Result<Self, Error> {
        Self::for_model(std::slice::from_ref(curve))
    }

    /// The distance from the nearest of several curves.
    ///
    /// # Errors
    /// [`Error::Footpoint`] when there are none; [`Error::Shape`] when coordinates are too large to compute with.
    pub fn for_model(curves: &[BsplineCurve<D>]) -> Result<Self, Error> {
        let projector = CurveProjector::for_model(curves)?;
        let boxes = curves.iter().map(|c| c.bounding_box(1e-3));
        let bounds = boxes.reduce(|a, b| a.merged(&b)).unwrap_or_else(|| Aabb::of_point(SVector::zeros()));
        let centre = bounds.centre();
        let curves: Vec<BsplineCurve<D>> =
            curves.iter().map(|c| c.translated(&-centre)).collect::<Result<_, _>>()?;
        let size = 0.5 * bounds.sides().amax();
        let ends = curves.iter().map(|c| CurveEnds::new(c, size)).collect();
        let options = ProjectionOptions::default();
        Ok(Self { projector, curves, ends, centre, size, bounds, options })
    }

    /// The same field with other options for global searches.
    ///
    /// # Errors
    /// [`Error::Footpoint`] when an option is invalid.
    pub fn with_projection(self, options: ProjectionOptions) -> Result<Self, Error> {
        options.validate()?;
        Ok(Self { options, ..self })
    }

    /// The projector that finds the feet.
    #[must_use]
    pub fn projector(&self) -> &CurveProjector<D> {
        &self.projector
    }

    /// Number of curves.
    #[must_use]
    pub fn curve_count(&self) -> usize {
        self.curves.len()
    }

    fn frame_of(&self, foot: &CurveFootpoint<D>, x: &SVector<f64, D>) -> PrincipalFrame<D> {
        if foot.shape >= self.curves.len() || !foot.parameter.is_finite() {
            return PrincipalFrame::invalid(foot.status);
        }
        let jet = self.curves[foot.shape].jet(foot.parameter);
        self.frame_at(foot.shape, foot.parameter, &jet, x, foot.status)
    }

    /// The frame at a parameter; `x` relative to the centre.
    fn frame_at(
        &self,
        shape: usize,
        parameter: f64,
        jet: &CurveJet<D>,
        x: &SVector<f64, D>,
        status: Status,
    ) -> PrincipalFrame<D> {
        let residual = x - jet.point;
        let (geometry, on_boundary) =
            self.ends[shape].geometry(&self.curves[shape], parameter, jet, &residual);
        PrincipalFrame {
            foot: jet.point + self.centre,
            axes: geometry.axes,
            curvatures: geometry.curvatures,
            tangent_dimension: geometry.tangent_dimension,
            distance: geometry.distance,
            on_boundary,
            hint: Hint::new(shape, [parameter, 0.0]),
            status,
        }
    }

    /// One step of Newton's method; `None` where it leads no nearer.
    fn one_step(&self, x: &SVector<f64, D>, shape: usize, parameter: f64) -> Option<PrincipalFrame<D>> {
        let before = self.curves[shape].jet(parameter);
        let to = self.ends[shape].moved(parameter, newton_curve(&before, x)?);
        let after = self.curves[shape].jet(to);
        let noise = ORTHOGONAL.1 * self.size;
        let (old, new) = ((x - before.point).norm_squared(), (x - after.point).norm_squared());
        // Not so either when a number is NaN.
        let nearer = new <= old + noise * noise;
        if !nearer {
            return None;
        }
        let mut frame = self.frame_at(shape, to, &after, x, Status::MaxIterations);
        let tangential = (x - after.point - frame.normal() * frame.distance).norm();
        if tangential <= ORTHOGONAL.0 * frame.distance.abs() + noise {
            frame.status = if frame.on_boundary { Status::OnBoundary } else { Status::Converged };
        }
        Some(frame)
    }
}

impl<const D: usize> DistanceField<D> for CurveField<D> {
    fn frame(&self, x: &SVector<f64, D>, search: Search, hint: &Hint) -> PrincipalFrame<D> {
        let local = x - self.centre;
        let finite = local.iter().all(|c| c.is_finite());
        let start = hint.element_below(self.curves.len()).filter(|_| finite && search != Search::Global);
        let Some(shape) = start else {
            return match self.projector.project_with(x, &self.options) {
                Ok(foot) => self.frame_of(&foot, &local),
                // Not reached: the options were checked when they were set.
                Err(_) => PrincipalFrame::invalid(Status::Diverged),
            };
        };
        let parameter = hint.parameter[0];
        if search == Search::OneStep
            && let Some(frame) = self.one_step(&local, shape, parameter)
        {
            return frame;
        }
        self.frame_of(&self.projector.project_from(x, shape, parameter), &local)
    }

    fn frames(&self, points: &[SVector<f64, D>], search: Search, hints: &[Hint]) -> Vec<PrincipalFrame<D>> {
        if search != Search::Global && !hints.is_empty() {
            return parallel::map(points.len(), |i| {
                self.frame(&points[i], search, hints.get(i).unwrap_or(&Hint::NONE))
            });
        }
        match self.projector.project_many(points, &self.options, &no_progress) {
            Ok(feet) => parallel::map(points.len(), |i| self.frame_of(&feet[i], &(points[i] - self.centre))),
            // Not reached: the options were checked when they were set.
            Err(_) => vec![PrincipalFrame::invalid(Status::Diverged); points.len()],
        }
    }

    fn bounding_box(&self) -> Aabb<D> {
        self.bounds
    }
}
