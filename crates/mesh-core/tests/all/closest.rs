//! Closest points on meshes against brute force and closed forms.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mesh_core::nalgebra::{Point3, Vector3};
use mesh_core::{Error, Feature, MeshProjector, TriangleMesh};
use proptest::prelude::*;

fn p(x: f64, y: f64, z: f64) -> Point3<f64> {
    Point3::new(x, y, z)
}

/// The unit cube, corner `i` at the bits of `i`, normals outwards.
fn cube() -> TriangleMesh {
    let corner = |i: u32| p(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap()
}

fn cube_signed_distance(x: &Point3<f64>) -> f64 {
    let q = x.coords.map(|c| (c - 0.5).abs() - 0.5);
    q.map(|c| c.max(0.0)).norm() + q.max().min(0.0)
}

/// Triangle soup in which every triangle is split into its own vertices.
fn unshared(mesh: &TriangleMesh) -> TriangleMesh {
    let vertices = (0..mesh.triangles().len()).flat_map(|t| mesh.corners(t).unwrap()).collect();
    let triangles = (0u32..).take(mesh.triangles().len()).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriangleMesh::new(vertices, triangles).unwrap()
}

/// Distance to a triangle by dense sampling of its three edges and the foot on its plane, if inside.
fn brute_distance(corners: &[Point3<f64>; 3], x: &Point3<f64>) -> f64 {
    let segment = |a: &Point3<f64>, b: &Point3<f64>| {
        let along = b - a;
        let t = if along.norm_squared() > 0.0 { (x - a).dot(&along) / along.norm_squared() } else { 0.0 };
        (a + along * t.clamp(0.0, 1.0) - x).norm()
    };
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let mut best = segment(a, b).min(segment(b, c)).min(segment(c, a));
    if normal.norm() > 1e-12 {
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(from, to)| (*to - *from).cross(&(x - *from)).dot(&normal) >= 0.0);
        if inside {
            best = best.min(((x - a).dot(&normal) / normal.norm()).abs());
        }
    }
    best
}

#[test]
fn signs_of_a_cube() {
    for mesh in [cube(), unshared(&cube())] {
        let projector = MeshProjector::new(&mesh).unwrap();
        assert!(projector.is_solid());
        for i in 0..9 * 9 * 9 {
            let x =
                p(f64::from(i % 9), f64::from(i / 9 % 9), f64::from(i / 81)) * 0.37 - Vector3::repeat(1.03);
            let foot = projector.project(&x).unwrap();
            let expected = cube_signed_distance(&x);
            assert!((foot.signed_distance.unwrap() - expected).abs() < 1e-14, "{x}: {foot:?}, {expected}");
            assert!((foot.distance - (foot.point - x).norm()).abs() < 1e-15);
        }
        let corner = projector.project(&p(2.0, 3.0, 4.0)).unwrap();
        assert!(matches!(corner.feature, Feature::Vertex(_)));
        assert!((corner.normal - Vector3::repeat(1.0).normalize()).norm() < 1e-15);
    }
}

#[test]
fn a_sliver_without_area_does_not_spoil_the_sign() {
    // The edge (0,0,0)-(1,0,0) of the cube carries a vertex in its middle on one side only; a triangle without area
    // closes the gap.
    let mesh = cube();
    let mut vertices = mesh.vertices().to_vec();
    vertices.push(p(0.5, 0.0, 0.0));
    let mut triangles = mesh.triangles().to_vec();
    let split = triangles.iter().position(|t| t.contains(&0) && t.contains(&1) && t.contains(&5)).unwrap();
    assert_eq!(triangles[split], [0, 1, 5]);
    triangles[split] = [0, 8, 5];
    triangles.extend([[8, 1, 5], [0, 1, 8]]);
    let projector = MeshProjector::new(&TriangleMesh::new(vertices, triangles).unwrap()).unwrap();
    assert!(projector.is_solid());
    for i in 0..400 {
        let angle = f64::from(i) * 0.0157;
        for along in [0.0, 0.2, 0.5, 0.9] {
            let x = p(along, 0.3 * angle.cos(), 0.3 * angle.sin());
            let foot = projector.project(&x).unwrap();
            assert!(
                (foot.signed_distance.unwrap() - cube_signed_distance(&x)).abs() < 1e-12,
                "{x}: {foot:?}"
            );
        }
    }
}

#[test]
fn open_and_inconsistent_meshes_have_no_sign() {
    let cube = cube();
    let open = TriangleMesh::new(cube.vertices().to_vec(), cube.triangles()[1..].to_vec()).unwrap();
    assert_eq!(MeshProjector::new(&open).unwrap().project(&p(0.5, 0.5, 0.5)).unwrap().signed_distance, None);
    let mut flipped = cube.triangles().to_vec();
    flipped[3].swap(0, 1);
    let flipped = TriangleMesh::new(cube.vertices().to_vec(), flipped).unwrap();
    let projector = MeshProjector::new(&flipped).unwrap();
    assert_eq!(projector.topology().inconsistent_edges, 3);
    assert_eq!(projector.project(&p(0.5, 0.5, 0.5)).unwrap().signed_distance, None);
}

