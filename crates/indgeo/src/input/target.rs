//! A model prepared for projection, and the footpoints on it in one form for all kinds of model.

use crate::error::Error;
use crate::input::cad::{self, CadModel};
use crate::input::field_model::LevelSet;
use crate::input::model::{Indexed, Model};
use crate::input::points::Points;
use crate::runtime::threads;
use industrial_geometry::brep::{self, On};
use industrial_geometry::distance_field::{DistanceField, Hint, PrincipalFrame, Search};
use industrial_geometry::footpoint::Facing;
use industrial_geometry::footpoint::{
    self, CurveFootpoint, CurveProjector, Location, Mode, Multiplicity, ProjectionOptions, Status,
    SurfaceFootpoint, SurfaceProjector,
};
use industrial_geometry::mesh::nalgebra::{Point3, SVector, Vector3};
use industrial_geometry::mesh::{self, Feature, MeshFootpoint, MeshProjector};
use std::ops::ControlFlow;
use std::path::Path;

/// Told the number of points done and the total; a break cancels what is left.
pub(crate) type Progress<'a> = &'a (dyn Fn(usize, usize) -> ControlFlow<()> + Sync);

/// A footpoint on any model. Numbers are NaN where nothing was computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Foot {
    /// The closest point; z = 0 in the plane.
    pub(crate) point: [f64; 3],
    /// Distance, with a sign where the model gives one.
    pub(crate) distance: f64,
    /// No point of the model is nearer than this; NaN where nothing was certified.
    pub(crate) lower_bound: f64,
    /// Parameters `u, v` on a surface, `t` and NaN on a curve, NaN on a mesh.
    pub(crate) parameter: [f64; 2],
    /// Index of the curve or surface in the file, 0 on a mesh.
    pub(crate) shape: u32,
    /// Index of the triangle on a mesh.
    pub(crate) triangle: u32,
    /// How the projection ended.
    pub(crate) status: Status,
    /// Where on the shape the point lies.
    pub(crate) location: &'static str,
    /// Whether others are as near.
    pub(crate) multiplicity: Multiplicity,
    /// Number in the file of the face or edge of a CAD model that holds the foot.
    pub(crate) entity: u32,
    /// Side of a CAD model: `outside`, `inside` or `undecided`; `none` on others.
    pub(crate) side: &'static str,
}

impl Foot {
    /// Nothing was computed, for the reason given.
    pub(crate) fn none(status: Status) -> Self {
        Self {
            point: [f64::NAN; 3],
            distance: f64::NAN,
            lower_bound: f64::NAN,
            parameter: [f64::NAN; 2],
            shape: u32::MAX,
            triangle: u32::MAX,
            status,
            location: "none",
            multiplicity: Multiplicity::Unknown,
            entity: u32::MAX,
            side: "none",
        }
    }

    /// How much nearer another point could be at most; NaN where nothing was certified.
    pub(crate) fn gap(&self) -> f64 {
        self.distance.abs() - self.lower_bound
    }

    /// Whether there is a footpoint.
    pub(crate) fn exists(&self) -> bool {
        !self.distance.is_nan()
    }
}

/// A projector, and the index in the file of each of its shapes.
type Indices<P> = Box<(P, Vec<u32>)>;

/// A model prepared for queries.
#[derive(Debug)]
pub(crate) enum Target {
    /// Curves in the plane.
    Plane(Box<CurveProjector<2>>),
    /// Curves and surfaces in space, with their indices in the file.
    Space { surfaces: Option<Indices<SurfaceProjector>>, curves: Option<Indices<CurveProjector<3>>> },
    /// A triangle mesh.
    Mesh(Box<MeshProjector>),
    /// A CAD model.
    Cad(Box<CadModel>),
    /// The level set 0 of values on a grid.
    LevelSet(LevelSet),
}

