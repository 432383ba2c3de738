//! Ruled surfaces and layers through the public API.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use distance_field::{AnalyticField, OffsetField, SurfaceField};
use nalgebra::Vector3;
use nurbs_core::{
    BsplineCurve, BsplineSurface, Cylinder, Frame, Interval, KnotVector, ParametricSurface, construct,
};
use sdm_fit::ruled::{ActiveRuled, Developability, RuledOptions, fit_ruled};
use sdm_fit::{ActiveShape, Error, Smoothing, Target};
use std::f64::consts::TAU;

/// A closed curve of degree 3 near a circle about the z axis.
fn ring(controls: usize, radius: f64, height: f64) -> BsplineCurve<3> {
    let point = |i: usize| {
        let a = TAU * (i % controls) as f64 / controls as f64;
        Vector3::new(radius * a.cos(), radius * a.sin(), height)
    };
    let knots = KnotVector::uniform_periodic(3, controls).unwrap();
    BsplineCurve::new(knots, (0..controls + 3).map(point).collect(), None).unwrap()
}

/// Layers between rings.
fn layers(controls: usize, rings: &[(f64, f64)]) -> BsplineSurface {
    let sections: Vec<_> = rings.iter().map(|&(radius, height)| ring(controls, radius, height)).collect();
    construct::skin(&sections, 1).unwrap()
}

fn grid(n: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..n * n).map(move |k| ((k / n) as f64 / (n - 1) as f64, (k % n) as f64 / (n - 1) as f64))
}

#[test]
fn a_conoid_comes_back() {
    // Rulings from a straight line to a wavy one, all parallel to a plane.
    let knots = KnotVector::uniform_clamped(3, 7).unwrap();
    let wave = [0.0, 0.6, -0.5, 0.8, 0.1, -0.7, 0.2];
    let greville = knots.greville();
    let line = |y: f64, z: &dyn Fn(usize) -> f64| {
        let points = (0..7).map(|i| Vector3::new(4.0 * greville[i], y, z(i))).collect();
        BsplineCurve::new(knots.clone(), points, None).unwrap()
    };
    let truth = construct::ruled(&line(0.0, &|_| 0.0), &line(1.5, &|i| wave[i])).unwrap();
    let points: Vec<_> = grid(40).map(|(u, v)| truth.point(u, v)).collect();
    let start = construct::ruled(&line(0.0, &|_| 0.05), &line(1.5, &|i| 0.8 * wave[i] + 0.1)).unwrap();
    let target = Target::Points { points: &points, weights: None };
    let options = RuledOptions::default().with_section_normal(Some([0.0, 1.0, 0.0]));
    let fit = options.fit.with_smoothing(Smoothing::Continuation { start: 1e-6, factor: 0.1, floor: 0.0 });
    let options = options.with_fit(fit.with_fairing(0.0).with_cost_tolerance(0.0));
    let found = fit_ruled(target, start, &options).unwrap();
    assert!(found.report.fit.rms < 1e-9 && found.report.fit.max < 1e-8, "{}", found.report);
    assert_eq!(found.report.controls, [7, 2]);
    // It is as far from developable as the conoid is.
    let twist = Developability::of(&truth).unwrap();
    assert!((found.report.developability.max_angle - twist.max_angle).abs() < 0.02, "{}", found.report);
}

#[test]
fn a_hyperboloid_is_approached_to_the_order_of_the_spline() {
    // x² + y² − z² = 1 between z = ±1, from a cylinder around it: the rulings turn by themselves.
    let points: Vec<_> = (0..4000)
        .map(|k| {
            let (a, z) = (f64::from(k) * 2.399_963, f64::from(k) / 2000.0 - 1.0);
            let (c, s) = (a.cos(), a.sin());
            Vector3::new(c - z * s, s + z * c, z)
        })
        .collect();
    let mut last = f64::INFINITY;
    for controls in [8, 16, 32] {
        // Turned a little, or both families of rulings are equally near.
        let (low, high) = (ring(controls, 1.4, -1.0), ring(controls, 1.4, 1.0));
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), 0.6);
        let high = high.transformed(turn.matrix(), &Vector3::zeros()).unwrap();
        let start = construct::ruled(&low, &high).unwrap();
        let target = Target::Points { points: &points, weights: None };
        let options = RuledOptions::default();
        let fit =
            options.fit.with_smoothing(Smoothing::Continuation { start: 1e-2, factor: 0.3, floor: 1e-14 });
        let options = options.with_fit(fit.with_fairing(1e-14).with_max_iterations(60));
        let rms = fit_ruled(target, start, &options).unwrap().report.fit.rms;
        assert!(rms < last / 6.0, "{controls}: {rms} after {last}");
        last = rms;
    }
    assert!(last < 1e-5, "{last}");
}

