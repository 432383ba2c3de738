//! Crossings of lines with faces, against closed forms.

use crate::shapes::Builder;
use brep_core::Model;
use brep_core::description::{
    Carrier, FaceDescription, InstanceDescription, ModelDescription, PartDescription, Placement,
    ShellDescription,
};
use footpoint::Facing;
use nalgebra::{Matrix3, Vector3};
use nurbs_core::{AnalyticSurface, Frame, Torus};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

fn whole(carrier: Carrier, placement: Placement) -> Model {
    let face =
        FaceDescription { name: String::new(), source: 1, carrier, same_sense: true, loops: Vec::new() };
    let shell = ShellDescription { faces: vec![0], closed: true, ..ShellDescription::default() };
    let part = PartDescription { faces: vec![face], shells: vec![shell], ..PartDescription::default() };
    let instance = InstanceDescription { part: 0, name: String::new(), placement };
    let model =
        ModelDescription { parts: vec![part], instances: vec![instance], ..ModelDescription::default() };
    Model::new(&model).unwrap()
}

fn offset(model: &Model, x: [f64; 3], d: [f64; 3]) -> Option<f64> {
    let found = model.nearest_on_line(&Vector3::from(x), &Vector3::from(d), f64::INFINITY, None).unwrap();
    let nearest = found.nearest?;
    assert_eq!(found.free, nearest.offset.abs());
    Some(nearest.offset)
}

#[test]
fn spheres_and_tori_are_met_where_they_are() {
    let ball = whole(Carrier::Sphere { frame: Frame::WORLD, radius: 2.0 }, Placement::IDENTITY);
    assert!((offset(&ball, [0.5, 0.0, 0.0], [3.0, 0.0, 0.0]).unwrap() - 1.5).abs() < 1e-14);
    assert!((offset(&ball, [9.0, 0.0, 0.0], [1.0, 0.0, 0.0]).unwrap() + 7.0).abs() < 1e-13);
    assert_eq!(offset(&ball, [9.0, 2.1, 0.0], [1.0, 0.0, 0.0]), None);
    // In its place: twice as large, and moved.
    let placement =
        Placement { translation: Vector3::new(10.0, 0.0, 0.0), scale: 2.0, ..Placement::IDENTITY };
    let moved = whole(Carrier::Sphere { frame: Frame::WORLD, radius: 2.0 }, placement);
    assert!((offset(&moved, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]).unwrap() - 6.0).abs() < 1e-12);

    let torus = Carrier::Torus { frame: Frame::WORLD, major_radius: 5.0, minor_radius: 1.0 };
    let ring = whole(torus, Placement::IDENTITY);
    let spline = AnalyticSurface::from(Torus::new(Frame::WORLD, 5.0, 1.0).unwrap()).to_nurbs().unwrap();
    let same = whole(Carrier::Nurbs(Arc::new(spline)), Placement::IDENTITY);
    for model in [&ring, &same] {
        assert!((offset(model, [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]).unwrap() - 3.5).abs() < 1e-12);
        assert!(
            (offset(model, [5.1, 0.0, 0.0], [0.0, 0.0, 1.0]).unwrap().abs() - 0.99_f64.sqrt()).abs() < 1e-12
        );
        assert_eq!(offset(model, [0.0, 0.0, 7.0], [0.0, 0.0, 1.0]), None);
        assert_eq!(offset(model, [-20.0, 0.0, 1.01], [1.0, 0.0, 0.0]), None);
        // Across both sides of the tube, at an angle.
        let s = FRAC_PI_4.sin();
        let found = offset(model, [5.0 - 3.0 * s, 0.0, 3.0 * s], [s, 0.0, -s]).unwrap();
        assert!((found - 2.0).abs() < 1e-12, "{found}");
    }
}

#[test]
fn only_the_piece_inside_of_the_loops_is_met() {
    // A cylinder of radius 2 between two heights.
    let mut shape = Builder::default();
    let (low, high) = (shape.circle(2.0, 0.0, 0.3), shape.circle(2.0, 1.0, 1.0));
    let carrier = Carrier::Cylinder { frame: Frame::WORLD, radius: 2.0 };
    shape.face(carrier, true, &[&[(low, true)], &[(high, false)]]);
    let model = Model::new(&shape.description(false)).unwrap();
    assert!((offset(&model, [0.0, 0.5, 0.5], [0.0, 1.0, 0.0]).unwrap() - 1.5).abs() < 1e-13);
    assert_eq!(offset(&model, [0.0, 0.5, 1.5], [0.0, 1.0, 0.0]), None);
    // A line along a generator lies in the cylinder or beside it.
    assert_eq!(offset(&model, [2.0, 0.0, 9.0], [0.0, 0.0, 1.0]), None);
    // Through the edge: met, and said so.
    let edge = model.nearest_on_line(&Vector3::new(0.0, 0.5, 1.0), &Vector3::y(), 9.0, None).unwrap();
    assert!(edge.nearest.is_some_and(|hit| hit.is_at_edge && (hit.offset - 1.5).abs() < 1e-12), "{edge:?}");
    // Only the far wall has a normal that agrees.
    let facing = Facing::new(&-Vector3::y(), 1.0).unwrap();
    let far = model.nearest_on_line(&Vector3::new(0.0, 0.5, 0.5), &Vector3::y(), 9.0, Some(&facing)).unwrap();
    assert!(far.nearest.is_some_and(|hit| (hit.offset + 2.5).abs() < 1e-13), "{far:?}");
    assert!((far.refused - 1.5).abs() < 1e-13, "{far:?}");
    // Nothing within reach.
    let near = model.nearest_on_line(&Vector3::new(0.0, 0.5, 0.5), &Vector3::y(), 1.0, None).unwrap();
    assert!(near.nearest.is_none() && near.free == f64::INFINITY);
}

#[test]
fn what_is_not_finite_is_refused() {
    let placement = Placement { rotation: -Matrix3::identity(), ..Placement::IDENTITY };
    let ball = whole(Carrier::Sphere { frame: Frame::WORLD, radius: 2.0 }, placement);
    assert!((offset(&ball, [0.0; 3], [0.0, 1e-300, 0.0]).unwrap().abs() - 2.0).abs() < 1e-14);
    for (x, d) in [([f64::NAN; 3], [1.0; 3]), ([0.0; 3], [0.0; 3]), ([0.0; 3], [f64::INFINITY, 0.0, 0.0])] {
        assert!(ball.nearest_on_line(&Vector3::from(x), &Vector3::from(d), 1.0, None).is_none());
    }
    let far = offset(&ball, [1e300, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert!(far.is_none_or(|far| far.is_finite()));
}
