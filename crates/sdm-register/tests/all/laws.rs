//! What must hold for every registration: locks, units, free motions, covariance, bad input.

use crate::common::{Random, case, distance, model};
use distance_field::{CurveField, DistanceField, Search, SurfaceField};
use nalgebra::{Matrix3, Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, Cylinder, Frame, Interval, KnotVector, ParametricCurve, ParametricSurface, Plane, Sphere,
};
use sdm_register::{
    Error, FreeMotion, Locks, NonFinite, Outliers, Pose, RegisterOptions, Source, Status, register, rotation,
};

fn turn(w: Vector3<f64>) -> Matrix3<f64> {
    rotation::exponential::<3>(&w).0
}

/// Points of the model with noise, and the pose that takes them from where they are back to it.
fn scan(n: usize, noise: f64, seed: u64) -> (Vec<Vector3<f64>>, Pose<3>) {
    let (surface, mut random) = (model(), Random::new(seed));
    let truth = Pose::new(turn(Vector3::new(0.5, -0.8, 0.3)), Vector3::new(0.3, -1.0, 2.0));
    let points = (0..n)
        .map(|_| {
            let x = surface.point(0.05 + 0.9 * random.uniform(), 0.05 + 0.9 * random.uniform());
            truth.inverse().apply(&(x + random.vector() * noise))
        })
        .collect();
    (points, truth)
}

fn near(truth: &Pose<3>, angle: f64) -> Pose<3> {
    let w = Vector3::new(0.6, -0.64, 0.48) * angle;
    truth.followed_by(&Pose::new(turn(w), Vector3::new(0.02, 0.01, -0.03)))
}

#[test]
fn locks_give_the_constrained_minimum() {
    let field = SurfaceField::new(&model()).unwrap();
    let (points, truth) = scan(400, 1e-3, 1);
    let start = near(&truth, 0.05);
    let axes = turn(Vector3::new(0.2, 0.9, -0.4));
    let locks = Locks::default().with_frame(Vector3::new(0.5, 0.1, 0.2), axes);
    let cost = |pose: &Pose<3>| {
        let moved: Vec<_> = points.iter().map(|x| pose.apply(x)).collect();
        field.frames(&moved, Search::Global, &[]).iter().map(|f| f.distance * f.distance).sum::<f64>()
    };
    for (translations, rotations) in [
        ([true, false, false], [false, false, false]),
        ([false, true, true], [true, false, true]),
        ([true, true, true], [false, false, false]),
        ([false, false, false], [true, true, true]),
        ([false, true, false], [false, true, false]),
    ] {
        let locks = locks.with_translations(translations).with_rotations(rotations);
        let options = RegisterOptions::default().with_locks(locks).with_outliers(Outliers::None);
        let report = register(&field, &Source::new(&points), &start, &options).unwrap();
        assert!(report.is_converged(), "{report}");
        let moved = start.inverse().followed_by(&report.pose);
        let t = axes.tr_mul(&(moved.apply(&locks.origin) - locks.origin));
        let w = axes.tr_mul(&moved.rotation_vector());
        let least = cost(&report.pose);
        for i in 0..3 {
            assert!(!translations[i] || t[i].abs() < 1e-12, "{t}");
            assert!(!rotations[i] || w[i].abs() < 1e-12, "{w}");
            // No free coordinate lowers the cost.
            for h in [-1e-4, 1e-4] {
                let (mut t, mut w) = (t, w);
                if !translations[i] {
                    t[i] += h;
                }
                if !rotations[i] {
                    w[i] += h;
                }
                let about = Pose {
                    source_origin: locks.origin,
                    target_origin: locks.origin + axes * t,
                    ..Pose::new(turn(axes * w), Vector3::zeros())
                };
                assert!(
                    cost(&start.followed_by(&about)) >= least * (1.0 - 1e-9),
                    "{translations:?} {rotations:?}"
                );
            }
        }
    }
}

