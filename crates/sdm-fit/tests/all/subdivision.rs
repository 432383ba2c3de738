//! Loop subdivision surfaces through the public API.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use distance_field::ErrorTerm;
use mesh_core::{HalfEdgeMesh, LoopSurface, MeshProjector, TriangleMesh, sample_uniform};
use nalgebra::{Point3, Vector3};
use sdm_fit::subdivision::{ActiveLoop, coarsened, fit_subdivision, subdivision_options};
use sdm_fit::{ActiveShape, Error, Smoothing, Target};

/// A lumpy ball of 26 vertices with 4 to 8 neighbours: an octahedron divided once, without its symmetry.
fn ball() -> TriangleMesh {
    let corners = [[1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
    let triangles = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]];
    let octahedron = TriangleMesh::new(corners.map(Point3::from).to_vec(), triangles.to_vec()).unwrap();
    let fine = mesh_core::LoopScheme::new(&octahedron).subdivide().unwrap();
    let lump = |p: &Point3<f64>| p * (2.0 + 0.3 * (5.0 * p.x).sin() + 0.4 * p.y * p.z);
    TriangleMesh::new(fine.vertices().iter().map(lump).collect(), fine.triangles().to_vec()).unwrap()
}

/// Points of the limit surface inside and on the edges of control triangles.
fn samples(surface: &LoopSurface) -> Vec<Vector3<f64>> {
    let mut out = Vec::new();
    for triangle in 0..surface.triangles().len() {
        for i in 0..6 {
            for j in 0..6 - i {
                let at = [(f64::from(i) + 0.2) / 6.2, (f64::from(j) + 0.2) / 6.2];
                out.push(surface.jet(triangle, at).unwrap().position.coords);
            }
        }
    }
    out
}

fn bunny() -> TriangleMesh {
    let text = include_str!("../../../../fixtures/mesh/bunny.obj");
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let c: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
                corners.push(Point3::new(c[0], c[1], c[2]));
            }
            Some("f") => {
                let index = |w: &str| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                let f: Vec<u32> = words.map(index).collect();
                triangles.push([f[0], f[1], f[2]]);
            }
            _ => {}
        }
    }
    TriangleMesh::new(corners, triangles).unwrap()
}

#[test]
fn points_are_those_of_the_limit_surface() {
    let shape = ActiveLoop::new(&ball()).unwrap();
    let surface = shape.surface();
    for triangle in [0, 7, 31] {
        for at in [[0.1, 0.3], [0.0, 0.5], [0.7, 0.3], [1.0 / 3.0, 1.0 / 3.0]] {
            let parameter = [2.0 * triangle as f64 + at[0], at[1]];
            let expected = surface.jet(triangle, at).unwrap().position.coords;
            assert_eq!(shape.cell(parameter), triangle);
            assert!((shape.point(parameter) - expected).norm() < 1e-12);
        }
    }
    // A shape without bends in the plane of its parameters has no energy: moved, the energy stays.
    let form = |shape: &ActiveLoop| -> f64 {
        let of = |g: &sdm_fit::CellGram| {
            let d: Vec<_> = shape.cells().columns(g.cell).iter().map(|&i| shape.coefficients()[i]).collect();
            (0..d.len() * d.len()).map(|e| g.gram[e] * d[e / d.len()].dot(&d[e % d.len()])).sum::<f64>()
        };
        shape.energy([0.5, 1.0, 0.0]).iter().map(of).sum()
    };
    let mut moved = shape.clone();
    let shift = Vector3::new(3.0, -1.0, 2.0);
    moved.set_coefficients(&shape.coefficients().iter().map(|d| d + shift).collect::<Vec<_>>()).unwrap();
    assert!((form(&shape) - form(&moved)).abs() < 1e-9 * form(&shape) && form(&shape) > 0.1);
    assert_eq!(shape.sensors(3).len(), 9 * surface.triangles().len());
}

