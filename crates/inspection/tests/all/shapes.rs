//! Deviations from surfaces, meshes and analytic shapes against closed forms and against each other.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use inspection::{Along, Error, InspectionOptions, Nominal, Outcome, Place, Tolerance, no_progress};
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use nurbs_core::{
    AnalyticSurface, BsplineSurface, Frame, Interval, KnotVector, Plane, Sphere, TessellationOptions, Torus,
};
use std::ops::ControlFlow;

fn frame() -> Frame {
    Frame::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(1.0, 1.0, 2.0), Vector3::new(1.0, -1.0, 0.0))
        .unwrap()
}

fn options() -> InspectionOptions {
    InspectionOptions::new(Tolerance::symmetric(0.1).unwrap())
}

/// Points in a box of half the size given about the origin of the frame, without order.
fn scattered(count: u32, half: f64) -> Vec<Point3<f64>> {
    let fraction = |i: u32, step: f64| (f64::from(i) * step).fract() * 2.0 - 1.0;
    let local =
        |i: u32| Vector3::new(fraction(i, 0.754_877), fraction(i, 0.569_840), fraction(i, 0.430_159)) * half;
    (1..=count).map(|i| Point3::from(frame().point(&local(i)))).collect()
}

fn distances(nominal: &Nominal, points: &[Point3<f64>], options: &InspectionOptions) -> Vec<f64> {
    nominal
        .measure(points, None, options, &no_progress)
        .unwrap()
        .iter()
        .map(|deviation| deviation.distance)
        .collect()
}

#[test]
fn a_sphere_in_three_forms() {
    let sphere = Sphere::new(frame(), 2.0).unwrap();
    let nurbs = sphere.to_nurbs().unwrap();
    let triangles = nurbs.tessellate(&TessellationOptions::new(1e-3)).unwrap();
    let mesh =
        TriangleMesh::new(triangles.vertices.into_iter().map(Point3::from).collect(), triangles.triangles)
            .unwrap();
    let forms = [
        (Nominal::from_analytic(&[sphere.into()]).unwrap(), 1e-13),
        (Nominal::from_surfaces(vec![nurbs]).unwrap(), 1e-10),
        (Nominal::from_mesh(&mesh).unwrap(), 1.1e-3),
    ];
    let points = scattered(400, 3.0);
    for (nominal, tolerance) in &forms {
        assert!(nominal.is_signed());
        for (deviation, point) in
            nominal.measure(&points, None, &options(), &no_progress).unwrap().iter().zip(&points)
        {
            let expected = (point.coords - frame().origin()).norm() - 2.0;
            assert!((deviation.distance - expected).abs() < *tolerance, "{deviation:?} {expected}");
            // The foot, the normal and the distance lead back to the point.
            let back = deviation.foot + deviation.normal * deviation.distance;
            let apart = (back - point).norm();
            assert!(apart < 1e-7 || deviation.place != Place::Interior, "{apart} {deviation:?}");
            assert_eq!((deviation.outcome, deviation.on_boundary), (Outcome::Measured, false));
        }
    }
}

/// A wavy bicubic sheet over [0, 9]².
fn sheet() -> BsplineSurface {
    let knots = KnotVector::uniform_clamped(3, 10).unwrap();
    let height = |i: usize, j: usize| 1.5 * ((i * 7 + j * 5) as f64 * 0.7).sin();
    let points =
        (0..100).map(|k| Vector3::new((k / 10) as f64, (k % 10) as f64, height(k / 10, k % 10))).collect();
    BsplineSurface::new(knots.clone(), knots, points, None).unwrap()
}

