//! Frames of clouds.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::{Numbers, check_frame, global_frame, sphere_mesh, wavy};
use distance_field::{CloudField, CloudOptions, DistanceField, Error, ErrorTerm, Hint, Search};
use footpoint::Status;
use nalgebra::{Point3, Vector3};
use nurbs_core::ParametricSurface;

#[test]
fn a_dense_cloud_stands_for_its_surface() {
    let points = sphere_mesh(40, 2.0).vertices().to_vec();
    let field = CloudField::new(&points, None).unwrap();
    assert_eq!(field.border_count(), 0);
    let mut numbers = Numbers::new(6);
    for _ in 0..200 {
        let direction = numbers.direction::<3>();
        let distance = 0.8 * numbers.next();
        let x = direction * (2.0 + distance);
        let frame = global_frame(&field, &x);
        check_frame(&frame, &x, 0.02);
        assert!((frame.distance - distance).abs() < 1e-3, "{distance} {frame:?}");
        assert!((frame.foot - direction * 2.0).norm() < 0.02, "{frame:?}");
        assert!((frame.curvatures.xy().map(|k| k + 0.5)).norm() < 0.03, "{:?}", frame.curvatures);
        let weight = ErrorTerm::Taylor.model(&frame).weights[0];
        assert!((weight - distance / (2.0 + distance)).abs() < 0.03);
    }
}

#[test]
fn the_border_of_an_open_cloud_is_found() {
    let surface = wavy();
    let n = 40u16;
    let at = |i: u16| f64::from(i) / f64::from(n);
    let grid: Vec<Point3<f64>> = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| (i, j)))
        .map(|(i, j)| Point3::from(surface.point(at(i), at(j))))
        .collect();
    for options in [CloudOptions::default(), CloudOptions::default().with_curvature(false)] {
        let field = CloudField::with_options(&grid, None, &options).unwrap();
        let count = field.border_count();
        assert!((150..=200).contains(&count), "{count}");
        let outside = global_frame(&field, &Vector3::new(-1.5, 0.0, 0.0));
        assert!(outside.on_boundary && outside.is_finite());
        let mut numbers = Numbers::new(4);
        for _ in 0..100 {
            let jet = surface.jet(0.5 + 0.4 * numbers.next(), 0.5 + 0.4 * numbers.next());
            let distance = 0.05 * numbers.next();
            let frame = global_frame(&field, &(jet.point + jet.unit_normal().unwrap() * distance));
            assert!(!frame.on_boundary);
            assert!((frame.distance.abs() - distance.abs()).abs() < 1e-3, "{distance} {frame:?}");
        }
    }
}

#[test]
fn given_normals_tell_the_side() {
    let mesh = sphere_mesh(12, 1.0);
    let inwards: Vec<Vector3<f64>> = mesh.vertices().iter().map(|p| -p.coords).collect();
    let field = CloudField::new(mesh.vertices(), Some(&inwards)).unwrap();
    let frame = global_frame(&field, &Vector3::new(0.3, 0.4, 0.2));
    assert!(frame.distance > 0.0 && frame.curvatures[0] > 0.8);
}

#[test]
fn poor_clouds_and_queries_do_no_harm() {
    let nan = Point3::new(f64::NAN, 0.0, 0.0);
    assert!(matches!(CloudField::new(&[], None), Err(Error::NoPoints { count: 0 })));
    assert!(matches!(CloudField::new(&[nan], None), Err(Error::NoPoints { count: 1 })));
    assert!(CloudField::new(&[Point3::origin()], Some(&[])).is_err());
    let x = Vector3::new(0.3, 4.0, 0.0);
    for points in [
        vec![Point3::origin()],
        vec![Point3::new(1.0, 2.0, 3.0); 30],
        (0..30u8).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect(),
        vec![Point3::origin(), nan, Point3::new(1.0, 0.0, 0.0)],
    ] {
        let field = CloudField::new(&points, None).unwrap();
        let frame = global_frame(&field, &x);
        assert!(frame.is_finite() && frame.on_boundary, "{frame:?}");
        assert_eq!(global_frame(&field, &Vector3::repeat(f64::NAN)).status, Status::InvalidPoint);
        assert!(!global_frame(&field, &Vector3::repeat(1e200)).is_finite());
    }
}

#[test]
fn hints_change_nothing() {
    let points = sphere_mesh(40, 2.0).vertices().to_vec();
    let field = CloudField::new(&points, None).unwrap();
    let mut numbers = Numbers::new(9);
    let queries: Vec<Vector3<f64>> =
        (0..400).map(|_| numbers.direction::<3>() * (1.9 + 0.2 * numbers.next())).collect();
    let hints: Vec<Hint> =
        field.frames(&queries, Search::Global, &[]).iter().map(|frame| frame.hint).collect();
    for step in [0.0, 0.01, 0.1, 1.0] {
        let moved: Vec<_> = queries.iter().map(|x| x + numbers.direction::<3>() * step).collect();
        let global = field.frames(&moved, Search::Global, &[]);
        assert_eq!(field.frames(&moved, Search::Local, &hints), global);
        assert_eq!(field.frames(&moved, Search::OneStep, &hints), global);
    }
}
