//! The shape that points are compared with.

mod analytic;
mod curves;
mod mesh;
mod surfaces;
mod trace;

use crate::options::unit;
use crate::{Along, Backdrop, Deviation, Error, Inspection, InspectionOptions, Outcome, Partial};
use analytic::AnalyticNominal;
use curves::CurvesNominal;
use footpoint::{Progress, no_progress};
use mesh::MeshNominal;
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use nurbs_core::{AnalyticSurface, BsplineCurve, BsplineSurface};
use surfaces::SurfacesNominal;

/// What a surface of a model is called.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ShapeInfo {
    /// `surface`, `curve`, `mesh`, `plane`, `sphere`, …
    pub kind: &'static str,
    /// Its name, if it has one.
    pub name: Option<String>,
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
    Analytic(AnalyticNominal),
    Profile(Box<CurvesNominal<2>>),
    Curves(Box<CurvesNominal<3>>),
}

impl Nominal {
    /// A model of NURBS surfaces.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without surfaces.
    pub fn from_surfaces(surfaces: Vec<BsplineSurface>) -> Result<Self, Error> {
        let shapes = vec![ShapeInfo { kind: "surface", name: None }; surfaces.len()];
        Ok(Self { kind: Kind::Surfaces(Box::new(SurfacesNominal::new(surfaces)?)), shapes })
    }

    /// A triangle mesh.
    ///
    /// # Errors
    /// [`Error::Mesh`] if no triangle has finite coordinates.
    pub fn from_mesh(mesh: &TriangleMesh) -> Result<Self, Error> {
        let shapes = vec![ShapeInfo { kind: "mesh", name: None }];
        Ok(Self { kind: Kind::Mesh(Box::new(MeshNominal::new(mesh)?)), shapes })
    }

    /// A model of analytic surfaces.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without surfaces.
    pub fn from_analytic(surfaces: &[AnalyticSurface]) -> Result<Self, Error> {
        let nominal = AnalyticNominal::new(surfaces.to_vec())?;
        let shapes = surfaces.iter().map(|s| ShapeInfo { kind: analytic::kind(s), name: None }).collect();
        Ok(Self { kind: Kind::Analytic(nominal), shapes })
    }

    /// A profile: NURBS curves in the plane. Points lie in it with z = 0; their z is not looked at.
    ///
    /// Deviations are positive on the left of a curve, in the sense of its parameter. They are measured along the shortest
    /// lines only.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without curves.
    pub fn from_profile(curves: Vec<BsplineCurve<2>>) -> Result<Self, Error> {
        let shapes = vec![ShapeInfo { kind: "curve", name: None }; curves.len()];
        Ok(Self { kind: Kind::Profile(Box::new(CurvesNominal::new(curves)?)), shapes })
    }

