//! New feet of points that have moved a little.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use footpoint::{
    CurveFootpoint, CurveProjector, Error, ProjectionOptions, Status, SurfaceFootpoint, SurfaceProjector,
    UpdateOptions, no_progress,
};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Cylinder, Frame, Interval, KnotVector, ParametricCurve, ParametricSurface,
    Sphere, Torus,
};

fn noise(i: usize, step: f64) -> f64 {
    (i as f64 * step).fract()
}

/// A wavy surface with `n` control points in each direction.
fn wavy(p: usize, q: usize, n: usize, rational: bool) -> BsplineSurface {
    let knots = |degree| KnotVector::uniform_clamped(degree, n).unwrap();
    let at = |k: usize| k as f64 / (n - 1) as f64;
    let net = (0..n * n)
        .map(|k| (at(k / n), at(k % n)))
        .map(|(x, y)| Vector3::new(x, y, 0.05 * (9.0 * x).sin() * (7.0 * y).cos()))
        .collect();
    let weights = rational.then(|| (0..n * n).map(|k| 1.0 + 0.3 * noise(k, 0.7)).collect());
    BsplineSurface::new(knots(p), knots(q), net, weights).unwrap()
}

/// All pairs of degrees up to 3 and one above, polynomial and rational, and round shapes with seams and poles.
fn shapes() -> Vec<BsplineSurface> {
    let mut shapes = Vec::new();
    for p in 1..=3 {
        for q in 1..=3 {
            shapes.extend([false, true].map(|rational| wavy(p, q, 8, rational)));
        }
    }
    shapes.push(wavy(5, 2, 8, true));
    shapes.push(Sphere::new(Frame::WORLD, 0.7).unwrap().to_nurbs().unwrap());
    shapes.push(Torus::new(Frame::WORLD, 0.6, 0.2).unwrap().to_nurbs().unwrap());
    shapes.push(Cylinder::new(Frame::WORLD, 0.4, Interval::UNIT).unwrap().to_nurbs().unwrap());
    shapes
}

/// Points around the unit cube, on all sides of the shapes and beyond their boundaries.
fn cloud(count: usize) -> Vec<Vector3<f64>> {
    (0..count)
        .map(|i| Vector3::new(noise(i, 0.7548), noise(i, 0.5698), 0.3 * noise(i, 0.4301)) * 1.2)
        .map(|x| x - Vector3::new(0.1, 0.1, 0.15))
        .collect()
}

/// All numbers of an answer, bit by bit, NaN included.
fn bits(foot: &SurfaceFootpoint) -> ([u64; 8], String) {
    let [u, v] = foot.parameter;
    let p = foot.point;
    let numbers = [u, v, p.x, p.y, p.z, foot.distance, foot.signed_distance, foot.lower_bound];
    let words = format!("{} {} {:?} {}", foot.shape, foot.status, foot.location, foot.iterations);
    (numbers.map(f64::to_bits), words)
}

fn with_threads<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

#[test]
fn batches_have_the_bits_of_single_updates_on_any_number_of_threads() {
    // More than one task, so that threads matter.
    let points = cloud(5000);
    for (number, surface) in shapes().iter().enumerate() {
        let projector = SurfaceProjector::new(surface);
        let options = ProjectionOptions::default().with_mode(footpoint::Mode::Fast);
        let feet = projector.project_many(&points, &options, &no_progress).unwrap();
        for shift in [1e-3, 3e-2] {
            let moved: Vec<_> = points.iter().map(|x| x + Vector3::new(0.6, -0.5, 0.4) * shift).collect();
            let run = |threads| with_threads(threads, || projector.update_many(&moved, &feet).unwrap());
            let (one, two) = (run(1), run(2));
            for (i, x) in moved.iter().enumerate() {
                let single = projector.project_from(x, feet[i].shape, feet[i].parameter);
                assert_eq!(bits(&one[i]), bits(&two[i]), "shape {number} point {i} with two threads");
                assert_eq!(bits(&one[i]), bits(&single), "shape {number} point {i} {x:?}");
            }
            let converged = one.iter().filter(|foot| foot.status.is_converged()).count();
            assert!(converged >= 4990, "shape {number}: {converged}");
        }
    }
}

#[test]
fn one_step_is_never_worse_and_many_of_them_converge() {
    let points = cloud(1000);
    for surface in shapes() {
        let projector = SurfaceProjector::new(&surface);
        let mut feet = projector.project_many(&points, &ProjectionOptions::default(), &no_progress).unwrap();
        let moved: Vec<_> = points.iter().map(|x| x + Vector3::new(0.01, 0.005, -0.01)).collect();
        let goal = projector.update_many(&moved, &feet).unwrap();
        let one = UpdateOptions::default().with_max_steps(1);
        for step in 0..60 {
            let before: Vec<_> = moved.iter().zip(&feet).map(|(x, foot)| (x - foot.point).norm()).collect();
            projector.update_in_place(&moved, &mut feet, &one).unwrap();
            for (i, foot) in feet.iter().enumerate() {
                assert!(
                    foot.iterations <= 1 && foot.distance <= before[i] * (1.0 + 1e-12) + 1e-15,
                    "{step}: {foot}"
                );
                assert!(((foot.point - moved[i]).norm() - foot.distance).abs() < 1e-14);
            }
        }
        let reached = feet.iter().zip(&goal).filter(|(a, b)| a.distance <= b.distance + 1e-9).count();
        let converged = feet.iter().filter(|foot| foot.status.is_converged()).count();
        assert!(reached >= 995 && converged >= 995, "{reached} {converged}");
    }
}