#[test]
fn the_scale_is_found() {
    let (points, truth) = scan(500, 0.0, 2);
    let small: Vec<_> = points.iter().map(|x| x / 1.03).collect();
    let field = SurfaceField::new(&model()).unwrap();
    let options = RegisterOptions::default().with_scale(true).with_outliers(Outliers::None);
    let report = register(&field, &Source::new(&small), &near(&truth, 0.05), &options).unwrap();
    assert!(
        report.is_converged() && (report.pose.scale - 1.03).abs() < 1e-12,
        "{report} {}",
        report.pose.scale
    );
}

#[test]
fn units_and_origins_do_not_matter() {
    let (points, truth) = scan(300, 1e-3, 3);
    let start = near(&truth, 0.3);
    let options = RegisterOptions::default();
    let field = SurfaceField::new(&model()).unwrap();
    let plain = register(&field, &Source::new(&points), &start, &options).unwrap().pose;
    for (unit, far) in [(1e3, 0.0), (1e-3, 0.0), (1.0, 2e5), (1e3, 2e5)] {
        let (a, b) =
            (Vector3::new(0.6, -0.64, 0.48) * far * unit, Vector3::new(-0.48, 0.6, 0.64) * far * unit);
        let surface = model().scaled(unit, &Vector3::zeros()).unwrap().translated(&b).unwrap();
        let field = SurfaceField::new(&surface).unwrap();
        let there = |pose: &Pose<3>| Pose {
            source_origin: pose.source_origin * unit + a,
            target_origin: pose.target_origin * unit + b,
            ..*pose
        };
        let cloud: Vec<_> = points.iter().map(|x| x * unit + a).collect();
        let found = register(&field, &Source::new(&cloud), &there(&start), &options).unwrap();
        let difference = distance(&cloud, &found.pose, &there(&plain)) / (2.2 * unit);
        assert!(difference < 1e-9 + 1e-15 * far, "{unit} {far}: {difference:e} {found}");
    }
}

#[test]
fn free_motions_are_named_and_left_alone() {
    let tilt = Pose::new(turn(Vector3::new(0.03, 0.02, 0.05)), Vector3::new(0.01, 0.02, 0.03));
    let frame = Frame::WORLD;
    let range = Interval::new(-9.0, 9.0).unwrap();
    let plane = Plane::new(frame, range, range).to_nurbs().unwrap();
    let sphere = Sphere::new(frame, 1.0).unwrap().to_nurbs().unwrap();
    let cylinder = Cylinder::new(frame, 1.0, range).unwrap().to_nurbs().unwrap();
    let mut random = Random::new(4);
    for (name, surface, free) in [("plane", plane, 3), ("sphere", sphere, 3), ("cylinder", cylinder, 2)] {
        let [u, v] = surface.domain();
        let points: Vec<_> = (0..400)
            .map(|_| {
                let at = |i: &Interval, r: f64| i.start() + i.length() * (0.4 + 0.2 * r);
                let (a, b) = (random.uniform(), random.uniform());
                surface.point(at(&u, a), at(&v, b)) + random.vector() * 1e-4
            })
            .collect();
        let field = SurfaceField::new(&surface).unwrap();
        let options = RegisterOptions::default();
        let report = register(&field, &Source::new(&points), &tilt, &options).unwrap();
        assert!(report.is_converged() && report.rms < 2e-4, "{name}: {report}");
        assert_eq!(report.free_motions.len(), free, "{name}: {report}");
        let translations =
            report.free_motions.iter().filter(|m| matches!(m, FreeMotion::Translation { .. })).count();
        assert_eq!(
            translations,
            [("plane", 2), ("sphere", 0), ("cylinder", 1)].into_iter().find(|x| x.0 == name).unwrap().1
        );
        // Started again from the result moved along the free motions it stays there.
        let slid = match name {
            "plane" => Pose::new(turn(Vector3::z() * 0.2), Vector3::new(0.5, 0.3, 0.0)),
            "sphere" => Pose::new(turn(Vector3::new(0.2, -0.3, 0.1)), Vector3::zeros()),
            _ => Pose::new(turn(Vector3::z() * 0.2), Vector3::new(0.0, 0.0, 0.4)),
        };
        let slid = report.pose.followed_by(&slid);
        let again = register(&field, &Source::new(&points), &slid, &options).unwrap();
        assert!(distance(&points, &again.pose, &slid) < 1e-6, "{name}: {again}");
    }
}

