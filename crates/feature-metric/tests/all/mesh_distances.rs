//! Geodesic distances on meshes against closed forms.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::shapes::{cube, grid, nearest};
use feature_metric::{Error, Method, Metric, MetricMesh, insert_point};
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

fn distances(mesh: &TriangleMesh, metric: Metric, source: usize, method: Method) -> Vec<f64> {
    MetricMesh::new(mesh, metric).unwrap().distances(&[source], method).unwrap().values
}

/// A square whose inner vertices are not regular.
fn sheet(n: u32) -> TriangleMesh {
    let place = |u: f64, v: f64| {
        let inner = (PI * u).sin() * (PI * v).sin() / f64::from(n);
        Vector3::new(u + 0.3 * inner * (9.0 * v).sin(), v + 0.25 * inner * (7.0 * u).cos(), 0.0)
    };
    grid([n, n], place, None)
}

#[test]
fn the_plane_is_euclidean_in_both_metrics() {
    for mesh in [sheet(20), grid([16, 16], |u, v| Vector3::new(u, v, 0.0), None)] {
        for source in [0, 100, 211] {
            let from = mesh.vertices()[source];
            for metric in [Metric::Euclidean, Metric::Feature { width: 0.7 }] {
                for (vertex, found) in distances(&mesh, metric, source, Method::Exact).iter().enumerate() {
                    let right = (mesh.vertices()[vertex] - from).norm();
                    assert!((found - right).abs() < 1e-12, "{source} {vertex} {found} {right}");
                }
                // In the plane circles are what the fast method takes for granted.
                let fast = distances(&mesh, metric, source, Method::Fast);
                let error = |k: usize| (fast[k] - (mesh.vertices()[k] - from).norm()).abs();
                let mean = (0..fast.len()).map(error).sum::<f64>() / fast.len() as f64;
                assert!(mean < 1e-3, "{mean}");
            }
        }
    }
}

#[test]
fn a_cube_is_unfolded() {
    for n in [1, 2, 7] {
        let mesh = cube(n);
        let corner = nearest(&mesh, [0.0; 3]);
        let found = distances(&mesh, Metric::Euclidean, corner, Method::Exact);
        let at = |point: [f64; 3]| found[nearest(&mesh, point)];
        // The opposite corner over two squares side by side, one edge away over one square.
        assert!((at([1.0; 3]) - 5.0f64.sqrt()).abs() < 1e-12, "{n} {}", at([1.0; 3]));
        assert!((at([1.0, 1.0, 0.0]) - 2.0f64.sqrt()).abs() < 1e-12);
        for (k, d) in found.iter().enumerate() {
            let x = mesh.vertices()[k];
            let mut sides: Vec<f64> = x.iter().copied().collect();
            sides.sort_by(f64::total_cmp);
            // On the three faces at the corner the straight line, elsewhere over one of the edges that are not next to it.
            let right = if sides[0] == 0.0 {
                x.coords.norm()
            } else {
                let [a, b] = [sides[0], sides[1]];
                a.hypot(1.0 + b).min(b.hypot(1.0 + a))
            };
            if n > 1 && sides[2] == 1.0 {
                assert!((d - right).abs() < 1e-12, "{x} {d} {right}");
            }
        }
    }
}