impl Target {
    /// Prepares a model; `path` is named in errors.
    pub(crate) fn build(model: Model, path: &Path) -> Result<Self, Error> {
        let model_error = |source| Error::Model { path: path.to_path_buf(), source };
        Ok(match model {
            Model::Plane(curves) => {
                Self::Plane(Box::new(CurveProjector::for_model(&curves).map_err(model_error)?))
            }
            Model::Space { surfaces, curves } => Self::Space {
                surfaces: prepare(surfaces, SurfaceProjector::for_model).map_err(model_error)?,
                curves: prepare(curves, CurveProjector::for_model).map_err(model_error)?,
            },
            Model::Mesh(mesh) => {
                let mesh_error = |source| Error::Mesh { path: path.to_path_buf(), source };
                Self::Mesh(Box::new(MeshProjector::new(&mesh).map_err(mesh_error)?))
            }
            Model::Cad(cad) => Self::Cad(Box::new(cad)),
            Model::LevelSet(field) => Self::LevelSet(field),
        })
    }

    /// Whether it lies in the plane, and takes points of two columns.
    pub(crate) fn is_planar(&self) -> bool {
        matches!(self, Self::Plane(_) | Self::LevelSet(LevelSet::Plane(_)))
    }

    /// Number of Bézier pieces, faces, triangles or crossings of grid lines that are searched.
    pub(crate) fn piece_count(&self) -> usize {
        match self {
            Self::Plane(curves) => curves.piece_count(),
            Self::Space { surfaces, curves } => {
                surfaces.as_ref().map_or(0, |surfaces| surfaces.0.patch_count())
                    + curves.as_ref().map_or(0, |curves| curves.0.piece_count())
            }
            Self::Mesh(mesh) => mesh.topology().triangles - mesh.skipped(),
            Self::Cad(cad) => cad.face_count(),
            Self::LevelSet(LevelSet::Plane(field)) => field.crossings().len(),
            Self::LevelSet(LevelSet::Space(field)) => field.crossings().len(),
        }
    }

    /// Makes sure that the model has normals, with which those of the points can agree.
    pub(crate) fn check_normals(&self, path: &Path) -> Result<(), Error> {
        let what = match self {
            Self::Space { curves: None, .. } | Self::Cad(_) => return Ok(()),
            Self::Mesh(mesh) if mesh.topology().is_oriented() => return Ok(()),
            Self::Mesh(_) => "neighbouring triangles disagree on the side of their normals",
            Self::Plane(_) | Self::Space { .. } => "the model has curves, which have no normals",
            Self::LevelSet(_) => "on a level set only the nearest feet are looked for",
        };
        Err(Error::content(
            path,
            what,
            "leave out --max-angle, or give a model of surfaces or an oriented mesh",
        ))
    }

    /// Projects all points; `path` is the file they came from. With an angle, in radians, only feet count whose normals are
    /// within it of those of the points.
    pub(crate) fn project(
        &self,
        points: &Points,
        path: &Path,
        options: &ProjectionOptions,
        max_angle: Option<f64>,
        progress: Progress<'_>,
    ) -> Result<Vec<Foot>, Error> {
        let feet = self.search(points, path, options, max_angle, progress)?;
        // Without a proof the bound of the library is 0, which says nothing.
        let is_proven = match self {
            Self::Mesh(_) | Self::Cad(_) => true,
            Self::LevelSet(_) => false,
            Self::Plane(_) | Self::Space { .. } => options.mode == Mode::Certified,
        };
        let unproven = |foot: Foot| Foot { lower_bound: f64::NAN, ..foot };
        Ok(if is_proven { feet } else { feet.into_iter().map(unproven).collect() })
    }

