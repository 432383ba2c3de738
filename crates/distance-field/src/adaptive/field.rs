//! An adaptively sampled distance as the distance field of its zero set.

use super::AdaptiveField;
use crate::implicit::{LagrangeStep, Taylor};
use crate::local_geometry::{of_plane_normal, of_tensor};
use crate::{DistanceField, Hint, PrincipalFrame, Search};
use footpoint::Status;
use nalgebra::{SMatrix, SVector, Vector2, Vector3};
use nurbs_core::Aabb;

/// Limit of the iteration to a foot.
const MAX_STEPS: usize = 30;
/// Share of the tolerance of the field below which a residual counts as none.
const SETTLED: f64 = 1e-2;

/// A point of the zero set, with the unit normal and minus the Hessian as a share of the gradient there.
struct Foot<const D: usize> {
    point: SVector<f64, D>,
    normal: SVector<f64, D>,
    tensor: SMatrix<f64, D, D>,
    is_settled: bool,
}

impl<const D: usize> AdaptiveField<D> {
    fn inside(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        SVector::from_fn(|k, _| x[k].clamp(self.low[k], self.high[k]))
    }

    /// The foot to which the gradient at the point leads, or at the nearest point of the box.
    ///
    /// Newton's method on the equations of Lagrange, as for grids; where the polynomials of neighbouring leaves differ by their
    /// errors, the iteration ends within the tolerance of the field.
    fn foot(&self, x: &SVector<f64, D>) -> Option<Foot<D>> {
        let start = self.inside(x);
        let (value, gradient, _) = self.taylor(&start)?;
        let mut point = self.inside(&(start - gradient * (value / gradient.norm_squared())));
        let mut last = f64::INFINITY;
        for step in 0..=MAX_STEPS {
            let (value, gradient, hessian) = self.taylor(&point)?;
            let taylor = Taylor { value, gradient, hessian };
            let LagrangeStep { normal, across, step: move_by, .. } = taylor.lagrange_step(&(x - point));
            if !normal.iter().all(|c| c.is_finite()) {
                return None;
            }
            let size = move_by.norm();
            let is_settled = size <= SETTLED * self.abs_tolerance;
            // Between leaves the iteration may go to and fro within their errors.
            let is_at_rest = size <= self.abs_tolerance && size > 0.5 * last;
            if is_settled || is_at_rest || step == MAX_STEPS {
                let tensor = taylor.tensor();
                let is_settled = is_settled || is_at_rest;
                return Some(Foot { point: point + normal * across, normal, tensor, is_settled });
            }
            last = size;
            let next = self.inside(&(point + move_by));
            if next == point {
                let tensor = taylor.tensor();
                return Some(Foot { point, normal, tensor, is_settled: false });
            }
            point = next;
        }
        None
    }

    fn frame_with(
        &self,
        x: &SVector<f64, D>,
        geometry: impl Fn(&SMatrix<f64, D, D>, &SVector<f64, D>, f64) -> (SMatrix<f64, D, D>, SVector<f64, D>),
    ) -> PrincipalFrame<D> {
        if !x.iter().all(|c| c.is_finite()) {
            return PrincipalFrame::invalid(Status::InvalidPoint);
        }
        let Some(foot) = self.foot(x) else { return PrincipalFrame::invalid(Status::Stalled) };
        let distance = (x - foot.point).dot(&foot.normal);
        let (axes, curvatures) = geometry(&foot.tensor, &foot.normal, distance);
        let is_at_border = (0..D).any(|k| foot.point[k] <= self.low[k] || foot.point[k] >= self.high[k]);
        PrincipalFrame {
            foot: foot.point,
            axes,
            curvatures,
            tangent_dimension: D - 1,
            distance,
            on_boundary: is_at_border,
            hint: Hint::NONE,
            status: match (foot.is_settled, is_at_border) {
                (true, false) => Status::Converged,
                (_, true) => Status::OnBoundary,
                (false, false) => Status::Stalled,
            },
        }
    }
}

/// The foot is the one to which the gradient at the point leads, within the tolerance of the field; [`Search`] and [`Hint`] make no
/// difference.
impl DistanceField<2> for AdaptiveField<2> {
    fn frame(&self, x: &Vector2<f64>, _search: Search, _hint: &Hint) -> PrincipalFrame<2> {
        self.frame_with(x, |tensor, normal, distance| {
            let geometry = of_plane_normal(tensor, normal, distance);
            (geometry.axes, geometry.curvatures)
        })
    }

    fn bounding_box(&self) -> Aabb<2> {
        self.bounds
    }
}

/// As in the plane.
impl DistanceField<3> for AdaptiveField<3> {
    fn frame(&self, x: &Vector3<f64>, _search: Search, _hint: &Hint) -> PrincipalFrame<3> {
        self.frame_with(x, |tensor, normal, distance| {
            let geometry = of_tensor(tensor, normal, distance);
            (geometry.axes, geometry.curvatures)
        })
    }

    fn bounding_box(&self) -> Aabb<3> {
        self.bounds
    }
}
