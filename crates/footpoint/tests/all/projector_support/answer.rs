//! Answers of the curve and the surface projector in one form, and what every one of them must keep to.

use footpoint::{CurveFootpoint, Location, Multiplicity, Status, SurfaceFootpoint};
use nalgebra::{SVector, Vector3};
use nurbs_core::{Aabb, BsplineCurve, BsplineSurface, ParametricCurve, ParametricSurface};

/// The answer to a query; curves have `parameter[1] = 0`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer<const D: usize> {
    pub(crate) shape: usize,
    pub(crate) parameter: [f64; 2],
    pub(crate) point: SVector<f64, D>,
    pub(crate) distance: f64,
    pub(crate) lower_bound: f64,
    pub(crate) status: Status,
    pub(crate) location: Location,
    pub(crate) multiplicity: Multiplicity,
}

impl<const D: usize> From<CurveFootpoint<D>> for Answer<D> {
    fn from(f: CurveFootpoint<D>) -> Self {
        Self {
            shape: f.shape,
            parameter: [f.parameter, 0.0],
            point: f.point,
            distance: f.distance,
            lower_bound: f.lower_bound,
            status: f.status,
            location: f.location,
            multiplicity: f.multiplicity,
        }
    }
}

impl From<SurfaceFootpoint> for Answer<3> {
    fn from(f: SurfaceFootpoint) -> Self {
        assert!(f.signed_distance.abs() == f.distance || f.distance.is_nan(), "{f:?}");
        Self {
            shape: f.shape,
            parameter: f.parameter,
            point: f.point,
            distance: f.distance,
            lower_bound: f.lower_bound,
            status: f.status,
            location: f.location,
            multiplicity: f.multiplicity,
        }
    }
}

/// A shape that can check an answer.
pub(crate) trait Judge<const D: usize> {
    /// The box around the control points.
    fn bounds(&self) -> Aabb<D>;
    /// The point at a parameter, `None` outside the domain.
    fn point_at(&self, parameter: [f64; 2]) -> Option<SVector<f64, D>>;

    /// Diagonal of the box around the control points.
    fn size(&self) -> f64 {
        self.bounds().diagonal()
    }

    /// What is wrong with an answer in itself, the search apart: parameters outside the domain, or a distance or
    /// point that is not that of the parameters.
    fn inconsistency(&self, x: &SVector<f64, D>, answer: &Answer<D>) -> Option<String> {
        let Some(point) = self.point_at(answer.parameter) else {
            return Some("the parameter lies outside the domain".into());
        };
        // Rounding errors are a share of the coordinates.
        let bounds = self.bounds();
        let largest = [bounds.min.amax(), bounds.max.amax(), x.amax()].into_iter().fold(0.0, f64::max);
        let tolerance = 1e-12 * self.size() + 64.0 * f64::EPSILON * largest;
        let off = (point - answer.point).norm();
        if off.is_nan() || off > tolerance {
            return Some(format!("the point is {off:e} away from that of the parameter"));
        }
        let off = ((point - x).norm() - answer.distance).abs();
        (off.is_nan() || off > tolerance)
            .then(|| format!("the distance is {off:e} off that of the parameter"))
    }
}

impl<const D: usize> Judge<D> for BsplineCurve<D> {
    fn bounds(&self) -> Aabb<D> {
        self.control_box()
    }

    fn point_at(&self, [t, _]: [f64; 2]) -> Option<SVector<f64, D>> {
        self.domain().contains(t).then(|| self.point(t))
    }
}

impl Judge<3> for BsplineSurface {
    fn bounds(&self) -> Aabb<3> {
        self.control_box()
    }

    fn point_at(&self, [u, v]: [f64; 2]) -> Option<Vector3<f64>> {
        let [du, dv] = self.domain();
        (du.contains(u) && dv.contains(v)).then(|| self.point(u, v))
    }
}
