//! Morphology by geodesic balls.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::shapes::{grid, nearest, obj, text};
use feature_metric::{Error, Metric, MetricMesh, Operation};
use mesh_core::TriangleMesh;
use nalgebra::Vector3;

#[test]
fn dilation_and_erosion_are_those_of_the_plane() {
    let mesh = grid([60, 60], |u, v| Vector3::new(u, v, 0.0), None);
    let metric_mesh = MetricMesh::new(&mesh, Metric::Euclidean).unwrap();
    let within = |radius: f64| -> Vec<bool> {
        mesh.vertices().iter().map(|x| (x - nalgebra::Point3::new(0.5, 0.5, 0.0)).norm() <= radius).collect()
    };
    let count = |region: &[bool]| region.iter().filter(|inside| **inside).count();
    let disk = within(0.2);
    for (operation, radius) in [(Operation::Dilate, 0.3), (Operation::Erode, 0.1)] {
        let found = metric_mesh.morphology(&disk, operation, 0.1).unwrap();
        let right = within(radius);
        let wrong = found.iter().zip(&right).filter(|(a, b)| a != b).count();
        // Within one spacing of the border of a disk of some hundred vertices around.
        assert!(wrong * 8 < count(&right), "{operation:?}: {wrong} of {}", count(&right));
    }
    // Opening removes a bridge, closing a slit.
    let bridge = |x: &nalgebra::Point3<f64>| (x.x - 0.5).abs() > 0.2 || (x.y - 0.5).abs() < 0.03;
    let region: Vec<bool> = mesh.vertices().iter().map(bridge).collect();
    let middle = nearest(&mesh, [0.5, 0.5, 0.0]);
    let opened = metric_mesh.morphology(&region, Operation::Open, 0.08).unwrap();
    assert!(region[middle] && !opened[middle] && opened[nearest(&mesh, [0.1, 0.5, 0.0])]);
    let gap: Vec<bool> = mesh.vertices().iter().map(|x| (x.x - 0.5).abs() > 0.03).collect();
    let closed = metric_mesh.morphology(&gap, Operation::Close, 0.08).unwrap();
    assert!(!gap[middle] && closed[middle]);
}

#[test]
fn dilation_stops_at_fillets() {
    // A side of a box with filleted edges, grown by more than the width of a fillet: in space it leaks onto the sides beside it,
    // in the feature sensitive metric with w of half the radius and more it does not.
    let mesh = obj("box10.obj");
    let normals: Vec<Vector3<f64>> = text("box10.normals.txt")
        .lines()
        .map(|line| {
            let c: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
            Vector3::new(c[0], c[1], c[2])
        })
        .collect();
    let (cloud, triangles) = mesh.into_parts();
    let mesh = TriangleMesh::from_cloud(cloud.with_normals(normals.clone()).unwrap(), triangles).unwrap();
    let flat = |k: usize, axis: usize, sign: f64| normals[k][axis] * sign > 1.0 - 1e-9;
    let count = mesh.vertices().len();
    let top: Vec<bool> = (0..count).map(|k| flat(k, 2, 1.0)).collect();
    let beside: Vec<usize> = (0..count).filter(|&k| flat(k, 0, 1.0) || flat(k, 1, -1.0)).collect();
    // The fillets: radius of the box's edges, .08 (from the difference of the flat parts and the sides).
    let extent = mesh.vertices().iter().map(|x| x.z).fold(0.0, f64::max);
    let inner = (0..count).filter(|&k| top[k]).map(|k| mesh.vertices()[k].x).fold(0.0, f64::max);
    let radius = extent - inner;
    let leaked = |width: f64, ball: f64| {
        let metric_mesh = MetricMesh::new(&mesh, Metric::Feature { width }).unwrap();
        let grown = metric_mesh.morphology(&top, Operation::Dilate, ball).unwrap();
        beside.iter().filter(|&&k| grown[k]).count() as f64 / beside.len() as f64
    };
    let ball = std::f64::consts::FRAC_PI_2 * radius * 1.1;
    assert!(leaked(0.0, ball) > 0.05, "{}", leaked(0.0, ball));
    for width in [0.5, 1.0, 4.0] {
        assert_eq!(leaked(width * radius, ball), 0.0, "{width}");
    }
}

#[test]
fn odd_regions_and_radii() {
    let mesh = grid([5, 5], |u, v| Vector3::new(u, v, 0.0), None);
    let metric_mesh = MetricMesh::new(&mesh, Metric::Euclidean).unwrap();
    let (none, all) = (vec![false; 36], vec![true; 36]);
    for operation in [Operation::Dilate, Operation::Erode, Operation::Open, Operation::Close] {
        assert_eq!(metric_mesh.morphology(&none, operation, 0.3).unwrap(), none);
        assert_eq!(metric_mesh.morphology(&all, operation, 0.3).unwrap(), all);
        for radius in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(metric_mesh.morphology(&all, operation, radius), Err(Error::Option { .. })));
        }
        assert!(matches!(
            metric_mesh.morphology(&all[1..], operation, 1.0),
            Err(Error::Labels { found: 35, expected: 36 })
        ));
    }
}