    /// NURBS curves in space. Deviations have no sign, and are measured along the shortest lines only.
    ///
    /// # Errors
    /// [`Error::EmptyModel`] without curves.
    pub fn from_curves(curves: Vec<BsplineCurve<3>>) -> Result<Self, Error> {
        let shapes = vec![ShapeInfo { kind: "curve", name: None }; curves.len()];
        Ok(Self { kind: Kind::Curves(Box::new(CurvesNominal::new(curves)?)), shapes })
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
        }
    }

    /// Whether distances have a sign: false only for curves in space, and for a mesh whose triangles disagree on the side of
    /// their normals.
    #[must_use]
    pub fn is_signed(&self) -> bool {
        match &self.kind {
            Kind::Mesh(nominal) => nominal.is_signed(),
            Kind::Curves(_) => false,
            Kind::Surfaces(_) | Kind::Analytic(_) | Kind::Profile(_) => true,
        }
    }

    /// Measures the deviations of many points, in parallel; the result has their order. With [`Along::Normal`], `normals`
    /// holds one vector per point (of any length but zero).
    ///
    /// `progress` may cancel: what is left then has [`Outcome::Cancelled`].
    ///
    /// Lines of projection are followed in both senses to the nearest point of the shape: on meshes by exact intersection;
    /// on surfaces by steps as long as the certified distance allows (\[Ha96\]), so that no nearer point is missed but within
    /// the [`gap`](Deviation::gap), and by Newton's method at the end.
    ///
    /// # Errors
    /// As [`InspectionOptions::validate`]; [`Error::Normals`] if normals are needed and not given; [`Error::AlongCurves`] for
    /// curves and anything but the shortest lines.
    pub fn measure(
        &self,
        points: &[Point3<f64>],
        normals: Option<&[Vector3<f64>]>,
        options: &InspectionOptions,
        progress: Progress<'_>,
    ) -> Result<Vec<Deviation>, Error> {
        options.validate()?;
        if options.along != Along::Shortest && matches!(self.kind, Kind::Profile(_) | Kind::Curves(_)) {
            return Err(Error::AlongCurves);
        }
        let mut deviations = match options.along {
            Along::Shortest => match &self.kind {
                Kind::Surfaces(nominal) => nominal.shortest(points, options, progress)?,
                Kind::Mesh(nominal) => nominal.shortest(points, progress),
                Kind::Analytic(nominal) => nominal.shortest(points, progress),
                Kind::Profile(nominal) => nominal.shortest(points, options, progress)?,
                Kind::Curves(nominal) => nominal.shortest(points, options, progress)?,
            },
            Along::Normal => {
                let normals = normals.filter(|normals| normals.len() == points.len());
                let count = normals.map_or(0, <[_]>::len);
                let normals = normals.ok_or(Error::Normals { found: count, points: points.len() })?;
                self.along(points, options, progress, |index| unit(&normals[index]).ok())
            }
            Along::Direction(direction) => {
                let direction = unit(&Vector3::from(direction))?;
                self.along(points, options, progress, |_| Some(direction))
            }
        };
        for deviation in &mut deviations {
            judge(deviation, options);
        }
        Ok(deviations)
    }

    /// Measures and judges a whole cloud at once, without normals.
    ///
    /// # Errors
    /// As [`Nominal::measure`].
    pub fn inspect(&self, points: &[Point3<f64>], options: &InspectionOptions) -> Result<Inspection, Error> {
        let deviations = self.measure(points, None, options, &no_progress)?;
        let mut partial = Partial::new(options)?;
        partial.extend(0, points, &deviations);
        partial.finish(options, &self.shapes)
    }

    fn along(
        &self,
        points: &[Point3<f64>],
        options: &InspectionOptions,
        progress: Progress<'_>,
        direction: impl Fn(usize) -> Option<Vector3<f64>> + Sync + Send,
    ) -> Vec<Deviation> {
        let cancelled = Deviation::none(Outcome::Cancelled);
        crate::parallel::map(points.len(), &cancelled, progress, |index| {
            let point = &points[index];
            if !point.iter().all(|value| value.is_finite()) {
                return Deviation::none(Outcome::InvalidPoint);
            }
            let Some(direction) = direction(index) else { return Deviation::none(Outcome::NoNormal) };
            match &self.kind {
                Kind::Surfaces(nominal) => {
                    trace::along(nominal.as_ref(), point, &direction, options.max_distance)
                }
                Kind::Mesh(nominal) => nominal.along(point, &direction),
                Kind::Analytic(nominal) => trace::along(nominal, point, &direction, options.max_distance),
                // Refused before.
                Kind::Profile(_) | Kind::Curves(_) => Deviation::none(Outcome::NoHit),
            }
        })
    }
}

/// Sorts out deviations that are not to be used.
fn judge(deviation: &mut Deviation, options: &InspectionOptions) {
    if deviation.outcome != Outcome::Measured {
        return;
    }
    if !deviation.distance.is_finite() {
        deviation.outcome = Outcome::NotConverged;
    } else if deviation.distance.abs() > options.max_distance {
        deviation.outcome = Outcome::BeyondMaxDistance;
    } else if deviation.on_boundary && options.drop_beyond_boundary {
        deviation.outcome = Outcome::BeyondBoundary;
    }
}

/// `distance` with the sign of the side of `normal` on which `offset` (from the foot to the point) lies.
fn signed(distance: f64, offset: &Vector3<f64>, normal: &Vector3<f64>) -> f64 {
    if offset.dot(normal) < 0.0 { -distance } else { distance }
}
