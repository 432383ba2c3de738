//! Deviations from NURBS surfaces.

use super::judge::outcome;
use super::sides::{Side, Sides};
use super::trace::{Near, Traceable};
use crate::{Deviation, Error, InspectionOptions, Outcome, Place};
use footpoint::{Facing, Location, Progress, ProjectionOptions, SurfaceFootpoint, SurfaceProjector};
use nalgebra::{Point3, Vector3};
use nurbs_core::{Aabb, BsplineSurface, Interval, ParametricSurface, SurfaceJet};

/// Relative difference of distances that is none.
pub(super) const SAME: f64 = 1e-9;

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

    /// The largest side of a box around the model, to which gaps of the search are relative.
    pub(super) fn size(&self) -> f64 {
        (self.bounds.max - self.bounds.min).max()
    }

    /// Deviations along the shortest lines, each finished by `finish`.
    pub(super) fn shortest(
        &self,
        points: &[Point3<f64>],
        sides: &Sides<'_>,
        options: &InspectionOptions,
        progress: Progress<'_>,
        finish: &(dyn Fn(Deviation) -> Deviation + Sync),
        receive: &mut dyn FnMut(&[(usize, Deviation)]),
    ) -> Result<(), Error> {
        let treat = |index: usize, nearest: &SurfaceFootpoint| {
            let x = &points[index].coords;
            let deviation = match sides.of(index) {
                Side::Any => self.deviation(x, nearest),
                Side::Unknown if nearest.distance.is_nan() => self.deviation(x, nearest),
                Side::Unknown => Deviation::none(Outcome::NoNormal),
                Side::Facing(facing) => {
                    let foot = self.projector.facing_foot(x, nearest, &facing, &options.projection);
                    let is_restricted = foot.distance > nearest.distance * (1.0 + SAME);
                    Deviation { is_restricted, ..self.deviation(x, &foot) }
                }
            };
            finish(deviation)
        };
        let at = |index: usize| points[index].coords;
        self.projector.project_each(points.len(), &at, &options.projection, progress, &treat, receive)?;
        Ok(())
    }

    /// The unit normal at a place; where the surface has none, that of the line to the point, on the side that `distance`
    /// tells; zero where that has no length.
    pub(super) fn normal(
        &self,
        shape: usize,
        [u, v]: [f64; 2],
        offset: &Vector3<f64>,
        distance: f64,
    ) -> Vector3<f64> {
        let across = || offset.try_normalize(0.0).map(|unit| unit * distance.signum());
        let normal = self.surfaces.get(shape).and_then(|surface| surface.jet(u, v).unit_normal());
        normal.or_else(across).unwrap_or_default()
    }

    fn deviation(&self, x: &Vector3<f64>, foot: &SurfaceFootpoint) -> Deviation {
        let outcome = outcome(foot.status, foot.distance);
        if foot.distance.is_nan() {
            return Deviation::none(outcome);
        }
        let offset = x - foot.point;
        Deviation {
            outcome,
            foot: foot.point.into(),
            normal: self.normal(foot.shape, foot.parameter, &offset, foot.signed_distance),
            distance: foot.signed_distance,
            gap: foot.gap(),
            parameter: foot.parameter,
            shape: u32::try_from(foot.shape).unwrap_or(u32::MAX),
            triangle: u32::MAX,
            place: place(foot.location),
            corner: 0,
            is_restricted: false,
            on_boundary: matches!(
                foot.status,
                footpoint::Status::OnBoundary | footpoint::Status::Uncertified
            ) && matches!(foot.location, Location::Edge | Location::Corner),
        }
    }
}

impl Traceable for SurfacesNominal {
    fn near(&self, x: &Vector3<f64>) -> Option<Near> {
        near(&self.projector.project(x))
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

    fn facing_near(&self, x: &Vector3<f64>, facing: &Facing) -> Option<Near> {
        let options = ProjectionOptions::default();
        let foot = self.projector.facing_foot(x, &self.projector.project(x), facing, &options);
        near(&foot)
    }
}

/// A footpoint, if it is one.
pub(super) fn near(foot: &SurfaceFootpoint) -> Option<Near> {
    foot.distance.is_finite().then_some(Near {
        bound: foot.lower_bound,
        shape: foot.shape,
        parameter: foot.parameter,
        point: foot.point,
    })
}

pub(super) fn place(location: Location) -> Place {
    match location {
        Location::Interior => Place::Interior,
        Location::Edge => Place::Edge,
        Location::Corner => Place::Corner,
        Location::Seam => Place::Seam,
        Location::Pole => Place::Pole,
    }
}
