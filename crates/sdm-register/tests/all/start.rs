//! Coarse starts, through the public API.

#![allow(clippy::unwrap_used, reason = "helpers of tests may panic, too")]

use crate::bodies::{Bumpy, Random};
use footpoint::no_progress;
use nalgebra::Vector3;
use sdm_register::start::{
    CoarseStart, OrientedPoints, StartMethod, StartOptions, StartStatus, coarse_start,
};
use sdm_register::{Error, FeatureMatching, Pose};
use std::ops::ControlFlow;

fn model() -> OrientedPoints {
    let (points, normals) = Bumpy::new().view(None, 8000, &mut Random(1));
    OrientedPoints::new(&points, &normals).unwrap()
}

/// Points moved by a pose, normals with random signs.
fn moved(
    points: &[Vector3<f64>],
    normals: &[Vector3<f64>],
    pose: &Pose<3>,
    random: &mut Random,
) -> OrientedPoints {
    let x: Vec<_> = points.iter().map(|x| pose.apply(x)).collect();
    let n: Vec<_> =
        normals.iter().map(|n| pose.rotate(n) * if random.unit() < 0.5 { -1.0 } else { 1.0 }).collect();
    OrientedPoints::new(&x, &n).unwrap()
}

fn error(found: &Pose<3>, motion: &Pose<3>, points: &[Vector3<f64>]) -> f64 {
    let sum: f64 = points.iter().map(|x| (found.apply(&motion.apply(x)) - x).norm_squared()).sum();
    (sum / points.len() as f64).sqrt()
}

#[test]
fn finds_any_rotation_of_a_whole_scan_a_part_and_among_outliers() {
    let start = CoarseStart::new(&model(), &StartOptions::default()).unwrap();
    let mut random = Random(2);
    let part = Some((Vector3::y(), 1.3));
    for (name, towards, outliers) in [("whole", None, 0), ("part", part, 0), ("outliers", None, 2000)] {
        for _ in 0..3 {
            let (mut points, mut normals) = Bumpy::new().view(towards, 2000, &mut random);
            let inliers = points.len();
            for _ in 0..outliers {
                points.push(random.vector().map(|c: f64| c.clamp(-1.5, 1.5)));
                normals.push(random.vector());
            }
            let motion = Pose::new(random.rotation(), random.vector() * 4.0);
            let cloud = moved(&points, &normals, &motion, &mut random);
            let report = start.search(&cloud, &no_progress).unwrap();
            let best = report.best().unwrap();
            let error = error(&best.pose, &motion, &points[..inliers]);
            assert!(error < 0.01, "{name}: {error}, {report}");
            assert_eq!(report.status, StartStatus::Found, "{name}: {report}");
            assert!(best.share > 0.8 * inliers as f64 / points.len() as f64, "{name}: {report}");
        }
    }
}

#[test]
fn principal_axes_suffice_for_a_whole_scan() {
    let options = StartOptions::default().with_method(StartMethod::PrincipalAxes);
    let mut random = Random(3);
    let (points, normals) = Bumpy::new().view(None, 2000, &mut random);
    let motion = Pose::new(random.rotation(), random.vector());
    let cloud = moved(&points, &normals, &motion, &mut random);
    let report = coarse_start(&model(), &cloud, &options, &no_progress).unwrap();
    assert_eq!((report.rounds, report.tried), (0, 4));
    assert!(error(&report.best().unwrap().pose, &motion, &points) < 0.01, "{report}");
}

#[test]
fn far_coordinates_and_other_units_change_nothing() {
    let (points, normals) = Bumpy::new().view(None, 1000, &mut Random(4));
    let far = |x: &Vector3<f64>| x * 1e3 + Vector3::new(2e6, -3e6, 1e6);
    let big: Vec<_> = model().points().iter().map(far).collect();
    let big = OrientedPoints::new(&big, model().normals()).unwrap();
    let motion = Pose::new(Random(5).rotation(), Vector3::zeros());
    let cloud: Vec<_> = points.iter().map(|x| far(&motion.apply(x))).collect();
    let turned: Vec<_> = normals.iter().map(|n| motion.rotate(n)).collect();
    let cloud = OrientedPoints::new(&cloud, &turned).unwrap();
    let report = coarse_start(&big, &cloud, &StartOptions::default(), &no_progress).unwrap();
    let pose = report.best().unwrap().pose;
    let gap = points.iter().map(|x| (pose.apply(&far(&motion.apply(x))) - far(x)).norm()).fold(0.0, f64::max);
    assert!(gap < 20.0, "{gap} of 2000");
}

