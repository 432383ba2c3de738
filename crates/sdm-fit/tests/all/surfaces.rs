//! Surfaces through the public API: exactness, seams, folds, starts, tolerances, bad input.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Interval, KnotVector, ParametricSurface};
use sdm_fit::{
    ActiveShape, ActiveSurface, BaseShape, Error, FitOptions, Folds, NetSize, Smoothing, SurfaceOptions,
    fit_cloud, fit_surface, initial_surface, with_controls,
};
use std::f64::consts::TAU;

/// Numbers in [−½, ½), the same everywhere.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.next())
    }

    /// Approximately normally distributed with variance 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum()
    }
}

/// A bumpy open patch with 7 × 6 control points.
fn patch() -> BsplineSurface {
    let mut noise = Noise(5);
    let (u, v) = (KnotVector::uniform_clamped(3, 7).unwrap(), KnotVector::uniform_clamped(3, 6).unwrap());
    let net = (0..42).map(|k| Vector3::new((k / 6) as f64, (k % 6) as f64, 1.2 * noise.next())).collect();
    BsplineSurface::new(u, v, net, None).unwrap()
}

/// A lobed tube: angle and relative height to a point.
fn tube(a: f64, h: f64) -> Vector3<f64> {
    let r = 10.0 + 2.0 * (3.0 * a).sin() * h + (5.0 * h).cos();
    Vector3::new(r * a.cos(), 30.0 * h, r * a.sin())
}

fn tube_cloud(count: usize, sigma: f64) -> Vec<Vector3<f64>> {
    let mut noise = Noise(9);
    (0..count)
        .map(|_| {
            let (a, h) = (TAU * noise.next(), noise.next() + 0.5);
            tube(a, h) + Vector3::from_fn(|_, _| sigma * noise.normal())
        })
        .collect()
}

/// Options without the search for the smoothing, which takes most of the time.
fn quick() -> SurfaceOptions {
    let options = SurfaceOptions::default();
    let smoothing = Smoothing::Continuation { start: 1e-2, factor: 0.2, floor: 1e-6 };
    options.with_fit(options.fit.with_smoothing(smoothing).with_max_iterations(12))
}