#[test]
fn the_covariance_foretells_the_scatter() {
    let field = SurfaceField::new(&model()).unwrap();
    let options = RegisterOptions::default().with_outliers(Outliers::None).with_tolerance(1e-9);
    let (mut sum, runs) = (0.0, 400);
    for seed in 0..runs {
        let (points, truth) = scan(200, 1e-3, 100 + seed);
        let report = register(&field, &Source::new(&points), &near(&truth, 0.01), &options).unwrap();
        let covariance = report.covariance.clone().unwrap();
        assert!((covariance.sigma - 1e-3).abs() < 4e-4, "{}", covariance.sigma);
        sum += covariance.squared_distance(&report.pose, &truth);
    }
    // Six unknowns: mean 6, standard deviation of the mean of 400 runs 0.17.
    let mean = sum / runs as f64;
    assert!(mean > 5.0 && mean < 7.0, "{mean}");
}

#[test]
fn bad_input_is_an_error_or_a_status() {
    let case = case("cad_zero");
    let start = case.starts[0].1;
    let options = RegisterOptions::default();
    let run = |points: &[Vector3<f64>], options: &RegisterOptions<3>| {
        register(&case.field, &Source::new(points), &start, options)
    };
    assert!(matches!(run(&case.points[..2], &options), Err(Error::TooFewPoints { .. })));
    let line: Vec<_> = (0..100).map(|i| Vector3::x() * f64::from(i)).collect();
    assert!(matches!(run(&line, &options), Err(Error::Collinear { .. })));
    let mut nan = case.points.clone();
    nan[7].y = f64::NAN;
    nan[9].x = f64::INFINITY;
    let dropped = run(&nan, &options).unwrap();
    assert!(dropped.dropped == 2 && case.error(&dropped.pose) < 1e-12, "{dropped}");
    let refused = run(&nan, &options.with_non_finite(NonFinite::Refuse));
    assert_eq!(refused.unwrap_err(), Error::NotFinite { index: 7, count: 2 });
    let far = options.with_rejection(sdm_register::Rejection::default().with_abs_distance(1e-9));
    let away: Vec<_> = case.points.iter().map(|x| x + Vector3::repeat(50.0)).collect();
    assert_eq!(run(&away, &far.with_outliers(Outliers::None)).unwrap().status, Status::NoOverlap);
    let bad = options.with_outliers(Outliers::Trimmed { outliers: 1.5 });
    assert!(matches!(run(&case.points, &bad), Err(Error::Option { name: "outliers", .. })));
}

#[test]
fn curves_in_the_plane() {
    let control =
        [[0.0, 0.0], [1.0, 2.0], [3.0, 2.5], [4.0, -1.0], [6.0, 0.5], [7.0, 3.0]].map(Vector2::from);
    let knots = KnotVector::new(3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0]).unwrap();
    let curve = BsplineCurve::<2>::new(knots, control.to_vec(), None).unwrap();
    let field = CurveField::new(&curve).unwrap();
    let truth = Pose::new(rotation::exponential::<2>(&(Vector3::x() * 0.4)).0, Vector2::new(5.0, -3.0));
    let points: Vec<_> =
        (0..200).map(|i| truth.inverse().apply(&curve.point(0.1 + 2.8 * f64::from(i) / 199.0))).collect();
    let start = truth
        .followed_by(&Pose::new(rotation::exponential::<2>(&(Vector3::x() * 0.2)).0, Vector2::new(0.2, 0.3)));
    let report = register(&field, &Source::new(&points), &start, &RegisterOptions::default()).unwrap();
    assert!(report.is_converged() && distance(&points, &report.pose, &truth) < 1e-12, "{report}");
    assert_eq!(report.covariance.unwrap().rows.len(), 3);
}
