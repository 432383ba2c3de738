//! What noise, its absence, and the sampling of clouds do to a registration.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::common::{Random, distance, model};
use distance_field::{CloudField, DistanceField, MeshField, SurfaceField};
use mesh_core::TriangleMesh;
use nalgebra::{Matrix3, Point3, Vector3};
use nurbs_core::{ParametricSurface, TessellationOptions};
use sdm_register::{
    Doubt, Outliers, Pose, RegisterOptions, RegisterReport, Source, Status, register, rotation,
};

type Points = Vec<Vector3<f64>>;

fn turn(by: [f64; 3]) -> Matrix3<f64> {
    rotation::exponential::<3>(&Vector3::from(by)).0
}

fn run(field: &dyn DistanceField<3>, points: &[Vector3<f64>]) -> RegisterReport<3> {
    register(field, &Source::new(points), &Pose::identity(), &RegisterOptions::default()).unwrap()
}

fn cloud(points: &[Vector3<f64>]) -> CloudField {
    let points: Vec<Point3<f64>> = points.iter().copied().map(Into::into).collect();
    CloudField::new(&points, None).unwrap()
}

/// Points of the surface of the cases.
fn sampled(count: usize, noise: f64, random: &mut Random) -> Points {
    let surface = model();
    (0..count).map(|_| surface.point(random.uniform(), random.uniform()) + random.vector() * noise).collect()
}

/// What a scanner of rings sees from a place in a room of 20 × 12 × 4 with three columns.
fn rings(scanner: Vector3<f64>, steps: u32, noise: f64, random: &mut Random) -> Points {
    let columns = [[6.0, 3.0], [13.0, 8.0], [10.0, 2.0]];
    let (low, high) = (Vector3::zeros(), Vector3::new(20.0, 12.0, 4.0));
    let mut points = Vec::new();
    for ring in 0..24 {
        let height = (f64::from(ring) - 11.5) * 0.035;
        for step in 0..steps {
            let angle = std::f64::consts::TAU * (f64::from(step) + 0.37 * f64::from(ring)) / f64::from(steps);
            let ray = Vector3::new(angle.cos(), angle.sin(), height).normalize();
            let mut way = f64::INFINITY;
            for k in (0..3).filter(|&k| ray[k].abs() > 1e-9) {
                let wall = if ray[k] > 0.0 { high[k] } else { low[k] };
                way = way.min((wall - scanner[k]) / ray[k]);
            }
            for [x, y] in columns {
                let (dx, dy) = (scanner.x - x, scanner.y - y);
                let (a, b) = (ray.x * ray.x + ray.y * ray.y, dx * ray.x + dy * ray.y);
                let root = b * b - a * (dx * dx + dy * dy - 0.36);
                if root > 0.0 && -b - root.sqrt() > 0.0 {
                    way = way.min((-b - root.sqrt()) / a);
                }
            }
            points.push(scanner + ray * (way + noise * random.normal()));
        }
    }
    points
}

#[test]
fn scans_in_rings_converge() {
    let mut random = Random::new(11);
    let target = rings(Vector3::new(9.0, 5.5, 1.7), 700, 0.01, &mut random);
    let truth = Pose::new(turn([0.004, -0.003, 0.03]), Vector3::new(0.35, 0.1, 0.02));
    let scanned = rings(Vector3::new(9.5, 5.8, 1.7), 650, 0.01, &mut random);
    let points: Points = scanned.iter().map(|x| truth.inverse().apply(x)).collect();
    let report = run(&cloud(&target), &points);
    // Hardly a ring meets the floor or the ceiling, which alone tell the height.
    let off = |x: &Vector3<f64>| (report.pose.apply(x) - truth.apply(x)).xy().norm_squared();
    let error = (points.iter().map(off).sum::<f64>() / points.len() as f64).sqrt();
    assert_eq!(report.status, Status::Converged, "{report}");
    assert!(error < 0.03, "{error}: {report}");
    assert!(report.iterations < 120, "{report}");
}

#[test]
fn noise_of_normals_fixes_no_motion() {
    let mut random = Random::new(3);
    let mut cylinder = |count: usize| -> Points {
        let mut point = || {
            let angle = std::f64::consts::TAU * random.uniform();
            Vector3::new(angle.cos(), angle.sin(), 3.0 * random.uniform()) + random.vector() * 0.001
        };
        (0..count).map(|_| point()).collect()
    };
    let target = cylinder(8000);
    let moved: Points = cylinder(3000)
        .iter()
        .filter(|x| x.z > 0.5 && x.z < 2.5)
        .map(|x| turn([0.05, -0.02, 0.4]) * x + Vector3::new(0.05, 0.02, 0.1))
        .collect();
    let report = run(&cloud(&target), &moved);
    assert_eq!((report.status, report.free_motions.len()), (Status::Converged, 2), "{report}");
    let mut sphere = |count: usize| -> Points {
        (0..count).map(|_| random.vector().normalize() + random.vector() * 0.001).collect()
    };
    let (target, points) = (sphere(8000), sphere(3000));
    let report = run(&cloud(&target), &points);
    assert_eq!((report.status, report.free_motions.len()), (Status::Converged, 3), "{report}");
    // A shape with features has none.
    let target = sampled(8000, 0.001, &mut random);
    let points: Points =
        sampled(3000, 0.001, &mut random).iter().map(|x| turn([0.05, -0.02, 0.1]) * x).collect();
    let report = run(&cloud(&target), &points);
    assert_eq!((report.status, report.free_motions.len()), (Status::Converged, 0), "{report}");
}

