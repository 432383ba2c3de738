//! Sampling of surfaces and clouds, and outliers.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use crate::shapes::{bunny, octasphere, sphere, spread, torus};
use mesh_core::nalgebra::{Point2, Point3, Vector3};
use mesh_core::{
    CloudIndex, Colours, Error, MeshProjector, PointCloud, SurfaceSample, TriangleMesh, VoxelPoint,
    eliminate_samples, farthest_points, radius_outliers, sample_poisson_disk, sample_uniform,
    sample_wide_triangles, statistical_outliers, voxel_downsample,
};

fn points(samples: &[SurfaceSample]) -> Vec<Point3<f64>> {
    samples.iter().map(|sample| sample.point).collect()
}

/// Distance of every point to its nearest other.
fn spacings(points: &[Point3<f64>]) -> Vec<f64> {
    CloudIndex::new(points).unwrap().map_nearest_n(points, 2, |_, near| near[1].distance())
}

#[test]
fn uniform_samples_lie_on_the_surface_by_area() {
    let (mesh, _) = torus(0.8, 60, 30, 0.4);
    let samples = sample_uniform(&mesh, 20_000, 1).unwrap();
    let projector = MeshProjector::new(&mesh).unwrap();
    for sample in samples.iter().step_by(17) {
        assert!(projector.project(&sample.point).unwrap().distance < 1e-14);
        let corners = mesh.corners(sample.triangle).unwrap();
        let placed: Vector3<f64> = corners.iter().zip(sample.barycentric).map(|(c, w)| c.coords * w).sum();
        assert!(
            (placed - sample.point.coords).norm() < 1e-14 && sample.barycentric.iter().all(|&w| w >= 0.0)
        );
    }
    // The outer half of a torus has the share 1/2 + tube / (π radius) of the area; six standard deviations of chance.
    let outer = samples.iter().filter(|sample| sample.point.coords.xy().norm() > 2.0).count() as f64 / 2e4;
    let expected = 0.5 + 0.8 / (2.0 * std::f64::consts::PI);
    assert!((outer - expected).abs() < 6.0 * (0.25f64 / 2e4).sqrt(), "{outer} {expected}");
    assert_eq!(samples[..9], sample_uniform(&mesh, 9, 1).unwrap());
    assert_ne!(samples[..9], sample_uniform(&mesh, 9, 2).unwrap());
}

#[test]
fn poisson_disks_keep_their_distance() {
    for mesh in [octasphere(4), bunny()] {
        let samples = sample_poisson_disk(&mesh, 1000, 3).unwrap();
        assert_eq!(samples.len(), 1000);
        let largest = (mesh.area() / (2.0 * 3f64.sqrt() * 1000.0)).sqrt();
        let closest = spacings(&points(&samples)).into_iter().fold(f64::INFINITY, f64::min);
        let of_chance = spacings(&points(&sample_uniform(&mesh, 1000, 3).unwrap()))
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        // Sample elimination reaches some 70 % of the densest packing, chance almost nothing.
        assert!(closest > 0.6 * 2.0 * largest, "{}", closest / (2.0 * largest));
        assert!(of_chance < 0.2 * closest);
        assert_eq!(samples, sample_poisson_disk(&mesh, 1000, 3).unwrap());
    }
}