    fn search(
        &self,
        points: &Points,
        path: &Path,
        options: &ProjectionOptions,
        max_angle: Option<f64>,
        progress: Progress<'_>,
    ) -> Result<Vec<Foot>, Error> {
        let invalid = |source: footpoint::Error| Error::usage(source.to_string(), "choose another value");
        let normals = points.normals.as_deref().zip(max_angle);
        match self {
            Self::Plane(curves) => {
                let queries = points.in_plane(path)?;
                let found = curves.project_many(&queries, options, progress).map_err(invalid)?;
                drop(queries);
                Ok(found.iter().map(|foot| curve_foot(foot, u32_index(foot.shape))).collect())
            }
            Self::Space { surfaces, curves } => {
                let queries = points.in_space(path)?;
                let on_surfaces = surfaces.as_deref().map(|(projector, indices)| {
                    let mut found = projector.project_many(&queries, options, progress).map_err(invalid)?;
                    if let Some((normals, angle)) = normals {
                        let restricted = |i: &usize| -> SurfaceFootpoint {
                            let (nearest, facing) = (&found[*i], Facing::new(&normals[*i], angle));
                            match facing {
                                Ok(facing) => projector.facing_foot(&queries[*i], nearest, &facing, options),
                                Err(_) => no_normal(nearest),
                            }
                        };
                        let indices: Vec<usize> = (0..queries.len()).collect();
                        let go_on = |_: usize, _: usize| ControlFlow::Continue(());
                        if let Some(first) = found.first() {
                            found = threads::map(&indices, first, &go_on, restricted);
                        }
                    }
                    Ok::<_, Error>(found.iter().map(|foot| surface_foot(foot, indices)).collect::<Vec<_>>())
                });
                let on_curves = curves.as_deref().map(|(projector, indices)| {
                    let found = projector.project_many(&queries, options, progress).map_err(invalid)?;
                    let index =
                        |foot: &CurveFootpoint<3>| indices.get(foot.shape).copied().unwrap_or(u32::MAX);
                    Ok::<_, Error>(found.iter().map(|foot| curve_foot(foot, index(foot))).collect::<Vec<_>>())
                });
                Ok(match (on_surfaces.transpose()?, on_curves.transpose()?) {
                    (Some(surfaces), Some(curves)) => {
                        let pairs = surfaces.into_iter().zip(curves);
                        pairs.map(|(a, b)| nearer(a, b, options)).collect()
                    }
                    (Some(feet), None) | (None, Some(feet)) => feet,
                    (None, None) => Vec::new(),
                })
            }
            Self::LevelSet(LevelSet::Plane(field)) => {
                let queries = points.in_plane(path)?;
                let is_proof_wanted = options.mode == Mode::Certified;
                let cancelled = Foot::none(Status::Cancelled);
                Ok(threads::map(&queries, &cancelled, progress, |x| {
                    level_foot(x, &field.frame(x, Search::Global, &Hint::NONE), is_proof_wanted)
                }))
            }
            Self::LevelSet(LevelSet::Space(field)) => {
                let queries = points.in_space(path)?;
                let is_proof_wanted = options.mode == Mode::Certified;
                let cancelled = Foot::none(Status::Cancelled);
                Ok(threads::map(&queries, &cancelled, progress, |x| {
                    level_foot(x, &field.frame(x, Search::Global, &Hint::NONE), is_proof_wanted)
                }))
            }
            Self::Cad(cad) => {
                points.in_space(path)?;
                let cancelled = Foot::none(Status::Cancelled);
                if let Some((normals, angle)) = normals {
                    let pairs: Vec<_> = points.positions.iter().zip(normals).collect();
                    return Ok(threads::map(&pairs, &cancelled, progress, |(x, normal)| {
                        facing_cad_foot(cad, x, normal, angle)
                    }));
                }
                Ok(threads::map(&points.positions, &cancelled, progress, |x| {
                    cad_foot(cad, x, cad.model.nearest(&x.coords))
                }))
            }
            Self::Mesh(mesh) => {
                points.in_space(path)?;
                let cancelled = Foot::none(Status::Cancelled);
                if let Some((normals, angle)) = normals {
                    let pairs: Vec<_> = points.positions.iter().zip(normals).collect();
                    return Ok(threads::map(&pairs, &cancelled, progress, |(x, normal)| {
                        facing_mesh_foot(mesh, x, normal, angle)
                    }));
                }
                Ok(threads::map(&points.positions, &cancelled, progress, |x| mesh_foot(mesh, x)))
            }
        }
    }
}

fn prepare<T, P, E>(
    shapes: Indexed<T>,
    build: impl Fn(&[T]) -> Result<P, E>,
) -> Result<Option<Indices<P>>, E> {
    if shapes.shapes.is_empty() {
        return Ok(None);
    }
    Ok(Some(Box::new((build(&shapes.shapes)?, shapes.indices))))
}

fn u32_index(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

fn place(location: Location) -> &'static str {
    match location {
        Location::Interior => "interior",
        Location::Edge => "edge",
        Location::Corner => "corner",
        Location::Seam => "seam",
        Location::Pole => "pole",
    }
}

