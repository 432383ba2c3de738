//! Deviations from analytic surfaces.

use super::signed;
use super::surfaces::{SAME, near};
use super::trace::{Near, Traceable};
use crate::{Deviation, Error, Outcome, Place};
use footpoint::{Facing, ProjectionOptions, SurfaceProjector};
use nalgebra::Vector3;
use nurbs_core::{
    Aabb, AnalyticSurface, BsplineSurface, Interval, ParametricSurface, SurfaceFoot, SurfaceJet,
};
use std::sync::OnceLock;

/// A share of a domain within which a parameter counts as its end.
const END: f64 = 1e-12;

/// Analytic surfaces; their footpoints are closed formulas.
#[derive(Debug)]
pub(super) struct AnalyticNominal {
    surfaces: Vec<AnalyticSurface>,
    exact: Vec<BsplineSurface>,
    bounds: Aabb<3>,
    projector: OnceLock<SurfaceProjector>,
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
        Ok(Self { surfaces, exact, bounds, projector: OnceLock::new() })
    }

    /// The same surfaces as NURBS.
    pub(super) fn exact(&self) -> &[BsplineSurface] {
        &self.exact
    }

    /// The nearest surface, the first where several are as near.
    fn nearest(&self, x: &Vector3<f64>) -> Option<(usize, SurfaceFoot)> {
        let feet = self.surfaces.iter().map(|surface| surface.footpoint(x)).enumerate();
        feet.filter(|(_, foot)| foot.distance.is_finite())
            .reduce(|best, next| if next.1.distance < best.1.distance { next } else { best })
    }

    /// The deviation along the shortest line, to where the normal agrees with a direction if one is given.
    pub(super) fn shortest(&self, x: &Vector3<f64>, facing: Option<&Facing>) -> Deviation {
        let Some((shape, foot)) = self.nearest(x) else { return Deviation::none(Outcome::NotConverged) };
        let [u, v] = foot.parameters;
        match facing {
            Some(facing) if !facing.agrees(&self.surfaces[shape].jet(u, v).normal_direction()) => {
                // Closed formulas give the nearest foot only; the same surfaces as NURBS have them all.
                let projector = self.projector();
                let nearest = projector.project(x);
                let found = projector.facing_foot(x, &nearest, facing, &ProjectionOptions::default());
                let Some(near) = near(&found) else { return Deviation::none(Outcome::NoMatchingFoot) };
                let foot = self.surfaces[near.shape].footpoint(&near.point);
                let is_restricted = found.distance > nearest.distance * (1.0 + SAME);
                let foot = SurfaceFoot { distance: (x - foot.point).norm(), ..foot };
                let gap = (foot.distance - near.bound).max(0.0);
                Deviation { is_restricted, gap, ..self.deviation(x, near.shape, &foot) }
            }
            _ => self.deviation(x, shape, &foot),
        }
    }

    /// The surfaces as NURBS, prepared when they are first needed.
    fn projector(&self) -> &SurfaceProjector {
        self.projector.get_or_init(|| {
            SurfaceProjector::for_model(&self.exact).unwrap_or_else(|_| SurfaceProjector::new(&self.exact[0]))
        })
    }

    /// The unit normal at a place; where the surface has none, that of the line to the point; zero where that has no length.
    pub(super) fn normal(&self, shape: usize, [u, v]: [f64; 2], offset: &Vector3<f64>) -> Vector3<f64> {
        let normal = self.surfaces.get(shape).and_then(|surface| surface.jet(u, v).unit_normal());
        normal.or_else(|| offset.try_normalize(0.0)).unwrap_or_default()
    }

    fn deviation(&self, x: &Vector3<f64>, shape: usize, foot: &SurfaceFoot) -> Deviation {
        let [u, v] = foot.parameters;
        let is_pole = self.surfaces[shape].jet(u, v).unit_normal().is_none();
        let offset = x - foot.point;
        let (place, on_boundary) = self.place(shape, foot.parameters, is_pole);
        let normal = self.normal(shape, foot.parameters, &offset);
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
            corner: 0,
            on_boundary,
            is_restricted: false,
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

    fn facing_near(&self, x: &Vector3<f64>, facing: &Facing) -> Option<Near> {
        let projector = self.projector();
        let foot = projector.facing_foot(x, &projector.project(x), facing, &ProjectionOptions::default());
        let near = near(&foot)?;
        let parameter = self.surfaces[near.shape].footpoint(&near.point).parameters;
        Some(Near { parameter, ..near })
    }
}
