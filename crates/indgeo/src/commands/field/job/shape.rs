//! Shapes whose distance is asked for.

use super::MARGIN;
use crate::commands::contour::job::plane::of_source;
use crate::error::Error;
use crate::input::image_or_grid::refused;
use industrial_geometry::distance_field::grid::{Element, Inside, Outline};
use industrial_geometry::distance_field::{Error as FieldError, LevelSetField};
use industrial_geometry::footpoint::{
    CurveProjector, ProjectionOptions, Status, SurfaceProjector, no_progress,
};
use industrial_geometry::io::{Content, Shape as NurbsShape};
use industrial_geometry::level_set::Image;
use industrial_geometry::mesh::nalgebra::{Point, Point3, SVector, Vector2, Vector3};
use industrial_geometry::mesh::{CloudIndex, MeshProjector, TriangleMesh};
use industrial_geometry::nurbs::{BsplineCurve, BsplineSurface, ParametricCurve, TessellationOptions};
use std::path::Path;

/// Chord tolerance of the elements that stand for curves and for surfaces, in cells.
const CHORD: f64 = 1e-3;
const CHORD_OF_SURFACES: f64 = 1e-2;
/// Chord tolerance of the outline that decides what is inside of curves, in their size.
const OUTLINE: f64 = 1e-6;
/// Largest distance of curves from the contours of an image, in pixels.
const CONTOUR: f64 = 0.02;
/// Share of the size up to which the ends of a curve are one point.
const CLOSED: f64 = 1e-9;

/// What a field is made of.
pub(super) trait Shape<const D: usize> {
    /// The box around it, with some room; `None` without extent.
    fn bounds(&self) -> Option<(SVector<f64, D>, SVector<f64, D>)>;

    /// The distances of some points, and whether each is proven; negative inside, if they are to be signed.
    fn distances(&self, points: &[SVector<f64, D>], signed: bool) -> Result<Vec<(f64, bool)>, Error>;

    /// Points, segments and triangles in its place for cells of this size, and how far the shape is from them at most.
    fn elements(&self, cell: f64, path: &Path) -> Result<(Vec<Element<D>>, Option<f64>), Error>;

    /// Which of some points are inside.
    fn inside(&self, points: &[SVector<f64, D>]) -> Result<Vec<bool>, Error>;
}

/// A shape by the space it lies in.
pub(super) enum Sides {
    Plane(PlaneShape),
    Space(SpaceShape),
}

/// A shape in the plane.
pub(super) enum PlaneShape {
    Points(Vec<Vector2<f64>>, CloudIndex<2>),
    Curves(Vec<BsplineCurve<2>>, Box<CurveProjector<2>>, Outline),
    /// The contours of an image, the level function that tells what is inside, and the size of the image.
    Image {
        curves: Vec<BsplineCurve<2>>,
        projector: Box<CurveProjector<2>>,
        level: Box<LevelSetField<2>>,
        size: Vector2<f64>,
    },
}

/// A shape in space.
pub(super) enum SpaceShape {
    Points(Vec<Vector3<f64>>, CloudIndex<3>),
    Mesh { mesh: TriangleMesh, closest: Closest },
    Nurbs { surfaces: Vec<BsplineSurface>, curves: Vec<BsplineCurve<3>>, projectors: Box<Projectors> },
}

/// Closest points of a mesh.
pub(super) enum Closest {
    /// Without a sign.
    Plain(Box<MeshProjector>),
    /// Negative inside.
    Signed(Box<Inside>),
}

impl Closest {
    pub(super) fn projector(&self) -> &MeshProjector {
        match self {
            Self::Plain(projector) => projector,
            Self::Signed(inside) => inside.projector(),
        }
    }
}

/// Projectors of surfaces and of curves.
pub(super) struct Projectors {
    surfaces: Option<SurfaceProjector>,
    curves: Option<CurveProjector<3>>,
}

