//! Descriptions that say things that cannot be.

use crate::shapes::{Builder, cuboid, disc, frame};
use brep_core::description::{Carrier, EdgeCurve, LoopDescription, ModelDescription};
use brep_core::{Error, Model};
use nalgebra::Vector3;

#[test]
fn an_empty_description_is_an_error() {
    assert_eq!(Model::new(&ModelDescription::default()).unwrap_err(), Error::Empty);
}

#[test]
fn indices_of_nothing_are_errors() {
    let mut description = cuboid([1.0; 3]).description(true);
    description.instances[0].part = 7;
    assert!(matches!(Model::new(&description), Err(Error::Description { .. })));

    let mut description = cuboid([1.0; 3]).description(true);
    description.parts[0].shells[0].faces.push(99);
    assert!(matches!(Model::new(&description), Err(Error::Description { .. })));
}

#[test]
fn a_face_with_a_bad_edge_is_left_out_and_named() {
    for value in [f64::NAN, f64::INFINITY, 1e300] {
        let mut description = cuboid([1.0; 3]).description(true);
        let direction = Vector3::new(value, 0.0, 0.0);
        description.parts[0].edges[0].curve = EdgeCurve::Line { origin: Vector3::zeros(), direction };
        let model = Model::new(&description).unwrap();
        // Whatever became of the damaged edge, the answer is one or none, never a panic.
        let _ = model.nearest(&Vector3::new(0.1, 0.2, 2.0));
        if !value.is_finite() {
            assert_eq!(model.unread().len(), 3, "the edge and its two faces");
            assert!(!model.parts()[0].shells()[0].is_closed());
        }
    }
    let mut description = cuboid([1.0; 3]).description(true);
    let LoopDescription::Edges(uses) = &mut description.parts[0].faces[2].loops[0] else {
        panic!("a loop of edges")
    };
    uses[1].edge = 1234;
    let model = Model::new(&description).unwrap();
    assert_eq!(model.unread().len(), 1);
    assert_eq!(model.unread()[0].source, 3);
}

#[test]
fn surfaces_without_end_need_a_boundary() {
    let mut description = cuboid([1.0; 3]).description(true);
    description.parts[0].faces[0].loops.clear();
    let model = Model::new(&description).unwrap();
    assert_eq!(model.unread().len(), 1);
    let Carrier::Plane { frame } = description.parts[0].faces[1].carrier.clone() else { panic!("a plane") };
    description.parts[0].faces[1].carrier = Carrier::Cylinder { frame, radius: -1.0 };
    assert_eq!(Model::new(&description).unwrap().unread().len(), 2);
}

#[test]
fn points_that_are_not_finite_have_no_foot() {
    let model = cuboid([1.0; 3]).model();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(model.nearest(&Vector3::new(0.0, value, 0.0)).is_none());
    }
    assert!(model.nearest(&Vector3::new(1e150, 0.0, 0.0)).is_some());
}

#[test]
fn a_cylinder_needs_two_ends() {
    let mut b = Builder::default();
    let low = b.circle(1.0, 0.0, 0.0);
    b.face(Carrier::Cylinder { frame: frame(0.0, 1.0, 0.0), radius: 1.0 }, true, &[&[(low, true)]]);
    disc(&mut b, low, 0.0, -1.0);
    let model = Model::new(&b.description(true)).unwrap();
    assert_eq!((model.parts()[0].faces().len(), model.unread().len()), (1, 1));
    assert!(!model.parts()[0].shells()[0].is_closed());
}
