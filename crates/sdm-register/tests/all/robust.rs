//! Clouds with outliers, with parts that the model does not have, and with normals that do not fit.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::common::{Case, Random, case, distance, model};
use distance_field::SurfaceField;
use nalgebra::{Matrix3, Vector3};
use nurbs_core::{Direction, Interval, ParametricSurface};
use sdm_register::{
    Kernel, Outliers, Pose, RegisterOptions, RegisterReport, Rejection, Source, register, rotation,
};

fn run(case: &Case, start: &Pose<3>, outliers: Outliers) -> RegisterReport<3> {
    let options = RegisterOptions::default().with_outliers(outliers);
    register(&case.field, &Source::new(&case.points), start, &options).unwrap()
}

/// Points of a part of the model (`u` from, to) with noise.
fn cloud(from: f64, to: f64, count: usize, noise: f64, random: &mut Random) -> Vec<Vector3<f64>> {
    let surface = model();
    (0..count)
        .map(|_| {
            let (u, v) = (from + (to - from) * random.uniform(), 0.03 + 0.94 * random.uniform());
            surface.point(u, v) + random.vector() * noise
        })
        .collect()
}

/// A start that is displaced about the centre of the points.
fn start(points: &[Vector3<f64>], degrees: f64, random: &mut Random) -> Pose<3> {
    let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let axis = random.vector().normalize() * degrees.to_radians();
    let turn: Matrix3<f64> = rotation::exponential::<3>(&axis).0;
    let shift = random.vector().normalize() * 0.1 * random.uniform();
    Pose { scale: 1.0, rotation: turn, source_origin: centre, target_origin: centre + shift }
}

#[test]
fn a_cloud_that_slides_off_the_model_is_brought_back() {
    let case = case("cad_out20");
    // From here the points at the edges are left out one after the other, until a few fit well.
    let (degrees, start) = &case.starts[93];
    let report = run(&case, start, Outliers::Automatic);
    assert!(report.is_converged(), "{degrees}: {report}");
    assert!(case.error(&report.pose) <= 1.7e-4, "{degrees}: {report}, {:e}", case.error(&report.pose));
}

#[test]
fn half_of_the_points_are_outliers() {
    let mut random = Random::new(5);
    let field = SurfaceField::new(&model()).unwrap();
    let bounds = model().control_box();
    let mut points = cloud(0.03, 0.97, 1500, 2e-3, &mut random);
    points.extend((0..1500).map(|_| {
        let inside = Vector3::new(random.uniform(), random.uniform(), random.uniform());
        let margin = Vector3::repeat(0.2);
        bounds.min - margin + inside.component_mul(&(bounds.max - bounds.min + margin * 2.0))
    }));
    let inliers = &points[..1500];
    let options = RegisterOptions::default();
    let plain = options.with_outliers(Outliers::None);
    let optimum = register(&field, &Source::new(inliers), &Pose::identity(), &plain).unwrap().pose;
    for degrees in [5.0, 15.0, 30.0, 40.0, 50.0, 60.0, 60.0] {
        let start = start(&points, degrees, &mut random);
        let report = register(&field, &Source::new(&points), &start, &options).unwrap();
        let error = distance(inliers, &report.pose, &optimum) / 2.2;
        // Outliers that lie on the surface by chance cannot be told apart.
        assert!(report.is_converged() && error <= 1.5e-4, "{degrees}: {report}, {error:e}");
        assert!(report.used > 1480 && report.used < 1560, "{report}");
    }
}

#[test]
fn half_of_the_scan_has_no_counterpart() {
    let mut random = Random::new(6);
    let half = model().trimmed(Direction::U, Interval::new(0.0, 0.5).unwrap()).unwrap();
    let field = SurfaceField::new(&half).unwrap();
    let mut points = cloud(0.03, 0.5, 1500, 0.0, &mut random);
    points.extend(cloud(0.5, 0.97, 1500, 0.0, &mut random));
    for degrees in [5.0, 15.0, 30.0, 40.0, 50.0, 60.0] {
        let start = start(&points, degrees, &mut random);
        let report = register(&field, &Source::new(&points), &start, &RegisterOptions::default()).unwrap();
        let error = distance(&points[..1500], &report.pose, &Pose::identity());
        assert!(report.is_converged() && error <= 1e-9, "{degrees}: {report}, {error:e}");
    }
}

#[test]
fn a_known_share_of_the_points_is_trimmed() {
    let case = case("cad_out20");
    for (degrees, start) in case.starts.iter().step_by(17).take(3) {
        let report = run(&case, start, Outliers::Trimmed { outliers: 0.22 });
        assert!(case.error(&report.pose) <= 3e-4, "{degrees}: {report}, {:e}", case.error(&report.pose));
        assert!(report.used.abs_diff(4875) <= 2, "{report}");
    }
}

#[test]
fn every_kernel_resists_outliers() {
    let case = case("cad_out20");
    let start = &case.starts[30].1;
    for kernel in Kernel::ALL {
        let report = run(&case, start, Outliers::Kernel { kernel, abs_scale: None });
        let error = case.error(&report.pose);
        // The more the weights fall the less is left of the outliers.
        let (low, high) = match kernel {
            Kernel::Square => (1e-3, 1.0),
            Kernel::Huber => (1e-4, 5e-3),
            Kernel::Cauchy => (5e-5, 5e-4),
            Kernel::Welsch | Kernel::Tukey => (5e-5, 2e-4),
        };
        assert!(error > low && error < high, "{kernel}: {report}, {error:e}");
        let scaled = run(&case, start, Outliers::Kernel { kernel, abs_scale: Some(0.01) });
        assert_eq!(scaled.limit, (kernel != Kernel::Square).then_some(0.01));
    }
}

#[test]
fn points_whose_normals_disagree_do_not_count() {
    let mut random = Random::new(8);
    let surface = model();
    let field = SurfaceField::new(&surface).unwrap();
    // A rib: points near the surface whose normals are at right angles to its normals, all on one side.
    let (mut points, mut normals) = (Vec::new(), Vec::new());
    for i in 0..1200 {
        let jet = surface.jet(0.1 + 0.8 * random.uniform(), 0.1 + 0.8 * random.uniform());
        let normal = jet.unit_normal().unwrap();
        let is_rib = i % 3 == 0;
        points.push(jet.point + normal * if is_rib { 0.02 * random.uniform() } else { 0.0 });
        normals.push(if is_rib { jet.du.normalize() } else { normal * if i % 2 == 0 { 1.0 } else { -1.0 } });
    }
    let start = start(&points, 5.0, &mut random);
    let source = Source::new(&points).with_normals(&normals);
    let options = RegisterOptions::default().with_outliers(Outliers::None);
    let all = register(&field, &source, &start, &options).unwrap();
    assert!(distance(&points, &all.pose, &Pose::identity()) > 1e-3);
    let rejection = Rejection::default().with_normal_angle(0.5);
    let report = register(&field, &source, &start, &options.with_rejection(rejection)).unwrap();
    assert!(report.is_converged() && report.used == 800, "{report}");
    assert!(distance(&points, &report.pose, &Pose::identity()) < 1e-12, "{report}");
    // With sides that count, half of the rest is left.
    let oriented = Rejection { oriented_normals: true, ..rejection };
    let report = register(&field, &source, &start, &options.with_rejection(oriented)).unwrap();
    assert_eq!(report.used, 400, "{report}");
}
