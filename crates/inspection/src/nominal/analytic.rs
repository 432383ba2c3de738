//! Deviations from analytic surfaces.

use super::signed;
use super::trace::{Near, Traceable};
use crate::{Deviation, Error, Outcome, Place};
use footpoint::Progress;
use nalgebra::{Point3, Vector3};
use nurbs_core::{
    Aabb, AnalyticSurface, BsplineSurface, Interval, ParametricSurface, SurfaceFoot, SurfaceJet,
};

/// A share of a domain within which a parameter counts as its end.
const END: f64 = 1e-12;

/// Analytic surfaces; their footpoints are closed formulas.
#[derive(Debug)]
pub(super) struct AnalyticNominal {
    surfaces: Vec<AnalyticSurface>,
    exact: Vec<BsplineSurface>,
    bounds: Aabb<3>,
}

/// The name of a kind of surface.
pub(super) fn kind(surface: &AnalyticSurface) -> &'static str {
    match surface {
        AnalyticSurface::Plane(_) => "plane",
        AnalyticSurface::Sphere(_) => "sphere",
        AnalyticSurface::Cylinder(_) => "cylinder",
        AnalyticSurface::Cone(_) => "cone",
        AnalyticSurface::Torus(_) => "torus",
        _ => "surface",
    }
}

impl AnalyticNominal {
    pub(super) fn new(surfaces: Vec<AnalyticSurface>) -> Result<Self, Error> {
        let exact: Vec<BsplineSurface> =
            surfaces.iter().map(AnalyticSurface::to_nurbs).collect::<Result<_, _>>()?;
        let boxes = exact.iter().map(BsplineSurface::control_box);
        let bounds = boxes.reduce(|a, b| a.merged(&b)).ok_or(Error::EmptyModel)?;
        Ok(Self { surfaces, exact, bounds })
    }

    /// The same surfaces as NURBS.
    pub(super) fn exact(&self) -> &[BsplineSurface] {
        &self.exact
    }

    /// Deviations along the shortest lines.
    pub(super) fn shortest(&self, points: &[Point3<f64>], progress: Progress<'_>) -> Vec<Deviation> {
        let cancelled = Deviation::none(Outcome::Cancelled);
        crate::parallel::map(points.len(), &cancelled, progress, |index| {
            self.deviation(&points[index].coords)
        })
    }

    /// The nearest surface, the first where several are as near.
    fn nearest(&self, x: &Vector3<f64>) -> Option<(usize, SurfaceFoot)> {
        let feet = self.surfaces.iter().map(|surface| surface.footpoint(x)).enumerate();
        feet.filter(|(_, foot)| foot.distance.is_finite())
            .reduce(|best, next| if next.1.distance < best.1.distance { next } else { best })
    }

    fn deviation(&self, x: &Vector3<f64>) -> Deviation {
        if !x.iter().all(|value| value.is_finite()) {
            return Deviation::none(Outcome::InvalidPoint);
        }
        let Some((shape, foot)) = self.nearest(x) else { return Deviation::none(Outcome::NotConverged) };
        let [u, v] = foot.parameters;
        let normal = self.surfaces[shape].jet(u, v).unit_normal();
        let offset = x - foot.point;
        let (place, on_boundary) = self.place(shape, foot.parameters, normal.is_none());
        let normal = normal.or_else(|| offset.try_normalize(0.0)).unwrap_or_default();
        Deviation {
            outcome: Outcome::Measured,
            foot: foot.point.into(),
            normal,
            distance: signed(foot.distance, &offset, &normal),
            gap: 0.0,
            parameter: foot.parameters,
            shape: u32::try_from(shape).unwrap_or(u32::MAX),
            triangle: u32::MAX,
            place,
            on_boundary,
        }
    }

    fn place(&self, shape: usize, parameter: [f64; 2], is_pole: bool) -> (Place, bool) {
        let (domain, period) = self.domain(shape);
        let at_end = |axis: usize| {
            let slack = END * domain[axis].length();
            let inside = parameter[axis] - domain[axis].start() > slack
                && domain[axis].end() - parameter[axis] > slack;
            period[axis].is_none() && !inside
        };
        match (is_pole, at_end(0), at_end(1)) {
            (true, ..) => (Place::Pole, false),
            (_, true, true) => (Place::Corner, true),
            (_, false, false) => (Place::Interior, false),
            _ => (Place::Edge, true),
        }
    }
}

impl Traceable for AnalyticNominal {
    fn near(&self, x: &Vector3<f64>) -> Option<Near> {
        let (shape, foot) = self.nearest(x)?;
        // Closed formulas are exact up to rounding, of which this is more than enough.
        let bound = foot.distance - 1e-12 * (foot.distance + self.bounds.diagonal());
        Some(Near { bound: bound.max(0.0), shape, parameter: foot.parameters, point: foot.point })
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
