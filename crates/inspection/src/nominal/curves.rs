//! Deviations from NURBS curves, in the plane or in space.

use super::judge::outcome;
use super::surfaces::place;
use crate::{Backdrop, Deviation, Error, InspectionOptions};
use footpoint::{CurveFootpoint, CurveProjector, Location, Progress, Status};
use nalgebra::{Point3, SVector, Vector3};
use nurbs_core::{Aabb, BsplineCurve, ParametricCurve};

/// Samples of a curve in the picture, and the width of the ribbon that shows it as a share of the size.
const SAMPLES: usize = 600;
const WIDTH: f64 = 1e-3;

/// Curves and what is needed to project onto them. Points of the plane have z = 0; their z is not looked at.
#[derive(Debug)]
pub(super) struct CurvesNominal<const D: usize> {
    curves: Vec<BsplineCurve<D>>,
    projector: CurveProjector<D>,
}

impl<const D: usize> CurvesNominal<D> {
    pub(super) fn new(curves: Vec<BsplineCurve<D>>) -> Result<Self, Error> {
        if curves.is_empty() {
            return Err(Error::EmptyModel);
        }
        Ok(Self { projector: CurveProjector::for_model(&curves)?, curves })
    }

    pub(super) fn piece_count(&self) -> usize {
        self.projector.piece_count()
    }

    /// The largest side of a box around the model, to which gaps of the search are relative.
    pub(super) fn size(&self) -> f64 {
        let boxes = self.curves.iter().map(BsplineCurve::control_box);
        let bounds = boxes.reduce(|a, b| a.merged(&b));
        bounds.map_or(0.0, |bounds: Aabb<D>| (bounds.max - bounds.min).max())
    }

    /// Deviations along the shortest lines, each finished by `finish`.
    pub(super) fn shortest(
        &self,
        points: &[Point3<f64>],
        options: &InspectionOptions,
        progress: Progress<'_>,
        finish: &(dyn Fn(Deviation) -> Deviation + Sync),
        receive: &mut dyn FnMut(&[(usize, Deviation)]),
    ) -> Result<(), Error> {
        let at = |index: usize| SVector::from_fn(|i, _| points[index][i]);
        let treat = |index: usize, foot: &CurveFootpoint<D>| finish(self.deviation(&at(index), foot));
        self.projector.project_each(points.len(), &at, &options.projection, progress, &treat, receive)?;
        Ok(())
    }

    /// In the plane the unit normal on the left of the curve; in space, and where the curve stands still, that of the line to
    /// the point; zero where that has no length.
    pub(super) fn normal(&self, shape: usize, parameter: f64, offset: &Vector3<f64>) -> Vector3<f64> {
        let curve = self.curves.get(shape).filter(|_| D == 2);
        let left = curve.and_then(|curve| left_normal(&in_space(&curve.jet(parameter).d1)));
        left.or_else(|| offset.try_normalize(0.0)).unwrap_or_default()
    }

    /// The line to a point from its foot.
    pub(super) fn offset(&self, x: &Point3<f64>, foot: &Point3<f64>) -> Vector3<f64> {
        in_space(&SVector::<f64, D>::from_fn(|i, _| x[i] - foot[i]))
    }

    fn deviation(&self, x: &SVector<f64, D>, foot: &CurveFootpoint<D>) -> Deviation {
        let outcome = outcome(foot.status, foot.distance);
        if foot.distance.is_nan() || foot.shape >= self.curves.len() {
            return Deviation::none(outcome);
        }
        let offset = in_space(&(x - foot.point));
        let normal = self.normal(foot.shape, foot.parameter, &offset);
        let is_right = D == 2 && offset.dot(&normal) < 0.0;
        Deviation {
            outcome,
            foot: in_space(&foot.point).into(),
            normal,
            distance: if is_right { -foot.distance } else { foot.distance },
            gap: (foot.distance - foot.lower_bound).max(0.0),
            parameter: [foot.parameter, f64::NAN],
            shape: u32::try_from(foot.shape).unwrap_or(u32::MAX),
            triangle: u32::MAX,
            place: place(foot.location),
            corner: 0,
            is_restricted: false,
            on_boundary: matches!(foot.status, Status::OnBoundary | Status::Uncertified)
                && matches!(foot.location, Location::Edge | Location::Corner),
        }
    }

    /// Narrow ribbons along the curves; in the plane they lie in it.
    pub(super) fn backdrop(&self) -> Backdrop {
        let boxes = self.curves.iter().map(BsplineCurve::control_box);
        let size = boxes.reduce(|a, b| a.merged(&b)).map_or(0.0, |bounds: Aabb<D>| bounds.diagonal());
        let mut out = Backdrop::default();
        for curve in &self.curves {
            let domain = curve.domain();
            let jets = (0..SAMPLES)
                .map(|i| curve.jet(domain.start() + domain.length() * i as f64 / (SAMPLES - 1) as f64));
            let rail: Vec<[Vector3<f64>; 2]> =
                jets.map(|jet| [in_space(&jet.point), in_space(&jet.d1)]).collect();
            out.append_ribbon(&rail, 0.5 * WIDTH * size);
        }
        out
    }
}

/// A vector of the plane with z = 0.
fn in_space<const D: usize>(vector: &SVector<f64, D>) -> Vector3<f64> {
    Vector3::from_fn(|i, _| if i < D { vector[i] } else { 0.0 })
}

/// The unit normal on the left of a direction in the plane.
fn left_normal(tangent: &Vector3<f64>) -> Option<Vector3<f64>> {
    Vector3::new(-tangent.y, tangent.x, 0.0).try_normalize(f64::MIN_POSITIVE)
}
