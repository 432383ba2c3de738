//! Where footpoints lie, whether they are the only ones, and on which side the query is.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use crate::projector_support::shapes::{parabola, rectangle};
use footpoint::Location::{Corner, Edge, Interior, Pole, Seam};
use footpoint::Multiplicity::{Continuum, Tied, Unique, Unknown};
use footpoint::{CurveProjector, Mode, ProjectionOptions, Status, SurfaceProjector};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Circle, Cone, Cylinder, Frame, Interval, KnotVector, Sphere, Torus,
};

/// Positions of the test shapes: in place, turned, and turned and far out.
fn frames() -> Vec<Frame> {
    let (axis, reference) = (Vector3::new(1.0, -2.0, 0.7), Vector3::new(0.3, 1.0, 2.0));
    vec![
        Frame::WORLD,
        Frame::new(Vector3::new(3.0, -1.0, 4.0), axis, reference).unwrap(),
        Frame::new(Vector3::new(300.0, -100.0, 400.0), axis, reference).unwrap(),
    ]
}

fn v(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

/// Projects points given in local coordinates in every position; yields all answers.
fn in_all_frames(
    shape: impl Fn(Frame) -> BsplineSurface,
    points: &[Vector3<f64>],
    check: impl Fn(&Vector3<f64>, &footpoint::SurfaceFootpoint),
) {
    for frame in frames() {
        let projector = SurfaceProjector::new(&shape(frame));
        for x in points {
            let foot = projector.project(&frame.point(x));
            assert!(foot.status.is_converged(), "{frame:?} {x:?}: {foot:?}");
            check(x, &foot);
        }
    }
}

#[test]
fn centre_of_a_sphere_has_a_continuum() {
    let sphere = |frame| Sphere::new(frame, 2.0).unwrap().to_nurbs().unwrap();
    in_all_frames(sphere, &[v(0.0, 0.0, 0.0)], |x, foot| {
        assert_eq!(foot.multiplicity, Continuum, "{x:?} {foot:?}");
    });
    // Everywhere else there is one footpoint, also next to the centre and on the axis.
    let others = [v(0.0, 0.0, 1.0), v(0.0, 0.0, -0.3), v(0.2, 0.1, 0.0), v(0.0, 0.0, 5.0), v(4.0, 3.0, 1.0)];
    in_all_frames(sphere, &others, |x, foot| assert_eq!(foot.multiplicity, Unique, "{x:?} {foot:?}"));
}

#[test]
fn poles_of_a_sphere() {
    let sphere = |frame| Sphere::new(frame, 2.0).unwrap().to_nurbs().unwrap();
    let on_axis =
        [v(0.0, 0.0, 2.5), v(0.0, 0.0, 40.0), v(0.0, 0.0, 1.0), v(0.0, 0.0, -3.0), v(0.0, 0.0, -0.2)];
    in_all_frames(sphere, &on_axis, |x, foot| {
        assert_eq!(foot.location, Pole, "{x:?} {foot:?}");
        assert_eq!(foot.signed_distance > 0.0, x.norm() > 2.0, "{x:?} {foot:?}");
    });
    in_all_frames(sphere, &[v(0.3, 0.4, 1.0), v(-1.0, 3.0, -2.0)], |x, foot| {
        assert_eq!(foot.location, Interior, "{x:?} {foot:?}");
        assert_eq!(foot.signed_distance > 0.0, x.norm() > 2.0, "{x:?} {foot:?}");
    });
    in_all_frames(sphere, &[v(1.0, 0.0, 0.0), v(4.0, 0.0, 1.0)], |x, foot| {
        // Rounding may leave the foot a little beside the seam.
        assert!(foot.location == Seam || foot.parameter[0].abs() < 1e-7, "{x:?} {foot:?}");
    });
}

#[test]
fn axis_of_a_cylinder_has_a_continuum() {
    let cylinder =
        |frame| Cylinder::new(frame, 1.5, Interval::new(-1.0, 2.0).unwrap()).unwrap().to_nurbs().unwrap();
    // Between the ends, and beyond them: there the edges are the nearest.
    in_all_frames(cylinder, &[v(0.0, 0.0, 0.0), v(0.0, 0.0, 1.3)], |x, foot| {
        assert_eq!(foot.multiplicity, Continuum, "{x:?} {foot:?}");
        assert!((foot.signed_distance + 1.5).abs() < 1e-12, "{x:?} {foot:?}");
    });
    in_all_frames(cylinder, &[v(0.0, 0.0, 3.0), v(0.0, 0.0, -8.0)], |x, foot| {
        assert_eq!((foot.multiplicity, foot.location), (Continuum, Edge), "{x:?} {foot:?}");
        assert_eq!(foot.status, Status::OnBoundary);
    });
    in_all_frames(cylinder, &[v(0.1, 0.0, 0.5), v(1.0, 1.0, 1.0), v(-4.0, 2.0, 0.0)], |x, foot| {
        assert_eq!(foot.multiplicity, Unique, "{x:?} {foot:?}");
    });
    in_all_frames(cylinder, &[v(2.0, 0.0, 0.5), v(1.0, 0.0, 1.0)], |x, foot| {
        assert_eq!(foot.location, Seam, "{x:?} {foot:?}");
    });
    in_all_frames(cylinder, &[v(2.0, 0.0, 5.0), v(0.2, 0.7, -3.0)], |x, foot| {
        assert_eq!(foot.location, Edge, "{x:?} {foot:?}");
    });
}

#[test]
fn apex_and_axis_of_a_cone() {
    // Apex at height 2; half angle 45°.
    let cone = |frame| Cone::new(frame, 2.0, 0.0, 2.0).unwrap().to_nurbs().unwrap();
    in_all_frames(cone, &[v(0.0, 0.0, 2.5), v(0.0, 0.0, 30.0), v(0.2, 0.1, 3.0)], |x, foot| {
        assert_eq!((foot.location, foot.multiplicity), (Pole, Unique), "{x:?} {foot:?}");
    });
    in_all_frames(cone, &[v(0.0, 0.0, 1.0), v(0.0, 0.0, 0.2)], |x, foot| {
        assert_eq!(foot.multiplicity, Continuum, "{x:?} {foot:?}");
    });
    in_all_frames(cone, &[v(0.0, 0.0, -3.0)], |x, foot| {
        assert_eq!((foot.location, foot.multiplicity), (Edge, Continuum), "{x:?} {foot:?}");
    });
    in_all_frames(cone, &[v(1.0, 2.0, 1.0), v(0.1, -0.1, 0.5)], |x, foot| {
        assert_eq!((foot.location, foot.multiplicity), (Interior, Unique), "{x:?} {foot:?}");
    });
}

#[test]
fn axis_and_core_of_a_torus_have_continua() {
    let torus = |frame| Torus::new(frame, 3.0, 1.0).unwrap().to_nurbs().unwrap();
    let axis = [v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.4), v(0.0, 0.0, -7.0)];
    in_all_frames(torus, &axis, |x, foot| assert_eq!(foot.multiplicity, Continuum, "{x:?} {foot:?}"));
    let core = [v(3.0, 0.0, 0.0), v(0.0, -3.0, 0.0), v(1.8, 2.4, 0.0)];
    in_all_frames(torus, &core, |x, foot| {
        assert_eq!(foot.multiplicity, Continuum, "{x:?} {foot:?}");
        assert!((foot.signed_distance + 1.0).abs() < 1e-9, "{x:?} {foot:?}");
    });
    in_all_frames(torus, &[v(1.0, 0.5, 0.2), v(4.0, -4.0, 1.0), v(0.1, 0.05, 0.0)], |x, foot| {
        assert_eq!((foot.location, foot.multiplicity), (Interior, Unique), "{x:?} {foot:?}");
    });
    in_all_frames(torus, &[v(5.0, 0.0, 0.5), v(0.0, 6.0, 0.0)], |x, foot| {
        assert_eq!(foot.location, Seam, "{x:?} {foot:?}");
    });
}

