//! Registrations of some of the points, and of the points that matter alone.

#![allow(clippy::unwrap_used, reason = "tests may panic")]

use crate::bodies::{Bumpy, Random};
use distance_field::{CloudField, DistanceField, Search};
use nalgebra::{Point3, Vector3};
use sdm_register::{Pose, RegisterOptions, Source, no_progress, register, register_some};

/// One side of the body as a field, another that has some of it in common, displaced, and where that belongs.
fn sides(count: usize) -> (CloudField, Vec<Vector3<f64>>, Pose<3>) {
    let (body, mut random) = (Bumpy::new(), Random(3));
    let side = |towards: Vector3<f64>, random: &mut Random| body.view(Some((towards, 1.3)), count, random).0;
    let fixed: Vec<Point3<f64>> = side(Vector3::z(), &mut random).into_iter().map(Point3::from).collect();
    let moving = side(Vector3::new(0.7, 0.1, 0.6).normalize(), &mut random);
    let motion = random.motion(0.12, 0.05);
    let displaced = moving.iter().map(|x| motion.apply(x)).collect();
    (CloudField::new(&fixed, None).unwrap(), displaced, motion.inverse())
}

fn error(points: &[Vector3<f64>], pose: &Pose<3>, truth: &Pose<3>) -> f64 {
    let squares = points.iter().map(|x| (pose.apply(x) - truth.apply(x)).norm_squared());
    (squares.sum::<f64>() / points.len() as f64).sqrt()
}

#[test]
fn some_points_lead_near_where_all_of_them_do() {
    let (field, points, truth) = sides(9000);
    let (source, options) = (Source::new(&points), RegisterOptions::default());
    let some = register_some(&field, &source, &Pose::identity(), &options, &no_progress).unwrap().unwrap();
    assert!(some.is_converged() && (3000..6000).contains(&some.points), "{some}");
    assert!(error(&points, &some.pose, &truth) < 1e-3, "{some}");
    let all = register(&field, &source, &Pose::identity(), &options).unwrap();
    assert!(all.is_converged() && all.points == 9000, "{all}");
    assert!(error(&points, &all.pose, &truth) < 2e-4, "{all}");
    // Few points are all that there are.
    let few = Source::new(&points[..5000]);
    let none = register_some(&field, &few, &Pose::identity(), &options, &no_progress).unwrap();
    assert_eq!(none, None);
}

#[test]
fn points_that_were_left_out_on_the_way_are_judged_at_the_end() {
    let (field, points, _) = sides(9000);
    let report =
        register(&field, &Source::new(&points), &Pose::identity(), &RegisterOptions::default()).unwrap();
    let limit = report.limit.unwrap();
    // A fresh look at all points finds the ones that the report counts.
    let moved: Vec<_> = points.iter().map(|x| report.pose.apply(x)).collect();
    let frames = field.frames(&moved, Search::Global, &[]);
    let near = frames.iter().filter(|frame| frame.distance.abs() <= limit && !frame.on_boundary).count();
    let difference = near.abs_diff(report.used);
    assert!(report.used < 8000 && difference <= points.len() / 200, "{near} against {report}");
}

#[test]
fn some_points_refuse_what_all_of_them_do() {
    let (field, mut points, _) = sides(7000);
    let nan = Pose::new(nalgebra::Matrix3::identity(), Vector3::repeat(f64::NAN));
    let some = |points: &[Vector3<f64>], pose: &Pose<3>| {
        register_some(&field, &Source::new(points), pose, &RegisterOptions::default(), &no_progress)
    };
    assert!(some(&points, &nan).is_err());
    points.fill(Vector3::x());
    assert!(some(&points, &Pose::identity()).is_err());
    assert!(some(&[], &Pose::identity()).is_err());
}
