//! The whole way, from clouds of many kinds.

use crate::common::{noise, scattered, vase, vase_point};
use cloud_param::{
    DirectedWeight, Error, FinishOutcome, FitOptions, Neighbourhood, ParameterStatus, ParameteriseOptions,
    RefineOptions, Shape, Stage, SurfaceDefects, dynamic_base_surface, finish_fit, finish_fit_with_progress,
    finish_options, fit_parameters, parameterise, parameterise_with_progress,
};
use footpoint::SurfaceProjector;
use nalgebra::{Rotation3, Vector3};
use nurbs_core::construct::BoundaryCurves;
use nurbs_core::{BsplineCurve, BsplineSurface, ParameterMethod, ParametricCurve, ParametricSurface};
use sdm_fit::FitStep;
use std::ops::ControlFlow;
use std::sync::Mutex;

fn find(points: &[Vector3<f64>]) -> Result<cloud_param::Parameterisation, Error> {
    parameterise(points, &ParameteriseOptions::default())
}

#[test]
fn a_noisy_vase_and_its_fit() {
    let points = vase(8000, 0.02);
    let found = find(&points).unwrap();
    let r = &found.report;
    assert_eq!((r.status, r.shape.shape), (ParameterStatus::Converged, Shape::Cylinder));
    assert!(r.rms < 0.035 && r.unique > 0.99 && r.used > 7990, "{r}");
    let history = &r.curve_history;
    assert!(history[history.len() - 1].rms < history[0].rms);
    assert!(history.iter().all(|s| s.self_loops == 0));
    let fit =
        fit_parameters(&points, &found.base, &found.feet, &found.counts, &FitOptions::default()).unwrap();
    assert!(fit.rms < 0.0225, "{:?}", fit.history);
    assert!(SurfaceDefects::of(&fit.surface, None).is_none());
    // Near the truth: less than the noise.
    let [u, v] = fit.surface.domain();
    let truth: Vec<_> = (0..3000).map(scattered).map(|[a, h]| vase_point(a, h)).collect();
    let projector = SurfaceProjector::new(&fit.surface);
    let squares: f64 = truth.iter().map(|p| projector.project(p).distance.powi(2)).sum();
    assert!((squares / 3000.0).sqrt() < 0.01, "{}", (squares / 3000.0).sqrt());
    // The seam is no seam.
    for k in 0..20 {
        let t = v.lerp(f64::from(k) / 19.0);
        let (a, b) = (fit.surface.jet(u.start(), t), fit.surface.jet(u.end() - 1e-12, t));
        assert!((a.point - b.point).norm() < 1e-9 && (a.duu - b.duu).norm() < 1e-4 * a.duu.norm().max(1.0));
    }
}

#[test]
fn neither_pose_nor_order_nor_threads_matter() {
    let points = vase(3000, 0.01);
    let found = find(&points).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let again = one.install(|| find(&points)).unwrap();
    assert_eq!(found.base, again.base);
    assert!(found.feet.iter().zip(&again.feet).all(|(a, b)| a == b));
    let turn = Rotation3::from_euler_angles(1.0, 0.3, -2.0);
    let moved: Vec<_> =
        points.iter().rev().map(|p| (turn * p) * 1000.0 + Vector3::new(1e6, -2e6, 3e5)).collect();
    let other = find(&moved).unwrap();
    assert!(other.is_converged());
    assert!(
        (other.report.rms / 1000.0 - found.report.rms).abs() < 0.3 * found.report.rms,
        "{} {}",
        other.report,
        found.report
    );
}

#[test]
fn every_weight_and_number_of_views_works() {
    let points = vase(3000, 0.01);
    for weight in [DirectedWeight::Near, DirectedWeight::Axis, DirectedWeight::NearAxis] {
        let options = ParameteriseOptions::default().with_weight(weight).with_views(6).with_grid(48, 20);
        let found = parameterise(&points, &options).unwrap();
        assert!(found.is_converged(), "{weight:?}: {}", found.report);
        assert_eq!((found.report.grid, found.report.views), ([48, 20], 6));
    }
    let two = ParameteriseOptions::default().with_views(2);
    assert!(matches!(parameterise(&points, &two), Err(Error::Option { name: "views", .. })));
}

