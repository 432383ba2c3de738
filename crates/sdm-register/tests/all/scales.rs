//! Registrations with an unknown scale.

use crate::common::{Random, distance, model};
use distance_field::{CloudField, SurfaceField};
use nalgebra::{Point3, Vector3};
use nurbs_core::ParametricSurface;
use sdm_register::{Outliers, Pose, RegisterOptions, Source, Status, register, rotation};

fn part(u: [f64; 2], v: [f64; 2], count: usize, random: &mut Random) -> Vec<Vector3<f64>> {
    let surface = model();
    (0..count)
        .map(|_| {
            let u = u[0] + (u[1] - u[0]) * random.uniform();
            surface.point(u, v[0] + (v[1] - v[0]) * random.uniform())
        })
        .collect()
}

/// The pose from a scan in another unit to the model; the scan lies turned about its own origin.
fn truth(scale: f64, degrees: f64, random: &mut Random) -> Pose<3> {
    let turn = rotation::exponential::<3>(&(random.vector().normalize() * f64::to_radians(degrees))).0;
    Pose { scale, ..Pose::new(turn, random.vector() * 0.05) }
}

#[test]
fn scales_come_back_to_the_last_digits() {
    let field = SurfaceField::new(&model()).unwrap();
    let options = RegisterOptions::default().with_scale(true);
    let all = [0.02, 0.98];
    let mut wrong = Vec::new();
    for (k, exponent) in (-6..=6).enumerate() {
        for (u, v) in [(all, all), ([0.05, 0.7], all), ([0.3, 0.9], [0.1, 0.95])] {
            let mut random = Random::new(k as u64 + 1);
            let scale = 10f64.powf(f64::from(exponent) * 0.5) * (0.9 + 0.2 * random.uniform());
            let truth = truth(scale, 12.0, &mut random);
            let on: Vec<_> = part(u, v, 1500, &mut random);
            let points: Vec<_> = on.iter().map(|x| truth.inverse().apply(x)).collect();
            let report = register(&field, &Source::new(&points), &Pose::identity(), &options).unwrap();
            let error = (report.pose.scale / truth.scale - 1.0).abs();
            let off = distance(&points, &report.pose, &truth) / 2.2;
            if !report.is_converged() || error > 1e-10 || off > 1e-10 {
                wrong.push(format!(
                    "{scale} {u:?} {v:?}: {error:.1e} {off:.1e} {report} | {}",
                    report.support
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn noise_outliers_and_clouds_as_models() {
    let (surface, options) = (model(), RegisterOptions::default().with_scale(true));
    let field = SurfaceField::new(&surface).unwrap();
    let mut random = Random::new(4);
    let dense: Vec<_> =
        part([0.0, 1.0], [0.0, 1.0], 12_000, &mut random).into_iter().map(Point3::from).collect();
    let cloud = CloudField::new(&dense, None).unwrap();
    for scale in [0.04, 1.0, 25.4] {
        let truth = truth(scale, 10.0, &mut random);
        let on = part([0.1, 0.9], [0.1, 0.9], 2000, &mut random);
        let mut points: Vec<_> =
            on.iter().map(|x| truth.inverse().apply(&(x + random.vector() * 1e-3))).collect();
        let report = register(&field, &Source::new(&points), &Pose::identity(), &options).unwrap();
        assert!(report.is_converged(), "{scale}: {report}");
        assert!((report.pose.scale / truth.scale - 1.0).abs() < 1e-3, "{scale}: {report}");
        // Reported lengths are in the unit of the model.
        assert!((report.rms / 1e-3 - 1.0).abs() < 0.1, "{scale}: {report}");
        assert!((report.covariance.as_ref().unwrap().sigma / 1e-3 - 1.0).abs() < 0.1);
        let report = register(&cloud, &Source::new(&points), &Pose::identity(), &options).unwrap();
        assert!(report.is_converged(), "cloud {scale}: {report} | {}", report.support);
        assert!((report.pose.scale / truth.scale - 1.0).abs() < 5e-3, "cloud {scale}: {report}");
        points.extend((0..600).map(|_| {
            let x =
                Vector3::new(2.0 * random.uniform(), 0.8 * random.uniform(), 0.8 * random.uniform() - 0.2);
            truth.inverse().apply(&x)
        }));
        let report = register(&field, &Source::new(&points), &Pose::identity(), &options).unwrap();
        assert!(report.is_converged(), "outliers {scale}: {report} | {}", report.support);
        assert!((report.pose.scale / truth.scale - 1.0).abs() < 2e-3, "outliers {scale}: {report}");
        assert!(report.limit.unwrap() > 2e-3 && report.limit.unwrap() < 1e-2, "{report}");
    }
}

#[test]
fn a_collapse_is_never_converged() {
    let field = SurfaceField::new(&model()).unwrap();
    let mut random = Random::new(6);
    for scale in [1e-12, 1e-3, 1.0, 1e9] {
        let points: Vec<_> = (0..800).map(|_| random.vector() / scale).collect();
        for outliers in [Outliers::Automatic, Outliers::None] {
            let options = RegisterOptions::default().with_scale(true).with_outliers(outliers);
            let report = register(&field, &Source::new(&points), &Pose::identity(), &options).unwrap();
            assert!(!report.is_converged(), "{scale}: {report} | {}", report.support);
            assert_ne!(report.status, Status::Cancelled);
        }
    }
}
