//! The shape that points are registered to: its distance field, and samples for a start without a guess.

use crate::commands::register::field::RegistrationField;
use crate::error::Error;
use crate::files;
use crate::input::cad::{CadModel, Choice};
use crate::input::field_model::{self, LevelSet};
use crate::input::image_or_grid::refused;
use crate::input::model::{self, Loaded};
use crate::report::wording::{counted, not_finite};
use industrial_geometry::distance_field::{
    BrepField, CloudField, CurveField, DistanceField, LevelSetField, MeshField, PlanarCloudField,
    SurfaceField,
};
use industrial_geometry::io::{Content, ReadOptions, ReadReport, Shape};
use industrial_geometry::level_set::surface::{dual_contour, of_field};
use industrial_geometry::mesh::{MeshProjector, PointCloud, TriangleMesh};
use industrial_geometry::nurbs::{BsplineCurve, BsplineSurface, ParametricSurface};
use industrial_geometry::register::start::OrientedPoints;
use std::path::Path;

/// Points of a model from which a start is looked for.
const SAMPLES: usize = 12_000;

const ADVICE: &str = "check it with `indgeo info`";

/// A model as read.
#[derive(Debug)]
pub(crate) enum RegistrationModel {
    /// NURBS surfaces.
    Surfaces(Vec<BsplineSurface>),
    /// NURBS curves in the plane.
    Plane(Vec<BsplineCurve<2>>),
    /// NURBS curves in space.
    Curves(Vec<BsplineCurve<3>>),
    /// A triangle mesh.
    Mesh(TriangleMesh),
    /// A cloud, dense enough to stand for a surface.
    Cloud(PointCloud),
    /// A cloud in the plane, dense enough to stand for a curve.
    PlanarCloud(PointCloud),
    /// A CAD model.
    Cad(CadModel),
    /// The level set 0 of values on a grid in space.
    LevelSet(Box<LevelSetField<3>>),
    /// The same in the plane.
    PlanarLevelSet(Box<LevelSetField<2>>),
}

