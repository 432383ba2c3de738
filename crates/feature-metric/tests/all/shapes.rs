//! Meshes with known distances.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use std::path::PathBuf;

/// A file of `fixtures/field-cases`.
pub(crate) fn text(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/field-cases").join(name);
    std::fs::read_to_string(path).unwrap()
}

/// The image of a grid of `(m + 1) × (n + 1)` vertices over the unit square, of which diagonals alternate; with normals if given.
pub(crate) fn grid(
    [m, n]: [u32; 2],
    place: impl Fn(f64, f64) -> Vector3<f64>,
    normal: Option<&dyn Fn(f64, f64) -> Vector3<f64>>,
) -> TriangleMesh {
    let at = |k: u32| (f64::from(k % (m + 1)) / f64::from(m), f64::from(k / (m + 1)) / f64::from(n));
    let count = (m + 1) * (n + 1);
    let vertices = (0..count).map(|k| Point3::from(place(at(k).0, at(k).1))).collect();
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..m {
            let [a, b, c, d] = [0, 1, m + 2, m + 1].map(|k| j * (m + 1) + i + k);
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    let mesh = TriangleMesh::new(vertices, triangles).unwrap();
    match normal {
        None => mesh,
        Some(normal) => {
            let normals = (0..count).map(|k| normal(at(k).0, at(k).1)).collect();
            let (cloud, triangles) = mesh.into_parts();
            TriangleMesh::from_cloud(cloud.with_normals(normals).unwrap(), triangles).unwrap()
        }
    }
}

/// The surface of the cube `[0, 1]³`, `n × n` squares a side.
pub(crate) fn cube(n: u32) -> TriangleMesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3usize {
        for side in [0.0, 1.0] {
            let place = |s: f64, t: f64| {
                let mut x = Vector3::zeros();
                (x[axis], x[(axis + 1) % 3], x[(axis + 2) % 3]) = (side, s, t);
                x
            };
            let face = grid([n, n], place, None);
            let first = u32::try_from(vertices.len()).unwrap();
            vertices.extend_from_slice(face.vertices());
            let turned = |[a, b, c]: [u32; 3]| if side == 1.0 { [a, b, c] } else { [a, c, b] };
            triangles.extend(face.triangles().iter().map(|t| turned(*t).map(|k| k + first)));
        }
    }
    TriangleMesh::new(vertices, triangles).unwrap().welded().0
}

/// The mesh of an OBJ file of triangles without anything else.
pub(crate) fn obj(name: &str) -> TriangleMesh {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for line in text(name).lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["v", x, y, z] => vertices.push(Point3::from([x, y, z].map(|c| c.parse::<f64>().unwrap()))),
            ["f", a, b, c] => {
                triangles.push([a, b, c].map(|k| k.split('/').next().unwrap().parse::<u32>().unwrap() - 1));
            }
            _ => {}
        }
    }
    TriangleMesh::new(vertices, triangles).unwrap()
}

/// The vertex nearest to a point.
pub(crate) fn nearest(mesh: &TriangleMesh, point: [f64; 3]) -> usize {
    let point = Point3::from(point);
    let distance = |k: &usize| (mesh.vertices()[*k] - point).norm();
    (0..mesh.vertices().len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
}
