//! Surfaces of STEP as carriers.

use super::offset::offset;
use super::reader::Reader;
use brep_core::description::Carrier;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Frame, KnotVector};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;
use step_io::model::{
    Axis2Placement3dId, Axis2Placement3dRef, CartesianPointRef, DirectionRef, EntityKey, PartialEntity,
};
use step_io::scene::{Face, NurbsSurface, Surface, SurfaceKind};

impl Reader<'_> {
    /// Coordinates of a point; missing ones are 0.
    pub(super) fn point(&self, reference: &CartesianPointRef) -> Result<Vector3<f64>, String> {
        let CartesianPointRef::CartesianPoint(id) = reference else {
            return Err("a point is not a CARTESIAN_POINT".to_owned());
        };
        let c = &self.model[*id].coordinates;
        let x = Vector3::from_fn(|i, _| c.get(i).copied().unwrap_or(0.0));
        if x.iter().all(|c| c.is_finite()) { Ok(x) } else { Err("a point is not finite".to_owned()) }
    }

    /// Ratios of a direction, not normalised.
    pub(super) fn direction(&self, reference: &DirectionRef) -> Result<Vector3<f64>, String> {
        let DirectionRef::Direction(id) = reference else {
            return Err("a direction is not a DIRECTION".to_owned());
        };
        let c = &self.model[*id].direction_ratios;
        Ok(Vector3::from_fn(|i, _| c.get(i).copied().unwrap_or(0.0)))
    }

    /// The frame of a placement, with the defaults of ISO 10303-42 for omitted axes.
    pub(super) fn frame(&self, id: Axis2Placement3dId) -> Result<Frame, String> {
        let placement = &self.model[id];
        let origin = self.point(&placement.location)?;
        let axis = placement.axis.as_ref().map_or(Ok(Vector3::z()), |d| self.direction(d))?;
        let frame = match &placement.ref_direction {
            Some(d) => Frame::new(origin, axis, self.direction(d)?),
            None => {
                Frame::new(origin, axis, Vector3::x()).or_else(|_| Frame::new(origin, axis, Vector3::y()))
            }
        };
        frame.map_err(|e| e.to_string())
    }

    fn surface_frame(&self, reference: &Axis2Placement3dRef) -> Result<Frame, String> {
        let Axis2Placement3dRef::Axis2Placement3d(id) = reference;
        self.frame(*id)
    }

    /// The carrier of a face.
    pub(super) fn carrier(&self, face: &Face<'_>) -> Result<Carrier, String> {
        match self.analytic(&face.surface(), 0.0)? {
            Some(carrier) => Ok(carrier),
            None => {
                if let Some(offset) = self.free_form_offset(face)? {
                    return Ok(Carrier::Nurbs(Arc::new(offset)));
                }
                let rational = self.is_rational(face.surface().key());
                let nurbs = face.to_nurbs().ok_or_else(|| {
                    "it has no exact form as a B-spline, or its numbers do not fit together".to_owned()
                })?;
                nurbs_surface(nurbs, rational).map(|s| Carrier::Nurbs(Arc::new(s)))
            }
        }
    }

    /// The offset of a surface that has no exact form; `None` for other surfaces.
    fn free_form_offset(&self, face: &Face<'_>) -> Result<Option<BsplineSurface>, String> {
        let surface = face.surface();
        let SurfaceKind::Offset(own) = surface.kind() else { return Ok(None) };
        let Some(basis) = surface.basis_surface().filter(|_| surface.to_nurbs().is_none()) else {
            return Ok(None);
        };
        let Some(nurbs) = basis.to_nurbs() else { return Ok(None) };
        let basis = nurbs_surface(nurbs, self.is_rational(basis.key()))?;
        offset(&basis, own.distance).map(Some)
    }

    /// An elementary surface, moved by `offset` along its normal; `None` for other kinds.
    fn analytic(&self, surface: &Surface<'_>, offset: f64) -> Result<Option<Carrier>, String> {
        let positive = |name: &str, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(value)
            } else {
                Err(format!("its {name} is {value}; it must be positive"))
            }
        };
        Ok(Some(match surface.kind() {
            SurfaceKind::Plane(p) => {
                let frame = self.surface_frame(&p.position)?;
                let origin = frame.origin() + frame.z() * offset;
                let frame = Frame::new(origin, frame.z(), frame.x()).map_err(|e| e.to_string())?;
                Carrier::Plane { frame }
            }
            SurfaceKind::Cylindrical(c) => Carrier::Cylinder {
                frame: self.surface_frame(&c.position)?,
                radius: positive("radius", c.radius + offset)?,
            },
            SurfaceKind::Conical(c) if offset == 0.0 => {
                let half_angle = c.semi_angle * self.angle;
                if !(half_angle.abs() > 0.0 && half_angle.abs() < FRAC_PI_2) {
                    return Err(format!(
                        "its half angle is {} degrees; it must lie between 0 and 90",
                        half_angle.to_degrees()
                    ));
                }
                if !(c.radius >= 0.0 && c.radius.is_finite()) {
                    return Err(format!("its radius is {}; it must not be negative", c.radius));
                }
                Carrier::Cone { frame: self.surface_frame(&c.position)?, radius: c.radius, half_angle }
            }
            SurfaceKind::Spherical(s) => Carrier::Sphere {
                frame: self.surface_frame(&s.position)?,
                radius: positive("radius", s.radius + offset)?,
            },
            SurfaceKind::Toroidal(t) => Carrier::Torus {
                frame: self.surface_frame(&t.position)?,
                major_radius: positive("major radius", t.major_radius)?,
                minor_radius: positive("minor radius", t.minor_radius + offset)?,
            },
            SurfaceKind::DegenerateToroidal(t) => {
                let major = positive("major radius", t.major_radius)?;
                Carrier::Torus {
                    frame: self.surface_frame(&t.position)?,
                    major_radius: if t.select_outer { major } else { -major },
                    minor_radius: positive("minor radius", t.minor_radius + offset)?,
                }
            }
            SurfaceKind::Offset(o) if offset == 0.0 => match surface.basis_surface() {
                Some(basis) => return self.analytic(&basis, o.distance),
                None => return Ok(None),
            },
            _ => return Ok(None),
        }))
    }

    /// Whether the file gives weights for a surface or curve.
    pub(super) fn is_rational(&self, key: EntityKey) -> bool {
        let EntityKey::ComplexEntity(id) = key else { return false };
        self.model[id].parts.iter().any(|part| {
            matches!(
                part,
                PartialEntity::RationalBSplineSurface { .. } | PartialEntity::RationalBSplineCurve { .. }
            )
        })
    }

    /// A B-spline surface that is no face: an element of a geometric set.
    pub(super) fn bare_surface(&self, key: EntityKey) -> Result<Carrier, String> {
        let EntityKey::BSplineSurfaceWithKnots(id) = key else {
            return Err("a surface of this kind is read as part of a face only".to_owned());
        };
        let s = &self.model[id];
        let degree = |d: i64| usize::try_from(d).map_err(|_| format!("its degree is {d}"));
        let knots = |values: &[f64], counts: &[i64]| {
            let total: i64 = counts.iter().map(|c| (*c).clamp(0, 1_000_000)).sum();
            if counts.len() != values.len() || total > 10_000_000 {
                return Err("knots and multiplicities do not fit together".to_owned());
            }
            let pairs = values.iter().zip(counts);
            Ok(pairs.flat_map(|(v, c)| (0..(*c).max(0)).map(move |_| *v)).collect::<Vec<f64>>())
        };
        let mut points = Vec::new();
        for row in &s.control_points_list {
            for point in row {
                points.push(self.point(point)?);
            }
        }
        let u = KnotVector::new(degree(s.u_degree)?, knots(&s.u_knots, &s.u_multiplicities)?);
        let v = KnotVector::new(degree(s.v_degree)?, knots(&s.v_knots, &s.v_multiplicities)?);
        let build = || BsplineSurface::new(u?, v?, points, None);
        build().map(|s| Carrier::Nurbs(Arc::new(s))).map_err(|e| e.to_string())
    }
}

fn nurbs_surface(nurbs: NurbsSurface, rational: bool) -> Result<BsplineSurface, String> {
    let weights: Vec<f64> = nurbs.weights.into_iter().flatten().collect();
    let weights = (rational || weights.iter().any(|w| *w != 1.0)).then_some(weights);
    let points = nurbs.control_points.into_iter().flatten().map(Vector3::from).collect();
    let build = || {
        let u = KnotVector::new(nurbs.degree_u, nurbs.knots_u)?;
        let v = KnotVector::new(nurbs.degree_v, nurbs.knots_v)?;
        BsplineSurface::new(u, v, points, weights)
    };
    build().map_err(|e: nurbs_core::Error| e.to_string())
}