#[test]
fn perfect_scans_count_wherever_they_are() {
    let mut random = Random::new(7);
    let triangles = model().tessellate(&TessellationOptions::new(1e-3)).unwrap();
    for offset in [0.0, 1e3, 2e6] {
        let shift = Vector3::new(offset, -offset, 0.5 * offset);
        let vertices: Vec<Point3<f64>> =
            triangles.vertices.iter().map(|x| Point3::from(*x) + shift).collect();
        let mesh = TriangleMesh::new(vertices.clone(), triangles.triangles.clone()).unwrap();
        let field = MeshField::new(&mesh).unwrap();
        let on_mesh: Points = (0..4000)
            .map(|k| {
                let corners = triangles.triangles[k * 7 % triangles.triangles.len()];
                let [a, b, c] = corners.map(|i| vertices[i as usize].coords);
                let (s, t) = (random.uniform(), random.uniform());
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                a + (b - a) * s + (c - a) * t
            })
            .collect();
        let centre = on_mesh.iter().sum::<Vector3<f64>>() / 4000.0;
        let away = |x: &Vector3<f64>| turn([0.04, 0.03, -0.08]) * (x - centre) + centre;
        let mut points: Points = on_mesh.iter().map(away).collect();
        let report = run(&field, &points);
        assert_eq!((report.status, report.used), (Status::Converged, 4000), "{offset}: {report}");
        points.extend((0..800).map(|_| {
            let mut side = |length: f64| length * (random.uniform() - 0.5);
            centre + Vector3::new(side(2.0), side(0.8), side(0.6))
        }));
        let report = run(&field, &points);
        // Where points near the border have their feet on it they are left out.
        assert!(report.status == Status::Converged && report.used > 3700, "{offset}: {report}");
        assert!(report.rms <= 1e-12 + 1e-15 * offset, "{offset}: {report}");
    }
}

#[test]
fn many_points_take_few_steps_and_end_at_the_same_place() {
    let mut random = Random::new(19);
    let field = SurfaceField::new(&model()).unwrap();
    let points: Points =
        sampled(40_000, 1e-3, &mut random).iter().map(|x| turn([0.05, -0.02, 0.1]) * x).collect();
    let quick = run(&field, &points);
    let options = RegisterOptions::default().with_coarse_points(usize::MAX);
    let exact = register(&field, &Source::new(&points), &Pose::identity(), &options).unwrap();
    assert_eq!([quick.status, exact.status], [Status::Converged; 2]);
    let long = quick.history.iter().filter(|step| step.points > 20_000);
    let (steps, searches) = long.fold((0, 0), |(steps, all), step| (steps + 1, all + step.evaluations));
    assert!(steps > searches && searches <= 2, "{steps} steps, {searches} searches: {quick}");
    let standard_error = exact.rms / (points.len() as f64).sqrt();
    assert!(distance(&points, &quick.pose, &exact.pose) < 1e-3 * standard_error);
    assert!((quick.rms - exact.rms).abs() < 1e-6 * exact.rms);
}

#[test]
fn points_that_hang_over_the_end_of_a_model_are_doubtful() {
    let mut random = Random::new(23);
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]];
    let corners = corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
    let plate = MeshField::new(&TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap();
    let mut scan = |length: f64| -> Points {
        (0..3000)
            .map(|_| {
                let (x, y) = (length * (random.uniform() - 0.5) + 2.0, 2.0 * random.uniform());
                Vector3::new(x, y, 0.001 * random.normal())
            })
            .collect()
    };
    let options = RegisterOptions::default().with_outliers(Outliers::None);
    let long = register(&plate, &Source::new(&scan(4.5)), &Pose::identity(), &options).unwrap();
    assert_eq!((long.status, long.support.doubt), (Status::Doubtful, Some(Doubt::LargeDistances)), "{long}");
    assert!(long.support.along_surface.unwrap() > 0.9);
    let fitting = register(&plate, &Source::new(&scan(3.9)), &Pose::identity(), &options).unwrap();
    assert_eq!(fitting.status, Status::Converged, "{fitting}");
}