#[test]
fn ways_bend_around_corners() {
    // A plane without its quadrant x > .5, y > .5: the way bends at the inner corner.
    let whole = grid([20, 20], |u, v| Vector3::new(u, v, 0.0), None);
    let inside = |t: &&[u32; 3]| {
        let centre = t.iter().map(|&k| whole.vertices()[k as usize].coords).sum::<Vector3<f64>>() / 3.0;
        !(centre.x > 0.5 && centre.y > 0.5)
    };
    let kept = whole.triangles().iter().filter(inside).copied().collect();
    let mesh = TriangleMesh::new(whole.vertices().to_vec(), kept).unwrap();
    let source = nearest(&mesh, [1.0, 0.3, 0.0]);
    let metric_mesh = MetricMesh::new(&mesh, Metric::Euclidean).unwrap();
    let found = metric_mesh.distances(&[source], Method::Exact).unwrap();
    let target = nearest(&mesh, [0.3, 1.0, 0.0]);
    let right = 2.0 * 0.5f64.hypot(0.2);
    assert!((found.values[target] - right).abs() < 1e-12, "{} {right}", found.values[target]);
    let path = metric_mesh.path(&found, target).unwrap().unwrap();
    assert!((path.length - right).abs() < 1e-12 && path.is_geodesic, "{path:?}");
    // Vertices without triangles cannot be reached, and cannot be sources.
    let alone = nearest(&mesh, [1.0; 3]);
    assert!(found.values[alone].is_infinite() && found.unreachable() == 100);
    assert!(matches!(metric_mesh.distances(&[alone], Method::Exact), Err(Error::Vertex { .. })));
}

#[test]
fn saddles_are_passed_by_the_shortest_way() {
    // A monkey saddle: exact distances obey the triangle inequality, and every one is the length of a way that exists.
    let surface = |u: f64, v: f64| {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        Vector3::new(x, y, 0.8 * (x * x * x - 3.0 * x * y * y))
    };
    let mesh = grid([24, 24], surface, None);
    let metric_mesh = MetricMesh::new(&mesh, Metric::Euclidean).unwrap();
    for source in [0, 312, 600] {
        let found = metric_mesh.distances(&[source], Method::Exact).unwrap();
        for target in (0..mesh.vertices().len()).step_by(13) {
            let path = metric_mesh.path(&found, target).unwrap().unwrap();
            // A straightened way is never shorter than the exact distance, and most often it is the shortest.
            assert!(path.length > found.values[target] - 1e-10, "{source} {target}");
            assert!(
                path.length < found.values[target] + 1e-9,
                "{source} {target} {} {}",
                path.length,
                found.values[target]
            );
        }
    }
}