#[test]
fn models_of_several_shapes_and_degrees() {
    let shapes = [
        wavy(3, 3, 6, false),
        wavy(2, 5, 8, true),
        Torus::new(Frame::WORLD, 0.6, 0.2).unwrap().to_nurbs().unwrap(),
    ];
    let projector = SurfaceProjector::for_model(&shapes).unwrap();
    let points = cloud(2000);
    let feet = projector.project_many(&points, &ProjectionOptions::default(), &no_progress).unwrap();
    let moved: Vec<_> = points.iter().map(|x| x + Vector3::repeat(2e-3)).collect();
    for (i, foot) in projector.update_many(&moved, &feet).unwrap().iter().enumerate() {
        let single = projector.project_from(&moved[i], feet[i].shape, feet[i].parameter);
        assert_eq!(bits(foot), bits(&single));
    }
}

#[test]
fn points_and_starts_that_are_unusable() {
    let projector = SurfaceProjector::new(&wavy(3, 3, 6, false));
    let points = vec![Vector3::new(0.4, 0.3, 0.2); 40];
    let feet = vec![projector.project(&points[0]); 40];
    let (mut moved, mut starts) = (points.clone(), feet.clone());
    moved[0].x = f64::NAN;
    moved[1].y = f64::INFINITY;
    starts[2].parameter[0] = f64::NAN;
    starts[3].parameter[1] = f64::NEG_INFINITY;
    starts[4].shape = 1;
    starts[5].parameter = [-7.0, 1e300];
    moved[6] = Vector3::repeat(1e200);
    for count in [7, 40] {
        let updated = projector.update_many(&moved[..count], &starts[..count]).unwrap();
        for (i, foot) in updated.iter().enumerate() {
            match i {
                0..=4 => assert_eq!(foot.status, Status::InvalidPoint, "{i}"),
                5 => assert!(foot.status.is_converged() && foot.distance.is_finite()),
                // Squares overflow: no status may claim a foot.
                6 => assert!(!foot.status.is_converged(), "{foot}"),
                _ => assert!(foot.status.is_converged() && (foot.distance - feet[0].distance).abs() < 1e-12),
            }
        }
    }
    let error = projector.update_many(&points, &feet[..3]).unwrap_err();
    assert_eq!(error, Error::StartCount { found: 3, needed: 40 });
    let none = UpdateOptions::default().with_max_steps(0);
    let error = projector.update_in_place(&points, &mut feet.clone(), &none).unwrap_err();
    assert!(matches!(error, Error::Option { option: "max_steps", .. }), "{error}");
    assert!(projector.update_many(&[], &[]).unwrap().is_empty());
}

#[test]
fn curves_are_updated_like_surfaces() {
    for (p, rational) in [(1, false), (2, true), (3, false), (3, true), (5, false)] {
        let n = 12;
        let net = (0..n).map(|i| Vector2::new(i as f64, (0.9 * i as f64).sin())).collect();
        let weights = rational.then(|| (0..n).map(|k| 1.0 + 0.3 * noise(k, 0.7)).collect());
        let curve = BsplineCurve::new(KnotVector::uniform_clamped(p, n).unwrap(), net, weights).unwrap();
        let projector = CurveProjector::new(&curve);
        let points: Vec<_> =
            (0..5000).map(|i| Vector2::new(11.0 * noise(i, 0.618), 3.0 * noise(i, 0.7548) - 1.5)).collect();
        let feet = projector.project_many(&points, &ProjectionOptions::default(), &no_progress).unwrap();
        let moved: Vec<_> = points.iter().map(|x| x + Vector2::new(0.01, -0.02)).collect();
        let run = |threads| with_threads(threads, || projector.update_many(&moved, &feet).unwrap());
        let (one, two) = (run(1), run(2));
        for i in 0..points.len() {
            let single = projector.project_from(&moved[i], feet[i].shape, feet[i].parameter);
            assert!(one[i] == two[i] && one[i] == single, "{:?} {:?} {single:?}", one[i], two[i]);
        }
        let mut invalid: Vec<CurveFootpoint<2>> = vec![feet[0]; 3];
        invalid[0].parameter = f64::NAN;
        invalid[1].shape = 9;
        let updated =
            projector.update_many(&[moved[0], moved[0], Vector2::repeat(f64::NAN)], &invalid).unwrap();
        assert!(updated.iter().all(|foot| foot.status == Status::InvalidPoint));
        assert!(projector.update_many(&moved, &feet[..1]).is_err());
    }
}

