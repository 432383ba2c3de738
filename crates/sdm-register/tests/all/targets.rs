//! Meshes and clouds as targets, helical surfaces, and the same bits for any number of threads.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::bodies::SixViews;
use crate::common::{Random, distance, model};
use distance_field::{CloudField, DistanceField, MeshField, MeshGeometry, MeshOptions, SurfaceField};
use footpoint::no_progress;
use mesh_core::TriangleMesh;
use nalgebra::{Matrix3, Point3, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, KnotVector, ParametricSurface, TessellationOptions};
use sdm_register::views::{View, ViewsOptions, register_views};
use sdm_register::{FreeMotion, Outliers, Pose, RegisterOptions, Source, register, rotation};

/// Points of the model away from its edges.
fn inner(count: usize, random: &mut Random) -> Vec<Vector3<f64>> {
    let surface = model();
    (0..count).map(|_| surface.point(0.05 + 0.9 * random.uniform(), 0.05 + 0.9 * random.uniform())).collect()
}

fn away() -> Pose<3> {
    let turn: Matrix3<f64> = rotation::exponential::<3>(&Vector3::new(0.1, -0.15, 0.2)).0;
    Pose::new(turn, Vector3::new(0.05, 0.02, -0.04))
}

#[test]
fn meshes_and_clouds_stand_for_the_surface() {
    let mut random = Random::new(1);
    let points = inner(1000, &mut random);
    let triangles = model().tessellate(&TessellationOptions::new(2e-5)).unwrap();
    let vertices = triangles.vertices.into_iter().map(Point3::from).collect();
    let mesh = TriangleMesh::new(vertices, triangles.triangles).unwrap();
    let options = |geometry| MeshOptions::default().with_geometry(geometry);
    let grid: Vec<Point3<f64>> = (0..150 * 80)
        .map(|k| Point3::from(model().point((k / 80) as f64 / 149.0, (k % 80) as f64 / 79.0)))
        .collect();
    let smooth = MeshField::with_options(&mesh, &options(MeshGeometry::Smooth)).unwrap();
    let exact = MeshField::with_options(&mesh, &options(MeshGeometry::Exact)).unwrap();
    let cloud = CloudField::new(&grid, None).unwrap();
    let fields: [(&str, &dyn DistanceField<3>, f64); 3] =
        [("smooth mesh", &smooth, 2e-5), ("polyhedron", &exact, 2e-5), ("cloud", &cloud, 2e-5)];
    let source: Vec<_> = points.iter().map(|x| away().apply(x)).collect();
    let plain = RegisterOptions::default().with_outliers(Outliers::None);
    let mut minima = Vec::new();
    for (name, field, allowed) in fields {
        for options in [RegisterOptions::default(), plain] {
            let report = register(field, &Source::new(&source), &Pose::identity(), &options).unwrap();
            let error = distance(&source, &report.pose, &away().inverse());
            assert!(error < allowed && report.pose.is_finite(), "{name}: {report}, {error:e}");
            minima.push(report.pose);
        }
    }
    // Both models of the same mesh have the same gradient, and so the same minimum.
    assert!(distance(&source, &minima[1], &minima[3]) < 1e-7);
}

#[test]
fn a_helical_surface_leaves_one_motion_open() {
    let pitch = 0.3;
    let knots = KnotVector::uniform_clamped(3, 80).unwrap();
    let parameters: Vec<f64> = knots.greville();
    let helix = |radius: f64| {
        let on = |t: &f64| Vector3::new(radius * (4.0 * t).cos(), radius * (4.0 * t).sin(), pitch * 4.0 * t);
        let points: Vec<_> = parameters.iter().map(on).collect();
        BsplineCurve::interpolate_at(knots.clone(), &parameters, &points).unwrap()
    };
    let (inside, outside) = (helix(0.5), helix(1.5));
    let net =
        inside.control_points().iter().zip(outside.control_points()).flat_map(|(a, b)| [*a, *b]).collect();
    let across = KnotVector::uniform_clamped(1, 2).unwrap();
    let surface = BsplineSurface::new(inside.knots().clone(), across, net, None).unwrap();
    let mut random = Random::new(4);
    let points: Vec<_> = (0..500)
        .map(|_| surface.point(0.25 + 0.5 * random.uniform(), 0.2 + 0.6 * random.uniform()))
        .collect();
    let start = Pose::new(rotation::exponential::<3>(&Vector3::new(0.02, 0.01, 0.0)).0, Vector3::zeros());
    let field = SurfaceField::new(&surface).unwrap();
    let report = register(&field, &Source::new(&points), &start, &RegisterOptions::default()).unwrap();
    assert!(report.is_converged() && report.rms < 1e-6, "{report}");
    let moved = |x: &Vector3<f64>| (report.pose.apply(x) - start.apply(x)).norm();
    assert!(points.iter().map(moved).fold(0.0, f64::max) < 0.05, "carried along the helix: {report}");
    match report.free_motions.as_slice() {
        [FreeMotion::Helical { axis, point, pitch: found }] => {
            assert!((found * axis.z.signum() - pitch * axis.z.signum()).abs() < 1e-4, "{report}");
            assert!(axis.xy().norm() < 1e-4 && point.xy().norm() < 1e-4, "{report}");
        }
        other => assert!(other.is_empty(), "one helical motion is expected: {report}"),
    }
    assert_eq!(report.free_motions.len(), 1);
    // Screwed along itself and started again, it stays there.
    let screw =
        Pose::new(rotation::exponential::<3>(&(Vector3::z() * 0.3)).0, Vector3::new(0.0, 0.0, 0.3 * pitch));
    let slid = report.pose.followed_by(&screw);
    let again = register(&field, &Source::new(&points), &slid, &RegisterOptions::default()).unwrap();
    assert!(again.pose.is_finite() && distance(&points, &again.pose, &slid) < 1e-6, "{again}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mut random = Random::new(2);
    let mut points = inner(9000, &mut random);
    for x in &mut points {
        *x += random.vector() * 1e-3;
    }
    points
        .extend((0..1000).map(|_| Vector3::new(2.0 * random.uniform(), random.uniform(), random.uniform())));
    let source: Vec<_> = points.iter().map(|x| away().apply(x)).collect();
    let field = SurfaceField::new(&model()).unwrap();
    let cloud: Vec<Point3<f64>> = inner(6000, &mut random).into_iter().map(Point3::from).collect();
    let cloud = CloudField::new(&cloud, None).unwrap();
    let six = SixViews::new(1200, 1e-4, 0.1, 3);
    let views: Vec<View> = six.points.iter().map(|points| View::new(points)).collect();
    let run = || {
        let options = RegisterOptions::default();
        let exact = register(&field, &Source::new(&source), &Pose::identity(), &options).unwrap();
        let sampled = register(&cloud, &Source::new(&source[..3000]), &Pose::identity(), &options).unwrap();
        let many = register_views(&views, &six.initial, &ViewsOptions::default(), &no_progress).unwrap();
        (exact, sampled, many)
    };
    let with_threads =
        |count| rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap().install(run);
    let one = with_threads(1);
    assert!(one.0.is_converged() && one.2.status.is_converged());
    for count in [2, 4] {
        assert!(with_threads(count) == one, "{count} threads");
    }
}