#[test]
fn centre_and_axis_of_a_circle_have_a_continuum() {
    let plane = Circle::new(Vector2::new(2.0, -1.0), 3.0).unwrap();
    let projector = CurveProjector::new(&plane.to_nurbs().unwrap());
    assert_eq!(projector.project(&Vector2::new(2.0, -1.0)).multiplicity, Continuum);
    let foot = projector.project(&Vector2::new(2.3, -1.1));
    assert_eq!((foot.multiplicity, foot.location), (Unique, Interior));
    assert_eq!(projector.project(&Vector2::new(3.0, -1.0)).location, Seam);
    for frame in frames() {
        let circle = Circle::in_frame(&frame, 2.0).unwrap().to_nurbs().unwrap();
        let projector = CurveProjector::new(&circle);
        for z in [0.0, 1.0, -20.0] {
            let foot = projector.project(&frame.point(&v(0.0, 0.0, z)));
            assert_eq!(foot.multiplicity, Continuum, "{z} {foot:?}");
            let foot = projector.project(&frame.point(&v(0.5, 0.1, z)));
            assert_eq!(foot.multiplicity, Unique, "{z} {foot:?}");
        }
    }
    // The centre of an arc as well.
    let arc = plane.with_arc(Interval::new(0.3, 1.0).unwrap()).unwrap().to_nurbs().unwrap();
    let projector = CurveProjector::new(&arc);
    assert_eq!(projector.project(&Vector2::new(2.0, -1.0)).multiplicity, Continuum);
    // Opposite an arc, both ends are far and one is nearer.
    assert_eq!(projector.project(&Vector2::new(2.0, -5.0)).location, Edge);
}

