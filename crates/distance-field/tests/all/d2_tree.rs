//! The d²-tree against the field it is made of.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::{Numbers, check_frame, global_frame, wavy};
use distance_field::{
    CurveField, D2Tree, D2TreeOptions, DistanceField, Error, ErrorTerm, Hint, Search, SurfaceField,
};
use footpoint::Status;
use nalgebra::{Vector2, Vector3};
use nurbs_core::{Circle, Frame, Sphere};

#[test]
fn errors_stay_below_the_tolerance_away_from_the_cut_locus() {
    let field = SurfaceField::new(&wavy()).unwrap();
    let diagonal = field.bounding_box().diagonal();
    let mut numbers = Numbers::new(17);
    let mut before = usize::MAX;
    for tolerance in [3e-3, 1e-2] {
        let options = D2TreeOptions::default().with_tolerance(tolerance).with_margin(0.05).with_max_depth(5);
        let tree = D2Tree::new(field.clone(), &options).unwrap();
        let report = tree.report();
        assert!(report.leaves < before && report.leaves > 8, "{report:?}");
        assert!(report.error <= report.tolerance && report.memory > report.leaves * 100);
        before = report.leaves;
        let (mut worse, mut count) = (0, 0);
        for _ in 0..2000 {
            let x = numbers.vector::<3>() * 0.9;
            let (here, exact) = (global_frame(&tree, &x), global_frame(&field, &x));
            assert!(here.is_finite());
            let error = (here.distance.abs() - exact.distance.abs()).abs();
            count += 1;
            worse += usize::from(error > tolerance * diagonal);
        }
        // Cells on the cut locus and on the borders between kinds of feet remain.
        assert!(worse * 50 <= count, "{worse} of {count} beyond {tolerance}, {report:?}");
    }
}

#[test]
fn models_are_those_of_the_shape() {
    let sphere = Sphere::new(Frame::WORLD, 1.0).unwrap().to_nurbs().unwrap();
    let field = SurfaceField::new(&sphere).unwrap();
    let options = D2TreeOptions::default().with_tolerance(1e-4).with_max_depth(6);
    let tree = D2Tree::new(field, &options).unwrap();
    let mut numbers = Numbers::new(23);
    for _ in 0..500 {
        let x = numbers.direction::<3>() * (1.0 + 0.2 * numbers.next());
        let frame = global_frame(&tree, &x);
        check_frame(&frame, &x, 2e-3);
        let exact = ErrorTerm::Taylor.model(&global_frame(tree.field(), &x)).matrix();
        let gap = (ErrorTerm::Taylor.model(&frame).matrix() - exact).norm();
        assert!(gap < 0.06, "{gap} {frame:?}");
        assert!((frame.distance - (x.norm() - 1.0)).abs() < 4e-4);
    }
}

#[test]
fn the_plane_has_a_quadtree() {
    let circle =
        CurveField::new(&Circle::<2>::new(Vector2::new(2.0, 1.0), 1.0).unwrap().to_nurbs().unwrap()).unwrap();
    let tree = D2Tree::new(circle, &D2TreeOptions::default().with_tolerance(1e-5)).unwrap();
    let mut numbers = Numbers::new(3);
    for _ in 0..500 {
        let x = Vector2::new(2.0, 1.0) + numbers.direction::<2>() * (1.0 + 0.3 * numbers.next());
        let frame = global_frame(&tree, &x);
        let exact = 1.0 - (x - Vector2::new(2.0, 1.0)).norm();
        assert!((frame.distance - exact).abs() < 1e-4, "{exact} {frame:?}");
    }
    let report = tree.report();
    assert!(report.depth >= 4 && report.cells == report.leaves + (report.leaves - 1) / 3, "{report:?}");
}

#[test]
fn far_and_invalid_queries_go_to_the_field() {
    let field = SurfaceField::new(&wavy()).unwrap();
    let options = D2TreeOptions::default().with_tolerance(1e-2).with_max_depth(4);
    let tree = D2Tree::new(field.clone(), &options).unwrap();
    let far = Vector3::new(7.0, -3.0, 2.0);
    assert_eq!(global_frame(&tree, &far), global_frame(&field, &far));
    let frame = tree.frame(&Vector3::new(f64::NAN, 0.0, 0.0), Search::Local, &Hint::NONE);
    assert_eq!(frame.status, Status::InvalidPoint);
    let options = D2TreeOptions::default().with_tolerance(f64::NAN);
    assert!(matches!(D2Tree::new(field.clone(), &options), Err(Error::Option { .. })));
    // Nothing left to divide: one cell.
    let tree = D2Tree::new(field, &D2TreeOptions::default().with_max_leaves(1)).unwrap();
    assert_eq!((tree.report().cells, tree.report().open_leaves), (1, 1));
}
