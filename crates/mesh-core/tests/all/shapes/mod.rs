//! Meshes and clouds of surfaces whose normals and curvatures are known.

#![allow(dead_code, reason = "every test uses its part")]

use mesh_core::TriangleMesh;
use mesh_core::nalgebra::{Point3, Vector3};

/// The fractional parts of multiples of an irrational number: spread evenly, in no order.
pub(crate) fn spread(i: usize, step: f64) -> f64 {
    (i as f64 * step).fract()
}

/// Even samples of the unit sphere.
pub(crate) fn sphere(count: usize) -> Vec<Point3<f64>> {
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let angle = std::f64::consts::TAU * spread(i, 0.618_033_988_749_895);
            let radius = (1.0 - z * z).sqrt();
            Point3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
        .collect()
}

/// A point of a torus around the z axis by its angles around the axis and around the tube.
pub(crate) fn torus_point(radius: f64, tube: f64, u: f64, v: f64) -> Point3<f64> {
    let out = radius + tube * v.cos();
    Point3::new(out * u.cos(), out * u.sin(), tube * v.sin())
}

/// The outward normal there.
pub(crate) fn torus_normal(u: f64, v: f64) -> Vector3<f64> {
    Vector3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin())
}

/// A torus (radii 2 and `tube`) of `2 n m` triangles with normals outwards; `jitter` moves the vertices by a part of a
/// step. The angles of the vertices come along.
pub(crate) fn torus(tube: f64, n: u32, m: u32, jitter: f64) -> (TriangleMesh, Vec<[f64; 2]>) {
    let step = |i: u32, count: u32| f64::from(i) * std::f64::consts::TAU / f64::from(count);
    let parameters: Vec<[f64; 2]> = (0..n * m)
        .map(|k| {
            let moved = |offset: f64| jitter * (spread(k as usize, offset) - 0.5);
            [
                step(k / m, n) + moved(0.754_877_666_246_693) * step(1, n),
                step(k % m, m) + moved(0.569_840_290_998_053) * step(1, m),
            ]
        })
        .collect();
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let triangles = (0..n * m)
        .map(|k| (k / m, k % m))
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    let vertices = parameters.iter().map(|&[u, v]| torus_point(2.0, tube, u, v)).collect();
    (TriangleMesh::new(vertices, triangles).expect("valid mesh"), parameters)
}

/// The octahedron divided `levels` times, its vertices on the unit sphere, normals outwards.
pub(crate) fn octasphere(levels: usize) -> TriangleMesh {
    let mut vertices: Vec<Vector3<f64>> =
        vec![Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32, vertices: &mut Vec<Vector3<f64>>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                u32::try_from(vertices.len() - 1).expect("few vertices")
            })
        };
        triangles = (triangles.iter())
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| middle(a, b, &mut vertices));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    TriangleMesh::new(vertices.into_iter().map(Point3::from).collect(), triangles).expect("valid mesh")
}

/// The Stanford bunny of the fixtures.
pub(crate) fn bunny() -> TriangleMesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/mesh/bunny.obj");
    let text = std::fs::read_to_string(path).expect("the fixture exists");
    let rows = |key: &'static str| text.lines().filter_map(move |line| line.strip_prefix(key));
    let vertices = rows("v ")
        .map(|row| {
            row.split_whitespace().map(|word| word.parse::<f64>().expect("a number")).collect::<Vec<_>>()
        })
        .map(|row| Point3::new(row[0], row[1], row[2]))
        .collect();
    let number =
        |word: &str| word.split('/').next().and_then(|index| index.parse::<u32>().ok()).expect("an index");
    let triangles = rows("f ")
        .map(|row| row.split_whitespace().map(number).collect::<Vec<_>>())
        .map(|row| [row[0] - 1, row[1] - 1, row[2] - 1])
        .collect();
    TriangleMesh::new(vertices, triangles).expect("valid mesh")
}
