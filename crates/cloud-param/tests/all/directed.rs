//! Directed projection: poles, bounds, units.

use crate::common;
use cloud_param::{DirectedOptions, DirectedWeight, Neighbourhood, project_directed};
use nalgebra::Vector3;
use proptest::prelude::*;

const WEIGHTS: [DirectedWeight; 3] = [DirectedWeight::Near, DirectedWeight::Axis, DirectedWeight::NearAxis];

fn wave() -> Vec<Vector3<f64>> {
    (0..4000)
        .map(common::scattered)
        .map(|[a, b]| Vector3::new(10.0 * a, 10.0 * b, (3.0 * a).sin() + b * b))
        .collect()
}

#[test]
fn poles_are_harmless() {
    let points = wave();
    let cloud = Neighbourhood::new(&points).unwrap();
    for weight in WEIGHTS {
        let options = DirectedOptions::default().with_weight(weight);
        // At a point of the cloud, and on a ray that meets one exactly.
        for place in [points[17], points[17] + Vector3::z() * 0.3, points[17] - Vector3::z() * 1e-9] {
            let foot = project_directed(&cloud, &place, &Vector3::z(), &options).unwrap().unwrap();
            assert!(foot.point.iter().all(|c| c.is_finite()));
            if weight == DirectedWeight::NearAxis {
                assert!((foot.point - points[17]).norm() < 0.05, "{weight:?} {foot:?}");
            }
        }
        assert_eq!(project_directed(&cloud, &points[0], &Vector3::zeros(), &options).unwrap(), None);
        assert!(project_directed(&cloud, &points[0], &Vector3::z(), &options.with_neighbours(0)).is_err());
        assert!(
            project_directed(&cloud, &points[0], &Vector3::z(), &options.with_regularisation(0.0)).is_err()
        );
    }
}

#[test]
fn the_bound_holds_against_the_full_sum() {
    let points = wave();
    let cloud = Neighbourhood::new(&points).unwrap();
    for weight in WEIGHTS {
        for [a, b] in (0..50).map(common::scattered) {
            let place = Vector3::new(2.0 + 6.0 * a, 2.0 + 6.0 * b, 1.0);
            let direction = Vector3::new(a - 0.5, 0.2, 1.0);
            let near =
                project_directed(&cloud, &place, &direction, &DirectedOptions::default().with_weight(weight))
                    .unwrap()
                    .unwrap();
            let all = DirectedOptions::default().with_weight(weight).with_neighbours(points.len());
            let full = project_directed(&cloud, &place, &direction, &all).unwrap().unwrap();
            assert_eq!(full.bound, 0.0);
            assert!((near.offset - full.offset).abs() <= near.bound, "{weight:?}: {near:?} {full:?}");
            if weight == DirectedWeight::NearAxis {
                assert!((near.offset - full.offset).abs() < 0.02);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn unit_and_place_do_not_matter(scale in 0.001..1000.0f64, shift in -1e4..1e4f64, which in 0usize..3) {
        let points = wave();
        let options = DirectedOptions::default().with_weight(WEIGHTS[which]);
        let (place, n) = (Vector3::new(4.0, 5.0, 2.0), Vector3::new(0.1, 0.0, 1.0));
        let foot = project_directed(&Neighbourhood::new(&points).unwrap(), &place, &n, &options).unwrap().unwrap();
        let move_to = |p: &Vector3<f64>| p * scale + Vector3::repeat(shift * scale);
        let moved: Vec<_> = points.iter().map(move_to).collect();
        let again = project_directed(&Neighbourhood::new(&moved).unwrap(), &move_to(&place), &n, &options).unwrap().unwrap();
        prop_assert!((again.offset / scale - foot.offset).abs() < 1e-7);
    }
}