#[test]
fn spheres_in_the_feature_metric_are_larger_spheres() {
    // Unit sphere: d = √(1 + w²) θ. Away from the poles of the grid, normals exact.
    let place = |u: f64, v: f64| {
        let (phi, theta) = (1.6 * u, 0.8 + 1.5 * v);
        Vector3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    for width in [0.5, 2.0] {
        let mut errors = Vec::new();
        for n in [16, 32] {
            let mesh = grid([n, n], place, Some(&place));
            let source = nearest(&mesh, place(0.5, 0.5).into());
            let found = distances(&mesh, Metric::Feature { width }, source, Method::Exact);
            let error = |k: usize| {
                let [a, b] = [source, k].map(|k| mesh.vertices()[k].coords);
                let angle = a.cross(&b).norm().atan2(a.dot(&b));
                // Only where the shortest way on the whole sphere stays on the sheet.
                if angle > 0.7 { 0.0 } else { (found[k] - angle * (1.0 + width * width).sqrt()).abs() }
            };
            errors.push((0..found.len()).map(error).fold(0.0, f64::max));
        }
        assert!(errors[1] < 2e-3 * (1.0 + width) && errors[0] > 3.0 * errors[1], "{width} {errors:?}");
    }
}

#[test]
fn a_fillet_costs_its_closed_form() {
    // Two planes joined by a quarter of a cylinder of radius ρ: across (π/2) √(ρ² + w²), along as in space.
    let (rho, width) = (0.1, 0.4);
    let profile = |u: f64| {
        let s = 2.0 * u - 1.0;
        // A third of the grid on the fillet.
        let angle = (s * 1.5 * FRAC_PI_2 + 0.5 * FRAC_PI_2).clamp(0.0, FRAC_PI_2);
        let before = (-s - 1.0 / 3.0).max(0.0);
        let after = (s - 1.0 / 3.0).max(0.0);
        let point = Vector3::new(rho * angle.sin() - before, 0.0, rho * angle.cos() - after);
        (point, Vector3::new(angle.sin(), 0.0, angle.cos()))
    };
    let place = |u: f64, v: f64| profile(u).0 + Vector3::new(0.0, v, 0.0);
    let normal = |u: f64, _: f64| profile(u).1;
    let mesh = grid([48, 12], place, Some(&normal));
    let source = nearest(&mesh, place(0.0, 0.5).into());
    let found = distances(&mesh, Metric::Feature { width }, source, Method::Exact);
    let across = found[nearest(&mesh, place(1.0, 0.5).into())];
    let right = 2.0 * (2.0 / 3.0) + FRAC_PI_2 * rho.hypot(width);
    assert!((across - right).abs() < 1e-3, "{across} {right}");
    let along = found[nearest(&mesh, place(0.0, 1.0).into())];
    assert!((along - 0.5).abs() < 1e-12, "{along}");
}

#[test]
fn a_sharp_edge_costs_the_turn_of_its_normal_whatever_the_mesh() {
    // From the middle of one side of a cube to that of the next: 1, and half a turn in all of the normal's quarter.
    let width = 0.3;
    let right = 1.0 + FRAC_PI_2 * width;
    for n in [2, 6, 12] {
        let mesh = cube(n);
        let source = nearest(&mesh, [0.5, 0.5, 1.0]);
        let found = distances(&mesh, Metric::Feature { width }, source, Method::Exact);
        let at = found[nearest(&mesh, [1.0, 0.5, 0.5])];
        assert!((at - right).abs() < 3e-3 * right, "{n}: {at} {right}");
        // Opposite sides: two edges.
        let far = found[nearest(&mesh, [0.5, 0.5, 0.0])];
        assert!((far - 2.0 - PI * width).abs() < 6e-3 * far, "{n}: {far}");
    }
}

#[test]
fn the_fast_method_converges() {
    let place = |u: f64, v: f64| {
        let (phi, z) = (2.0 * u, v);
        Vector3::new(phi.cos(), phi.sin(), z)
    };
    let mut errors = Vec::new();
    for n in [20, 40, 80] {
        let mesh = grid([2 * n, n], place, None);
        let source = nearest(&mesh, place(0.25, 0.5).into());
        let found = distances(&mesh, Metric::Euclidean, source, Method::Fast);
        let error = |k: usize| {
            let [a, b] = [source, k].map(|k| mesh.vertices()[k]);
            let turn = a.y.atan2(a.x) - b.y.atan2(b.x);
            (found[k] - turn.hypot(a.z - b.z)).abs()
        };
        errors.push((0..found.len()).map(error).sum::<f64>() / found.len() as f64);
    }
    assert!(errors[2] < 1.5e-3 && errors[0] > 2.5 * errors[2], "{errors:?}");
}

#[test]
fn a_point_becomes_a_vertex() {
    let mesh = cube(3);
    for point in [[0.41, 0.27, 1.0], [1.0 / 3.0, 0.2, 1.0], [1.0, 0.4, 0.9]] {
        let inserted = insert_point(&mesh, &Point3::from(point)).unwrap();
        assert!(inserted.distance < 1e-12 && inserted.vertex == mesh.vertices().len());
        let metric_mesh = MetricMesh::new(&inserted.mesh, Metric::Euclidean).unwrap();
        assert!(metric_mesh.is_manifold());
        let found = metric_mesh.distances(&[inserted.vertex], Method::Exact).unwrap();
        for (k, d) in found.values.iter().enumerate() {
            let x = inserted.mesh.vertices()[k];
            if (0..3).any(|axis| x[axis] == point[axis] && x[axis].fract() == 0.0) {
                assert!((d - (x - Point3::from(point)).norm()).abs() < 1e-12, "{point:?} {x} {d}");
            }
        }
    }
    let corner = insert_point(&mesh, &Point3::new(-1.0, -1.0, -1.0)).unwrap();
    assert_eq!(corner.vertex, nearest(&mesh, [0.0; 3]));
    assert!((corner.distance - 3.0f64.sqrt()).abs() < 1e-12);
}

#[test]
fn ways_pass_vertices_where_several_fans_meet() {
    let points = |list: &[[f64; 3]]| list.iter().map(|p| Point3::from(*p)).collect::<Vec<_>>();
    // Two triangles that touch in the vertex 0, and three on the edge from 0 to 1.
    let bow =
        points(&[[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]]);
    let bow = TriangleMesh::new(bow, vec![[0, 2, 1], [0, 4, 3]]).unwrap();
    let fins =
        points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
    let fins = TriangleMesh::new(fins, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]).unwrap();
    for method in [Method::Fast, Method::Exact] {
        let found = distances(&bow, Metric::Euclidean, 1, method);
        let side = 2.0f64.sqrt();
        for (value, wanted) in found.iter().zip([side, 0.0, 2.0, 2.0 * side, 2.0 * side]) {
            assert!((value - wanted).abs() < 1e-12, "{method:?} {found:?}");
        }
        let found = distances(&fins, Metric::Euclidean, 2, method);
        for (value, wanted) in found.iter().zip([1.0, side, 0.0, 2.0, 2.0]) {
            assert!((value - wanted).abs() < 1e-12, "{method:?} {found:?}");
        }
    }
    let metric = MetricMesh::new(&bow, Metric::Euclidean).unwrap();
    let path = metric.path(&metric.distances(&[1], Method::Exact).unwrap(), 3).unwrap().unwrap();
    assert!((path.length - 2.0 * 2.0f64.sqrt()).abs() < 1e-12 && path.points.len() == 3, "{path:?}");
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let mesh = cube(2);
    for width in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(MetricMesh::new(&mesh, Metric::Feature { width }), Err(Error::Option { .. })));
    }
    for scale in [1e-200, 1e-75, 1e75, 1e300] {
        let scaled = mesh.vertices().iter().map(|x| x * scale).collect();
        let scaled = TriangleMesh::new(scaled, mesh.triangles().to_vec()).unwrap();
        assert!(
            matches!(MetricMesh::new(&scaled, Metric::Euclidean), Err(Error::Magnitude { .. })),
            "{scale}"
        );
    }
    for scale in [1e-60, 1e60] {
        let scaled = mesh.vertices().iter().map(|x| x * scale).collect();
        let scaled = TriangleMesh::new(scaled, mesh.triangles().to_vec()).unwrap();
        let (corner, far) = (nearest(&mesh, [0.0; 3]), nearest(&mesh, [1.0; 3]));
        let found = distances(&scaled, Metric::Euclidean, corner, Method::Exact)[far] / scale;
        assert!((found - 5.0f64.sqrt()).abs() < 1e-12, "{scale} {found}");
    }
    let nothing = TriangleMesh::new(vec![Point3::origin(); 3], vec![[0, 1, 2]]).unwrap();
    assert!(matches!(MetricMesh::new(&nothing, Metric::Euclidean), Err(Error::NoSurface)));
    let metric_mesh = MetricMesh::new(&mesh, Metric::Euclidean).unwrap();
    assert!(matches!(metric_mesh.distances(&[], Method::Fast), Err(Error::NoSource)));
    assert!(matches!(metric_mesh.distances(&[9999], Method::Fast), Err(Error::Vertex { vertex: 9999, .. })));
    // A vertex that is not finite, and needles without area, cost no distance of the others.
    let mut vertices = mesh.vertices().to_vec();
    let count = u32::try_from(vertices.len()).unwrap();
    vertices.push(Point3::new(f64::NAN, 0.0, 0.0));
    let mut triangles = mesh.triangles().to_vec();
    triangles.push([0, 1, count]);
    let odd = TriangleMesh::new(vertices, triangles).unwrap();
    let found = distances(&odd, Metric::Feature { width: 0.1 }, 0, Method::Exact);
    assert_eq!(found.iter().filter(|d| d.is_infinite()).count(), 1);
}