#[test]
fn between_two_shapes_there_are_two_feet() {
    let model = [rectangle(2.0, 1.0, 0.0), rectangle(2.0, 1.0, 3.0)];
    let projector = SurfaceProjector::for_model(&model).unwrap();
    assert_eq!(projector.project(&v(0.7, 0.3, 1.5)).multiplicity, Tied);
    assert_eq!(projector.project(&v(5.0, 4.0, 1.5)).multiplicity, Tied);
    let foot = projector.project(&v(0.7, 0.3, 1.4));
    assert_eq!((foot.multiplicity, foot.shape), (Unique, 0));
    let foot = projector.project(&v(0.7, 0.3, 1.6));
    assert_eq!((foot.multiplicity, foot.shape), (Unique, 1));
    // A shape twice in the model is one place in space.
    let twice = SurfaceProjector::for_model(&[rectangle(2.0, 1.0, 0.0), rectangle(2.0, 1.0, 0.0)]).unwrap();
    assert_eq!(twice.project(&v(0.7, 0.3, 1.5)).multiplicity, Unique);
}

#[test]
fn two_feet_on_one_shape() {
    let curve = CurveProjector::new(&parabola());
    // The centre of curvature of the vertex is (0, 1/2): above it there are two feet, below one.
    for (y, expected) in [(0.8, Tied), (0.55, Tied), (0.4, Unique), (-1.0, Unique), (40.0, Tied)] {
        let foot = curve.project(&Vector2::new(0.0, y));
        assert_eq!(foot.multiplicity, expected, "{y}: {foot:?}");
        assert_eq!(curve.project(&Vector2::new(0.01, y)).multiplicity, Unique, "{y}");
    }
    // The same, extruded.
    let line = KnotVector::uniform_clamped(1, 2).unwrap();
    let points = [v(-1.0, 1.0, 0.0), v(0.0, -1.0, 0.0), v(1.0, 1.0, 0.0)];
    let points = points.iter().flat_map(|p| [*p, p + Vector3::z()]).collect();
    let trough = BsplineSurface::new(KnotVector::uniform_clamped(2, 3).unwrap(), line, points, None).unwrap();
    let projector = SurfaceProjector::new(&trough);
    for (y, expected) in [(0.8, Tied), (0.55, Tied), (0.4, Unique), (-1.0, Unique), (40.0, Tied)] {
        let foot = projector.project(&v(0.0, y, 0.3));
        assert_eq!(foot.multiplicity, expected, "{y}: {foot:?}");
        assert_eq!(projector.project(&v(0.01, y, 0.3)).multiplicity, Unique, "{y}");
    }
}