/// The nearest crossing of the exact surface agrees with that of a fine mesh of it, wherever that is well defined.
#[test]
fn lines_meet_the_exact_surface_where_they_meet_a_fine_mesh() {
    let torus = Torus::new(frame(), 2.0, 0.7).unwrap();
    let surfaces = [torus.to_nurbs().unwrap(), sheet()];
    for (index, surface) in surfaces.into_iter().enumerate() {
        let triangles = surface.tessellate(&TessellationOptions::new(1e-3)).unwrap();
        let mesh = TriangleMesh::new(
            triangles.vertices.into_iter().map(Point3::from).collect(),
            triangles.triangles,
        )
        .unwrap();
        let mesh = Nominal::from_mesh(&mesh).unwrap();
        let mut exact = vec![Nominal::from_surfaces(vec![surface]).unwrap()];
        if index == 0 {
            exact.push(Nominal::from_analytic(&[torus.into()]).unwrap());
        }
        let mut points = if index == 0 { scattered(150, 3.0) } else { scattered(150, 5.0) };
        if index == 1 {
            let centred = |point: &Point3<f64>| frame().local(&point.coords) + Vector3::new(4.5, 4.5, 0.0);
            points = points.iter().map(|point| Point3::from(centred(point))).collect();
        }
        for direction in [[0.0, 0.0, 1.0], [1.0, 0.3, -0.2]] {
            let options = options().with_along(Along::Direction(direction));
            let unit = Vector3::from(direction).normalize();
            let expected = mesh.measure(&points, None, &options, &no_progress).unwrap();
            for nominal in &exact {
                let found = nominal.measure(&points, None, &options, &no_progress).unwrap();
                let mut hits = 0;
                for ((found, expected), point) in found.iter().zip(&expected).zip(&points) {
                    // Where the line grazes the surface the crossing moves far for a small change of the shape.
                    let grazes = [found, expected].iter().any(|d| d.normal.dot(&unit).abs() < 0.05);
                    if grazes {
                        continue;
                    }
                    assert_eq!(found.outcome, expected.outcome, "{point} {found:?} {expected:?}");
                    if found.outcome == Outcome::Measured {
                        hits += 1;
                        assert!(
                            (found.distance.abs() - expected.distance.abs()).abs() < 0.03,
                            "{found:?} {expected:?}"
                        );
                        let across = (found.foot - point).cross(&unit).norm();
                        assert!(across < 1e-9 && found.gap < 1e-5, "{across} {found:?}");
                        let offset = (point - found.foot).norm();
                        assert!((offset - found.distance.abs()).abs() < 1e-9);
                    }
                }
                assert!(hits > 20, "{hits}");
            }
        }
    }
}

#[test]
fn the_nearest_of_several_crossings_is_taken_in_either_sense() {
    let sphere = Nominal::from_analytic(&[Sphere::new(frame(), 2.0).unwrap().into()]).unwrap();
    let nurbs = Nominal::from_surfaces(vec![Sphere::new(frame(), 2.0).unwrap().to_nurbs().unwrap()]).unwrap();
    let axis = frame().x();
    let at = |x: f64| Point3::from(frame().point(&Vector3::new(x, 0.0, 1.0)));
    let half = 3f64.sqrt();
    let along = options().with_along(Along::Direction((axis * 5.0).into()));
    for nominal in [&sphere, &nurbs] {
        // Inside, nearer to the one or to the other side; outside on both sides; beside.
        let points =
            [at(0.5), at(-0.5), at(3.0), at(-3.0), Point3::from(frame().point(&Vector3::new(0.0, 0.0, 2.5)))];
        let found = nominal.measure(&points, None, &along, &no_progress).unwrap();
        let expected = [-(half - 0.5), -(half - 0.5), 3.0 - half, 3.0 - half];
        for (deviation, expected) in found.iter().zip(expected) {
            assert!((deviation.distance - expected).abs() < 1e-9, "{deviation:?} {expected}");
        }
        assert_eq!(found[4].outcome, Outcome::NoHit);
        // Not beyond the largest distance.
        let found =
            nominal.measure(&points[2..3], None, &along.with_max_distance(1.0), &no_progress).unwrap();
        assert_eq!(found[0].outcome, Outcome::NoHit);
    }
}

#[test]
fn normals_of_the_points() {
    let plane = Plane::new(
        Frame::new(Vector3::zeros(), Vector3::z(), Vector3::x()).unwrap(),
        Interval::new(-1.0, 1.0).unwrap(),
        Interval::new(-1.0, 1.0).unwrap(),
    );
    let nominal = Nominal::from_surfaces(vec![plane.to_nurbs().unwrap()]).unwrap();
    let points = [
        Point3::new(0.0, 0.0, 0.3),
        Point3::new(0.0, 0.0, -0.3),
        Point3::origin(),
        Point3::new(0.5, 0.0, 0.1),
    ];
    let normals =
        [Vector3::new(3.0, 0.0, 4.0), Vector3::new(0.0, 0.0, -1e-200), Vector3::zeros(), Vector3::x()];
    let options = options().with_along(Along::Normal);
    let found = nominal.measure(&points, Some(&normals), &options, &no_progress).unwrap();
    assert!(
        (found[0].distance - 0.375).abs() < 1e-12 && (found[0].foot.x + 0.225).abs() < 1e-12,
        "{:?}",
        found[0]
    );
    assert!((found[1].distance + 0.3).abs() < 1e-15);
    assert_eq!([found[2].outcome, found[3].outcome], [Outcome::NoNormal, Outcome::NoHit]);
    assert_eq!(
        nominal.measure(&points, None, &options, &no_progress),
        Err(Error::Normals { found: 0, points: 4 })
    );
    assert!(nominal.measure(&points, Some(&normals[1..]), &options, &no_progress).is_err());
}

