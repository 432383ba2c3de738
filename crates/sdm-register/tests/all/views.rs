//! Many views at once, through the public API.

use crate::bodies;
use crate::bodies::SixViews;
use footpoint::no_progress;
use nalgebra::Vector3;
use sdm_register::views::{
    View, ViewsOptions, ViewsReport, ViewsStatus, register_views, register_views_from,
};
use sdm_register::{Error, Pose};
use std::ops::ControlFlow;

fn views(six: &SixViews) -> Vec<View> {
    six.points.iter().map(|points| View::new(points)).collect()
}

fn poses(report: &ViewsReport) -> Vec<Pose<3>> {
    report.views.iter().map(|view| view.pose).collect()
}

#[test]
fn six_exact_views_agree_to_a_millionth() {
    let six = SixViews::new(4000, 0.0, 0.12, 1);
    let before = six.error(&six.initial);
    let report = register_views(&views(&six), &six.initial, &ViewsOptions::default(), &no_progress).unwrap();
    let error = six.error(&poses(&report));
    assert_eq!(report.status, ViewsStatus::Converged, "{report}");
    assert!(before > 0.02 && error < 5e-6, "{before} {error}");
    assert_eq!(report.components, [vec![0, 1, 2, 3, 4, 5]]);
    // Opposite views do not overlap, all others do.
    assert!(report.pairs.len() >= 12, "{}", report.pairs.len());
    for pair in report.pairs.iter().filter(|pair| pair.count > 500) {
        assert!(pair.rms_after < 1e-3 * pair.rms_before, "{pair:?}");
    }
    // The first view is held.
    let origin = Vector3::new(0.1, 0.2, 0.3);
    assert!((report.views[0].pose.apply(&origin) - six.initial[0].apply(&origin)).norm() < 1e-12);
}

#[test]
fn noise_averages_out_and_the_covariance_says_how_far() {
    let noise = 1e-3;
    let six = SixViews::new(2500, noise, 0.1, 2);
    let report = register_views(&views(&six), &six.initial, &ViewsOptions::default(), &no_progress).unwrap();
    let error = six.error(&poses(&report));
    assert_eq!(report.status, ViewsStatus::Converged, "{report}");
    assert!(error < 0.5 * noise, "{error}");
    let covariance = report.views[3].covariance.unwrap();
    let expected = (covariance.fixed_view::<3, 3>(3, 3).trace() / 3.0).sqrt() / six.diameter;
    assert!(expected > 0.02 * error && expected < 2.0 * noise, "{expected} {error}");
    assert_eq!(report.views[0].covariance.unwrap().norm(), 0.0);
}

#[test]
fn far_coordinates_and_other_units_change_nothing() {
    let six = SixViews::new(1500, 0.0, 0.1, 3);
    let plain = register_views(&views(&six), &six.initial, &ViewsOptions::default(), &no_progress).unwrap();
    let (shift, unit) = (Vector3::new(1e6, -2e6, 3e5), 1e3);
    let moved: Vec<View> = six
        .points
        .iter()
        .map(|points| View::new(&points.iter().map(|x| x * unit + shift).collect::<Vec<_>>()))
        .collect();
    let initial: Vec<Pose<3>> = (six.initial.iter())
        .map(|pose| Pose { source_origin: shift, target_origin: pose.translation() * unit + shift, ..*pose })
        .collect();
    let far = register_views(&moved, &initial, &ViewsOptions::default(), &no_progress).unwrap();
    for (a, b) in plain.views.iter().zip(&far.views) {
        let x = Vector3::new(0.3, -0.2, 0.5);
        let gap = (a.pose.apply(&x) * unit + shift - b.pose.apply(&(x * unit + shift))).norm();
        assert!(gap < 1e-6 * unit, "{gap}");
    }
}

#[test]
fn tells_which_views_hang_loose() {
    let six = SixViews::new(800, 0.0, 0.05, 4);
    let mut initial = six.initial.clone();
    // The last view far away from all others.
    initial[5].target_origin += Vector3::repeat(100.0);
    let report = register_views(&views(&six), &initial, &ViewsOptions::default(), &no_progress).unwrap();
    assert_eq!(report.status, ViewsStatus::Disconnected);
    assert_eq!(report.components, [vec![0, 1, 2, 3, 4], vec![5]]);
    assert_eq!(report.views[5].component, 1);

    let two = &views(&six)[..2];
    let apart = [Pose::identity(), Pose::new(nalgebra::Matrix3::identity(), Vector3::repeat(1e3))];
    let report = register_views(two, &apart, &ViewsOptions::default(), &no_progress).unwrap();
    assert_eq!(report.status, ViewsStatus::NoOverlap);
    assert!(report.pairs.is_empty() && report.views[1].covariance.is_none());
}