/// Prepares what a file holds.
pub(super) fn of_content(content: Content, path: &Path, signed: bool) -> Result<Sides, Error> {
    let fail = |what: String| Error::content(path, what, "check it with `indgeo info`");
    match content {
        Content::Cloud(_) if signed => Err(Error::content(
            path,
            "points have no inside",
            "leave out --signed, or give a mesh or closed curves",
        )),
        Content::Cloud(cloud) => {
            let finite = |p: &&Point3<f64>| p.iter().all(|c| c.is_finite());
            let points: Vec<Vector3<f64>> =
                cloud.positions().iter().filter(finite).map(|p| p.coords).collect();
            if points.is_empty() {
                return Err(fail("there are no points with finite coordinates in this file".to_owned()));
            }
            Ok(if cloud.dimension() == 2 {
                let points: Vec<Vector2<f64>> = points.iter().map(|p| p.xy()).collect();
                let index = index(&points).map_err(fail)?;
                Sides::Plane(PlaneShape::Points(points, index))
            } else {
                let index = index(&points).map_err(fail)?;
                Sides::Space(SpaceShape::Points(points, index))
            })
        }
        Content::Mesh(mesh) => {
            let closest = if signed {
                let inside = Inside::new(&mesh).map_err(|error| match error {
                    FieldError::NoInside { .. } => Error::content(
                        path,
                        error.to_string(),
                        "leave out --signed, or give a mesh of a body",
                    ),
                    _ => fail(error.to_string()),
                })?;
                Closest::Signed(Box::new(inside))
            } else {
                let projector = MeshProjector::new(&mesh).map_err(|error| fail(error.to_string()))?;
                Closest::Plain(Box::new(projector))
            };
            Ok(Sides::Space(SpaceShape::Mesh { mesh, closest }))
        }
        Content::Nurbs(model) => of_shapes(model.into_shapes(), path, signed),
    }
}

/// The contours of an image at the level of Otsu as curves, and how far these are from the level set at most.
pub(super) fn of_image(image: &Image, path: &Path) -> Result<(PlaneShape, f64), Error> {
    let (field, fitted) = of_source(image, CONTOUR).map_err(|error| refused(path, &error))?;
    let gap = fitted.iter().map(|contour| contour.forth.max(contour.back)).fold(0.0, f64::max);
    let curves: Vec<BsplineCurve<2>> = fitted.into_iter().map(|contour| contour.curve).collect();
    let model = |source| Error::Model { path: path.to_path_buf(), source };
    let projector = Box::new(CurveProjector::for_model(&curves).map_err(model)?);
    let size = Vector2::new(image.width() as f64, image.height() as f64);
    Ok((PlaneShape::Image { curves, projector, level: Box::new(field), size }, gap))
}

fn index<const D: usize>(points: &[SVector<f64, D>]) -> Result<CloudIndex<D>, String> {
    let points: Vec<Point<f64, D>> = points.iter().copied().map(Point::from).collect();
    CloudIndex::new(&points).map_err(|error| error.to_string())
}

fn of_shapes(shapes: Vec<NurbsShape>, path: &Path, signed: bool) -> Result<Sides, Error> {
    let model = |source| Error::Model { path: path.to_path_buf(), source };
    let (mut plane, mut curves, mut surfaces) = (Vec::new(), Vec::new(), Vec::new());
    for shape in shapes {
        match shape {
            NurbsShape::Curve2(curve) => plane.push(curve),
            NurbsShape::Curve3(curve) => curves.push(curve),
            NurbsShape::Surface(surface) => surfaces.push(surface),
        }
    }
    if !plane.is_empty() && curves.len() + surfaces.len() > 0 {
        return Err(Error::content(
            path,
            "the model has shapes in the plane and in space",
            "put them into files of their own",
        ));
    }
    if !plane.is_empty() {
        let projector = CurveProjector::for_model(&plane).map_err(model)?;
        let outline = if signed { outline(&plane, path)? } else { Outline::new(Vec::new()) };
        return Ok(Sides::Plane(PlaneShape::Curves(plane, Box::new(projector), outline)));
    }
    if signed && surfaces.is_empty() {
        return Err(Error::content(path, "curves in space have no inside", "leave out --signed"));
    }
    let some = |is_empty: bool| (!is_empty).then_some(());
    let projectors = Projectors {
        surfaces: some(surfaces.is_empty())
            .map(|()| SurfaceProjector::for_model(&surfaces))
            .transpose()
            .map_err(model)?,
        curves: some(curves.is_empty())
            .map(|()| CurveProjector::for_model(&curves))
            .transpose()
            .map_err(model)?,
    };
    Ok(Sides::Space(SpaceShape::Nurbs { surfaces, curves, projectors: Box::new(projectors) }))
}