#[test]
fn boundaries_and_the_largest_distance() {
    let unit = Interval::UNIT;
    let plane: AnalyticSurface =
        Plane::new(Frame::new(Vector3::zeros(), Vector3::z(), Vector3::x()).unwrap(), unit, unit).into();
    let corners =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let points = [
        Point3::new(0.5, 0.25, 0.2),
        Point3::new(1.3, 0.5, -0.4),
        Point3::new(1.3, 1.4, 0.0),
        Point3::new(0.5, 0.5, 9.0),
        Point3::new(f64::NAN, 0.0, 0.0),
    ];
    for nominal in [
        Nominal::from_analytic(&[plane]).unwrap(),
        Nominal::from_surfaces(vec![plane.to_nurbs().unwrap()]).unwrap(),
        Nominal::from_mesh(&mesh).unwrap(),
    ] {
        let found = distances(&nominal, &points, &options());
        for (found, expected) in found.iter().zip([0.2, -0.5, 0.5, 9.0]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        let options = options().with_drop_beyond_boundary(true).with_max_distance(1.0);
        let found = nominal.measure(&points, None, &options, &no_progress).unwrap();
        let outcomes: Vec<Outcome> = found.iter().map(|deviation| deviation.outcome).collect();
        use Outcome::{BeyondBoundary, BeyondMaxDistance, InvalidPoint, Measured};
        assert_eq!(outcomes, [Measured, BeyondBoundary, BeyondBoundary, BeyondMaxDistance, InvalidPoint]);
        let inspection = nominal.inspect(&points, &options).unwrap();
        assert_eq!(
            (inspection.points, inspection.total.count, inspection.outcomes["beyond_boundary"]),
            (5, 1, 2)
        );
        assert!(!inspection.verdict.pass);
    }
}

#[test]
fn meshes_without_sides_have_distances_without_sign() {
    let corners =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 3, 2]]).unwrap();
    let nominal = Nominal::from_mesh(&mesh).unwrap();
    assert!(!nominal.is_signed());
    assert_eq!(
        distances(&nominal, &[Point3::new(0.7, 0.2, -1.0), Point3::new(0.2, 0.7, -1.0)], &options()),
        [1.0, 1.0]
    );
}

#[test]
fn bad_options_and_cancelling() {
    assert_eq!(Nominal::from_surfaces(Vec::new()).unwrap_err(), Error::EmptyModel);
    assert_eq!(Nominal::from_analytic(&[]).unwrap_err(), Error::EmptyModel);
    let nominal = Nominal::from_surfaces(vec![sheet()]).unwrap();
    let points = scattered(2000, 5.0);
    for bad in [
        options().with_min_share(1.5),
        options().with_min_share(f64::NAN),
        options().with_max_distance(0.0),
        options().with_max_distance(f64::NAN),
        options().with_along(Along::Direction([0.0; 3])),
        options().with_along(Along::Direction([f64::NAN, 0.0, 1.0])),
        InspectionOptions { tolerance: Tolerance { lower: 1.0, upper: 1.0 }, ..options() },
    ] {
        assert!(nominal.inspect(&points, &bad).is_err(), "{bad:?}");
    }
    let stop = |_: usize, _: usize| ControlFlow::Break(());
    for along in [Along::Shortest, Along::Direction([0.0, 0.0, 1.0])] {
        let found = nominal.measure(&points, None, &options().with_along(along), &stop).unwrap();
        assert_eq!(found.len(), points.len());
        assert!(found.iter().any(|deviation| deviation.outcome == Outcome::Cancelled));
    }
}

/// A line meets a plane at 60 degrees in twice the height, to rounding: no approximation takes the place of the crossing.
#[test]
fn slanted_lines_are_exact() {
    let range = Interval::new(-9.0, 9.0).unwrap();
    let plane = Plane::new(frame(), range, range).to_nurbs().unwrap();
    let nominal = Nominal::from_surfaces(vec![plane]).unwrap();
    let direction = frame().vector(&Vector3::new(3f64.sqrt() / 2.0, 0.0, 0.5));
    let options = options().with_along(Along::Direction(direction.into()));
    let at = |i: u32| Vector3::new(f64::from(i) * 0.1, f64::from(i) * -0.2, (f64::from(i) - 5.0) * 0.01);
    let points: Vec<_> = (0..11).map(|i| Point3::from(frame().point(&at(i)))).collect();
    for (i, distance) in (0..11).zip(distances(&nominal, &points, &options)) {
        assert!((distance - 2.0 * at(i).z).abs() < 1e-14, "{i}: {distance}");
    }
}