#[test]
fn wide_triangles_are_filled_and_even_meshes_left_alone() {
    assert!(sample_wide_triangles(&octasphere(4), 1).unwrap().is_empty());
    // A square of 20 by 20 cells with a square of two triangles, as large as all of them, beside it.
    let (n, mut vertices, mut triangles) = (21u32, Vec::new(), Vec::new());
    vertices.extend((0..n * n).map(|k| Point3::new(f64::from(k % n) / 20.0, f64::from(k / n) / 20.0, 0.0)));
    for k in (0..n * (n - 1)).filter(|k| k % n + 1 < n) {
        triangles.extend([[k, k + 1, k + n + 1], [k, k + n + 1, k + n]]);
    }
    let corners = [(1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0)].map(|(x, y)| Point3::new(x, y, 0.0));
    let first = n * n;
    vertices.extend(corners);
    triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    let mesh = TriangleMesh::new(vertices, triangles).unwrap();
    let samples = sample_wide_triangles(&mesh, 7).unwrap();
    // Of 445 vertices on an area of 2, half would be there.
    assert!((220..=224).contains(&samples.len()), "{}", samples.len());
    assert!(samples.iter().all(|s| (1.0..=2.0).contains(&s.point.x) && (0.0..=1.0).contains(&s.point.y)));
    let left = samples.iter().filter(|s| s.point.x < 1.5).count();
    assert!((85..=137).contains(&left), "{left}");
    assert_eq!(samples, sample_wide_triangles(&mesh, 7).unwrap());
}

#[test]
fn sampling_nothing() {
    let none = TriangleMesh::new(vec![Point3::origin(); 3], vec![[0, 1, 2]]).unwrap();
    assert_eq!(sample_uniform(&none, 5, 0), Err(Error::NoArea { triangles: 1 }));
    assert_eq!(sample_wide_triangles(&none, 0), Err(Error::NoArea { triangles: 1 }));
    let mut vertices = octasphere(0).vertices().to_vec();
    vertices[0].x = f64::NAN;
    let half = TriangleMesh::new(vertices, octasphere(0).triangles().to_vec()).unwrap();
    let samples = sample_uniform(&half, 500, 0).unwrap();
    assert!(samples.iter().all(|s| s.point.x <= 0.0) && samples.len() == 500);
    assert!(sample_poisson_disk(&half, 0, 0).unwrap().is_empty());
    let odd = [Point3::origin(), Point3::new(f64::NAN, 0.0, 0.0), Point3::origin(), Point3::origin()];
    assert_eq!(eliminate_samples(&odd, 9, 1.0).unwrap(), [0, 2, 3]);
    assert_eq!(eliminate_samples(&odd, 1, 1.0).unwrap(), [0]);
    assert!(matches!(eliminate_samples(&odd, 1, f64::NAN), Err(Error::OutOfRange { what: "area", .. })));
}

#[test]
fn voxels_average_or_choose() {
    let shift = Vector3::new(3e6, -2e6, 50.0);
    let positions: Vec<_> = [0.1, 0.4, 1.7, f64::NAN, 0.4].map(|x| Point3::new(x, 0.0, 0.0) + shift).to_vec();
    let cloud = PointCloud::new(positions.clone())
        .with_normals(vec![Vector3::x(), Vector3::y(), Vector3::z(), Vector3::z(), Vector3::y()])
        .and_then(|cloud| {
            cloud.with_colours(Colours::Rgb(vec![[0; 3], [30, 3, 9], [7; 3], [1; 3], [255, 3, 9]]))
        })
        .and_then(|cloud| cloud.with_scalar("time", vec![1.0, 2.0, 3.0, 4.0, 6.0]))
        .unwrap();
    let mean = voxel_downsample(&cloud, 1.0, VoxelPoint::Centroid).unwrap();
    assert_eq!((mean.counts.as_slice(), mean.skipped), ([3, 1].as_slice(), 1));
    assert!((mean.cloud.positions()[0] - (Point3::new(0.3, 0.0, 0.0) + shift)).norm() < 1e-9);
    assert_eq!(mean.cloud.positions()[1], positions[2]);
    assert!(
        (mean.cloud.attributes().normals().unwrap()[0] - Vector3::new(1.0, 2.0, 0.0).normalize()).norm()
            < 1e-15
    );
    assert_eq!(mean.cloud.attributes().colours(), Some(&Colours::Rgb(vec![[95, 2, 6], [7; 3]])));
    assert_eq!(mean.cloud.attributes().scalar("time"), Some([3.0, 3.0].as_slice()));
    let nearest = voxel_downsample(&cloud, 1.0, VoxelPoint::Nearest).unwrap();
    assert_eq!(nearest.cloud, cloud.select(&[1, 2]).unwrap());
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-20] {
        assert!(matches!(
            voxel_downsample(&cloud, size, VoxelPoint::Centroid),
            Err(Error::OutOfRange { .. })
        ));
    }
    let empty = voxel_downsample(&PointCloud::new(vec![]), 1.0, VoxelPoint::Centroid).unwrap();
    assert!(empty.cloud.is_empty());
    let planar = PointCloud::planar(&[Point2::new(0.0, 0.0), Point2::new(0.1, 0.3)]);
    assert_eq!(voxel_downsample(&planar, 5.0, VoxelPoint::Centroid).unwrap().cloud.dimension(), 2);
}

