//! Deviations from NURBS surfaces.

use super::trace::{Near, Traceable};
use crate::{Deviation, Error, InspectionOptions, Outcome, Place};
use footpoint::{Location, Progress, SurfaceFootpoint, SurfaceProjector};
use nalgebra::{Point3, Vector3};
use nurbs_core::{Aabb, BsplineSurface, Interval, ParametricSurface, SurfaceJet};

/// Surfaces and what is needed to project onto them.
#[derive(Debug)]
pub(super) struct SurfacesNominal {
    surfaces: Vec<BsplineSurface>,
    projector: SurfaceProjector,
    bounds: Aabb<3>,
}

impl SurfacesNominal {
    pub(super) fn new(surfaces: Vec<BsplineSurface>) -> Result<Self, Error> {
        let boxes = surfaces.iter().map(BsplineSurface::control_box);
        let bounds = boxes.reduce(|a, b| a.merged(&b)).ok_or(Error::EmptyModel)?;
        Ok(Self { projector: SurfaceProjector::for_model(&surfaces)?, surfaces, bounds })
    }

    pub(super) fn surfaces(&self) -> &[BsplineSurface] {
        &self.surfaces
    }

    pub(super) fn patch_count(&self) -> usize {
        self.projector.patch_count()
    }

    /// Deviations along the shortest lines.
    pub(super) fn shortest(
        &self,
        points: &[Point3<f64>],
        options: &InspectionOptions,
        progress: Progress<'_>,
    ) -> Result<Vec<Deviation>, Error> {
        let queries: Vec<Vector3<f64>> = points.iter().map(|point| point.coords).collect();
        let feet = self.projector.project_many(&queries, &options.projection, progress)?;
        let unfinished = Deviation::none(Outcome::Cancelled);
        Ok(crate::parallel::map(points.len(), &unfinished, &footpoint::no_progress, |index| {
            self.deviation(&queries[index], &feet[index])
        }))
    }

    fn deviation(&self, x: &Vector3<f64>, foot: &SurfaceFootpoint) -> Deviation {
        use footpoint::Status;
        let outcome = match foot.status {
            // An open certificate leaves a true foot, and the gap tells what may be nearer.
            Status::Converged | Status::OnBoundary | Status::Uncertified => Outcome::Measured,
            Status::InvalidPoint => Outcome::InvalidPoint,
            Status::Cancelled => Outcome::Cancelled,
            _ => Outcome::NotConverged,
        };
        if foot.distance.is_nan() {
            return Deviation::none(outcome);
        }
        let offset = x - foot.point;
        let [u, v] = foot.parameter;
        let across = || offset.try_normalize(0.0).map(|unit| unit * foot.signed_distance.signum());
        let normal = self.surfaces.get(foot.shape).and_then(|surface| surface.jet(u, v).unit_normal());
        Deviation {
            outcome,
            foot: foot.point.into(),
            normal: normal.or_else(across).unwrap_or_default(),
            distance: foot.signed_distance,
            gap: foot.gap(),
            parameter: foot.parameter,
            shape: u32::try_from(foot.shape).unwrap_or(u32::MAX),
            triangle: u32::MAX,
            place: place(foot.location),
            on_boundary: foot.status.is_converged()
                && matches!(foot.location, Location::Edge | Location::Corner),
        }
    }
}

impl Traceable for SurfacesNominal {
    fn near(&self, x: &Vector3<f64>) -> Option<Near> {
        let foot = self.projector.project(x);
        let bound = foot.lower_bound;
        (foot.distance.is_finite()).then_some(Near {
            bound,
            shape: foot.shape,
            parameter: foot.parameter,
            point: foot.point,
        })
    }

    fn jet(&self, shape: usize, [u, v]: [f64; 2]) -> SurfaceJet {
        self.surfaces[shape].jet(u, v)
    }

    fn domain(&self, shape: usize) -> ([Interval; 2], [Option<f64>; 2]) {
        (self.surfaces[shape].domain(), self.surfaces[shape].period())
    }

    fn bounds(&self) -> &Aabb<3> {
        &self.bounds
    }
}

fn place(location: Location) -> Place {
    match location {
        Location::Interior => Place::Interior,
        Location::Edge => Place::Edge,
        Location::Corner => Place::Corner,
        Location::Seam => Place::Seam,
        Location::Pole => Place::Pole,
    }
}