#[test]
fn points_and_energies_are_those_of_the_surface() {
    let net = (0..8 * 6).map(|k| {
        let a = ((k / 6) % 5) as f64 * TAU / 5.0;
        Vector3::new(a.cos(), a.sin(), (k % 6) as f64) * (1.0 + 0.1 * (k % 6) as f64)
    });
    let closed = BsplineSurface::new(
        KnotVector::uniform_periodic(3, 5).unwrap(),
        KnotVector::uniform_clamped(3, 6).unwrap(),
        net.collect(),
        None,
    )
    .unwrap();
    for surface in [patch(), closed] {
        let active = ActiveSurface::new(surface.clone()).unwrap();
        let domain = surface.domain();
        for k in 0..200 {
            let (s, t) = ((k % 17) as f64 / 16.0, (k % 13) as f64 / 12.0);
            let (u, v) = (domain[0].lerp(s), domain[1].lerp(t));
            assert!((active.point([u, v]) - surface.point(u, v)).norm() < 1e-13);
        }
        // Midpoint rule against the exact quadrature, all orders.
        let spans = [surface.knots_u(), surface.knots_v()].map(|k| k.spans().count() as f64);
        let unit = [domain[0].length() / spans[0], domain[1].length() / spans[1]];
        let n = 80;
        for order in 1..=3 {
            let mut weights = [0.0; 3];
            weights[order - 1] = 1.0;
            let form = |g: &sdm_fit::CellGram| -> f64 {
                let d: Vec<_> =
                    active.cells().columns(g.cell).iter().map(|&i| active.coefficients()[i]).collect();
                (0..d.len() * d.len()).map(|e| g.gram[e] * d[e / d.len()].dot(&d[e % d.len()])).sum()
            };
            let found: f64 = active.energy(weights).iter().map(form).sum();
            let mut expected = 0.0;
            for i in 0..n {
                for j in 0..n {
                    let (s, t) = ((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64);
                    let d = surface.derivatives(domain[0].lerp(s), domain[1].lerp(t), order);
                    for k in 0..=order {
                        let times = [1.0, order as f64, [1.0, 1.0, 1.0, 3.0][order], 1.0][k];
                        let times = if order == 2 { [1.0, 2.0, 1.0][k] } else { times };
                        let power = |x: f64, n: usize| (0..n).map(|_| x).product::<f64>();
                        let scale = power(unit[0], k) * power(unit[1], order - k);
                        expected += times * (d[k][order - k] * scale).norm_squared() / (n * n) as f64;
                    }
                }
            }
            assert!((found / expected - 1.0).abs() < 1e-2, "{order}: {found} {expected}");
        }
    }
}

#[test]
fn points_of_a_surface_give_its_control_points() {
    let truth = patch();
    let points: Vec<_> =
        (0..40 * 36).map(|k| truth.point((k / 36) as f64 / 39.0, (k % 36) as f64 / 35.0)).collect();
    let mut noise = Noise(1);
    let net = truth.control_points().iter().map(|p| p + noise.vector() * 0.1).collect();
    let start = BsplineSurface::new(truth.knots_u().clone(), truth.knots_v().clone(), net, None).unwrap();
    // The boundary tells where parameter lines are; inside, points of a surface leave them open.
    let mut start = start;
    for (i, j) in (0..7).flat_map(|i| (0..6).map(move |j| (i, j))) {
        if i % 6 == 0 || j % 5 == 0 {
            let (u, v, mut net, _) = start.into_parts();
            net[i * 6 + j] = truth.control_point(i, j);
            start = BsplineSurface::new(u, v, net, None).unwrap();
        }
    }
    let fit = FitOptions::default().with_smoothing(Smoothing::CONTINUATION).with_max_iterations(100);
    let options = SurfaceOptions::default().with_fixed_boundary(true).with_fit(fit);
    let found = fit_surface(&points, start, &options).unwrap();
    assert!(found.report.fit.rms < 1e-10, "{}", found.report);
    // And at given parameters the control points come back.
    let knots = [truth.knots_u().clone(), truth.knots_v().clone()];
    let parameters: Vec<_> = found.frames.iter().map(|f| f.hint.parameter).collect();
    let again = BsplineSurface::approximate(knots, &parameters, &points, &Default::default()).unwrap().shape;
    let off = again.control_points().iter().zip(found.surface.control_points()).map(|(a, b)| (a - b).norm());
    assert!(off.fold(0.0, f64::max) < 1e-7);
}

#[test]
fn a_start_at_the_truth_stays() {
    let truth = patch();
    let points: Vec<_> =
        (0..40 * 36).map(|k| truth.point((k / 36) as f64 / 39.0, (k % 36) as f64 / 35.0)).collect();
    let fit = FitOptions::default().with_smoothing(Smoothing::NONE);
    let found = fit_surface(&points, truth.clone(), &SurfaceOptions::default().with_fit(fit)).unwrap();
    let off = truth.control_points().iter().zip(found.surface.control_points()).map(|(a, b)| (a - b).norm());
    assert!(off.fold(0.0, f64::max) < 1e-9);
}

#[test]
fn a_noisy_tube_is_closed_smoothly_and_unfolded() {
    let sigma = 0.05;
    let points = tube_cloud(4000, sigma);
    let size = NetSize { controls: [14, 10], ..NetSize::default() };
    let found = fit_cloud(&points, &SurfaceOptions::default().with_size(size)).unwrap();
    assert_eq!(found.report.base, Some(BaseShape::Cylinder));
    assert!(found.report.fit.rms > 0.9 * sigma && found.report.fit.rms < 1.1 * sigma, "{}", found.report);
    assert_eq!(found.report.folds.count(), 0);
    // The seam: derivatives from both sides.
    let domain = found.surface.domain();
    assert!(found.surface.knots_u().is_periodic());
    for k in 0..=20 {
        let v = domain[1].lerp(f64::from(k) / 20.0);
        let a = found.surface.derivatives(domain[0].start(), v, 2);
        let b = found.surface.derivatives(domain[0].end() - 1e-13, v, 2);
        for order in 0..=2 {
            assert!((a[order][0] - b[order][0]).norm() <= 1e-9 * (1.0 + a[order][0].norm()), "{order}");
        }
    }
    // Distance to the truth, over the whole tube: below the noise, also at the ends.
    let field = distance_field::SurfaceField::new(&found.surface).unwrap();
    let truth: Vec<_> =
        (0..4000).map(|k| tube(f64::from(k) * 2.399_963, (f64::from(k) + 0.5) / 4000.0)).collect();
    let frames = distance_field::DistanceField::frames(&field, &truth, distance_field::Search::Global, &[]);
    let rms = (frames.iter().map(|f| f.distance.powi(2)).sum::<f64>() / 4000.0).sqrt();
    let max = frames.iter().map(|f| f.distance.abs()).fold(0.0, f64::max);
    assert!(rms < 0.3 * sigma && max < 4.0 * sigma, "{rms} {max}");
    // And from the surface to the truth, up to its ends: no flaps where the data end.
    let mut worst = 0.0f64;
    for k in 0..60 * 41 {
        let (s, t) = (f64::from(k / 41) / 60.0, f64::from(k % 41) / 40.0);
        let p = found.surface.point(domain[0].lerp(s), domain[1].lerp(t));
        let h = (p.y / 30.0).clamp(0.0, 1.0);
        worst = worst.max((p - tube(p.z.atan2(p.x), h)).norm());
    }
    assert!(worst < 3.0 * sigma, "{worst}");
}

#[test]
fn bases_are_recognised() {
    let mut noise = Noise(2);
    let ball: Vec<_> = (0..1500)
        .map(|_| {
            let d = Vector3::from_fn(|_, _| noise.normal()).normalize();
            d.component_mul(&Vector3::new(3.0, 2.0, 2.5)) * (1.0 + 0.1 * (4.0 * d.x).sin())
        })
        .collect();
    let found = fit_cloud(&ball, &quick()).unwrap();
    assert_eq!(found.report.base, Some(BaseShape::Sphere));
    assert!(found.report.fit.rms < 0.02, "{}", found.report);
    // Poles stay points.
    let n = found.surface.n_v();
    for i in 1..found.surface.n_u() {
        assert_eq!(found.surface.control_point(i, 0), found.surface.control_point(0, 0));
        assert_eq!(found.surface.control_point(i, n - 1), found.surface.control_point(0, n - 1));
    }

    let truth = patch();
    let sheet: Vec<_> = (0..1500).map(|_| truth.point(noise.next() + 0.5, noise.next() + 0.5)).collect();
    let found = fit_cloud(&sheet, &quick()).unwrap();
    assert_eq!(found.report.base, Some(BaseShape::Plane));
    assert!(found.report.fit.rms < 0.02, "{}", found.report);
}

#[test]
fn knots_are_inserted_until_the_tolerance_holds() {
    let points = tube_cloud(2500, 0.0);
    let size = NetSize { controls: [8, 6], ..NetSize::default() };
    let options = quick().with_size(size).with_abs_tolerance(Some(0.05));
    let found = fit_cloud(&points, &options).unwrap();
    assert!(found.report.within_tolerance && found.report.fit.max <= 0.05, "{}", found.report);
    assert!(found.report.runs > 1 && found.report.controls[0] * found.report.controls[1] < 1200);
    // A cap that is too low is said plainly.
    let capped = fit_cloud(&points, &options.with_max_controls(60)).unwrap();
    assert!(!capped.report.within_tolerance && capped.report.share_within.unwrap() < 1.0);
    assert!(capped.report.controls[0] * capped.report.controls[1] <= 60);
}

#[test]
fn far_origins_do_no_harm() {
    let points = tube_cloud(2000, 0.02);
    let shift = Vector3::new(1e6, -2e6, 5e5);
    let moved: Vec<_> = points.iter().map(|p| p + shift).collect();
    let plain = fit_cloud(&points, &quick()).unwrap();
    let far = fit_cloud(&moved, &quick()).unwrap();
    let (a, b) = (plain.report.fit.rms, far.report.fit.rms);
    assert!((a - b).abs() < 1e-3 * a, "{a} {b}");
}

#[test]
fn bad_input_is_an_error() {
    let options = quick();
    assert!(matches!(fit_cloud(&[], &options), Err(Error::TooFewPoints { .. })));
    let line: Vec<_> = (0..100).map(|i| Vector3::new(1.0, 2.0, 3.0) * f64::from(i)).collect();
    assert!(matches!(fit_cloud(&line, &options), Err(Error::Degenerate { .. })));
    let place = vec![Vector3::new(1.0, 2.0, 3.0); 100];
    assert!(matches!(fit_cloud(&place, &options), Err(Error::Degenerate { .. })));
    let mut cloud = tube_cloud(2000, 0.0);
    cloud[7].y = f64::NAN;
    let found = fit_cloud(&cloud, &options).unwrap();
    assert_eq!((found.report.dropped, found.report.fit.samples), (1, 1999));
    assert!(matches!(
        initial_surface(&cloud, BaseShape::Auto, NetSize::default()),
        Err(Error::NotFinite { index: 7, .. })
    ));
    let tolerance = options.with_abs_tolerance(Some(-1.0));
    assert!(matches!(fit_cloud(&cloud, &tolerance), Err(Error::Option { name: "abs_tolerance", .. })));
    // Fewer points than control points, and duplicates: the energy decides what the data do not.
    let few: Vec<_> = cloud[10..40].iter().chain(&cloud[10..40]).copied().collect();
    let found = fit_cloud(&few, &options.with_base(BaseShape::Plane)).unwrap();
    assert!(found.surface.control_points().iter().all(|p| p.iter().all(|c| c.is_finite())));
}

#[test]
fn folds_are_found() {
    assert_eq!(Folds::of(&patch()).count(), 0);
    let (u, v, mut net, _) = patch().into_parts();
    net[2 * 6 + 3].x += 4.0;
    let folded = BsplineSurface::new(u, v, net, None).unwrap();
    assert!(Folds::of(&folded).count() > 0);
    assert_eq!(Folds::of(&folded).cells, 12);
    let domain = Interval::new(0.0, 1.0).unwrap();
    assert_eq!(folded.domain()[0], domain);
}

#[test]
fn quadrics_and_tori_are_exact_with_weights() {
    let mut noise = Noise(3);
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 0.8);
    let shift = Vector3::new(10.0, -4.0, 7.0);
    let mut cloud = |count: usize, shape: &dyn Fn(f64, f64) -> Vector3<f64>| -> Vec<Vector3<f64>> {
        (0..count).map(|_| turn * shape(TAU * noise.next(), noise.next() + 0.5) + shift).collect()
    };
    let cylinder = cloud(800, &|a, h| Vector3::new(3.0 * a.cos(), 3.0 * a.sin(), 8.0 * h));
    let sphere = cloud(1500, &|a, h| {
        let z = 2.0 * h - 1.0;
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * a.cos(), r * a.sin(), z) * 2.5
    });
    let torus = cloud(1500, &|a, h| {
        let b = TAU * h;
        let r = 5.0 + 1.5 * b.cos();
        Vector3::new(r * a.cos(), r * a.sin(), 1.5 * b.sin())
    });
    // In a spiral, and a hyperboloid of one sheet.
    let turns: Vec<_> =
        (0..500).map(|k| (f64::from(k) * 0.618_034 * TAU, (f64::from(k) + 0.5) / 500.0)).collect();
    let round = |r: f64, a: f64, z: f64| Vector3::new(r * a.cos(), r * a.sin(), z);
    let spiral = turns.iter().map(|&(a, h)| round(5.0, a, 12.0 * h)).collect();
    let waist =
        turns.iter().map(|&(a, h)| round((1.0 + (2.0 * h - 0.8).powi(2)).sqrt(), a, 2.0 * h - 0.8)).collect();
    let more = [("spiral", spiral, 12.0), ("hyperboloid", waist, 3.0)];
    for (name, points, size) in
        more.into_iter().chain([("cylinder", cylinder, 8.0), ("sphere", sphere, 5.0), ("torus", torus, 13.0)])
    {
        let found = fit_cloud(&points, &SurfaceOptions::default().with_rational(true)).unwrap();
        assert!(found.report.fit.max <= 1e-9 * size, "{name}: {}", found.report);
        assert!(found.surface.weights().is_some());
    }
}

