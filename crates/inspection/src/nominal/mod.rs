//! The shape that points are compared with.

mod analytic;
mod brep;
mod curves;
mod judge;
mod mesh;
mod sides;
mod surfaces;
mod trace;

use crate::options::unit;
use crate::{
    Along, Backdrop, Deviation, DeviationRecord, Error, Inspection, InspectionOptions, Outcome, Partial,
    Place,
};
use analytic::AnalyticNominal;
use brep::BrepNominal;
use brep_core::Model;
use curves::CurvesNominal;
use footpoint::{Facing, Progress, no_progress};
use judge::Judge;
use mesh::MeshNominal;
use mesh_core::{BoundingBox, TriangleMesh};
use nalgebra::{Point3, Vector3};
use nurbs_core::{AnalyticSurface, BsplineCurve, BsplineSurface};
use sides::{Side, Sides};
use std::sync::Arc;
use surfaces::SurfacesNominal;

/// What a surface of a model is called.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ShapeInfo {
    /// `surface`, `curve`, `mesh`, `plane`, `sphere`, …
    pub kind: &'static str,
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The part of a CAD model that it belongs to: index and name of the instance.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub part: Option<(u32, String)>,
}

/// The nominal shape, prepared for measurements.
#[derive(Debug)]
pub struct Nominal {
    kind: Kind,
    shapes: Vec<ShapeInfo>,
}

#[derive(Debug)]
enum Kind {
    Surfaces(Box<SurfacesNominal>),
    Mesh(Box<MeshNominal>),
    Analytic(Box<AnalyticNominal>),
    Profile(Box<CurvesNominal<2>>),
    Curves(Box<CurvesNominal<3>>),
    Brep(Box<BrepNominal>),
}

impl Nominal {
    /// A model of NURBS surfaces.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without surfaces.
    pub fn from_surfaces(surfaces: Vec<BsplineSurface>) -> Result<Self, Error> {
        let shapes = vec![ShapeInfo { kind: "surface", name: None, part: None }; surfaces.len()];
        Ok(Self { kind: Kind::Surfaces(Box::new(SurfacesNominal::new(surfaces)?)), shapes })
    }

    /// A triangle mesh.
    ///
    /// # Errors
    /// [`Error::Mesh`] if no triangle has finite coordinates.
    pub fn from_mesh(mesh: &TriangleMesh) -> Result<Self, Error> {
        let shapes = vec![ShapeInfo { kind: "mesh", name: None, part: None }];
        Ok(Self { kind: Kind::Mesh(Box::new(MeshNominal::new(mesh)?)), shapes })
    }

    /// A model of analytic surfaces.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without surfaces.
    pub fn from_analytic(surfaces: &[AnalyticSurface]) -> Result<Self, Error> {
        let nominal = AnalyticNominal::new(surfaces.to_vec())?;
        let shapes =
            surfaces.iter().map(|s| ShapeInfo { kind: analytic::kind(s), name: None, part: None }).collect();
        Ok(Self { kind: Kind::Analytic(Box::new(nominal)), shapes })
    }

    /// A profile: NURBS curves in the plane. Points lie in it with z = 0; their z is not looked at.
    ///
    /// Deviations are positive on the left of a curve, in the sense of its parameter. They are measured along the shortest
    /// lines only.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without curves.
    pub fn from_profile(curves: Vec<BsplineCurve<2>>) -> Result<Self, Error> {
        let shapes = vec![ShapeInfo { kind: "curve", name: None, part: None }; curves.len()];
        Ok(Self { kind: Kind::Profile(Box::new(CurvesNominal::new(curves)?)), shapes })
    }

    /// NURBS curves in space. Deviations have no sign, and are measured along the shortest lines only.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without curves.
    pub fn from_curves(curves: Vec<BsplineCurve<3>>) -> Result<Self, Error> {
        let shapes = vec![ShapeInfo { kind: "curve", name: None, part: None }; curves.len()];
        Ok(Self { kind: Kind::Curves(Box::new(CurvesNominal::new(curves)?)), shapes })
    }