#[test]
fn layers_stay_in_parallel_planes_and_approach_a_freeform_model() {
    // A vase with a lobed waist.
    let section = |t: f64| {
        let points = (0..15).map(|i| {
            let a = TAU * f64::from(i % 12) / 12.0;
            let r = 2.0 + 0.6 * (3.0 * t).sin() + 0.15 * (3.0 * a).cos() * t;
            Vector3::new(r * a.cos(), r * a.sin(), 4.0 * t)
        });
        let knots = KnotVector::uniform_periodic(3, 12).unwrap();
        BsplineCurve::new(knots, points.collect(), None).unwrap()
    };
    let sections: Vec<_> = (0..8).map(|k| section(f64::from(k) / 7.0)).collect();
    let model = construct::skin(&sections, 3).unwrap();
    let field = SurfaceField::new(&model).unwrap();
    let normal = Vector3::new(0.0, 0.0, 2.0);
    let options = RuledOptions::default().with_section_normal(Some(normal.into()));
    let mut last = f64::INFINITY;
    for count in [1, 2, 4, 8] {
        let rings: Vec<_> = (0..=count).map(|k| (3.0, 4.0 * f64::from(k) / f64::from(count))).collect();
        let target = Target::Model { field: &field, sensors: 4, boundary: true };
        let found = fit_ruled(target, layers(14, &rings), &options).unwrap();
        for (j, (_, height)) in rings.iter().enumerate() {
            for i in 0..found.surface.n_u() {
                assert!((found.surface.control_point(i, j).z - height).abs() < 1e-12, "{i} {j}");
            }
        }
        // Twice the layers: a quarter of the distance, in the end.
        let rms = found.report.fit.rms;
        assert!(rms < last / if count > 2 { 2.5 } else { 1.2 }, "{count}: {rms} after {last}");
        last = rms;
    }
    assert!(last < 0.01, "{last}");
}

#[test]
fn a_cutter_runs_on_the_offset() {
    let cylinder = Cylinder::new(Frame::WORLD, 2.0, Interval::new(-3.0, 3.0).unwrap()).unwrap();
    let offset = OffsetField::new(AnalyticField::new(cylinder).unwrap(), 0.5).unwrap();
    let target = Target::Model { field: &offset, sensors: 3, boundary: false };
    let start = layers(24, &[(3.0, -1.0), (2.9, 1.0)]);
    let found = fit_ruled(target, start, &RuledOptions::default()).unwrap();
    assert!(found.report.fit.rms < 1e-4, "{}", found.report);
    for (u, v) in grid(15) {
        let [a, b] = found.surface.domain();
        let p = found.surface.point(a.lerp(u), b.lerp(v));
        assert!((p.xy().norm() - 2.5).abs() < 1e-3, "{p}");
    }
    assert!(found.report.developability.max_angle < 1e-2, "{}", found.report);
}