/// A gabled roof: two planes that meet in a ridge at x = 1, of degree 1 across it.
fn roof() -> BsplineSurface {
    let across = KnotVector::new(1, vec![0.0, 0.0, 1.0, 2.0, 2.0]).unwrap();
    let along = KnotVector::bezier(1, Interval::UNIT).unwrap();
    let net = [[0., 0., 0.], [0., 1., 0.], [1., 0., 1.], [1., 1., 1.], [2., 0., 0.], [2., 1., 0.]];
    BsplineSurface::new(across, along, net.map(Vector3::from).to_vec(), None).unwrap()
}

#[test]
fn walks_cross_a_ridge_or_stay_on_it() {
    let surface = roof();
    let projector = SurfaceProjector::new(&surface);
    for i in 0..400 {
        let x = Vector3::new(2.0 * noise(i, 0.7548), noise(i, 0.5698), 2.5 * noise(i, 0.4301));
        let best = projector.project(&x);
        for start in [0.0, 0.3, 1.0, 1.7, 2.0] {
            let foot = projector.project_from(&x, 0, [start, 0.4]);
            assert!(foot.status.is_converged(), "{x:?} from {start}: {foot}");
            // Below the ridge both slopes have a foot, and the walk may end on either: no place around it is nearer.
            let [u, v] = foot.parameter;
            for [du, dv] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [0.7, 0.7], [-0.7, 0.7]] {
                let beside = surface.point((u + 1e-6 * du).clamp(0.0, 2.0), (v + 1e-6 * dv).clamp(0.0, 1.0));
                assert!((beside - x).norm() >= foot.distance - 1e-12, "{x:?} from {start}: {foot}");
            }
            if x.z > 1.0 - (x.x - 1.0).abs() {
                assert!((foot.distance - best.distance).abs() < 1e-12, "{x:?} from {start}: {foot}, {best}");
            }
        }
    }
}

#[test]
fn a_limit_on_steps_is_told_where_a_kink_is_left() {
    let projector = SurfaceProjector::new(&roof());
    // The foot of the old point lies on the ridge; that of the new one on the far slope.
    let mut feet = vec![projector.project(&Vector3::new(1.0, 0.5, 2.0)); 20];
    let points = vec![Vector3::new(0.25, 0.5, 0.75); 20];
    let one = UpdateOptions::default().with_max_steps(1);
    projector.update_in_place(&points, &mut feet, &one).unwrap();
    for foot in &feet {
        assert!((foot.parameter[0] - 0.5).abs() < 1e-12 && foot.status == Status::Converged, "{foot}");
    }
    // From the far slope one step leads to the ridge only, and that is no foot.
    let mut feet = vec![projector.project(&Vector3::new(1.6, 0.5, 0.5)); 20];
    projector.update_in_place(&points, &mut feet, &one).unwrap();
    assert!(feet.iter().all(|foot| foot.parameter[0] == 1.0 && !foot.status.is_converged()), "{}", feet[0]);
    projector.update_in_place(&points, &mut feet, &one).unwrap();
    assert!(feet.iter().all(|foot| foot.status == Status::Converged), "{}", feet[0]);
}

#[test]
fn walks_from_a_pole_leave_on_the_right_meridian() {
    let sphere = Sphere::new(Frame::WORLD, 0.7).unwrap().to_nurbs().unwrap();
    let projector = SurfaceProjector::new(&sphere);
    let [top, bottom] = [1.0, -1.0].map(|z| projector.project(&Vector3::new(0.0, 0.0, z)));
    for i in 0..200 {
        let x = Vector3::new(noise(i, 0.7548) - 0.5, noise(i, 0.5698) - 0.5, noise(i, 0.4301) - 0.5);
        for start in [&top, &bottom] {
            for turn in 0..5 {
                let u = 0.25 * f64::from(turn);
                let foot = projector.project_from(&x, 0, [u * domain_u(&sphere), start.parameter[1]]);
                assert!(foot.status.is_converged(), "{x:?}: {foot}");
                assert!((foot.distance - (0.7 - x.norm()).abs()).abs() < 1e-12, "{x:?} from {start}: {foot}");
            }
        }
    }
}

fn domain_u(surface: &BsplineSurface) -> f64 {
    surface.knots_u().domain().end()
}

#[test]
fn walks_on_a_polygon_turn_its_corners() {
    let knots = KnotVector::new(1, vec![0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0]).unwrap();
    let square = [[0., 0.], [1., 0.], [1., 1.], [0., 1.], [0., 0.]].map(Vector2::from).to_vec();
    let curve = BsplineCurve::new(knots, square, None).unwrap();
    let projector = CurveProjector::new(&curve);
    for i in 0..400 {
        let x = Vector2::new(3.0 * noise(i, 0.7548) - 1.0, 3.0 * noise(i, 0.5698) - 1.0);
        for start in [0.0, 0.5, 1.0, 1.5, 2.0, 3.7, 4.0] {
            let foot = projector.project_from(&x, 0, start);
            assert!(foot.status.is_converged(), "{x:?} from {start}: {foot}");
            for step in [1e-6, -1e-6] {
                let beside = curve.point((foot.parameter + step).rem_euclid(4.0));
                assert!((beside - x).norm() >= foot.distance - 1e-12, "{x:?} from {start}: {foot}");
            }
        }
    }
}
