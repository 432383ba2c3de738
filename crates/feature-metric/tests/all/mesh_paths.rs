//! Geodesic curves on meshes.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::shapes::{cube, grid, nearest};
use feature_metric::{Method, Metric, MetricMesh};
use nalgebra::Vector3;

#[test]
fn paths_are_as_long_as_the_exact_distance_and_as_their_points() {
    let mesh = cube(5);
    let metric_mesh = MetricMesh::new(&mesh, Metric::Euclidean).unwrap();
    let source = nearest(&mesh, [0.2, 0.4, 1.0]);
    let found = metric_mesh.distances(&[source], Method::Exact).unwrap();
    for target in 0..mesh.vertices().len() {
        let path = metric_mesh.path(&found, target).unwrap().unwrap();
        assert!(
            (path.length - found.values[target]).abs() < 1e-10,
            "{target}: {} {}",
            path.length,
            found.values[target]
        );
        let sum: f64 = path.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
        assert!((sum - path.length).abs() < 1e-10, "{target}: {sum} {}", path.length);
        assert!(path.is_geodesic);
        let ends = [path.points[0], path.points[path.points.len() - 1]];
        assert!(ends == [mesh.vertices()[source], mesh.vertices()[target]] || target == source);
    }
}

#[test]
fn paths_keep_to_one_side_of_a_feature() {
    // A ridge of two planes: in the feature metric the way from one end to the other of one plane stays on it, though the
    // distances along both are alike.
    let place = |u: f64, v: f64| {
        let x = 2.0 * u - 1.0;
        Vector3::new(x, 3.0 * v, -2.0 * x.abs())
    };
    let mesh = grid([10, 15], place, None);
    for width in [0.0, 1.0] {
        let metric_mesh = MetricMesh::new(&mesh, Metric::Feature { width }).unwrap();
        let [from, to] = [(0.3, 0.0), (0.3, 1.0)].map(|(u, v)| nearest(&mesh, place(u, v).into()));
        let found = metric_mesh.distances(&[from], Method::Exact).unwrap();
        let path = metric_mesh.path(&found, to).unwrap().unwrap();
        assert!((path.length - 3.0).abs() < 1e-9 && path.points.iter().all(|p| p.x < 0.0), "{path:?}");
        // Over the ridge it costs the turn of the normal.
        let over = nearest(&mesh, place(0.7, 0.0).into());
        let turn = 2.0 * 2.0f64.atan();
        let right = 2.0 * 0.4 * 5.0f64.sqrt() + width * turn;
        assert!((found.values[over] - right).abs() < 0.01 * right, "{} {right}", found.values[over]);
    }
}

#[test]
fn many_sources_share_the_surface() {
    let mesh = grid([30, 30], |u, v| Vector3::new(u, v, 0.0), None);
    let metric_mesh = MetricMesh::new(&mesh, Metric::Euclidean).unwrap();
    let sources = [nearest(&mesh, [0.1, 0.1, 0.0]), nearest(&mesh, [0.8, 0.7, 0.0])];
    let found = metric_mesh.distances(&sources, Method::Exact).unwrap();
    for (k, d) in found.values.iter().enumerate() {
        let right = sources.map(|s| (mesh.vertices()[s] - mesh.vertices()[k]).norm());
        assert!((d - right[0].min(right[1])).abs() < 1e-12, "{k}: {d} {right:?}");
    }
}