#[test]
fn bad_input_is_an_error() {
    let empty = TriangleMesh::new(vec![Point3::origin(); 3], vec![]).unwrap();
    assert_eq!(MeshProjector::new(&empty).unwrap_err(), Error::NoTriangles { triangles: 0 });
    let nowhere = TriangleMesh::new(vec![p(f64::NAN, 0.0, 0.0); 3], vec![[0, 1, 2]; 2]).unwrap();
    assert_eq!(MeshProjector::new(&nowhere).unwrap_err(), Error::NoTriangles { triangles: 2 });

    let projector = MeshProjector::new(&cube()).unwrap();
    assert!(matches!(projector.project(&p(f64::NAN, 0.0, 0.0)), Err(Error::NonFinitePoint { .. })));
    assert!(matches!(projector.project(&p(0.0, f64::INFINITY, 0.0)), Err(Error::NonFinitePoint { .. })));
    assert!(matches!(projector.project(&p(1e200, 0.0, 0.0)), Err(Error::DistanceOverflow { .. })));
}

#[test]
fn leaves_out_triangles_that_are_not_finite() {
    let mut vertices = cube().vertices().to_vec();
    vertices.push(p(0.0, f64::INFINITY, 0.0));
    let mut triangles = cube().triangles().to_vec();
    triangles.insert(0, [0, 1, 8]);
    let projector = MeshProjector::new(&TriangleMesh::new(vertices, triangles).unwrap()).unwrap();
    assert_eq!(projector.skipped(), 1);
    assert_eq!(projector.project(&p(0.5, 0.5, 3.0)).unwrap().triangle, 3);
    assert!(projector.is_solid());
}

#[test]
fn far_from_the_origin_nothing_is_lost() {
    let shift = Vector3::new(4.5e6, -3.2e6, 1e6);
    let moved: Vec<_> = cube().vertices().iter().map(|v| v + shift).collect();
    let projector =
        MeshProjector::new(&TriangleMesh::new(moved, cube().triangles().to_vec()).unwrap()).unwrap();
    for x in [p(0.25, 0.5, 0.75), p(2.0, 2.0, 0.5), p(-1.0, 0.5, 0.5)] {
        let foot = projector.project(&(x + shift)).unwrap();
        assert!((foot.signed_distance.unwrap() - cube_signed_distance(&x)).abs() < 2e-9);
    }
}

/// Coordinates from a coarse lattice, so that degenerate and coincident triangles are common.
fn lattice_point() -> impl Strategy<Value = Point3<f64>> {
    [0i8..5, 0i8..5, 0i8..5].prop_map(|[x, y, z]| p(f64::from(x), f64::from(y), f64::from(z)))
}

fn soup() -> impl Strategy<Value = TriangleMesh> {
    let free = [-3.0..3.0f64, -3.0..3.0, -3.0..3.0].prop_map(|[x, y, z]| p(x, y, z));
    let vertex = prop_oneof![lattice_point(), free];
    (
        prop::collection::vec(vertex, 3..60),
        prop::collection::vec([any::<u32>(), any::<u32>(), any::<u32>()], 1..120),
    )
        .prop_map(|(vertices, triangles)| {
            let count = u32::try_from(vertices.len()).unwrap();
            TriangleMesh::new(vertices, triangles.into_iter().map(|t| t.map(|i| i % count)).collect())
                .unwrap()
        })
}

