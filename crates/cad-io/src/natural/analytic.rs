//! Sides of planes, cylinders, cones, spheres and tori over their domains.

use super::{NaturalBoundary, SIDES, Side};
use brep_core::description::{Carrier, EdgeCurve};
use nalgebra::Vector3;
use nurbs_core::{AnalyticSurface, Direction, Error, Frame, ParametricSurface};

/// Share of the radius below which a circle is a point.
const POINT: f64 = 1e-12;

/// The carrier of a bounded analytic surface; its normal is that of the surface.
pub(crate) fn carrier(surface: &AnalyticSurface) -> Option<Carrier> {
    Some(match surface {
        AnalyticSurface::Plane(plane) => Carrier::Plane { frame: *plane.frame() },
        AnalyticSurface::Sphere(sphere) => {
            Carrier::Sphere { frame: *sphere.frame(), radius: sphere.radius() }
        }
        AnalyticSurface::Cylinder(cylinder) => {
            Carrier::Cylinder { frame: *cylinder.frame(), radius: cylinder.radius() }
        }
        AnalyticSurface::Cone(cone) => {
            let [base, top] = cone.radii();
            if base == top {
                Carrier::Cylinder { frame: *cone.frame(), radius: base }
            } else {
                Carrier::Cone { frame: *cone.frame(), radius: base, half_angle: cone.half_angle() }
            }
        }
        AnalyticSurface::Torus(torus) => Carrier::Torus {
            frame: *torus.frame(),
            major_radius: torus.major_radius(),
            minor_radius: torus.minor_radius(),
        },
        _ => return None,
    })
}

/// The boundary of a surface over its domain.
pub(crate) fn boundary(surface: &AnalyticSurface) -> Result<NaturalBoundary, Error> {
    let [u, v] = surface.domain();
    let closed = surface.period().map(|period| period.is_some());
    let mut sides = Vec::with_capacity(4);
    for (held, at_end, _) in SIDES {
        let (interval, running) = match held {
            Direction::U => (u, v),
            Direction::V => (v, u),
        };
        let at = if at_end { interval.end() } else { interval.start() };
        let (curve, is_point) = side(surface, held, at)?;
        sides.push(Side { curve, range: [running.start(), running.end()], is_point, pcurve: None });
    }
    let sides = <[Side; 4]>::try_from(sides);
    let sides = sides.map_err(|_| Error::Argument { what: "a surface has four sides".to_owned() })?;
    Ok(NaturalBoundary { sides, closed })
}

/// The curve at a constant parameter by the other one, and whether it is a point.
fn side(surface: &AnalyticSurface, held: Direction, at: f64) -> Result<(EdgeCurve, bool), Error> {
    let line = |origin, direction| Ok((EdgeCurve::Line { origin, direction }, false));
    Ok(match (surface, held) {
        (AnalyticSurface::Plane(plane), held) => {
            let f = plane.frame();
            let (along, across) = if held == Direction::U { (f.x(), f.y()) } else { (f.y(), f.x()) };
            line(f.origin() + along * at, across)?
        }
        (AnalyticSurface::Cylinder(cylinder), Direction::U) => {
            let f = cylinder.frame();
            line(f.origin() + ray(f, at) * cylinder.radius(), f.z())?
        }
        (AnalyticSurface::Cylinder(cylinder), Direction::V) => {
            parallel(cylinder.frame(), at, cylinder.radius(), 0.0)?
        }
        (AnalyticSurface::Cone(cone), Direction::U) => {
            let (f, [base, top]) = (cone.frame(), cone.radii());
            let out = ray(f, at);
            line(f.origin() + out * base, f.z() + out * ((top - base) / cone.height()))?
        }
        (AnalyticSurface::Cone(cone), Direction::V) => {
            let [base, top] = cone.radii();
            let share = at / cone.height();
            parallel(cone.frame(), at, (1.0 - share) * base + share * top, base.max(top))?
        }
        (AnalyticSurface::Sphere(sphere), Direction::U) => {
            meridian(sphere.frame(), at, 0.0, sphere.radius())?
        }
        (AnalyticSurface::Sphere(sphere), Direction::V) => {
            let (sin, cos) = at.sin_cos();
            let r = sphere.radius();
            parallel(sphere.frame(), r * sin, r * cos, r)?
        }
        (AnalyticSurface::Torus(torus), Direction::U) => {
            meridian(torus.frame(), at, torus.major_radius(), torus.minor_radius())?
        }
        (AnalyticSurface::Torus(torus), Direction::V) => {
            let (sin, cos) = at.sin_cos();
            let r = torus.minor_radius();
            parallel(torus.frame(), r * sin, torus.major_radius() + r * cos, r)?
        }
        _ => {
            return Err(Error::Argument {
                what: "this kind of surface has no sides that are known".to_owned(),
            });
        }
    })
}

/// The unit vector at an angle.
fn ray(frame: &Frame, angle: f64) -> Vector3<f64> {
    frame.x() * angle.cos() + frame.y() * angle.sin()
}

/// The circle about the axis at a height.
fn parallel(frame: &Frame, height: f64, radius: f64, size: f64) -> Result<(EdgeCurve, bool), Error> {
    let frame = Frame::new(frame.origin() + frame.z() * height, frame.z(), frame.x())?;
    Ok((EdgeCurve::Circle { frame, radius }, radius <= POINT * size))
}

/// The circle in the plane of the axis at an angle, its centre at a distance from the axis; its angle 0 is outside.
fn meridian(frame: &Frame, angle: f64, distance: f64, radius: f64) -> Result<(EdgeCurve, bool), Error> {
    let out = ray(frame, angle);
    let frame = Frame::new(frame.origin() + out * distance, out.cross(&frame.z()), out)?;
    Ok((EdgeCurve::Circle { frame, radius }, false))
}