#[test]
fn shapes_that_slide_along_themselves_are_called_ambiguous() {
    let mut random = Random(6);
    for (cylinder, free) in [(false, 3), (true, 2)] {
        let mut sample = |count: usize| {
            let (mut points, mut normals) = (Vec::new(), Vec::new());
            for _ in 0..count {
                let mut n = random.vector();
                if cylinder {
                    n.z = 0.0;
                }
                let n = n.normalize();
                let along = if cylinder { Vector3::z() * (6.0 * random.unit()) } else { Vector3::zeros() };
                points.push(n + along);
                normals.push(n);
            }
            OrientedPoints::new(&points, &normals).unwrap()
        };
        let (model, cloud) = (sample(4000), sample(1000));
        let options = StartOptions::default().with_max_rounds(3);
        let report = coarse_start(&model, &cloud, &options, &no_progress).unwrap();
        assert_eq!(report.status, StartStatus::Ambiguous, "{report}");
        assert_eq!(report.free_motions, free, "{report}");
        assert!(report.candidates.iter().all(|candidate| candidate.pose.is_finite()));
    }
}

#[test]
fn what_does_not_fit_is_not_found() {
    let mut random = Random(7);
    let mut noise = || (0..500).map(|_| random.vector() * 50.0).collect::<Vec<_>>();
    let (points, normals) = (noise(), noise());
    let cloud = OrientedPoints::new(&points, &normals).unwrap();
    let options = StartOptions::default().with_max_rounds(2);
    let report = coarse_start(&model(), &cloud, &options, &no_progress).unwrap();
    assert_eq!(report.status, StartStatus::NotFound, "{report}");
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let mut random = Random(8);
    let (points, normals) = Bumpy::new().view(Some((Vector3::x(), 1.2)), 700, &mut random);
    let cloud = OrientedPoints::new(&points, &normals).unwrap();
    let options = StartOptions::default().with_max_rounds(2);
    let run = || coarse_start(&model(), &cloud, &options, &no_progress).unwrap();
    assert_eq!(run(), run());
}

#[test]
fn bad_input_is_an_error_and_cancelling_a_status() {
    let few = OrientedPoints::new(&[Vector3::x(); 2], &[Vector3::z(); 2]).unwrap();
    let one_place = OrientedPoints::new(&[Vector3::x(); 9], &[Vector3::z(); 9]).unwrap();
    let nan = OrientedPoints::new(&[Vector3::repeat(f64::NAN); 9], &[Vector3::z(); 9]).unwrap();
    for bad in [few, one_place, nan] {
        let options = StartOptions::default();
        assert!(matches!(coarse_start(&bad, &model(), &options, &no_progress), Err(Error::Input { .. })));
        assert!(matches!(coarse_start(&model(), &bad, &options, &no_progress), Err(Error::Input { .. })));
    }
    let options = StartOptions::default().with_tolerance(-1.0);
    assert!(matches!(CoarseStart::new(&model(), &options), Err(Error::Option { name: "tolerance", .. })));
    let report =
        coarse_start(&model(), &model(), &StartOptions::default(), &|_, _| ControlFlow::Break(())).unwrap();
    assert_eq!(report.status, StartStatus::Cancelled);
}

#[test]
fn matching_by_normals_finds_the_neighbourhood_of_the_pose() {
    let model = model();
    let truth = model.points().to_vec();
    let few: Vec<usize> = (0..truth.len()).step_by(11).collect();
    let points: Vec<_> = few.iter().map(|&i| truth[i]).collect();
    let normals: Vec<_> = few.iter().map(|&i| model.normals()[i]).collect();
    let mut random = Random(5);
    for (width, oriented) in [(0.5, true), (0.5, false), (0.0, true)] {
        let matching = FeatureMatching::new(&model, width, oriented).unwrap();
        let motion = random.motion(0.4, 0.2);
        let cloud = if oriented {
            let x: Vec<_> = points.iter().map(|x| motion.apply(x)).collect();
            let n: Vec<_> = normals.iter().map(|n| motion.rotate(n)).collect();
            OrientedPoints::new(&x, &n).unwrap()
        } else {
            moved(&points, &normals, &motion, &mut random)
        };
        let found = matching.approach(&cloud, &Pose::identity()).unwrap();
        // Samples are 0.03 apart.
        assert!(error(&found.pose, &motion, &points) < 0.05, "w = {width}: {found:?}");
        assert_eq!(found, matching.approach(&cloud, &Pose::identity()).unwrap());
    }
    assert!(matches!(FeatureMatching::new(&model, -1.0, true).unwrap_err(), Error::Option { .. }));
    let none = OrientedPoints::default();
    assert!(matches!(FeatureMatching::new(&none, 1.0, true).unwrap_err(), Error::TooFewPoints { .. }));
    let matching = FeatureMatching::new(&model, 1.0, true).unwrap();
    assert!(matches!(matching.approach(&none, &Pose::identity()).unwrap_err(), Error::TooFewPoints { .. }));
}
