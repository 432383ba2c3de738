//! What is proven decides, what is left out can be computed again, and thin walls are measured on the right face.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use footpoint::ProjectionOptions;
use inspection::{
    Along, Deviation, DeviationRecord, Error, InspectionOptions, Nominal, Outcome, Tolerance, no_progress,
};
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector2, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, Cylinder, Frame, Interval, KnotVector, Sphere};

/// The sheet `z = height + wave(x, y)` over the unit square, facing up or down.
fn sheet(height: f64, wave: f64, up: bool) -> BsplineSurface {
    let knots = KnotVector::uniform_clamped(3, 8).unwrap();
    let point = |i: usize, j: usize| {
        let wave = wave * ((1.3 * i as f64).sin() + (1.7 * j as f64 + 0.4).cos());
        Vector3::new(i as f64 / 7.0, j as f64 / 7.0, height + wave)
    };
    let net = (0..64).map(|k| if up { point(k / 8, k % 8) } else { point(k % 8, k / 8) }).collect();
    BsplineSurface::new(knots.clone(), knots, net, None).unwrap()
}

/// Points about the unit square, with normals that point up or down, some of no use.
fn cloud(count: u32) -> (Vec<Point3<f64>>, Vec<Vector3<f64>>) {
    let share = |i: u32, step: f64| (f64::from(i) * step).fract();
    let point = |i: u32| {
        let z = if i % 101 == 7 { f64::NAN } else { 1.2 * share(i, 0.732) - 0.6 };
        Point3::new(1.2 * share(i, 0.618_034) - 0.1, 1.2 * share(i, 0.414_214) - 0.1, z)
    };
    let normal = |i: u32| match i % 17 {
        3 => Vector3::zeros(),
        k => Vector3::new(
            0.5 * f64::from(i).sin(),
            0.4 * f64::from(i).cos(),
            if k % 3 == 0 { -1.0 } else { 1.0 },
        ),
    };
    ((0..count).map(point).collect(), (0..count).map(normal).collect())
}

fn plate() -> TriangleMesh {
    let at = |i: u8| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), 0.1 * f64::from(i >> 2));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new((0..8).map(at).collect(), faces).unwrap()
}

fn options() -> InspectionOptions {
    InspectionOptions::new(Tolerance::symmetric(0.05).unwrap())
}

fn bits(value: &Vector3<f64>) -> [u64; 3] {
    [value.x, value.y, value.z].map(f64::to_bits)
}

#[test]
fn rounds_and_records_give_the_same_bits() {
    let line = KnotVector::uniform_clamped(2, 4).unwrap();
    let corners = [[0., 0., 0.], [1., 0., 0.2], [1., 1., 0.], [0., 1., 0.3]].map(Vector3::from).to_vec();
    let space = BsplineCurve::new(line.clone(), corners.clone(), None).unwrap();
    let plane: Vec<Vector2<f64>> = corners.iter().map(|corner| corner.xy()).collect();
    let profile = BsplineCurve::new(line, plane, None).unwrap();
    let cylinder = Cylinder::new(Frame::WORLD, 0.3, Interval::new(-0.4, 0.4).unwrap()).unwrap();
    let sphere = Sphere::new(Frame::WORLD, 0.5).unwrap();
    let sheets = vec![sheet(0.0, 0.05, true), sheet(-0.1, 0.05, false)];
    let solid = [
        Nominal::from_surfaces(sheets).unwrap(),
        Nominal::from_mesh(&plate()).unwrap(),
        Nominal::from_analytic(&[cylinder.into(), sphere.into()]).unwrap(),
    ];
    let curves = [Nominal::from_profile(vec![profile]).unwrap(), Nominal::from_curves(vec![space]).unwrap()];
    let (points, normals) = cloud(700);
    let plain = [options().with_max_distance(0.4)];
    let all = [
        plain[0],
        options().with_max_angle(0.8),
        options().with_along(Along::Normal),
        options().with_along(Along::Normal).with_max_angle(1.0),
        options().with_along(Along::Direction([0.1, 0.2, 1.0])).with_max_angle(1.2),
    ];
    let solid = solid.iter().flat_map(|nominal| all.iter().map(move |options| (nominal, options)));
    let curves = curves.iter().flat_map(|nominal| plain.iter().map(move |options| (nominal, options)));
    for (nominal, options) in solid.chain(curves) {
        let whole = nominal.measure(&points, Some(&normals), options, &no_progress).unwrap();
        let mut seen = vec![None; points.len()];
        let mut receive = |measured: &[(usize, Deviation)]| {
            measured.iter().for_each(|&(index, deviation)| seen[index] = Some(deviation));
        };
        nominal.measure_each(&points, Some(&normals), options, &no_progress, &mut receive).unwrap();
        let mut restricted = 0;
        for (index, deviation) in whole.iter().enumerate() {
            // Printed numbers read back to the same bits.
            assert_eq!(format!("{:?}", seen[index].unwrap()), format!("{deviation:?}"));
            let record = DeviationRecord::from(deviation);
            let normal = nominal.normal(&points[index], Some(&normals[index]), &record, options);
            if deviation.distance.is_nan() {
                assert!(normal.iter().all(|value| value.is_nan()));
            } else {
                assert_eq!(bits(&normal), bits(&deviation.normal), "{deviation:?}");
                assert_eq!((record.shape(), record.triangle()), (deviation.shape, deviation.triangle));
            }
            restricted += usize::from(deviation.is_restricted);
        }
        assert_eq!(restricted > 0, options.max_angle.is_some(), "{options:?}");
    }
}