    /// A CAD model with trimmed faces. Its faces are numbered through all instances of its parts, and called by their names in
    /// the file, or by their numbers there.
    ///
    /// Feet on edges count with the mean normal of the faces there; where a line meets an edge, with that of the face that it meets.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without faces.
    pub fn from_brep(model: Arc<Model>) -> Result<Self, Error> {
        let mut shapes = Vec::new();
        for (instance, index) in model.instances().iter().zip(0_u32..) {
            let part = &model.parts()[instance.part];
            shapes.extend(part.faces().iter().map(|face| {
                let number = format!("#{}", face.source());
                let name = if face.name().is_empty() || face.name() == "NONE" {
                    number
                } else {
                    format!("{} {number}", face.name())
                };
                let owner = if instance.name.is_empty() { part.name() } else { &instance.name };
                let name = if owner.is_empty() { name } else { format!("{owner}: {name}") };
                ShapeInfo { kind: "face", name: Some(name), part: Some((index, owner.to_owned())) }
            }));
        }
        Ok(Self { kind: Kind::Brep(Box::new(BrepNominal::new(model)?)), shapes })
    }

    /// Gives the surfaces names, in their order.
    #[must_use]
    pub fn with_names(mut self, names: impl IntoIterator<Item = Option<String>>) -> Self {
        for (shape, name) in self.shapes.iter_mut().zip(names) {
            shape.name = name;
        }
        self
    }

    /// Kinds and names of the surfaces, by index.
    #[must_use]
    pub fn shapes(&self) -> &[ShapeInfo] {
        &self.shapes
    }

    /// Number of Bézier patches, triangles or analytic surfaces that are searched.
    #[must_use]
    pub fn piece_count(&self) -> usize {
        match &self.kind {
            Kind::Surfaces(nominal) => nominal.patch_count(),
            Kind::Mesh(nominal) => nominal.triangle_count(),
            Kind::Analytic(_) => self.shapes.len(),
            Kind::Profile(nominal) => nominal.piece_count(),
            Kind::Curves(nominal) => nominal.piece_count(),
            Kind::Brep(nominal) => nominal.face_count(),
        }
    }

    /// Triangles that show the shape.
    #[must_use]
    pub fn backdrop(&self) -> Backdrop {
        match &self.kind {
            Kind::Surfaces(nominal) => Backdrop::of_surfaces(nominal.surfaces()),
            Kind::Mesh(nominal) => Backdrop::of_mesh(nominal.mesh()),
            Kind::Analytic(nominal) => Backdrop::of_surfaces(nominal.exact()),
            Kind::Profile(nominal) => nominal.backdrop(),
            Kind::Curves(nominal) => nominal.backdrop(),
            Kind::Brep(nominal) => Backdrop::of_brep(nominal.model()),
        }
    }

    /// Whether distances have a sign: false only for curves in space, and for a mesh whose triangles disagree on the side of
    /// their normals.
    #[must_use]
    pub fn is_signed(&self) -> bool {
        match &self.kind {
            Kind::Mesh(nominal) => nominal.is_signed(),
            Kind::Curves(_) => false,
            Kind::Surfaces(_) | Kind::Analytic(_) | Kind::Profile(_) | Kind::Brep(_) => true,
        }
    }

    /// Measures the deviations of many points, in parallel; the result has their order. With [`Along::Normal`], and with a
    /// [largest angle](InspectionOptions::max_angle), `normals` holds one vector per point (of any length but zero).
    ///
    /// `progress` may cancel: what is left then has [`Outcome::Cancelled`].
    ///
    /// Lines of projection are followed in both senses to the nearest point of the shape that counts: on meshes by exact
    /// intersection; on CAD models by all crossings with their faces; on surfaces by steps as long as the certified distance allows
    /// (\[Ha96\]), so that no nearer point is missed but within the [`gap`](Deviation::gap), and by Newton's method at the end.
    ///
    /// With a largest angle, the feet that count along shortest lines are the local minima of the distance on surfaces, and the
    /// nearest points of the triangles of a mesh, where the normal of the shape, on a kink or edge that of any face there, is
    /// within the angle of the point's. A point without such a foot has [`Outcome::NoMatchingFoot`].
    ///
    /// # Errors
    /// As [`InspectionOptions::validate`]; [`Error::Normals`] if normals are needed and not given; [`Error::AlongCurves`] for
    /// curves and anything but the shortest lines; [`Error::FacingCurves`] and [`Error::FacingUnoriented`] for a largest angle
    /// where the shape has no normals to compare with.
    pub fn measure(
        &self,
        points: &[Point3<f64>],
        normals: Option<&[Vector3<f64>]>,
        options: &InspectionOptions,
        progress: Progress<'_>,
    ) -> Result<Vec<Deviation>, Error> {
        let mut deviations = vec![Deviation::none(Outcome::Cancelled); points.len()];
        self.measure_each(points, normals, options, progress, &mut |measured| {
            for &(index, deviation) in measured {
                deviations[index] = deviation;
            }
        })?;
        Ok(deviations)
    }