fn surface_foot(foot: &SurfaceFootpoint, indices: &[u32]) -> Foot {
    if foot.distance.is_nan() {
        return Foot::none(foot.status);
    }
    Foot {
        point: foot.point.into(),
        distance: foot.signed_distance,
        lower_bound: foot.lower_bound,
        parameter: foot.parameter,
        shape: indices.get(foot.shape).copied().unwrap_or(u32::MAX),
        triangle: u32::MAX,
        status: foot.status,
        location: place(foot.location),
        multiplicity: foot.multiplicity,
        entity: u32::MAX,
        side: "none",
    }
}

fn curve_foot<const D: usize>(foot: &CurveFootpoint<D>, shape: u32) -> Foot {
    if foot.distance.is_nan() {
        return Foot::none(foot.status);
    }
    let mut point = [0.0; 3];
    for (to, from) in point.iter_mut().zip(foot.point.iter()) {
        *to = *from;
    }
    Foot {
        point,
        distance: foot.distance,
        lower_bound: foot.lower_bound,
        parameter: [foot.parameter, f64::NAN],
        shape,
        triangle: u32::MAX,
        status: foot.status,
        location: place(foot.location),
        multiplicity: foot.multiplicity,
        entity: u32::MAX,
        side: "none",
    }
}

/// The foot on a level set, found from the crossing of a grid line next to the point: there is no proof that none is nearer.
fn level_foot<const D: usize>(x: &SVector<f64, D>, frame: &PrincipalFrame<D>, is_proof_wanted: bool) -> Foot {
    if frame.distance.is_nan() {
        return Foot::none(frame.status);
    }
    let mut point = [0.0; 3];
    for (to, from) in point.iter_mut().zip(frame.foot.iter()) {
        *to = *from;
    }
    let status = match frame.status {
        Status::Converged | Status::OnBoundary if is_proof_wanted => Status::Uncertified,
        other => other,
    };
    Foot {
        point,
        // At the border of the grid the foot is not orthogonal.
        distance: (x - frame.foot).norm().copysign(frame.distance),
        status,
        location: if frame.on_boundary { "edge" } else { "interior" },
        ..Foot::none(status)
    }
}

/// The answer for a point without a normal, when that for any side is `nearest`.
fn no_normal(nearest: &SurfaceFootpoint) -> SurfaceFootpoint {
    let nan = f64::NAN;
    match nearest.status {
        Status::InvalidPoint | Status::Cancelled => *nearest,
        _ => SurfaceFootpoint { status: Status::NoNormal, distance: nan, signed_distance: nan, ..*nearest },
    }
}

fn facing_mesh_foot(mesh: &MeshProjector, x: &Point3<f64>, normal: &Vector3<f64>, angle: f64) -> Foot {
    match Facing::new(normal, angle) {
        Err(_) if x.coords.iter().all(|value| value.is_finite()) => Foot::none(Status::NoNormal),
        Err(_) => Foot::none(Status::InvalidPoint),
        Ok(facing) => match mesh.project_facing(x, facing.direction(), angle) {
            Ok(None) => Foot::none(Status::NoMatchingFoot),
            Ok(Some(found)) => of_mesh::<mesh::Error>(Ok(found.foot), x),
            Err(error) => of_mesh(Err(error), x),
        },
    }
}

/// Share of the diagonal of a CAD model up to which a gap counts as none.
const CAD_GAP: f64 = 1e-9;

/// Whether nothing is left open about a foot on a CAD model but the strips of the edges around it: those of the faces that hold it.
fn is_proven(cad: &CadModel, foot: &brep::Foot) -> bool {
    if foot.gap() <= CAD_GAP * cad.model.bounds().diagonal() {
        return true;
    }
    let Some(instance) = cad.model.instances().get(foot.instance) else { return false };
    let part = &cad.model.parts()[instance.part];
    let at_edge: Vec<usize> = match foot.on {
        On::Edge { edge, .. } | On::Vertex { edge, .. } => part.edges()[edge].faces().collect(),
        On::Face { .. } | On::Apex { .. } => Vec::new(),
    };
    let faces = at_edge.into_iter().chain(foot.face);
    let edges = faces.flat_map(|face| part.faces()[face].edges());
    let strip = edges.map(|&edge| 2.0 * part.edges()[edge].tolerance()).fold(0.0, f64::max);
    foot.gap() <= strip * instance.placement.scale
}

