//! Triangles that show the nominal shape. Nothing is measured on them.

use mesh_core::{BoundingBox, TriangleMesh};
use nalgebra::{Point3, Vector3};
use nurbs_core::{BsplineSurface, TessellationOptions};
use std::collections::HashMap;

/// Chord tolerance as a share of the size of a surface.
const FINE: f64 = 2e-4;
/// Most vertices of all surfaces, and of a mesh before it is thinned.
const MOST: usize = 200_000;
/// Cells along the longest side of a mesh that is thinned.
const CELLS: f64 = 250.0;

/// Triangles with normals at their corners, and lines along edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Backdrop {
    /// Vertices.
    pub vertices: Vec<Point3<f64>>,
    /// Unit normals of the vertices.
    pub normals: Vec<Vector3<f64>>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Lines where faces of a CAD model end.
    pub lines: Vec<Vec<Point3<f64>>>,
}

impl Backdrop {
    /// Triangles near the surfaces. A surface that cannot be shown is left out.
    pub(crate) fn of_surfaces(surfaces: &[BsplineSurface]) -> Self {
        let mut out = Self::default();
        for surface in surfaces {
            let most = MOST / surfaces.len().max(1);
            let mut tolerance = FINE * surface.control_box().diagonal();
            for _ in 0..12 {
                let options = TessellationOptions::new(tolerance).with_max_vertices(most.max(4));
                if let Ok(found) = surface.tessellate(&options) {
                    let vertices = found.vertices.into_iter().map(Point3::from);
                    out.append(vertices.collect(), found.normals, &found.triangles);
                    break;
                }
                tolerance *= 2.0;
            }
        }
        out
    }

    /// Triangles near the faces of a CAD model.
    pub(crate) fn of_brep(model: &brep_core::Model) -> Self {
        let picture = model.picture(FINE * model.bounds().diagonal());
        let mut out = Self::default();
        let (vertices, normals) = picture.vertices.iter().map(|v| (Point3::from(v.point), v.normal)).unzip();
        out.append(vertices, normals, &picture.triangles);
        out.lines =
            picture.lines.into_iter().map(|line| line.into_iter().map(Point3::from).collect()).collect();
        out
    }

    /// The triangles of a mesh; of a large one with its vertices pulled together in cells.
    pub(crate) fn of_mesh(mesh: &TriangleMesh) -> Self {
        let (mut vertices, mut triangles) = (mesh.vertices().to_vec(), mesh.triangles().to_vec());
        if vertices.len() > MOST
            && let Some(bounds) = mesh.bounding_box()
        {
            (vertices, triangles) = pulled_together(&vertices, &triangles, &bounds);
        }
        let finite = |vertex: u32| vertices[vertex as usize].iter().all(|value| value.is_finite());
        triangles.retain(|corners| corners.iter().all(|&corner| finite(corner)));
        let mut sums = vec![Vector3::zeros(); vertices.len()];
        for corners in &triangles {
            let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
            let normal = (b - a).cross(&(c - a));
            corners.iter().for_each(|&corner| sums[corner as usize] += normal);
        }
        let normals = sums.iter().map(|sum| sum.try_normalize(0.0).unwrap_or_default()).collect();
        let mut out = Self::default();
        out.append(vertices, normals, &triangles);
        out
    }

    /// A strip of the given half width along points with tangents. Its sides lie in the plane of x and y as far as the tangents
    /// do.
    pub(crate) fn append_ribbon(&mut self, rail: &[[Vector3<f64>; 2]], half: f64) {
        let (mut vertices, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for [point, tangent] in rail {
            let across = Vector3::new(-tangent.y, tangent.x, 0.0);
            let side = across.try_normalize(1e-9 * tangent.norm()).unwrap_or_else(Vector3::x);
            let normal = tangent.cross(&side).try_normalize(0.0).unwrap_or_else(Vector3::z);
            for sign in [half, -half] {
                vertices.push(Point3::from(point + side * sign));
                normals.push(normal);
            }
        }
        for k in (0u32..).step_by(2).take(rail.len().saturating_sub(1)) {
            triangles.extend([[k, k + 1, k + 2], [k + 1, k + 3, k + 2]]);
        }
        self.append(vertices, normals, &triangles);
    }

    fn append(&mut self, vertices: Vec<Point3<f64>>, normals: Vec<Vector3<f64>>, triangles: &[[u32; 3]]) {
        let Ok(first) = u32::try_from(self.vertices.len()) else { return };
        self.vertices.extend(vertices);
        self.normals.extend(normals);
        self.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| corner + first)));
    }
}

/// One vertex per cell, the first one met, and the triangles that are left.
fn pulled_together(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    bounds: &BoundingBox,
) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let scale = CELLS / bounds.extent().amax().max(f64::MIN_POSITIVE);
    #[expect(clippy::cast_possible_truncation, reason = "cells are few; NaN becomes 0")]
    let cell = |point: &Point3<f64>| [0, 1, 2].map(|axis| ((point[axis] - bounds.min[axis]) * scale) as i32);
    let mut kept = Vec::new();
    let mut numbers = HashMap::new();
    let mut number_of = |corner: u32| {
        let vertex = &vertices[corner as usize];
        *numbers.entry(cell(vertex)).or_insert_with(|| {
            kept.push(*vertex);
            u32::try_from(kept.len() - 1).unwrap_or(u32::MAX)
        })
    };
    let renamed: Vec<[u32; 3]> = triangles.iter().map(|corners| corners.map(&mut number_of)).collect();
    let apart = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    (kept, renamed.into_iter().filter(apart).collect())
}