    /// As [`measure`](Self::measure), without holding all deviations at once: `receive` gets them with the indices of their
    /// points, some tens of thousands at a time, in an order that depends on the points alone.
    ///
    /// # Errors
    /// As [`measure`](Self::measure).
    pub fn measure_each(
        &self,
        points: &[Point3<f64>],
        normals: Option<&[Vector3<f64>]>,
        options: &InspectionOptions,
        progress: Progress<'_>,
        receive: &mut dyn FnMut(&[(usize, Deviation)]),
    ) -> Result<(), Error> {
        options.validate()?;
        let limit = options.angle_limit();
        match (&self.kind, options.along) {
            (Kind::Profile(_) | Kind::Curves(_), Along::Normal | Along::Direction(_)) => {
                return Err(Error::AlongCurves);
            }
            (Kind::Profile(_) | Kind::Curves(_), _) if limit.is_some() => return Err(Error::FacingCurves),
            (Kind::Mesh(mesh), _) if limit.is_some() && !mesh.is_signed() => {
                return Err(Error::FacingUnoriented);
            }
            _ => {}
        }
        let needed = limit.is_some() || options.along == Along::Normal;
        let count = normals.map_or(0, <[_]>::len);
        let normals = normals.filter(|_| count == points.len()).unwrap_or_default();
        if needed && normals.len() != points.len() {
            return Err(Error::Normals { found: count, points: points.len() });
        }
        let sides = Sides::new(limit.map(|angle| (normals, angle)));
        let judge = Judge::new(options, self.size(), self.is_signed());
        let finish = |deviation: Deviation| judge.judged(deviation);
        let line = |index: usize| match options.along {
            Along::Shortest => None,
            Along::Normal => Some(unit(&normals[index]).ok()),
            Along::Direction(direction) => Some(unit(&Vector3::from(direction)).ok()),
        };
        if options.along == Along::Shortest {
            match &self.kind {
                Kind::Surfaces(nominal) => {
                    return nominal.shortest(points, &sides, options, progress, &finish, receive);
                }
                Kind::Profile(nominal) => {
                    return nominal.shortest(points, options, progress, &finish, receive);
                }
                Kind::Curves(nominal) => {
                    return nominal.shortest(points, options, progress, &finish, receive);
                }
                Kind::Mesh(_) | Kind::Analytic(_) | Kind::Brep(_) => {}
            }
        }
        let treat = |index: usize| {
            let point = &points[index];
            if !point.iter().all(|value| value.is_finite()) {
                return Deviation::none(Outcome::InvalidPoint);
            }
            let (line, side) = (line(index), sides.of(index));
            if matches!(side, Side::Unknown) || line == Some(None) {
                return Deviation::none(Outcome::NoNormal);
            }
            finish(self.measured(point, line.flatten().as_ref(), side.facing(), options))
        };
        let cancelled = Deviation::none(Outcome::Cancelled);
        crate::parallel::each(points.len(), &cancelled, progress, &treat, receive);
        Ok(())
    }

    /// The deviation of a point along a line, or the shortest one.
    fn measured(
        &self,
        point: &Point3<f64>,
        line: Option<&Vector3<f64>>,
        facing: Option<&Facing>,
        options: &InspectionOptions,
    ) -> Deviation {
        match (&self.kind, line) {
            (Kind::Mesh(nominal), None) => nominal.shortest(point, facing),
            (Kind::Mesh(nominal), Some(line)) => nominal.along(point, line, facing),
            (Kind::Analytic(nominal), None) => nominal.shortest(&point.coords, facing),
            (Kind::Analytic(nominal), Some(line)) => {
                trace::along(nominal.as_ref(), point, line, options.max_distance, facing)
            }
            (Kind::Surfaces(nominal), Some(line)) => {
                trace::along(nominal.as_ref(), point, line, options.max_distance, facing)
            }
            (Kind::Brep(nominal), None) => nominal.shortest(point, facing),
            (Kind::Brep(nominal), Some(line)) => nominal.along(point, line, options.max_distance, facing),
            // Many of these are measured at once, or refused before.
            (Kind::Surfaces(_) | Kind::Profile(_) | Kind::Curves(_), _) => Deviation::none(Outcome::NoHit),
        }
    }