#[test]
fn twists_can_be_kept_small() {
    // A helicoid: no ruling of it can be developable.
    let points: Vec<_> = grid(30).map(|(u, v)| (0.8 * u, v + 0.3)).collect();
    let points: Vec<_> =
        points.iter().map(|&(a, r)| Vector3::new(r * a.cos(), r * a.sin(), 0.5 * a)).collect();
    let knots = KnotVector::uniform_clamped(3, 6).unwrap();
    let greville = knots.greville();
    let side = |r: f64| {
        let points = greville.iter().map(|&g| Vector3::new(r, 0.6 * g * r, 0.4 * g)).collect();
        BsplineCurve::new(knots.clone(), points, None).unwrap()
    };
    let start = construct::ruled(&side(0.3), &side(1.3)).unwrap();
    let target = Target::Points { points: &points, weights: None };
    let mut last = (f64::INFINITY, 0.0);
    for abs_twist in [0.0, 0.005, 0.02] {
        let options = RuledOptions::default().with_abs_twist(abs_twist);
        let options = options.with_fit(options.fit.with_fairing(1e-7));
        let found = fit_ruled(target, start.clone(), &options).unwrap();
        let now = (found.report.developability.rms_angle, found.report.fit.rms);
        assert!(now.0 < 0.8 * last.0 && now.1 > last.1, "{abs_twist}: {} after {last:?}", found.report);
        last = now;
    }
    // Cylinders, cones and tangent surfaces have none to begin with.
    let cone = layers(24, &[(1.0, 0.0), (2.0, 1.0)]);
    assert!(Developability::of(&cone).unwrap().max_angle < 1e-7);
}

#[test]
fn penalties_are_the_derivatives_of_the_twist() {
    let (low, high) = (ring(6, 1.0, 0.0), ring(6, 1.3, 1.0));
    let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), 0.4);
    let high = high.transformed(turn.matrix(), &Vector3::zeros()).unwrap();
    let shape =
        ActiveRuled::new(construct::ruled(&low, &high).unwrap()).unwrap().with_abs_twist(2.0).unwrap();
    let penalties = shape.penalties();
    // Three coordinates at four nodes in each of six spans; the mean of squares, times the square of 2.
    assert_eq!(penalties.len(), 72);
    let square: f64 = penalties.iter().map(|p| p.value * p.value).sum();
    let angle = Developability::of(shape.surface()).unwrap().rms_angle;
    assert!((square.sqrt() - 4.0 * (0.5 * angle).sin()).abs() < 0.02, "{} {angle}", square.sqrt());
    for k in [0, 5, 11] {
        for axis in [Vector3::x(), Vector3::z()] {
            let moved = |h: f64| {
                let mut shape = shape.clone();
                let mut coefficients = shape.coefficients().to_vec();
                coefficients[k] += axis * h;
                shape.set_coefficients(&coefficients).unwrap();
                shape.penalties()
            };
            let (up, down) = (moved(1e-6), moved(-1e-6));
            for ((p, up), down) in penalties.iter().zip(&up).zip(&down) {
                let columns = shape.cells().columns(p.cell).iter().zip(&p.gradient);
                let derivative: f64 = columns.filter(|(c, _)| **c == k).map(|(_, g)| g.dot(&axis)).sum();
                assert!(((up.value - down.value) / 2e-6 - derivative).abs() < 1e-8);
            }
        }
    }
}

#[test]
fn bad_input_is_an_error() {
    let rings = layers(8, &[(1.0, 0.0), (1.0, 1.0)]);
    let points = vec![Vector3::zeros(); 3];
    let target = Target::Points { points: &points, weights: None };
    let options = RuledOptions::default();
    let turned = rings.transposed().unwrap();
    assert!(matches!(fit_ruled(target, turned.clone(), &options), Err(Error::NotRuled { degree: 3 })));
    assert!(matches!(Developability::of(&turned), Err(Error::NotRuled { .. })));
    let bad = options.with_section_normal(Some([0.0; 3]));
    assert!(matches!(fit_ruled(target, rings.clone(), &bad), Err(Error::Option { .. })));
    assert!(matches!(
        fit_ruled(target, rings.clone(), &options.with_abs_twist(f64::NAN)),
        Err(Error::Option { .. })
    ));
    let nan = [Vector3::new(f64::NAN, 0.0, 0.0)];
    let target = Target::Points { points: &nan, weights: None };
    assert!(matches!(fit_ruled(target, rings, &options), Err(Error::NotFinite { .. })));
    let cylinder = Cylinder::new(Frame::WORLD, 2.0, Interval::UNIT).unwrap();
    assert!(OffsetField::new(AnalyticField::new(cylinder).unwrap(), f64::INFINITY).is_err());
}