#[test]
fn many_points_have_the_feet_of_each() {
    // A body with large and small triangles; nodes of a grid, which share searches, and points far apart, which do not.
    let radii: Vec<f64> = (0..26u32).map(|k| 0.4 + 0.3 * f64::from(k * 7 % 11) / 11.0).collect();
    let body = uv_sphere(&radii);
    let projector = MeshProjector::new(&body).unwrap();
    let node = |k: u32| f64::from(k) * 0.11 - 1.3;
    let mut points: Vec<Point3<f64>> =
        (0..24 * 24 * 24).map(|k| p(node(k / 576), node(k / 24 % 24), node(k % 24))).collect();
    let far = |k: u32| (f64::from(k) * 0.754_877_666).fract() * 200.0 - 100.0;
    points.extend((0..3000).map(|k| p(far(k), far(3 * k + 1), far(7 * k + 2))));
    points.push(p(f64::NAN, 0.0, 0.0));
    let all = projector.map_feet(&points, |i, foot| (i, foot));
    for (k, (i, foot)) in all.into_iter().enumerate() {
        assert_eq!(k, i);
        match (foot, projector.project(&points[i])) {
            (Ok(one), Ok(other)) => assert_eq!(one, other, "{}", points[i]),
            (one, other) => assert!(one.is_err() && other.is_err(), "{}", points[i]),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, rng_seed: prop::test_runner::RngSeed::Fixed(9), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn agrees_with_brute_force(mesh in soup(), queries in prop::collection::vec([-6.0..6.0f64, -6.0..6.0, -6.0..6.0], 16)) {
        let projector = MeshProjector::new(&mesh).unwrap();
        let points: Vec<_> = queries.iter().map(|&[x, y, z]| p(x, y, z)).chain(mesh.vertices().iter().copied()).collect();
        for (x, foot) in points.iter().zip(projector.project_many(&points)) {
            let foot = foot.unwrap();
            let expected = (0..mesh.triangles().len())
                .map(|t| brute_distance(&mesh.corners(t).unwrap(), x))
                .fold(f64::INFINITY, f64::min);
            prop_assert!((foot.distance - expected).abs() <= 1e-9 * (1.0 + expected), "{} {} {:?}", x, expected, foot);
            // The foot is where its barycentric coordinates say.
            let corners = mesh.corners(foot.triangle).unwrap();
            let placed = corners.iter().zip(foot.barycentric).map(|(c, w)| c.coords * w).sum::<Vector3<f64>>();
            prop_assert!((placed - foot.point.coords).norm() <= 1e-9);
            prop_assert!(foot.barycentric.iter().all(|&w| w >= 0.0));
            prop_assert!(((foot.point - x).norm() - foot.distance).abs() <= 1e-15 * (1.0 + foot.distance));
        }
    }

    /// A star-shaped closed mesh around the origin: the side of x follows from the triangle its ray goes through.
    #[test]
    fn signs_of_a_star(radii in prop::collection::vec(0.2..2.0f64, 26), direction in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0], scale in 0.05..3.0f64) {
        let sphere = uv_sphere(&radii);
        let projector = MeshProjector::new(&sphere).unwrap();
        prop_assert!(projector.is_solid());
        let direction = Vector3::from(direction);
        prop_assume!(direction.norm() > 0.1);
        let Some(surface) = ray_from_origin(&sphere, &direction) else { return Ok(()); };
        prop_assume!((scale - 1.0).abs() > 1e-6);
        let signed = projector.project(&Point3::from(direction * (surface * scale))).unwrap().signed_distance.unwrap();
        prop_assert_eq!(signed < 0.0, scale < 1.0);
    }
}

/// Two poles and three rings of eight vertices, each at its own distance from the origin.
fn uv_sphere(radii: &[f64]) -> TriangleMesh {
    let mut vertices = vec![p(0.0, 0.0, radii[0]), p(0.0, 0.0, -radii[1])];
    for ring in 0..3u32 {
        for step in 0..8u32 {
            let (polar, azimuth) = (
                f64::from(ring + 1) * 0.25 * std::f64::consts::PI,
                f64::from(step) * 0.25 * std::f64::consts::PI,
            );
            let direction =
                Vector3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos());
            vertices.push(Point3::from(direction * radii[vertices.len()]));
        }
    }
    let at = |ring: u32, step: u32| 2 + 8 * ring + step % 8;
    let mut triangles = Vec::new();
    for step in 0..8 {
        triangles.extend([[0, at(0, step), at(0, step + 1)], [1, at(2, step + 1), at(2, step)]]);
        for ring in 0..2 {
            triangles.push([at(ring, step), at(ring + 1, step), at(ring + 1, step + 1)]);
            triangles.push([at(ring, step), at(ring + 1, step + 1), at(ring, step + 1)]);
        }
    }
    TriangleMesh::new(vertices, triangles).unwrap()
}

/// Where the ray leaves the mesh, in multiples of `direction`; `None` too close to an edge.
fn ray_from_origin(mesh: &TriangleMesh, direction: &Vector3<f64>) -> Option<f64> {
    (0..mesh.triangles().len()).find_map(|triangle| {
        let [a, b, c] = mesh.corners(triangle).unwrap().map(|v| v.coords);
        let volume = a.dot(&b.cross(&c));
        let weights = [direction.dot(&b.cross(&c)), direction.dot(&c.cross(&a)), direction.dot(&a.cross(&b))]
            .map(|w| w / volume);
        let sum: f64 = weights.iter().sum();
        weights.iter().all(|&w| w > 1e-6 * sum.abs()).then_some(1.0 / sum)
    })
}

#[test]
fn where_the_search_begins_does_not_change_the_answer() {
    // Vertices, edges and the centre of a cube are as near to several triangles; far away rounding is as large as what tells them apart.
    let mesh = cube();
    for mesh in [unshared(&mesh), mesh] {
        let projector = MeshProjector::new(&mesh).unwrap();
        for shift in [0.0, 0.25, 1.5, -40.0, 1e9] {
            for k in 0..64u32 {
                let at = |axis: u32| f64::from(k >> (2 * axis) & 3) * 0.5 - 0.25 + shift;
                let x = p(at(0), at(1), at(2));
                let expected = projector.project(&x).unwrap();
                for guess in 0..14 {
                    assert_eq!(
                        projector.project_near(&x, Some(guess)).unwrap(),
                        expected,
                        "{x} from {guess}"
                    );
                }
            }
        }
    }
}
