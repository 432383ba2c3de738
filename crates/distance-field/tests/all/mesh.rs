//! Frames of meshes: features, sides, boundaries, curvatures.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::{Numbers, check_frame, global_frame, sphere_mesh, wavy};
use distance_field::{
    DistanceField, ErrorTerm, Hint, MeshField, MeshGeometry, MeshOptions, Search, SurfaceField,
};
use footpoint::Status;
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use nurbs_core::ParametricSurface;

fn cube() -> TriangleMesh {
    let corners = (0..8u8).map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new(corners.collect(), triangles).unwrap()
}

fn exact() -> MeshOptions {
    MeshOptions::default().with_geometry(MeshGeometry::Exact)
}

#[test]
fn a_polyhedron_has_planes_lines_and_points() {
    let field = MeshField::with_options(&cube(), &exact()).unwrap();
    for (x, distance, dimension) in [
        ([0.5, 0.6, 1.5], 0.5, 2),
        ([0.5, 0.6, 0.9], -0.1, 2),
        ([0.5, 1.3, 1.4], 0.5, 1),
        ([2.0, 3.0, 3.0], 3.0, 0),
    ] {
        let x = Vector3::from(x);
        let frame = global_frame(&field, &x);
        check_frame(&frame, &x, 1e-14);
        assert!((frame.distance - distance).abs() < 1e-14, "{frame:?}");
        assert_eq!((frame.tangent_dimension, frame.on_boundary), (dimension, false), "{x}");
        assert_eq!(frame.curvatures, Vector3::zeros());
        // Planes, lines and points are their own models.
        let y = x + Vector3::new(0.01, -0.02, 0.015);
        let model = ErrorTerm::Taylor.model(&frame);
        assert!((model.value(&y) - field.distance(&y).powi(2)).abs() < 1e-13);
    }
}

#[test]
fn open_meshes_end() {
    let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(Point3::from).to_vec();
    let square = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    for options in [exact(), MeshOptions::default()] {
        let field = MeshField::with_options(&square, &options).unwrap();
        for (x, distance, dimension, on_boundary) in [
            ([0.5, 0.2, -0.3], -0.3, 2, false),
            ([0.5, -0.3, 0.4], 0.5, 1, true),
            ([0.5, -0.3, -0.4], -0.5, 1, true),
            ([1.0, 1.3, 0.4], 0.5, 0, true),
        ] {
            let x = Vector3::from(x);
            let frame = global_frame(&field, &x);
            check_frame(&frame, &x, 1e-14);
            assert!((frame.distance.abs() - f64::abs(distance)).abs() < 1e-14, "{frame:?}");
            assert_eq!((frame.tangent_dimension, frame.on_boundary), (dimension, on_boundary), "{x}");
        }
        // The diagonal is no boundary.
        assert!(!global_frame(&field, &Vector3::new(0.5, 0.5, 1.0)).on_boundary);
    }
}

#[test]
fn smooth_meshes_have_the_models_of_their_surface() {
    // On the sphere: Taylor weights δ/(δ − 1) with δ = −d/r.
    let field = MeshField::new(&sphere_mesh(40, 2.0)).unwrap();
    let mut numbers = Numbers::new(31);
    for _ in 0..200 {
        let direction = numbers.direction::<3>();
        let radius = 2.0 + 0.9 * numbers.next();
        let x = direction * radius;
        let frame = global_frame(&field, &x);
        check_frame(&frame, &x, 1e-12);
        assert_eq!((frame.tangent_dimension, frame.on_boundary), (2, false));
        let error = (frame.curvatures.xy().map(|k| k + 0.5)).norm();
        assert!(error < 0.02, "{:?}", frame.curvatures);
        assert_eq!(frame.distance < 0.0, radius < 1.999, "{radius}");
    }
}

#[test]
fn models_of_a_sampled_surface_come_near_those_of_the_surface() {
    let surface = wavy();
    let exact_field = SurfaceField::new(&surface).unwrap();
    let mut gaps = Vec::new();
    for n in [20u16, 40, 80] {
        let vertices = (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j)));
        let points = vertices.map(|(i, j)| {
            Point3::from(surface.point(f64::from(i) / f64::from(n), f64::from(j) / f64::from(n)))
        });
        let row = u32::from(n) + 1;
        let triangles = (0..u32::from(n)).flat_map(|i| {
            (0..u32::from(n)).flat_map(move |j| {
                let k = i * row + j;
                [[k, k + row, k + row + 1], [k, k + row + 1, k + 1]]
            })
        });
        let mesh = TriangleMesh::new(points.collect(), triangles.collect()).unwrap();
        let field = MeshField::new(&mesh).unwrap();
        let mut numbers = Numbers::new(8);
        let mut largest = 0.0f64;
        for _ in 0..200 {
            let jet = surface.jet(0.5 + 0.35 * numbers.next(), 0.5 + 0.35 * numbers.next());
            let x = jet.point + jet.unit_normal().unwrap() * 0.25;
            let models = [
                field.quadratic(&x, ErrorTerm::Taylor).matrix(),
                exact_field.quadratic(&x, ErrorTerm::Taylor).matrix(),
            ];
            assert!((field.distance(&x) - 0.25).abs() < 2.0 / f64::from(n * n));
            largest = largest.max((models[0] - models[1]).norm());
        }
        gaps.push(largest);
    }
    assert!(gaps[2] < 0.06 && gaps[2] < 0.5 * gaps[0], "{gaps:?}");
}

