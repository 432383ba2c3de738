//! What a file can hold.

use mesh_core::{PointCloud, TriangleMesh};

use crate::error::Location;
use crate::wording::counted;
use crate::{Error, Format, Model, Place, ReadReport, Scan, Shape};

/// Points, triangles, or curves and surfaces.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Points without triangles.
    Cloud(PointCloud),
    /// Triangles.
    Mesh(TriangleMesh),
    /// NURBS curves and surfaces.
    Nurbs(Model),
}

/// Something read, together with the report about reading it.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded<T> {
    /// What was read.
    pub content: T,
    /// How that went.
    pub report: ReadReport,
}

impl Content {
    /// A few words, such as `a mesh of 12 triangles`.
    #[must_use]
    pub fn describe(&self) -> String {
        match self {
            Self::Cloud(cloud) => format!("a cloud of {}", counted(cloud.len(), "point")),
            Self::Mesh(mesh) => format!("a mesh of {}", counted(mesh.triangles().len(), "triangle")),
            Self::Nurbs(model) => match model.shapes() {
                [Shape::Surface(_)] => "a NURBS surface".to_owned(),
                [_] => "a NURBS curve".to_owned(),
                shapes => format!("{} NURBS curves and surfaces", shapes.len()),
            },
        }
    }

    /// The points; of a mesh its vertices.
    pub(crate) fn into_cloud(self) -> Result<PointCloud, Error> {
        match self {
            Self::Cloud(cloud) => Ok(cloud),
            Self::Mesh(mesh) => Ok(mesh.into_parts().0),
            Self::Nurbs(_) => Err(self.wrong("a point cloud", "sample points on the shapes first")),
        }
    }

    pub(crate) fn into_mesh(self) -> Result<TriangleMesh, Error> {
        match self {
            Self::Mesh(mesh) => Ok(mesh),
            other => Err(other.wrong("a mesh", "give a file with triangles: STL, PLY, OBJ or OFF")),
        }
    }

    pub(crate) fn into_model(self) -> Result<Model, Error> {
        match self {
            Self::Nurbs(model) => Ok(model),
            other => Err(other.wrong("a NURBS model", "give a NURBS JSON file")),
        }
    }

    fn wrong(&self, wanted: &'static str, advice: &'static str) -> Error {
        let location = Location { file: None, place: Place::Whole };
        Error::WrongContent { location, wanted, found: self.describe(), advice }
    }

    /// Counts points that are not finite, drops them if asked to, and reports.
    pub(crate) fn into_loaded(
        mut self,
        format: Format,
        warnings: Vec<String>,
        scans: Vec<Scan>,
        drop_non_finite: bool,
    ) -> Loaded<Self> {
        let (points, triangles, shapes, non_finite) = match &self {
            Self::Cloud(cloud) => (cloud.len(), 0, 0, cloud.count_non_finite()),
            Self::Mesh(mesh) => (mesh.vertices().len(), mesh.triangles().len(), 0, mesh.count_non_finite()),
            Self::Nurbs(model) => (0, 0, model.shapes().len(), 0),
        };
        let dropped = match &mut self {
            _ if !drop_non_finite => 0,
            Self::Cloud(cloud) => cloud.retain_finite(),
            Self::Mesh(mesh) => mesh.retain_finite(),
            Self::Nurbs(_) => 0,
        };
        let report = ReadReport {
            path: None,
            format,
            points,
            triangles,
            shapes,
            scans,
            non_finite,
            dropped,
            warnings,
        };
        Loaded { content: self, report }
    }
}