fn facing_cad_foot(cad: &CadModel, x: &Point3<f64>, normal: &Vector3<f64>, angle: f64) -> Foot {
    match Facing::new(normal, angle) {
        _ if !x.coords.iter().all(|value| value.is_finite()) => Foot::none(Status::InvalidPoint),
        Err(_) => Foot::none(Status::NoNormal),
        Ok(facing) => match cad.model.nearest_facing(&x.coords, &facing) {
            None => Foot::none(Status::NoMatchingFoot),
            found => cad_foot(cad, x, found),
        },
    }
}

fn cad_foot(cad: &CadModel, x: &Point3<f64>, found: Option<brep::Foot>) -> Foot {
    let Some(foot) = found else {
        // A finite point without a foot is too far away for its distance to be a number: no answer, and not no question.
        let is_point = x.coords.iter().all(|value| value.is_finite());
        return Foot::none(if is_point { Status::Diverged } else { Status::InvalidPoint });
    };
    let status = if !is_proven(cad, &foot) {
        Status::Uncertified
    } else if foot.beyond_boundary {
        Status::OnBoundary
    } else {
        Status::Converged
    };
    Foot {
        point: foot.point.into(),
        distance: foot.signed_distance().unwrap_or(foot.distance),
        lower_bound: foot.lower_bound,
        parameter: match foot.on {
            On::Face { uv, .. } => uv,
            _ => [f64::NAN; 2],
        },
        shape: cad.face_number(&foot).map_or(u32::MAX, u32_index),
        triangle: u32::MAX,
        status,
        location: cad::location(&foot),
        multiplicity: Multiplicity::Unknown,
        entity: cad.entity(&foot).and_then(|number| u32::try_from(number).ok()).unwrap_or(u32::MAX),
        side: match foot.side {
            brep::Side::Positive => "outside",
            brep::Side::Negative => "inside",
            // On the surface itself there is nothing to decide.
            brep::Side::Undecided if foot.distance == 0.0 => "none",
            brep::Side::Undecided => "undecided",
        },
    }
}

fn mesh_foot(mesh: &MeshProjector, x: &Point3<f64>) -> Foot {
    of_mesh(mesh.project(x), x)
}

fn of_mesh<E>(found: Result<MeshFootpoint, E>, x: &Point3<f64>) -> Foot {
    match found {
        Ok(foot) => Foot {
            point: foot.point.into(),
            distance: foot.signed_distance.unwrap_or(foot.distance),
            lower_bound: foot.distance,
            parameter: [f64::NAN; 2],
            shape: 0,
            triangle: u32_index(foot.triangle),
            status: Status::Converged,
            location: match foot.feature {
                Feature::Face => "face",
                Feature::Edge(_) => "triangle_edge",
                Feature::Vertex(_) => "vertex",
            },
            multiplicity: Multiplicity::Unknown,
            entity: u32::MAX,
            side: "none",
        },
        // The only other reason is a distance beyond the range of doubles.
        Err(_) if x.coords.iter().all(|value| value.is_finite()) => Foot::none(Status::Diverged),
        Err(_) => Foot::none(Status::InvalidPoint),
    }
}

/// The nearer of two footpoints, `a` where both are as near; the bound is the lower one, since either could still hide more.
fn nearer(a: Foot, b: Foot, options: &ProjectionOptions) -> Foot {
    let tie = options.tie_tolerance;
    if !a.exists() || !b.exists() {
        return if a.exists() { a } else { b };
    }
    let (first, second) = if b.distance.abs() < a.distance.abs() { (b, a) } else { (a, b) };
    let lower_bound = first.lower_bound.min(second.lower_bound);
    let is_tie = second.distance.abs() - first.distance.abs() <= tie * first.distance.abs()
        && (Vector3::from(first.point) - Vector3::from(second.point)).norm() > tie * first.distance.abs();
    let multiplicity = match first.multiplicity {
        Multiplicity::Unique if is_tie => Multiplicity::Tied,
        other => other,
    };
    let hidden = second.status == Status::Uncertified
        && lower_bound < first.distance.abs() * (1.0 - options.relative_gap)
        && lower_bound < first.lower_bound;
    let status = if hidden && first.status.is_converged() { Status::Uncertified } else { first.status };
    Foot { lower_bound, multiplicity, status, ..first }
}