#[test]
fn holes_and_strays_are_bridged_and_told() {
    let mut points: Vec<_> = vase(9000, 0.01);
    // A window in one side, some points far away, and some that are no points.
    points.retain(|p| !(p.x > 2.0 && p.y.abs() < 1.0 && p.z.abs() < 1.0));
    points.push(Vector3::new(40.0, 0.0, 0.0));
    points.push(Vector3::repeat(f64::NAN));
    let found = find(&points).unwrap();
    assert!(found.is_converged(), "{}", found.report);
    assert_eq!((found.report.dropped, found.report.strays), (1, 1));
    assert!(!found.counts[points.len() - 1] && !found.counts[points.len() - 2] && found.report.max < 0.5);
    let fit =
        fit_parameters(&points, &found.base, &found.feet, &found.counts, &FitOptions::default()).unwrap();
    assert!(
        SurfaceDefects::of(&fit.surface, None).is_none(),
        "{:?} {:?}",
        fit.history,
        SurfaceDefects::of(&fit.surface, None)
    );
}

#[test]
fn uneven_ends_stay_open() {
    let ragged = |[a, h]: [f64; 2]| (h < 0.96 + 0.03 * (9.0 * a).sin()).then(|| vase_point(a, h));
    let points: Vec<_> = (0..8000).map(scattered).filter_map(ragged).collect();
    let found = find(&points).unwrap();
    assert!(found.is_converged(), "{}", found.report);
    assert!(found.report.used as f64 > 0.995 * points.len() as f64);
    assert!(!found.base.knots_v().is_periodic());
}

#[test]
fn planes_and_spheres() {
    let mut seed = 3;
    let turn = Rotation3::from_euler_angles(0.4, 0.5, 0.6);
    let sheet: Vec<_> = (0..4000)
        .map(scattered)
        .map(|[a, b]| turn * Vector3::new(8.0 * a, 5.0 * b, (6.0 * a).sin() * b) + noise(&mut seed, 0.01))
        .collect();
    let found = find(&sheet).unwrap();
    assert_eq!((found.report.shape.shape, found.report.status), (Shape::Plane, ParameterStatus::Converged));
    assert!(found.report.rms < 0.02 && found.base.knots_u().is_clamped(), "{}", found.report);
    let fit =
        fit_parameters(&sheet, &found.base, &found.feet, &found.counts, &FitOptions::default()).unwrap();
    assert!(fit.rms < 0.012, "{:?}", fit.history);

    let ball: Vec<_> = (0..6000)
        .map(scattered)
        .map(|[a, b]| {
            let (t, z) = (std::f64::consts::TAU * a, 2.0 * b - 1.0);
            let d = Vector3::new((1.0 - z * z).sqrt() * t.cos(), (1.0 - z * z).sqrt() * t.sin(), z);
            d.component_mul(&Vector3::new(4.0, 3.0, 5.0)) * (1.0 + 0.05 * (4.0 * t).cos() * (1.0 - z * z))
        })
        .collect();
    let found = find(&ball).unwrap();
    assert_eq!(
        (found.report.shape.shape, found.report.status),
        (Shape::Sphere, ParameterStatus::Converged),
        "{}",
        found.report
    );
    assert!(found.report.rms < 0.03, "{}", found.report);
    let fit = fit_parameters(&ball, &found.base, &found.feet, &found.counts, &FitOptions::default()).unwrap();
    assert!(fit.rms < 0.02, "{:?}", fit.history);
}

#[test]
fn what_is_no_cylinder_is_refused_with_the_reason() {
    let cylinder = ParameteriseOptions::default().with_shape(Shape::Cylinder);
    let why = |points: &[Vector3<f64>], options: &ParameteriseOptions| match parameterise(points, options) {
        Err(Error::Shape { why, .. }) => why,
        Err(other) => other.to_string(),
        Ok(found) => panic!("{}", found.report),
    };
    let half: Vec<_> = (0..6000).map(scattered).map(|[a, h]| vase_point(0.5 * a, h)).collect();
    assert!(why(&half, &cylinder).contains("like a bowl"));
    let along = cylinder.with_axis(Vector3::z());
    assert!(why(&half, &along).contains("gaps of"));
    let mut two = vase(3000, 0.0);
    two.extend(vase(3000, 0.0).iter().map(|p| p + Vector3::new(20.0, 0.0, 0.0)));
    assert!(why(&two, &cylinder).contains("parts"));
    let points = vase(4000, 0.0);
    let wrong = cylinder.with_axis(Vector3::x());
    assert!(why(&points, &wrong).contains("axis (0.0"), "{}", why(&points, &wrong));
    let mut seed = 1;
    let dust: Vec<_> = (0..3000).map(|_| noise(&mut seed, 1.0)).collect();
    if let Ok(found) = find(&dust) {
        assert!(!found.is_converged() || found.report.shape.shape != Shape::Cylinder, "{}", found.report);
    }
    assert!(matches!(find(&points[..10]), Err(Error::TooFewPoints { needed: 100, .. })));
    assert!(matches!(find(&[Vector3::zeros(); 500]), Err(Error::TooFewPoints { usable: 1, .. })));
    let line: Vec<_> = (0..500).map(|i| Vector3::new(f64::from(i), 0.0, 0.0)).collect();
    assert!(parameterise(&line, &cylinder).is_err());
    let nan = vec![Vector3::repeat(f64::NAN); 300];
    assert!(matches!(find(&nan), Err(Error::TooFewPoints { usable: 0, .. })));
}