    /// The unit normal at the foot of a record, the same as in the [`Deviation`] that it was made from. `normal` is that of the
    /// point; it is looked at where only feet count whose normals agree with it.
    #[must_use]
    pub fn normal(
        &self,
        point: &Point3<f64>,
        normal: Option<&Vector3<f64>>,
        record: &DeviationRecord,
        options: &InspectionOptions,
    ) -> Vector3<f64> {
        if record.place == Place::None {
            return Vector3::repeat(f64::NAN);
        }
        let shape = record.shape() as usize;
        let offset = point - record.foot;
        let is_hit = options.along != Along::Shortest;
        match &self.kind {
            Kind::Mesh(nominal) => {
                let facing = normal.zip(options.angle_limit()).and_then(|(n, a)| Facing::new(n, a).ok());
                nominal.normal(record, is_hit, facing.as_ref())
            }
            // A line that meets a surface where it has no normal tells nothing about one.
            Kind::Surfaces(nominal) => {
                let offset = if is_hit { Vector3::zeros() } else { offset };
                nominal.normal(shape, record.parameter, &offset, record.distance)
            }
            Kind::Analytic(nominal) => {
                let offset = if is_hit { Vector3::zeros() } else { offset };
                nominal.normal(shape, record.parameter, &offset)
            }
            Kind::Brep(nominal) if is_hit => nominal.face_normal(shape, record.parameter),
            Kind::Brep(nominal) => {
                let facing = normal.zip(options.angle_limit()).and_then(|(n, a)| Facing::new(n, a).ok());
                nominal.normal(point, facing.filter(|_| record.is_restricted()).as_ref())
            }
            Kind::Profile(nominal) => {
                nominal.normal(shape, record.parameter[0], &nominal.offset(point, &record.foot))
            }
            Kind::Curves(nominal) => {
                nominal.normal(shape, record.parameter[0], &nominal.offset(point, &record.foot))
            }
        }
    }

    /// A box around a shape of surfaces; `None` for curves.
    #[must_use]
    pub fn bounds(&self) -> Option<BoundingBox> {
        let around =
            |bounds: &nurbs_core::Aabb<3>| BoundingBox { min: bounds.min.into(), max: bounds.max.into() };
        match &self.kind {
            Kind::Surfaces(nominal) => Some(around(trace::Traceable::bounds(nominal.as_ref()))),
            Kind::Analytic(nominal) => Some(around(trace::Traceable::bounds(nominal.as_ref()))),
            Kind::Brep(nominal) => Some(around(nominal.model().bounds())),
            Kind::Mesh(nominal) => nominal.mesh().bounding_box(),
            Kind::Profile(_) | Kind::Curves(_) => None,
        }
    }

    /// The largest side of a box around the shape, to which gaps of a search are relative.
    fn size(&self) -> f64 {
        match &self.kind {
            Kind::Surfaces(nominal) => nominal.size(),
            Kind::Profile(nominal) => nominal.size(),
            Kind::Curves(nominal) => nominal.size(),
            Kind::Brep(nominal) => nominal.size(),
            Kind::Analytic(nominal) => {
                let bounds = trace::Traceable::bounds(nominal.as_ref());
                (bounds.max - bounds.min).max()
            }
            Kind::Mesh(nominal) => nominal.mesh().bounding_box().map_or(0.0, |bounds| bounds.extent().max()),
        }
    }

    /// Measures and judges a whole cloud at once, without normals.
    ///
    /// # Errors
    /// As [`Nominal::measure`].
    pub fn inspect(&self, points: &[Point3<f64>], options: &InspectionOptions) -> Result<Inspection, Error> {
        let mut partial = Partial::new(options)?;
        let mut receive = |measured: &[(usize, Deviation)]| partial.extend_with(0, points, measured);
        self.measure_each(points, None, options, &no_progress, &mut receive)?;
        partial.finish(options, &self.shapes)
    }
}

/// `distance` with the sign of the side of `normal` on which `offset` (from the foot to the point) lies.
fn signed(distance: f64, offset: &Vector3<f64>, normal: &Vector3<f64>) -> f64 {
    if offset.dot(normal) < 0.0 { -distance } else { distance }
}