impl RegistrationModel {
    /// Reads NURBS JSON, a mesh or a cloud.
    pub(crate) fn read(
        path: &Path,
        choice: &Choice,
        warnings: &mut Vec<String>,
    ) -> Result<(Self, ReadReport), Error> {
        if let Some(cad) = CadModel::read(path, choice)? {
            warnings.extend(cad.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
            let report = Loaded::of_cad(cad.clone(), path).report;
            return Ok((Self::Cad(cad), report));
        }
        if field_model::is_grid(path) {
            let (found, report) = field_model::read(path)?;
            let model = match found {
                LevelSet::Plane(field) => Self::PlanarLevelSet(field),
                LevelSet::Space(field) => Self::LevelSet(field),
            };
            return Ok((model, report));
        }
        let loaded = files::read(path, &ReadOptions::default().with_drop_non_finite(true))?;
        let report = loaded.report;
        warnings.extend(report.warnings.iter().map(|warning| format!("{}: {warning}", path.display())));
        if report.dropped > 0 {
            warnings.push(not_finite(path, report.dropped, report.points, "left out"));
        }
        let model = match loaded.content {
            Content::Nurbs(model) => {
                warnings.extend(model::whole(&model).map(|warning| format!("{}: {warning}", path.display())));
                Self::of_shapes(model.into_shapes(), path, warnings)?
            }
            Content::Mesh(mesh) => Self::Mesh(mesh),
            Content::Cloud(cloud) => {
                let first = cloud.positions().first();
                if cloud.len() > 1 && cloud.positions().iter().all(|point| Some(point) == first) {
                    let what = format!("all {} of the model are the same", counted(cloud.len(), "point"));
                    return Err(Error::content(path, what, "give a cloud that is dense on a surface"));
                }
                if cloud.dimension() == 2 { Self::PlanarCloud(cloud) } else { Self::Cloud(cloud) }
            }
        };
        Ok((model, report))
    }

    fn of_shapes(shapes: Vec<Shape>, path: &Path, warnings: &mut Vec<String>) -> Result<Self, Error> {
        let (mut surfaces, mut curves, mut plane) = (Vec::new(), Vec::new(), Vec::new());
        for shape in shapes {
            match shape {
                Shape::Surface(surface) => surfaces.push(surface),
                Shape::Curve3(curve) => curves.push(curve),
                Shape::Curve2(curve) => plane.push(curve),
            }
        }
        if !plane.is_empty() {
            let in_space = surfaces.len() + curves.len();
            if in_space == 0 {
                return Ok(Self::Plane(plane));
            }
            let what = format!("shapes in the plane: {}, in space: {in_space}", plane.len());
            return Err(Error::content(path, what, "put them into models of their own"));
        }
        match (surfaces.is_empty(), curves.is_empty()) {
            (true, true) => {
                Err(Error::content(path, "the model has no shapes", "give at least one curve or surface"))
            }
            (true, false) => Ok(Self::Curves(curves)),
            (false, _) => {
                if !curves.is_empty() {
                    warnings.push(format!(
                        "{}: {} left out, points are registered to the surfaces",
                        path.display(),
                        counted(curves.len(), "curve")
                    ));
                }
                Ok(Self::Surfaces(surfaces))
            }
        }
    }

    /// `nurbs`, `mesh`, `cloud` or `cad`.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Surfaces(_) | Self::Plane(_) | Self::Curves(_) => "nurbs",
            Self::Mesh(_) => "mesh",
            Self::Cloud(_) | Self::PlanarCloud(_) => "cloud",
            Self::Cad(_) => "cad",
            Self::LevelSet(_) | Self::PlanarLevelSet(_) => "level_set",
        }
    }

    /// Whether the model lies in the plane z = 0, and takes points of two columns.
    pub(crate) fn is_planar(&self) -> bool {
        matches!(self, Self::Plane(_) | Self::PlanarCloud(_) | Self::PlanarLevelSet(_))
    }

    /// Unit of length that a CAD file states.
    pub(crate) fn unit(&self) -> Option<String> {
        match self {
            Self::Cad(cad) => Some(cad.unit().to_owned()),
            _ => None,
        }
    }

    /// Number of curves, surfaces and faces, triangles or points.
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Surfaces(surfaces) => surfaces.len(),
            Self::Plane(curves) => curves.len(),
            Self::Curves(curves) => curves.len(),
            Self::Mesh(mesh) => mesh.triangles().len(),
            Self::Cloud(cloud) | Self::PlanarCloud(cloud) => cloud.len(),
            Self::Cad(cad) => cad.face_count(),
            Self::LevelSet(_) | Self::PlanarLevelSet(_) => 1,
        }
    }

    /// The distance field.
    pub(crate) fn field(&self, path: &Path) -> Result<RegistrationField, Error> {
        let failed = |error: industrial_geometry::distance_field::Error| {
            Error::content(path, error.to_string(), ADVICE)
        };
        let field: Result<Box<dyn DistanceField<3>>, _> = match self {
            Self::Plane(curves) => {
                let field = CurveField::for_model(curves).map_err(failed)?;
                return Ok(RegistrationField::Plane(Box::new(field)));
            }
            Self::PlanarCloud(cloud) => {
                let points: Vec<_> = cloud.positions().iter().map(|point| point.xy()).collect();
                let normals: Option<Vec<_>> =
                    cloud.attributes().normals().map(|all| all.iter().map(|normal| normal.xy()).collect());
                let field = PlanarCloudField::new(&points, normals.as_deref()).map_err(failed)?;
                return Ok(RegistrationField::Plane(Box::new(field)));
            }
            Self::PlanarLevelSet(field) => return Ok(RegistrationField::Plane(field.clone())),
            Self::LevelSet(field) => return Ok(RegistrationField::Space(field.clone())),
            Self::Surfaces(surfaces) => SurfaceField::for_model(surfaces).map(|field| Box::new(field) as _),
            Self::Curves(curves) => CurveField::for_model(curves).map(|field| Box::new(field) as _),
            Self::Mesh(mesh) => MeshField::new(mesh).map(|field| Box::new(field) as _),
            Self::Cad(cad) => Ok(Box::new(BrepField::new(cad.model.clone())) as _),
            Self::Cloud(cloud) => CloudField::new(cloud.positions(), cloud.attributes().normals())
                .map(|field| Box::new(field) as _),
        };
        field.map(RegistrationField::Space).map_err(failed)
    }

    /// Makes sure that the model has normals that tell sides, with which those of points can agree.
    pub(crate) fn check_normals(&self, path: &Path) -> Result<(), Error> {
        let what = match self {
            Self::Surfaces(_) | Self::Cad(_) | Self::LevelSet(_) | Self::PlanarLevelSet(_) => return Ok(()),
            Self::Plane(_) | Self::Curves(_) => "the model has curves, which have no normals",
            Self::Cloud(cloud) | Self::PlanarCloud(cloud) if cloud.attributes().normals().is_some() => {
                return Ok(());
            }
            Self::Cloud(_) | Self::PlanarCloud(_) => "the model is a cloud without normals",
            Self::Mesh(mesh) => match MeshProjector::new(mesh) {
                Ok(projector) if !projector.topology().is_oriented() => {
                    "neighbouring triangles disagree on the side of their normals"
                }
                // A mesh that cannot be used is refused where its field is built.
                _ => return Ok(()),
            },
        };
        Err(Error::content(path, what, "leave out --max-angle, or give a model with normals"))
    }

    /// Points with normals, spread over a model that has an area, or stands for one; of a cloud, some of its points.
    pub(crate) fn few_samples(&self) -> Option<OrientedPoints> {
        match self {
            Self::Cloud(cloud) => {
                let step = cloud.len().div_ceil(SAMPLES).max(1);
                let points: Vec<_> = cloud.positions().iter().step_by(step).map(|p| p.coords).collect();
                match cloud.attributes().normals() {
                    Some(normals) => {
                        let normals: Vec<_> = normals.iter().step_by(step).copied().collect();
                        OrientedPoints::new(&points, &normals).ok()
                    }
                    None => OrientedPoints::without_normals(&points).ok(),
                }
            }
            Self::Surfaces(_) | Self::Mesh(_) | Self::Cad(_) | Self::LevelSet(_) => {
                self.samples(Path::new("")).ok()
            }
            Self::Plane(_) | Self::PlanarCloud(_) | Self::PlanarLevelSet(_) | Self::Curves(_) => None,
        }
    }

    /// Points with normals, spread over the model.
    pub(crate) fn samples(&self, path: &Path) -> Result<OrientedPoints, Error> {
        match self {
            Self::Surfaces(surfaces) => {
                let surfaces: Vec<&dyn ParametricSurface> =
                    surfaces.iter().map(|surface| surface as _).collect();
                Ok(OrientedPoints::from_surfaces(&surfaces, SAMPLES))
            }
            Self::Mesh(mesh) => Ok(OrientedPoints::from_mesh(mesh, SAMPLES)),
            Self::Cad(cad) => {
                let (points, normals): (Vec<_>, Vec<_>) =
                    cad.model.samples(SAMPLES).into_iter().map(|s| (s.point, s.normal)).unzip();
                OrientedPoints::new(&points, &normals)
                    .map_err(|error| Error::content(path, error.to_string(), ADVICE))
            }
            Self::Cloud(cloud) => OrientedPoints::from_cloud(cloud)
                .map_err(|error| Error::content(path, error.to_string(), ADVICE)),
            Self::LevelSet(field) => {
                let mesh =
                    dual_contour(field.grid(), of_field(field)).map_err(|error| refused(path, &error))?;
                Ok(OrientedPoints::from_mesh(&mesh, SAMPLES))
            }
            Self::Plane(_) | Self::PlanarCloud(_) | Self::PlanarLevelSet(_) | Self::Curves(_) => {
                Err(Error::content(
                    path,
                    "a start without a guess needs surfaces, this model has curves only",
                    "give a starting pose (--init) or choose --start given",
                ))
            }
        }
    }
}