#[test]
fn points_given_many_times_over_count_once() {
    let once = vase(1500, 0.0);
    let many: Vec<_> = (0..20).flat_map(|_| once.clone()).collect();
    let (found, same) = (find(&many).unwrap(), find(&once).unwrap());
    assert_eq!(
        (found.base == same.base, found.report.used),
        (true, 20 * same.report.used),
        "{}",
        found.report
    );
    let few: Vec<_> = (0..20).flat_map(|_| once[..20].to_vec()).collect();
    assert!(matches!(find(&few), Err(Error::TooFewPoints { total: 400, usable: 20, needed: 100 })));
}

#[test]
fn can_be_cancelled_at_every_stage() {
    let points = vase(2000, 0.0);
    let stages = [
        Stage::Preparation,
        Stage::Axis,
        Stage::BaseCurves,
        Stage::Projection,
        Stage::Refinement,
        Stage::Parameters,
    ];
    for last in stages {
        let progress =
            |stage: Stage| if stage == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let result = parameterise_with_progress(&points, &ParameteriseOptions::default(), &progress);
        assert!(matches!(result, Err(Error::Cancelled)));
    }
}

#[test]
fn the_method_before_comes_near_the_shape_between_its_boundary_curves() {
    // A quarter of the vase between four curves on it.
    let points: Vec<_> = (0..6000).map(scattered).map(|[a, h]| vase_point(0.25 * a, h)).collect();
    let cloud = Neighbourhood::new(&points).unwrap();
    let curve = |f: &dyn Fn(f64) -> Vector3<f64>| {
        let places: Vec<_> = (0..25).map(|i| f(f64::from(i) / 24.0)).collect();
        BsplineCurve::interpolate(&places, 3, ParameterMethod::Uniform).unwrap()
    };
    let along_u = [0.0, 1.0].map(|h| curve(&|t| vase_point(0.25 * t, h)));
    let along_v = [0.0, 0.25].map(|a| curve(&|t| vase_point(a, t)));
    // In another order, and some the other way round.
    let curves = [along_u[0].clone(), along_v[0].reversed().unwrap(), along_u[1].clone(), along_v[1].clone()];
    let boundary = BoundaryCurves::of(curves, 1e-6).unwrap();
    for (found, given) in boundary.along_u.iter().zip(&along_u).chain(boundary.along_v.iter().zip(&along_v)) {
        assert_eq!(found.control_points(), given.control_points());
    }
    let options = RefineOptions::default();
    let (surface, report) = dynamic_base_surface(&cloud, &boundary, 1e-6, [16, 40], &options).unwrap();
    for k in 0..=200 {
        let t = f64::from(k) / 200.0;
        for (end, (u, v)) in [0.0, 1.0].into_iter().zip(boundary.along_u.iter().zip(&boundary.along_v)) {
            let along = |curve: &BsplineCurve<3>| curve.point(curve.domain().lerp(t));
            assert!(
                (surface.point(t, end) - along(u)).norm() < 1e-12
                    && (surface.point(end, t) - along(v)).norm() < 1e-12
            );
        }
    }
    assert!(report.history[report.kept].rms < report.history[0].rms);
    // How far a surface is from the vase itself, along the radius.
    let deviation = |surface: &BsplineSurface| {
        let [u, v] = surface.domain();
        let place =
            |k: u32| surface.point(u.lerp(f64::from(k % 23) / 22.0), v.lerp(f64::from(k / 23) / 60.0));
        let radial = |p: Vector3<f64>| {
            let around = p.y.atan2(p.x) / std::f64::consts::TAU;
            p.xy().norm() - vase_point(around, 0.1 * (p.z + 5.0)).xy().norm()
        };
        ((0..23 * 61).map(|k| radial(place(k)).powi(2)).sum::<f64>() / (23.0 * 61.0)).sqrt()
    };
    let coons = boundary.coons(1e-6).unwrap();
    let [before, after] = [deviation(&coons), deviation(&surface)];
    assert!(before > 0.1 && after < 0.25 * before, "{before} {after}");
    assert!(dynamic_base_surface(&cloud, &boundary, 1e-6, [3, 3], &options).is_err());
}