#[test]
fn a_rational_start_is_improved_with_its_weights() {
    let truth = nurbs_core::Sphere::new(nurbs_core::Frame::WORLD, 2.0).unwrap().to_nurbs().unwrap();
    let [u, v] = truth.domain();
    let points: Vec<_> = (0..900)
        .map(|k| {
            truth.point(u.lerp((f64::from(k) * 0.618_034).fract()), v.lerp((f64::from(k) + 0.5) / 900.0))
        })
        .collect();
    let (knots_u, knots_v, net, weights) = truth.into_parts();
    let net: Vec<_> = net.iter().map(|p| p * 1.02 + Vector3::new(0.01, 0.0, 0.0)).collect();
    let weights = weights.map(|w| w.iter().map(|w| w * if *w < 0.8 { 1.1 } else { 1.0 }).collect());
    let start = BsplineSurface::new(knots_u, knots_v, net, weights).unwrap();
    let options = SurfaceOptions::default();
    assert!(matches!(fit_surface(&points, start.clone(), &options), Err(Error::Rational)));
    let found = fit_surface(&points, start, &options.with_rational(true)).unwrap();
    assert!(found.report.fit.max < 2e-9, "{}", found.report);
    assert!(found.report.fit.is_converged() && found.report.fit.history.len() > 2);
}

#[test]
fn a_start_gets_as_many_control_points_as_asked() {
    let start = patch();
    let finer = with_controls(start.clone(), [11, 6]).unwrap();
    assert_eq!((finer.n_u(), finer.n_v()), (11, 6));
    for k in 0..100 {
        let (u, v) = (f64::from(k % 10) / 9.0, f64::from(k / 10) / 9.0);
        assert!((finer.point(u, v) - start.point(u, v)).norm() < 1e-13);
    }
    assert!(matches!(with_controls(start, [6, 6]), Err(Error::Option { name: "controls", .. })));
}