/// The polygons of closed curves.
fn outline(curves: &[BsplineCurve<2>], path: &Path) -> Result<Outline, Error> {
    let mut polygons = Vec::with_capacity(curves.len());
    for (number, curve) in curves.iter().enumerate() {
        let size = curve.control_box().diagonal();
        let domain = curve.domain();
        if (curve.point(domain.start()) - curve.point(domain.end())).norm() > CLOSED * size {
            let what = format!("curve {number} (from 0) is open and has no inside");
            return Err(Error::content(path, what, "leave out --signed, or close it"));
        }
        let points = curve.tessellate(&TessellationOptions::new(OUTLINE * size));
        polygons.push(points.map_err(|error| tessellation(&error, path))?.points);
    }
    Ok(Outline::new(polygons))
}

fn tessellation(error: &industrial_geometry::nurbs::Error, path: &Path) -> Error {
    Error::content(path, error.to_string(), "use --method exact, or a coarser --grid")
}

/// The box around some points, with some room.
fn grown<const D: usize>(
    points: impl Iterator<Item = SVector<f64, D>>,
) -> Option<(SVector<f64, D>, SVector<f64, D>)> {
    let ends = points.filter(|p| p.iter().all(|c| c.is_finite())).fold(None, |ends, p| match ends {
        None => Some((p, p)),
        Some((low, high)) => Some((SVector::inf(&low, &p), SVector::sup(&high, &p))),
    });
    let (low, high) = ends?;
    let room = SVector::repeat(MARGIN * (high - low).norm());
    (room[0] > 0.0 && room[0].is_finite()).then(|| (low - room, high + room))
}

fn is_proven(status: Status) -> bool {
    matches!(status, Status::Converged | Status::OnBoundary)
}

/// The distance with a sign, if it is to have one.
fn with_sign(distance: f64, is_inside: bool) -> f64 {
    if is_inside { -distance } else { distance }
}

impl PlaneShape {
    /// Whether a point is inside.
    fn holds(&self, x: &Vector2<f64>) -> bool {
        match self {
            Self::Points(..) => false,
            Self::Curves(_, _, outline) => outline.holds(x),
            Self::Image { level, .. } => level.value(x) < 0.0,
        }
    }
}

impl Shape<2> for PlaneShape {
    fn bounds(&self) -> Option<(Vector2<f64>, Vector2<f64>)> {
        match self {
            Self::Points(points, _) => grown(points.iter().copied()),
            Self::Curves(curves, ..) => {
                let boxes = curves.iter().map(|curve| curve.bounding_box(1e-6));
                grown(boxes.flat_map(|bounds| [bounds.min, bounds.max]))
            }
            Self::Image { size, .. } => Some((Vector2::zeros(), *size)),
        }
    }

    fn distances(&self, points: &[Vector2<f64>], signed: bool) -> Result<Vec<(f64, bool)>, Error> {
        match self {
            Self::Points(_, index) => Ok(nearest(index, points)),
            Self::Curves(_, projector, _) | Self::Image { projector, .. } => {
                let found = projector.project_many(points, &ProjectionOptions::default(), &no_progress);
                let found =
                    found.map_err(|error| Error::usage(error.to_string(), "see `indgeo field --help`"))?;
                let signed = |(foot, x): (_, &Vector2<f64>)| {
                    let foot: industrial_geometry::footpoint::CurveFootpoint<2> = foot;
                    (with_sign(foot.distance, signed && self.holds(x)), is_proven(foot.status))
                };
                Ok(found.into_iter().zip(points).map(signed).collect())
            }
        }
    }

    fn elements(&self, cell: f64, path: &Path) -> Result<(Vec<Element<2>>, Option<f64>), Error> {
        match self {
            Self::Points(points, _) => Ok((points.iter().copied().map(Element::Point).collect(), None)),
            Self::Curves(curves, ..) | Self::Image { curves, .. } => {
                Ok((segments(curves, CHORD * cell, path)?, Some(CHORD * cell)))
            }
        }
    }

    fn inside(&self, points: &[Vector2<f64>]) -> Result<Vec<bool>, Error> {
        Ok(points.iter().map(|x| self.holds(x)).collect())
    }
}

fn nearest<const D: usize>(index: &CloudIndex<D>, points: &[SVector<f64, D>]) -> Vec<(f64, bool)> {
    let queries: Vec<Point<f64, D>> = points.iter().copied().map(Point::from).collect();
    let found = index.nearest_many(&queries).into_iter();
    found.map(|found| found.map_or((f64::INFINITY, false), |near| (near.distance(), true))).collect()
}