#[test]
fn ends_and_corners() {
    let projector = SurfaceProjector::new(&rectangle(2.0, 1.0, 0.0));
    let cases = [
        (v(0.5, 0.5, 2.0), Interior, Status::Converged),
        (v(0.5, 0.5, 0.0), Interior, Status::Converged),
        (v(3.0, 0.5, 2.0), Edge, Status::OnBoundary),
        (v(-1.0, 0.5, 0.0), Edge, Status::OnBoundary),
        (v(0.5, -7.0, 1.0), Edge, Status::OnBoundary),
        (v(0.5, 1.5, -1.0), Edge, Status::OnBoundary),
        (v(3.0, 1.5, -1.0), Corner, Status::OnBoundary),
        (v(-3.0, -0.5, 0.0), Corner, Status::OnBoundary),
        (v(2.0, 1.0, 0.0), Corner, Status::OnBoundary),
    ];
    for (x, location, status) in cases {
        let foot = projector.project(&x);
        assert_eq!(
            (foot.location, foot.status, foot.multiplicity),
            (location, status, Unique),
            "{x:?} {foot:?}"
        );
        let fast = projector.project_with(&x, &ProjectionOptions::default().with_mode(Mode::Fast)).unwrap();
        assert_eq!(
            (fast.location, fast.status, fast.multiplicity),
            (location, status, Unknown),
            "{x:?} {fast:?}"
        );
    }
    let curve = CurveProjector::new(&parabola());
    let foot = curve.project(&Vector2::new(3.0, 0.5));
    assert_eq!((foot.location, foot.status, foot.parameter), (Edge, Status::OnBoundary, 1.0));
    let foot = curve.project(&Vector2::new(0.5, 0.0));
    assert_eq!((foot.location, foot.status), (Interior, Status::Converged));
}

#[test]
fn kinks_are_interior() {
    // An angle of two segments: from the outside, its vertex is nearest.
    let points = vec![Vector2::new(0.0, 0.0), Vector2::new(1.0, 0.0), Vector2::new(1.0, 1.0)];
    let knots = KnotVector::uniform_clamped(1, 3).unwrap();
    let curve = BsplineCurve::new(knots, points, None).unwrap();
    let projector = CurveProjector::new(&curve);
    let foot = projector.project(&Vector2::new(2.0, -1.5));
    assert_eq!((foot.location, foot.status, foot.multiplicity), (Interior, Status::Converged, Unique));
    assert_eq!(foot.parameter, 0.5);
    let foot = projector.project(&Vector2::new(0.6, 0.4));
    assert_eq!(foot.multiplicity, Tied);
}

#[test]
fn closed_curves_without_ends() {
    // A periodic cubic: its two ends are one point, and nothing special happens there.
    let knots = KnotVector::uniform_periodic(3, 6).unwrap();
    let ring = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / 6.0;
        Vector2::new(3.0 * angle.cos(), 2.0 * angle.sin())
    };
    let curve = BsplineCurve::new(knots, (0..9).map(|k| ring(k % 6)).collect(), None).unwrap();
    let projector = CurveProjector::new(&curve);
    let start = nurbs_core::ParametricCurve::jet(&curve, 0.0);
    let normal = Vector2::new(-start.d1.y, start.d1.x).normalize();
    for offset in [0.3, -0.3] {
        let foot = projector.project(&(start.point + normal * offset));
        assert_eq!((foot.status, foot.multiplicity), (Status::Converged, Unique), "{foot:?}");
        assert!(foot.parameter.min(1.0 - foot.parameter) < 1e-9, "{foot:?}");
        assert!((foot.distance - 0.3).abs() < 1e-12, "{foot:?}");
    }
}