#[test]
fn farthest_points_cover() {
    let cloud = sphere(3000);
    let chosen = farthest_points(&cloud, 100);
    let picked: Vec<_> = chosen.iter().map(|&i| cloud[i]).collect();
    let index = CloudIndex::new(&picked).unwrap();
    let radius = index.nearest_many(&cloud).into_iter().map(|n| n.unwrap().distance()).fold(0.0, f64::max);
    let spacing = spacings(&picked).into_iter().fold(f64::INFINITY, f64::min);
    // Every point is covered within the distance that the chosen ones keep.
    assert!(radius <= spacing && radius < 0.3, "{radius} {spacing}");
    assert_eq!(farthest_points(&cloud, 10), chosen[..10]);
    let few =
        [Point3::new(f64::NAN, 0.0, 0.0), Point3::origin(), Point3::origin(), Point3::new(4e5, 0.0, 0.0)];
    assert_eq!(farthest_points(&few, 4), [1, 3]);
    assert_eq!(farthest_points(&few[1..2], 4), [0]);
    assert!(farthest_points(&few[..1], 4).is_empty() && farthest_points(&few, 0).is_empty());
}

#[test]
fn outliers_are_found() {
    let mut cloud = sphere(2000);
    let outside: Vec<_> =
        (0..20).map(|i| Point3::from(cloud[i * 90].coords * (1.5 + spread(i, 0.618)))).collect();
    cloud.extend(&outside);
    cloud.push(Point3::new(0.0, f64::INFINITY, 0.0));
    let statistical = statistical_outliers(&cloud, 8, 2.0).unwrap();
    let radius = radius_outliers(&cloud, 0.15, 3).unwrap();
    for report in [&statistical, &radius] {
        assert_eq!((report.removed, report.non_finite), (20, 1));
        assert!(report.keep.iter().enumerate().all(|(i, &keep)| keep == (i < 2000)));
        assert!(report.measures[2020].is_nan() && report.mean > 0.0 && report.deviation > 0.0);
    }
    let mut thinned = PointCloud::new(cloud.clone());
    assert_eq!(thinned.retain(&statistical.keep), Ok(21));
    assert!(thinned.retain(&[true]).is_err());
    // A lattice has no outliers but by chance of rounding.
    let lattice: Vec<_> = (0..64u8).map(|i| Point3::new(f64::from(i) * 0.1, 0.0, 0.0)).collect();
    assert_eq!(statistical_outliers(&lattice, 1, 0.0).unwrap().removed, 0);
    assert_eq!(statistical_outliers(&[], 1, 1.0).unwrap().keep, []);
    assert_eq!(radius_outliers(&[Point3::origin(); 4], 0.0, 3).unwrap().removed, 0);
    assert!(matches!(statistical_outliers(&cloud, 0, 1.0), Err(Error::TooFew { .. })));
    assert!(matches!(statistical_outliers(&cloud, 5, f64::NAN), Err(Error::OutOfRange { .. })));
    assert!(matches!(radius_outliers(&cloud, -1.0, 1), Err(Error::OutOfRange { .. })));
}