#[test]
fn planes_stay_where_nothing_holds_them() {
    let mut random = bodies::Random(9);
    let mut plane =
        || View::new(&(0..800).map(|_| Vector3::new(random.unit(), random.unit(), 0.0)).collect::<Vec<_>>());
    let both = [plane(), plane()];
    let tilt = bodies::Random(3).motion(0.05, 0.02);
    let report =
        register_views(&both, &[Pose::identity(), tilt], &ViewsOptions::default(), &no_progress).unwrap();
    assert_eq!(report.status, ViewsStatus::Underdetermined);
    let pose = report.views[1].pose;
    assert!(pose.rotate(&Vector3::z()).xy().norm() < 1e-6);
    assert!(
        pose.is_finite()
            && (pose.apply(&Vector3::repeat(0.5)) - tilt.apply(&Vector3::repeat(0.5))).norm() < 0.1
    );
}

#[test]
fn bad_input_is_an_error_and_cancelling_a_status() {
    let six = SixViews::new(300, 0.0, 0.05, 5);
    let mut all = views(&six);
    let cancelled =
        register_views(&all, &six.initial, &ViewsOptions::default(), &|_, _| ControlFlow::Break(()));
    assert_eq!(cancelled.unwrap().status, ViewsStatus::Cancelled);
    let wrong = register_views(&all, &six.initial[..5], &ViewsOptions::default(), &no_progress);
    assert!(matches!(wrong, Err(Error::Length { found: 5, .. })));
    all[3] = View::new(&[Vector3::x(), Vector3::repeat(f64::NAN), Vector3::y()]);
    let error = register_views(&all, &six.initial, &ViewsOptions::default(), &no_progress).unwrap_err();
    assert_eq!(error.to_string(), "view 3: 2 of 3 points can be used, at least 3 are needed");
    all[3] = View::new(&[]);
    assert!(register_views_from(&all, &ViewsOptions::default(), &no_progress).is_err());
    all[3] = View::new(&[Vector3::x(); 50]);
    assert!(register_views(&all, &six.initial, &ViewsOptions::default(), &no_progress).is_err());
    let options = ViewsOptions::default().with_neighbours(1);
    assert!(matches!(
        register_views(&views(&six), &six.initial, &options, &no_progress),
        Err(Error::Option { name: "neighbours", .. })
    ));
}

#[test]
fn finds_the_poses_without_a_start() {
    let six = SixViews::seeing(1.5, 1500, 0.0, 0.1, 6);
    let report = register_views_from(&views(&six), &ViewsOptions::default(), &no_progress).unwrap();
    let error = six.error(&poses(&report));
    assert_eq!(report.status, ViewsStatus::Converged, "{report}");
    assert!(error < 5e-5, "{error}");
}

#[test]
fn spheres_keep_the_turns_that_their_poses_give() {
    let mut random = crate::common::Random::new(9);
    let mut cap = |axis: Vector3<f64>| -> Vec<Vector3<f64>> {
        std::iter::repeat_with(|| random.vector().normalize())
            .filter(|x| x.dot(&axis) > -0.3)
            .take(1500)
            .collect()
    };
    let caps = [cap(Vector3::x()), cap(Vector3::y())];
    let pose = Pose::new(
        sdm_register::rotation::exponential::<3>(&Vector3::new(0.3, 0.5, -1.0)).0,
        Vector3::new(2.0, 0.0, 1.0),
    );
    let back = pose.inverse();
    let second: Vec<_> = caps[1].iter().map(|x| back.apply(x)).collect();
    let views = [View::new(&caps[0]), View::new(&second)];
    let start = [Pose::identity(), pose];
    let report = register_views(&views, &start, &ViewsOptions::default(), &no_progress).unwrap();
    assert_eq!(report.status, ViewsStatus::Underdetermined);
    assert!(report.history.len() < 20, "{}", report.history.len());
    let moved = second.iter().map(|x| (report.views[1].pose.apply(x) - pose.apply(x)).norm());
    let farthest = moved.fold(0.0, f64::max);
    assert!(farthest < 1e-4, "{farthest}");
}