/// With next to no boxes for the proof most certificates stay open. Whatever is measured then is right.
#[test]
fn open_certificates_never_decide_wrongly() {
    let nominal = Nominal::from_surfaces(vec![sheet(0.0, 0.2, true), sheet(0.3, 0.2, false)]).unwrap();
    let (points, _) = cloud(1500);
    let tolerance = Tolerance::new(-0.08, 0.12).unwrap();
    let proven = InspectionOptions::new(tolerance);
    let hasty = proven.with_projection(ProjectionOptions { max_boxes: 1, ..ProjectionOptions::default() });
    let truth = nominal.measure(&points, None, &proven, &no_progress).unwrap();
    let found = nominal.measure(&points, None, &hasty, &no_progress).unwrap();
    for (found, truth) in found.iter().zip(&truth) {
        match found.outcome {
            Outcome::Measured => {
                assert_eq!(found.class(&tolerance), truth.class(&tolerance), "{found:?} {truth:?}");
            }
            Outcome::Undecided => assert!(found.distance.is_finite() && found.gap > 0.0, "{found:?}"),
            other => assert_eq!(other, truth.outcome),
        }
    }
    let mut partial = inspection::Partial::new(&hasty).unwrap();
    partial.extend(0, &points, &found);
    let inspection = partial.finish(&hasty, nominal.shapes()).unwrap();
    let undecided = found.iter().filter(|d| d.outcome == Outcome::Undecided).count() as u64;
    assert_eq!(inspection.outcomes["undecided"], undecided);
    assert_eq!(inspection.verdict.judged, inspection.total.count + undecided);
    assert_eq!(inspection.verdict.within, inspection.total.within);
}

/// Inside a hollow cylinder or ball all feet are known by hand.
#[test]
fn analytic_walls_are_measured_on_the_side_that_was_seen() {
    let tube = |radius: f64| Cylinder::new(Frame::WORLD, radius, Interval::new(-2.0, 2.0).unwrap()).unwrap();
    let nominal = Nominal::from_analytic(&[tube(1.0).into(), tube(1.1).into()]).unwrap();
    let points: Vec<_> = [1.02, 1.06, 1.2].map(|r| Point3::new(r, 0.0, 0.3)).to_vec();
    // Both face outwards: all feet agree, or none.
    let found = |normal: Vector3<f64>| {
        let options = options().with_max_angle(0.5);
        nominal.measure(&points, Some(&[normal; 3]), &options, &no_progress).unwrap()
    };
    let outwards: Vec<f64> = found(Vector3::x()).iter().map(|d| d.distance).collect();
    let expected = [0.02, -0.04, 0.1];
    assert!(outwards.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{outwards:?}");
    assert!(found(-Vector3::x()).iter().all(|d| d.outcome == Outcome::NoMatchingFoot));
    // The axis: the direction chooses the point.
    let axis = nominal.measure(
        &[Point3::new(0.0, 0.0, 0.3)],
        Some(&[Vector3::new(0.6, 0.8, 0.0)]),
        &options().with_max_angle(0.2),
        &no_progress,
    );
    let axis = axis.unwrap()[0];
    assert!((axis.distance + 1.0).abs() < 1e-9, "{axis:?}");
    assert!(axis.normal.dot(&Vector3::new(0.6, 0.8, 0.0)) > 0.2f64.cos(), "{axis:?}");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let curve = BsplineCurve::new(
        KnotVector::bezier(1, Interval::UNIT).unwrap(),
        vec![Vector2::zeros(), Vector2::x()],
        None,
    );
    let profile = Nominal::from_profile(vec![curve.unwrap()]).unwrap();
    let facing = options().with_max_angle(1.0);
    let points = [Point3::origin()];
    let up = [Vector3::z()];
    assert_eq!(profile.measure(&points, Some(&up), &facing, &no_progress), Err(Error::FacingCurves));
    let mut torn = plate().triangles().to_vec();
    torn[0].swap(0, 1);
    let torn = Nominal::from_mesh(&TriangleMesh::new(plate().vertices().to_vec(), torn).unwrap()).unwrap();
    assert_eq!(torn.measure(&points, Some(&up), &facing, &no_progress), Err(Error::FacingUnoriented));
    let nominal = Nominal::from_mesh(&plate()).unwrap();
    assert_eq!(
        nominal.measure(&points, None, &facing, &no_progress),
        Err(Error::Normals { found: 0, points: 1 })
    );
    for angle in [0.0, -1.0, 3.2, f64::NAN] {
        assert!(nominal.measure(&points, Some(&up), &options().with_max_angle(angle), &no_progress).is_err());
    }
    // A straight angle is no limit, and asks for no normals.
    let open = options().with_max_angle(std::f64::consts::PI);
    assert!(nominal.measure(&points, None, &open, &no_progress).is_ok());
}