fn segments<const D: usize>(
    curves: &[BsplineCurve<D>],
    chord: f64,
    path: &Path,
) -> Result<Vec<Element<D>>, Error> {
    let mut out = Vec::new();
    for curve in curves {
        let points =
            curve.tessellate(&TessellationOptions::new(chord)).map_err(|error| tessellation(&error, path))?;
        out.extend(points.points.windows(2).map(|pair| Element::Segment([pair[0], pair[1]])));
    }
    Ok(out)
}

impl Shape<3> for SpaceShape {
    fn bounds(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        match self {
            Self::Points(points, _) => grown(points.iter().copied()),
            Self::Mesh { mesh, .. } => grown(mesh.vertices().iter().map(|p| p.coords)),
            Self::Nurbs { surfaces, curves, .. } => {
                let surfaces = surfaces.iter().map(|surface| surface.bounding_box(1e-6));
                let curves = curves.iter().map(|curve| curve.bounding_box(1e-6));
                grown(surfaces.chain(curves).flat_map(|bounds| [bounds.min, bounds.max]))
            }
        }
    }

    fn distances(&self, points: &[Vector3<f64>], signed: bool) -> Result<Vec<(f64, bool)>, Error> {
        match self {
            Self::Points(_, index) => Ok(nearest(index, points)),
            Self::Mesh { closest, .. } => {
                let queries: Vec<Point3<f64>> = points.iter().copied().map(Point3::from).collect();
                Ok(closest.projector().map_feet(&queries, |i, found| match (found, closest) {
                    (Err(_), _) => (f64::INFINITY, false),
                    (Ok(foot), Closest::Signed(inside)) if signed => (inside.signed(&points[i], &foot), true),
                    (Ok(foot), _) => (foot.distance, true),
                }))
            }
            Self::Nurbs { projectors, .. } => {
                let options = ProjectionOptions::default();
                let fail = |error: industrial_geometry::footpoint::Error| {
                    Error::usage(error.to_string(), "see `indgeo field --help`")
                };
                let mut out = vec![(f64::INFINITY, false); points.len()];
                let take = |to: &mut (f64, bool), distance: f64, is_proven: bool| {
                    if distance.abs() < to.0.abs() {
                        *to = (distance, is_proven);
                    }
                };
                if let Some(projector) = &projectors.surfaces {
                    let found = projector.project_many(points, &options, &no_progress).map_err(fail)?;
                    for (to, foot) in out.iter_mut().zip(&found) {
                        // The normal points out of the material.
                        let distance = if signed { foot.signed_distance } else { foot.distance };
                        take(to, distance, is_proven(foot.status));
                    }
                }
                if let Some(projector) = &projectors.curves {
                    let found = projector.project_many(points, &options, &no_progress).map_err(fail)?;
                    for (to, foot) in out.iter_mut().zip(&found) {
                        take(to, foot.distance, is_proven(foot.status));
                    }
                }
                Ok(out)
            }
        }
    }

    fn elements(&self, cell: f64, path: &Path) -> Result<(Vec<Element<3>>, Option<f64>), Error> {
        match self {
            Self::Points(points, _) => Ok((points.iter().copied().map(Element::Point).collect(), None)),
            Self::Mesh { mesh, .. } => {
                let corners = |triangle: &[u32; 3]| triangle.map(|k| mesh.vertices()[k as usize].coords);
                let triangles = mesh.triangles().iter().map(|triangle| Element::Triangle(corners(triangle)));
                Ok((triangles.filter(Element::is_finite).collect(), None))
            }
            Self::Nurbs { surfaces, curves, .. } => {
                let mut out = segments(curves, CHORD * cell, path)?;
                let chord = if surfaces.is_empty() { CHORD } else { CHORD_OF_SURFACES } * cell;
                for surface in surfaces {
                    let found = surface.tessellate(&TessellationOptions::new(chord));
                    let found = found.map_err(|error| tessellation(&error, path))?;
                    let corners = |triangle: &[u32; 3]| triangle.map(|k| found.vertices[k as usize]);
                    out.extend(found.triangles.iter().map(|triangle| Element::Triangle(corners(triangle))));
                }
                Ok((out, Some(chord)))
            }
        }
    }

    fn inside(&self, points: &[Vector3<f64>]) -> Result<Vec<bool>, Error> {
        Ok(self.distances(points, true)?.into_iter().map(|(distance, _)| distance < 0.0).collect())
    }
}
