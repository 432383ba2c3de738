//! The model that points are projected onto.

use crate::error::Error;
use crate::files;
use crate::input::cad::{CadModel, Choice};
use crate::input::field_model::{self, LevelSet};
use crate::report::Input;
use crate::report::wording::counted;
use industrial_geometry::io::{Content, Format, ReadOptions, ReadReport, Shape};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::nurbs::{BsplineCurve, BsplineSurface};
use std::path::Path;

/// Shapes with their indices in the file.
#[derive(Debug)]
pub(crate) struct Indexed<T> {
    /// The shapes of one kind.
    pub(crate) shapes: Vec<T>,
    /// Index of each among all shapes of the file.
    pub(crate) indices: Vec<u32>,
}

/// What points can be projected onto.
#[derive(Debug)]
pub(crate) enum Model {
    /// Curves in the plane.
    Plane(Vec<BsplineCurve<2>>),
    /// Curves and surfaces in space.
    Space {
        /// The surfaces.
        surfaces: Indexed<BsplineSurface>,
        /// The curves.
        curves: Indexed<BsplineCurve<3>>,
    },
    /// A triangle mesh.
    Mesh(TriangleMesh),
    /// A CAD model.
    Cad(CadModel),
    /// The level set 0 of values on a grid.
    LevelSet(LevelSet),
}

/// A model as read.
#[derive(Debug)]
pub(crate) struct Loaded {
    /// The model.
    pub(crate) model: Model,
    /// Kind and name of each shape: `surface`, `curve`, `face` or `mesh`.
    pub(crate) shapes: Vec<(&'static str, Option<String>)>,
    /// How reading went.
    pub(crate) report: ReadReport,
}

/// What is to be said where pieces of surfaces are taken for the whole.
pub(crate) fn whole(model: &industrial_geometry::io::Model) -> Option<String> {
    (model.n_trimmed() > 0).then(|| {
        format!(
            "{} taken whole: the loops that bound a piece (trim) are not looked at; of STEP they are (`indgeo convert`)",
            counted(model.n_trimmed(), "surface")
        )
    })
}

impl Loaded {
    /// Reads NURBS JSON, a mesh, a CAD file or a grid.
    pub(crate) fn read(path: &Path, choice: &Choice) -> Result<Self, Error> {
        if let Some(cad) = CadModel::read(path, choice)? {
            return Ok(Self::of_cad(cad, path));
        }
        if field_model::is_grid(path) {
            let (found, report) = field_model::read(path)?;
            return Ok(Self { model: Model::LevelSet(found), shapes: vec![("level_set", None)], report });
        }
        let loaded = files::read(path, &ReadOptions::default())?;
        let mut report = loaded.report;
        match loaded.content {
            Content::Nurbs(model) => {
                report.warnings.extend(whole(&model));
                let name = |index: usize| model.name(index).map(str::to_owned);
                let shapes = model.shapes().iter().enumerate();
                let shapes = shapes.map(|(index, shape)| (kind(shape), name(index))).collect();
                Ok(Self { model: sort(model.into_shapes(), path)?, shapes, report })
            }
            Content::Mesh(mesh) => {
                Ok(Self { model: Model::Mesh(mesh), shapes: vec![("mesh", None)], report })
            }
            Content::Cloud(_) => {
                let what = format!(
                    "a model is needed (NURBS as JSON, STEP, or a mesh), but this file holds {} without triangles",
                    counted(report.points, "point")
                );
                Err(Error::content(path, what, "the order is MODEL POINTS"))
            }
        }
    }
}

impl Loaded {
    /// A CAD model with what reports say about its file.
    pub(crate) fn of_cad(cad: CadModel, path: &Path) -> Self {
        let report = ReadReport {
            path: Some(path.to_path_buf()),
            // Not looked at: the format of a CAD model is its own.
            format: Format::Json,
            points: 0,
            triangles: 0,
            shapes: cad.face_count(),
            scans: Vec::new(),
            non_finite: 0,
            dropped: 0,
            warnings: cad.warnings.clone(),
        };
        Self { shapes: cad.shapes(), model: Model::Cad(cad), report }
    }

    /// The file as an input of a report.
    pub(crate) fn input(&self, path: &Path) -> Input {
        let mut input = Input::new("model", path, &self.report);
        match &self.model {
            Model::Cad(cad) => cad.format.clone_into(&mut input.read.format),
            Model::LevelSet(_) => input.read.format = files::extension(path),
            _ => {}
        }
        input
    }
}

/// `curve` or `surface`.
pub(crate) fn kind(shape: &Shape) -> &'static str {
    match shape {
        Shape::Curve2(_) | Shape::Curve3(_) => "curve",
        Shape::Surface(_) => "surface",
    }
}

/// Sorts the shapes of a file by their kind.
fn sort(shapes: Vec<Shape>, path: &Path) -> Result<Model, Error> {
    if shapes.is_empty() {
        return Err(Error::content(path, "the model has no shapes", "give at least one curve or surface"));
    }
    let mut plane = Vec::new();
    let mut surfaces = Indexed { shapes: Vec::new(), indices: Vec::new() };
    let mut curves = Indexed { shapes: Vec::new(), indices: Vec::new() };
    for (shape, index) in shapes.into_iter().zip(0u32..) {
        match shape {
            Shape::Curve2(curve) => plane.push(curve),
            Shape::Curve3(curve) => {
                curves.shapes.push(curve);
                curves.indices.push(index);
            }
            Shape::Surface(surface) => {
                surfaces.shapes.push(surface);
                surfaces.indices.push(index);
            }
        }
    }
    let in_space = surfaces.shapes.len() + curves.shapes.len();
    match (plane.len(), in_space) {
        (_, 0) => Ok(Model::Plane(plane)),
        (0, _) => Ok(Model::Space { surfaces, curves }),
        (in_plane, _) => {
            let what = format!("shapes in the plane: {in_plane}, in space: {in_space}");
            Err(Error::content(path, what, "put them into models of their own"))
        }
    }
}