#[test]
fn tangled_meshes_and_queries_do_no_harm() {
    let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    let vertices =
        vec![p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.), p(0., -1., 0.), p(0., 0., 1.), p(f64::NAN, 0., 0.)];
    // Three triangles at one edge, one without area, one that is not finite.
    let triangles = vec![[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 1], [0, 1, 5], [2, 2, 2]];
    let mesh = TriangleMesh::new(vertices, triangles).unwrap();
    let mut numbers = Numbers::new(1);
    for options in [exact(), MeshOptions::default().with_smoothing(3)] {
        let field = MeshField::with_options(&mesh, &options).unwrap();
        for _ in 0..200 {
            let x = numbers.vector() * 2.0;
            check_frame(&global_frame(&field, &x), &x, 1e-12);
        }
        let frame = global_frame(&field, &Vector3::new(0.5, 0.0, 0.0));
        assert!(frame.is_finite() && !frame.on_boundary, "{frame:?}");
        assert_eq!(global_frame(&field, &Vector3::repeat(f64::NAN)).status, Status::InvalidPoint);
        assert_eq!(global_frame(&field, &Vector3::repeat(1e300)).status, Status::Diverged);
    }
    assert!(MeshField::new(&TriangleMesh::new(vec![], vec![]).unwrap()).is_err());
}

/// Both views of a mesh have the same feet and distances, and so the same gradients; they differ in how the foot moves.
#[test]
fn a_smooth_mesh_and_the_polyhedron() {
    let mesh = sphere_mesh(24, 1.0);
    let (smooth, polyhedron) =
        (MeshField::new(&mesh).unwrap(), MeshField::with_options(&mesh, &exact()).unwrap());
    let mut numbers = Numbers::new(3);
    let mut dimensions = [0; 3];
    for _ in 0..400 {
        let x = numbers.direction() * (0.4 + 1.4 * numbers.next());
        let (a, b) = (global_frame(&smooth, &x), global_frame(&polyhedron, &x));
        assert_eq!(a.foot, b.foot);
        assert!((a.distance - b.distance).abs() < 1e-13);
        let gradient = |frame| ErrorTerm::Taylor.model(frame).gradient(&x);
        assert!((gradient(&a) - gradient(&b)).norm() < 1e-9, "{a:?} {b:?}");
        assert_eq!((a.tangent_dimension, b.curvatures), (2, Vector3::zeros()));
        assert!((a.curvatures[0] + 1.0).abs() < 0.1 && (a.curvatures[1] + 1.0).abs() < 0.1, "{a:?}");
        dimensions[b.tangent_dimension] += 1;
    }
    assert!(dimensions.iter().all(|&count| count > 0), "{dimensions:?}");
}

#[test]
fn queries_within_the_slack_of_a_hint_have_the_frames_of_a_search() {
    // A sphere of triangles, queried near it, at its centre, and far away.
    let field = MeshField::new(&sphere_mesh(24, 1.0)).unwrap();
    let mut numbers = Numbers::new(7);
    let mut random = move || numbers.next();
    let points: Vec<Vector3<f64>> = (0..3000)
        .map(|i| {
            let direction = Vector3::new(random(), random(), random()).normalize();
            direction * [1.0 + 1e-3 * random(), 1.0 + 0.3 * random(), 1e-3 * random(), 4.0][i % 4]
        })
        .collect();
    let frames = field.frames(&points, Search::Global, &[]);
    assert_eq!(field.frame(&points[1], Search::Global, &Hint::NONE).foot, frames[1].foot);
    let mut proven = 0;
    for size in [1e-9, 1e-4, 1e-3, 1e-2, 0.1] {
        let moved: Vec<Vector3<f64>> =
            points.iter().map(|x| x + Vector3::new(random(), random(), random()) * size).collect();
        let hints: Vec<Hint> = frames
            .iter()
            .zip(points.iter().zip(&moved))
            .map(|(frame, (x, y))| frame.hint.moved((y - x).norm()))
            .collect();
        proven += hints.iter().filter(|hint| hint.is_proven).count();
        let followed = field.frames(&moved, Search::Local, &hints);
        for (one, other) in followed.iter().zip(field.frames(&moved, Search::Global, &[])) {
            assert_eq!((one.foot, one.distance, one.axes), (other.foot, other.distance, other.axes));
        }
    }
    // Hints would be of no use if none were; those of centres never are.
    assert!(proven > 2000 && proven < 12_000, "{proven}");
    assert!(!Hint { slack: 1.0, ..Hint::NONE }.moved(f64::NAN).is_proven);
}