#[test]
fn squared_distance_minimisation_finishes_a_fit() {
    let points = vase(3000, 0.01);
    let found = find(&points).unwrap();
    let options = FitOptions { control_points: [14, 10], corrections: 0, ..FitOptions::default() };
    let fit = fit_parameters(&points, &found.base, &found.feet, &found.counts, &options).unwrap();
    let before = fit.rms;
    let mut sdm = finish_options(points.len());
    sdm.fit = sdm.fit.with_max_iterations(8);
    let (done, report) = finish_fit(&points, &found.counts, fit, &sdm).unwrap();
    assert!(done.rms < 0.8 * before, "{before} {}", done.rms);
    assert!(
        report.outcome == FinishOutcome::Finished
            && report.defects[1].is_none()
            && SurfaceDefects::of(&done.surface, None).is_none()
    );
    assert!(done.surface.knots_u().is_periodic());
}

#[test]
fn a_finish_that_is_cancelled_keeps_the_fitted_surface() {
    let points = vase(4000, 0.02);
    let found = find(&points).unwrap();
    let options = FitOptions { control_points: [16, 16], ..FitOptions::default() };
    let fit = fit_parameters(&points, &found.base, &found.feet, &found.counts, &options).unwrap();
    // In the first and in later stages, where little is gained any more.
    for last in [1, 5, 6, 7] {
        let steps = Mutex::new(Vec::new());
        let progress = |step: &FitStep| {
            steps.lock().unwrap().push(step.iteration);
            if step.iteration == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let (done, report) = finish_fit_with_progress(
            &points,
            &found.counts,
            fit.clone(),
            &finish_options(points.len()),
            &progress,
        )
        .unwrap();
        let steps = steps.into_inner().unwrap();
        assert!(steps.iter().copied().eq(1..=steps.len()), "{steps:?}");
        if steps.contains(&last) {
            assert_eq!((report.outcome, done.rms), (FinishOutcome::Cancelled, fit.rms), "{last}");
        } else {
            assert!(last > 5 && report.outcome.is_new(), "{last}");
        }
    }
}

#[test]
fn threads_that_the_grid_does_not_resolve_make_no_folds() {
    let thread = |[a, h]: [f64; 2]| {
        let angle = std::f64::consts::TAU * a;
        let radius = 5.0 + 0.7 * (std::f64::consts::TAU * (25.0 * h - a)).sin();
        Vector3::new(radius * angle.cos(), radius * angle.sin(), 40.0 * h)
    };
    let points: Vec<_> = (0..6000).map(scattered).map(thread).collect();
    let found = find(&points).unwrap();
    assert!(found.report.defects.is_none(), "{}", found.report);
    let fit =
        fit_parameters(&points, &found.base, &found.feet, &found.counts, &FitOptions::default()).unwrap();
    assert!(SurfaceDefects::of(&fit.surface, None).is_none());
}

#[test]
fn an_axis_across_an_open_tube_makes_no_sphere_of_it() {
    let point = |[a, h]: [f64; 2]| {
        let angle = std::f64::consts::TAU * a;
        Vector3::new(10.0 * angle.cos(), 10.0 * angle.sin(), 40.0 * h)
    };
    let points: Vec<_> = (0..4000).map(scattered).map(point).collect();
    let options = ParameteriseOptions::default().with_axis(Vector3::x());
    let told = parameterise(&points, &options).unwrap_err().to_string();
    assert!(told.contains("0.000, 0.000, 1.000"), "{told}");
    assert!(parameterise(&points, &options.with_axis(Vector3::z())).unwrap().is_converged());
}
