//! Normals at the corners of triangles: one for all triangles around a vertex between which there is no sharp edge.

use mesh_core::{HalfEdge, HalfEdgeMesh, TriangleMesh};
use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

/// Cosine of the angle between triangles from which their edge is sharp: 40 degrees.
const SHARP: f64 = 0.766;
/// Difference of unit normals up to which they are one.
const EQUAL: f64 = 1e-9;

/// A vertex of a mesh with the normal that it has in some of its triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wedge {
    /// The vertex.
    pub(crate) vertex: u32,
    /// The unit normal.
    pub(crate) normal: Vector3<f64>,
}

/// The wedges of a mesh, and for every corner of every triangle its wedge.
#[derive(Clone, Debug)]
pub(crate) struct Wedges {
    pub(crate) all: Vec<Wedge>,
    pub(crate) corners: Vec<[u32; 3]>,
}

impl Wedges {
    /// With the normals of the mesh where it has some, otherwise with the mean of the normals of the triangles of a wedge,
    /// weighted by their angles.
    pub(crate) fn of(mesh: &TriangleMesh, connectivity: &HalfEdgeMesh) -> Self {
        let normals = corner_normals(mesh, connectivity);
        let mut all: Vec<Wedge> = Vec::new();
        let mut of_vertex: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut corners = vec![[u32::MAX; 3]; connectivity.triangles().len()];
        for half_edge in connectivity.half_edges() {
            let (triangle, k) = (half_edge.triangle(), half_edge.edge());
            let (vertex, normal) = (connectivity.origin(half_edge), normals[triangle][k]);
            let known = of_vertex.entry(vertex).or_default();
            let found = known.iter().find(|&&wedge| (all[wedge as usize].normal - normal).norm() <= EQUAL);
            corners[triangle][k] = found.copied().unwrap_or_else(|| {
                let wedge = u32::try_from(all.len()).unwrap_or(u32::MAX);
                all.push(Wedge { vertex, normal });
                known.push(wedge);
                wedge
            });
        }
        Self { all, corners }
    }
}

/// Unit normals at the corners of the triangles.
fn corner_normals(mesh: &TriangleMesh, connectivity: &HalfEdgeMesh) -> Vec<[Vector3<f64>; 3]> {
    let points = mesh.vertices();
    let faces: Vec<Vector3<f64>> =
        connectivity.triangles().iter().map(|triangle| face_normal(points, triangle)).collect();
    if let Some(given) = mesh.attributes().normals() {
        // Corners refer to vertices as they were before those at one place became one.
        let unit = |index: u32, face: &Vector3<f64>| {
            let normal = given[index as usize];
            let largest = normal.amax();
            let scaled = normal / largest;
            if largest > 0.0 && largest.is_finite() { scaled.normalize() } else { *face }
        };
        let corner = |(triangle, face): (&[u32; 3], &Vector3<f64>)| triangle.map(|index| unit(index, face));
        return mesh.triangles().iter().zip(&faces).map(corner).collect();
    }
    let mut normals: Vec<[Vector3<f64>; 3]> = faces.iter().map(|face| [*face; 3]).collect();
    let vertices = u32::try_from(connectivity.vertex_count()).unwrap_or(u32::MAX);
    for vertex in 0..vertices {
        let spokes: Vec<HalfEdge> = connectivity.spokes(vertex).collect();
        smooth_fan(points, connectivity, &faces, &spokes, &mut normals);
    }
    normals
}

/// Sets the normals around one vertex.
fn smooth_fan(
    points: &[Point3<f64>],
    connectivity: &HalfEdgeMesh,
    faces: &[Vector3<f64>],
    spokes: &[HalfEdge],
    normals: &mut [[Vector3<f64>; 3]],
) {
    let count = spokes.len();
    let is_sharp = |i: usize| {
        // Between the triangle of this spoke and the one before.
        let before = connectivity.twin(spokes[i]).map(HalfEdge::triangle);
        before.is_none_or(|before| faces[before].dot(&faces[spokes[i].triangle()]) < SHARP)
    };
    let sharp: Vec<bool> = (0..count).map(is_sharp).collect();
    let first = sharp.iter().position(|sharp| *sharp).unwrap_or(0);
    let mut from = 0;
    while from < count {
        let mut to = from + 1;
        while to < count && !sharp[(first + to) % count] {
            to += 1;
        }
        let wedge = (from..to).map(|k| spokes[(first + k) % count]);
        let sum: Vector3<f64> = wedge
            .clone()
            .map(|spoke| faces[spoke.triangle()] * corner_angle(points, connectivity, spoke))
            .sum();
        let length = sum.norm();
        if length > 1e-12 {
            for spoke in wedge {
                normals[spoke.triangle()][spoke.edge()] = sum / length;
            }
        }
        from = to;
    }
}

fn corner_angle(points: &[Point3<f64>], connectivity: &HalfEdgeMesh, spoke: HalfEdge) -> f64 {
    let at = |vertex: u32| points[vertex as usize];
    let origin = at(connectivity.origin(spoke));
    let (one, other) =
        (at(connectivity.target(spoke)) - origin, at(connectivity.origin(spoke.previous())) - origin);
    one.cross(&other).norm().atan2(one.dot(&other))
}

/// The unit normal of a triangle; 0 without an area.
fn face_normal(points: &[Point3<f64>], triangle: &[u32; 3]) -> Vector3<f64> {
    let [a, b, c] = triangle.map(|index| points[index as usize]);
    let (one, other) = (b - a, c - a);
    let size = one.amax().max(other.amax());
    if size.is_nan() || size <= 0.0 || size.is_infinite() {
        return Vector3::zeros();
    }
    let cross = (one / size).cross(&(other / size));
    let length = cross.norm();
    if length > 0.0 { cross / length } else { Vector3::zeros() }
}
