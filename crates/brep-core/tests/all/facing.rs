//! Feet on faces that agree with a direction.

use crate::shapes::{Builder, cuboid, frame, moved, points};
use brep_core::description::Carrier;
use brep_core::{Model, On, Side};
use footpoint::Facing;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_4;

/// A tube of radii 9 and 10 between z = 0 and z = 6, with its rims.
fn tube() -> Builder {
    let mut b = Builder::default();
    let [il, iu, ol, ou] =
        [(9.0, 0.0), (9.0, 6.0), (10.0, 0.0), (10.0, 6.0)].map(|(radius, z)| b.circle(radius, z, 0.7));
    let cylinder = |radius: f64| Carrier::Cylinder { frame: frame(0.0, 1.0, 0.0), radius };
    b.face(cylinder(10.0), true, &[&[(ol, true)], &[(ou, false)]]);
    b.face(cylinder(9.0), false, &[&[(il, false)], &[(iu, true)]]);
    b.face(Carrier::Plane { frame: frame(6.0, 1.0, 0.0) }, true, &[&[(ou, true)], &[(iu, false)]]);
    b.face(Carrier::Plane { frame: frame(0.0, 1.0, 0.0) }, false, &[&[(ol, false)], &[(il, true)]]);
    b
}

#[test]
fn a_wall_is_measured_from_the_side_that_is_seen() {
    let model = tube().model();
    for x in points(300, 9.8).into_iter().filter(|x| x.xy().norm() > 9.2) {
        let x = Vector3::new(x.x, x.y, 3.0 + 0.25 * x.z);
        let (away, radius) = (Vector3::new(x.x, x.y, 0.0).normalize(), x.xy().norm());
        for (direction, wall, sign) in [(away, 10.0, 1.0), (-away, 9.0, -1.0)] {
            let facing = Facing::new(&direction, FRAC_PI_4).unwrap();
            let foot = model.nearest_facing(&x, &facing).unwrap();
            let expected = sign * (radius - wall);
            assert!((foot.signed_distance().unwrap() - expected).abs() < 1e-12, "{x} {foot:?}");
            assert!(foot.normal.dot(&direction) > 1.0 - 1e-12 && foot.gap() < 1e-12);
            assert!(matches!(foot.on, On::Face { .. }));
        }
        // Upwards only the rim counts, and its edges.
        let foot = model.nearest_facing(&x, &Facing::new(&Vector3::z(), FRAC_PI_4).unwrap()).unwrap();
        let over = (radius - radius.clamp(9.0, 10.0)).hypot(6.0 - x.z);
        assert!((foot.distance - over).abs() < 1e-12 && foot.normal == Vector3::z(), "{x} {foot:?}");
        assert!(foot.side == Side::Negative);
    }
}

#[test]
fn faces_of_a_box_count_up_to_their_edges() {
    let description = cuboid([3.0, 2.0, 1.0]).description(true);
    let mut placed = description.clone();
    placed.instances[0].placement = moved(2.5);
    let (model, moved_model) = (Model::new(&description).unwrap(), Model::new(&placed).unwrap());
    let placement = moved(2.5);
    for (x, towards) in points(500, 4.0).into_iter().zip(points(1000, 1.0).into_iter().skip(500)) {
        let facing = Facing::new(&towards, 0.9).unwrap();
        let mut expected = f64::INFINITY;
        for (i, size) in [3.0, 2.0, 1.0].into_iter().enumerate() {
            for (side, sign) in [(0.0, -1.0), (size, 1.0)] {
                if facing.agrees(&(Vector3::ith(i, sign))) {
                    let mut nearest =
                        Vector3::new(x.x.clamp(0.0, 3.0), x.y.clamp(0.0, 2.0), x.z.clamp(0.0, 1.0));
                    nearest[i] = side;
                    expected = expected.min((x - nearest).norm());
                }
            }
        }
        let found = model.nearest_facing(&x, &facing);
        assert_eq!(found.is_some(), expected.is_finite());
        let turned = Facing::new(&placement.direction(&towards), 0.9).unwrap();
        let again = moved_model.nearest_facing(&placement.point(&x), &turned);
        if let (Some(found), Some(again)) = (found, again) {
            assert!((found.distance - expected).abs() < 1e-12, "{x} {found:?} {expected}");
            assert!(found.lower_bound <= found.distance && found.gap() < 1e-12);
            assert!((again.distance - 2.5 * expected).abs() < 1e-11);
        }
    }
}

#[test]
fn nothing_agrees_or_can() {
    let model = cuboid([1.0; 3]).model();
    let facing = Facing::new(&Vector3::new(1.0, 1.0, 1.0), 0.5).unwrap();
    assert!(model.nearest_facing(&Vector3::new(0.5, 0.5, 2.0), &facing).is_none());
    let up = Facing::new(&Vector3::z(), 0.5).unwrap();
    assert!(model.nearest_facing(&Vector3::new(f64::NAN, 0.0, 0.0), &up).is_none());
    let far = model.nearest_facing(&Vector3::repeat(1e150), &up);
    assert!(far.is_none_or(|foot| foot.distance > 1e150));
}
