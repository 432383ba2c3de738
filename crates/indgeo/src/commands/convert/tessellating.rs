//! NURBS as triangles and polylines, for programs that know neither.

use crate::error::Error;
use industrial_geometry::io::{Model, Shape};
use industrial_geometry::mesh::nalgebra::{Point3, SVector, Vector3};
use industrial_geometry::mesh::{Attributes, PointCloud, TriangleMesh};
use industrial_geometry::nurbs::{BsplineCurve, TessellationOptions};
use std::path::Path;

/// Chord tolerance where none is given, as a share of the diagonal of the box around all shapes.
const DEFAULT_CHORD: f64 = 1e-3;
/// Share of the size up to which the ends of a curve count as one point.
const SAME: f64 = 1e-12;

/// Shapes as triangles and polylines within a chord tolerance.
#[derive(Debug)]
pub(crate) struct Tessellated {
    /// The surfaces.
    pub(crate) mesh: Option<TriangleMesh>,
    /// The curves; those that are closed end with their first vertex.
    pub(crate) polylines: Vec<Vec<[f64; 3]>>,
    /// Largest distance of the shapes from their chords and triangles.
    pub(crate) chord: f64,
}

/// Tessellates the shapes of the file at `path`.
pub(crate) fn tessellate(model: &Model, chord: Option<f64>, path: &Path) -> Result<Tessellated, Error> {
    let chord = chord.unwrap_or_else(|| DEFAULT_CHORD * size(model));
    if !(chord > 0.0 && chord.is_finite()) {
        let what = "the shapes have no extent from which a chord tolerance would follow";
        return Err(Error::content(path, what, "give one: --chord T"));
    }
    let options = TessellationOptions::new(chord);
    let failed = |error: industrial_geometry::nurbs::Error| {
        Error::content(path, error.to_string(), "choose another --chord")
    };
    let (mut vertices, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    let mut polylines = Vec::new();
    for (index, shape) in model.shapes().iter().enumerate() {
        match shape {
            Shape::Surface(surface) => {
                let found = match model.trim(index) {
                    Some(trim) => surface.tessellate_trimmed(trim, &options),
                    None => surface.tessellate(&options),
                };
                let found = found.map_err(failed)?;
                let first = u32::try_from(vertices.len()).ok();
                let end = u32::try_from(vertices.len() + found.vertices.len());
                let Some(first) = first.filter(|_| end.is_ok()) else {
                    let what = "the tessellation has more vertices than a mesh can hold";
                    return Err(Error::content(path, what, "choose a larger --chord"));
                };
                vertices.extend(found.vertices.into_iter().map(Point3::from));
                normals.extend(found.normals);
                triangles.extend(found.triangles.into_iter().map(|corners| corners.map(|k| first + k)));
            }
            Shape::Curve2(curve) => polylines.push(polyline(curve, &options).map_err(failed)?),
            Shape::Curve3(curve) => polylines.push(polyline(curve, &options).map_err(failed)?),
        }
    }
    let mesh = if vertices.is_empty() { None } else { Some(mesh(vertices, normals, triangles, path)?) };
    Ok(Tessellated { mesh, polylines, chord })
}

fn mesh(
    vertices: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    triangles: Vec<[u32; 3]>,
    path: &Path,
) -> Result<TriangleMesh, Error> {
    let failed = |error: industrial_geometry::mesh::Error| {
        Error::content(path, error.to_string(), "check it with `indgeo info`")
    };
    let mut attributes = Attributes::default();
    attributes.set_normals(Some(normals));
    let cloud = PointCloud::new(vertices).with_attributes(attributes).map_err(failed)?;
    TriangleMesh::from_cloud(cloud, triangles).map_err(failed)
}

fn polyline<const D: usize>(
    curve: &BsplineCurve<D>,
    options: &TessellationOptions,
) -> Result<Vec<[f64; 3]>, industrial_geometry::nurbs::Error> {
    let mut points = curve.tessellate(options)?.points;
    if let [first, .., last] = &mut points[..] {
        let hull = curve.control_box();
        if (*first - *last).norm() <= SAME * (hull.diagonal() + hull.centre().amax()) {
            *last = *first;
        }
    }
    let in_space = |point: SVector<f64, D>| {
        let mut out = [0.0; 3];
        out.iter_mut().zip(point.iter()).for_each(|(to, from)| *to = *from);
        out
    };
    Ok(points.into_iter().map(in_space).collect())
}

/// Diagonal of the box around the control points of all shapes.
fn size(model: &Model) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut take = |point: &[f64]| {
        for (axis, value) in point.iter().enumerate() {
            low[axis] = low[axis].min(*value);
            high[axis] = high[axis].max(*value);
        }
    };
    for shape in model.shapes() {
        match shape {
            Shape::Surface(surface) => surface.control_points().iter().for_each(|p| take(p.as_slice())),
            Shape::Curve2(curve) => curve.control_points().iter().for_each(|p| take(p.as_slice())),
            Shape::Curve3(curve) => curve.control_points().iter().for_each(|p| take(p.as_slice())),
        }
    }
    let side = |axis: usize| (high[axis] - low[axis]).max(0.0);
    side(0).hypot(side(1)).hypot(side(2))
}