#[test]
fn a_sampled_surface_comes_back() {
    let truth = ball();
    let points = samples(&LoopSurface::new(&truth).unwrap());
    let shaken = truth.vertices().iter().enumerate().map(|(k, p)| {
        let wave = |s: f64| 0.03 * (s * (k as f64 + 1.0)).sin();
        p + Vector3::new(wave(1.7), wave(2.3), wave(3.1))
    });
    let start = TriangleMesh::new(shaken.collect(), truth.triangles().to_vec()).unwrap();
    let options = subdivision_options()
        .with_smoothing(Smoothing::Continuation { start: 1e-5, factor: 0.1, floor: 0.0 })
        .with_fairing(0.0)
        .with_cost_tolerance(0.0);
    let target = Target::Points { points: &points, weights: None };
    let found = fit_subdivision(target, &start, &options).unwrap();
    assert!(found.report.rms < 1e-9 && found.report.initial_rms > 1e-3, "{}", found.report);
}

#[test]
fn a_body_is_fitted_from_a_coarse_mesh() {
    let bunny = bunny();
    let coarse = coarsened(&bunny, 160).unwrap();
    let connectivity = HalfEdgeMesh::new(&coarse);
    assert_eq!((coarse.vertices().len(), connectivity.defects().is_empty()), (160, true));
    assert_eq!(connectivity.euler_characteristic(), HalfEdgeMesh::new(&bunny).euler_characteristic());
    let points: Vec<Vector3<f64>> = bunny.vertices().iter().map(|p| p.coords).collect();
    let size = bunny.bounding_box().unwrap().diagonal();
    let target = Target::Points { points: &points, weights: None };
    let fit = |term| {
        let options = subdivision_options().with_term(term).with_max_iterations(10);
        fit_subdivision(target, &coarse, &options).unwrap()
    };
    let (squared, point) = (fit(ErrorTerm::SquaredDistance), fit(ErrorTerm::Point));
    assert!(squared.report.rms < 0.8 * point.report.rms, "{} {}", squared.report, point.report);
    assert!(squared.report.rms < 3e-3 * size, "{} {size}", squared.report);
    // And from the surface back: no limit point is far from the body.
    let projector = MeshProjector::new(&bunny).unwrap();
    let distances = samples(&squared.surface);
    let distances = distances.iter().map(|p| projector.project(&Point3::from(*p)).unwrap().distance);
    assert!(distances.fold(0.0, f64::max) < 0.06 * size);
}

#[test]
fn coarse_meshes_keep_their_boundary() {
    // A dome of 21 × 21 vertices.
    let at = |i: u32, j: u32| i * 21 + j;
    let point = |k: u32| {
        let (x, y) = (f64::from(k / 21) / 20.0, f64::from(k % 21) / 20.0);
        Point3::new(x, y, x * (1.0 - x) * y)
    };
    let cell = |k: u32| {
        let (i, j) = (k / 20, k % 20);
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    };
    let dome = TriangleMesh::new((0..441).map(point).collect(), (0..400).flat_map(cell).collect()).unwrap();
    let coarse = coarsened(&dome, 120).unwrap();
    assert_eq!(coarse.vertices().len(), 120);
    let boundary =
        |mesh: &TriangleMesh| HalfEdgeMesh::new(mesh).boundary_loops().iter().map(Vec::len).sum::<usize>();
    assert_eq!(boundary(&coarse), boundary(&dome));
    assert!(HalfEdgeMesh::new(&coarse).defects().is_empty());
    // The area hardly changes, and nothing turns over.
    assert!((coarse.area() / dome.area() - 1.0).abs() < 0.02);
    assert_eq!(sample_uniform(&coarse, 10, 1).unwrap().len(), 10);
}

#[test]
fn bad_input_is_an_error() {
    let points = [Vector3::new(f64::NAN, 0.0, 0.0)];
    let target = Target::Points { points: &points, weights: None };
    let options = subdivision_options();
    assert!(matches!(fit_subdivision(target, &ball(), &options), Err(Error::NotFinite { .. })));
    // Three triangles at one edge.
    let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.]].map(Point3::from);
    let fan = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
    assert!(matches!(fit_subdivision(target, &fan, &options), Err(Error::Field { .. })));
    assert!(matches!(coarsened(&fan, 4), Err(Error::Field { .. })));
    let empty = TriangleMesh::new(Vec::new(), Vec::new()).unwrap();
    assert!(matches!(fit_subdivision(target, &empty, &options), Err(Error::Field { .. })));
}
