//! Nearest neighbours against brute force.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mesh_core::nalgebra::{Point, Point3, Vector3};
use mesh_core::{CloudIndex, Neighbour};
use proptest::prelude::*;

/// All finite points by (distance, index).
fn brute<const D: usize>(points: &[Point<f64, D>], x: &Point<f64, D>) -> Vec<Neighbour> {
    let mut all: Vec<_> = (points.iter().enumerate())
        .filter(|(_, p)| p.iter().all(|c| c.is_finite()))
        .map(|(index, p)| Neighbour {
            index,
            distance_sq: p.iter().zip(x.iter()).map(|(a, b)| (a - b) * (a - b)).sum(),
        })
        .collect();
    all.sort_by(|a, b| a.distance_sq.total_cmp(&b.distance_sq).then(a.index.cmp(&b.index)));
    all
}

/// Lattice points, so that ties and repetitions abound, free points, and points that are not finite.
fn cloud<const D: usize>() -> impl Strategy<Value = Vec<Point<f64, D>>> {
    let lattice = prop::array::uniform::<_, D>((-3i8..4).prop_map(f64::from));
    let free = prop::array::uniform::<_, D>(-4.0..4.0f64);
    let odd = prop::array::uniform::<_, D>(prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(-0.0)]);
    let point = prop_oneof![6 => lattice, 3 => free, 1 => odd].prop_map(Point::from);
    prop::collection::vec(point, 0..300)
}

fn agrees<const D: usize>(points: &[Point<f64, D>], x: &Point<f64, D>, count: usize, radius: f64) {
    let index = CloudIndex::new(points).unwrap();
    let expected = brute(points, x);
    assert_eq!(index.len(), expected.len());
    assert_eq!(index.skipped(), points.len() - expected.len());
    assert_eq!(index.nearest(x), expected.first().copied());
    for guess in (0..points.len() + 2).step_by(7) {
        assert_eq!(index.nearest_near(x, Some(guess)), expected.first().copied(), "{guess}");
    }
    assert_eq!(index.nearest_n(x, count), expected[..count.min(expected.len())]);
    let within: Vec<_> = expected.iter().filter(|n| n.distance_sq <= radius * radius).copied().collect();
    assert_eq!(index.nearest_within(x, radius), within.first().copied());
    assert_eq!(index.within(x, radius), within);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, rng_seed: prop::test_runner::RngSeed::Fixed(5), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn agrees_with_brute_force_in_space(points in cloud::<3>(), x in prop::array::uniform3(-5.0..5.0f64), lattice in any::<bool>(), count in 0usize..40, radius in 0.0..6.0f64) {
        let x = Point::from(if lattice { x.map(f64::round) } else { x });
        agrees(&points, &x, count, if lattice { radius.round() } else { radius });
    }

    #[test]
    fn agrees_with_brute_force_in_the_plane(points in cloud::<2>(), x in prop::array::uniform2(-5.0..5.0f64), lattice in any::<bool>(), count in 0usize..40, radius in 0.0..6.0f64) {
        let x = Point::from(if lattice { x.map(f64::round) } else { x });
        agrees(&points, &x, count, if lattice { radius.round() } else { radius });
    }
}

#[test]
fn agrees_with_another_tree_on_many_points() {
    // Points of a wavy sheet, and queries near it, far from it, and farther than its size.
    let place = |k: u32| {
        let [u, v] = [0.754_877_666, 0.569_840_291].map(|step: f64| (f64::from(k) * step).fract());
        Point3::new(u, v, 0.1 * (9.0 * u).sin() * (7.0 * v).cos())
    };
    let points: Vec<Point3<f64>> = (0..20_000).map(place).collect();
    let rows: Vec<[f64; 3]> = points.iter().map(|x| x.coords.into()).collect();
    let other = kiddo::ImmutableKdTree::new_from_slice(&rows).unwrap();
    let index = CloudIndex::new(&points).unwrap();
    for k in 0..600 {
        let x = place(100_000 + k) + Vector3::z() * [0.001, 0.3, 40.0][k as usize % 3];
        let found = other.query(&x.coords.into()).nearest_one::<kiddo::SquaredEuclidean<f64>>().execute();
        let nearest = index.nearest(&x).unwrap();
        assert!((nearest.distance_sq - found.distance).abs() <= 1e-14 * found.distance, "{k}");
        assert_eq!(index.nearest_n(&x, 30).len(), 30);
    }
}

#[test]
fn the_order_of_the_cloud_decides_ties() {
    // The centre of a sphere of lattice points is equally far from all of them.
    let ring = [(3.0, 4.0), (4.0, 3.0), (5.0, 0.0), (0.0, 5.0), (-3.0, 4.0), (-5.0, 0.0), (0.0, -5.0)];
    let points: Vec<_> = (0..70).map(|i| Point::from([ring[i % 7].0, ring[i % 7].1])).collect();
    let index = CloudIndex::new(&points).unwrap();
    assert_eq!(index.repeated(), 63);
    let found: Vec<_> = index.nearest_n(&Point::origin(), 20).iter().map(|n| n.index).collect();
    assert_eq!(found, (0..20).collect::<Vec<_>>());
    assert_eq!(index.nearest(&Point::origin()).unwrap().index, 0);
}

#[test]
fn empty_clouds_and_odd_queries_have_no_neighbours() {
    for points in [vec![], vec![Point3::new(f64::NAN, 0.0, 0.0); 5]] {
        let index = CloudIndex::new(&points).unwrap();
        assert!(index.is_empty());
        assert_eq!(index.nearest(&Point3::origin()), None);
        assert_eq!(index.nearest_n(&Point3::origin(), 3), []);
        assert_eq!(index.within(&Point3::origin(), f64::INFINITY), []);
    }
    let index = CloudIndex::new(&[Point3::origin()]).unwrap();
    for x in [f64::NAN, f64::INFINITY, 1e200] {
        let x = Point3::new(x, 0.0, 0.0);
        assert_eq!(index.nearest(&x), None);
        assert_eq!(index.nearest_n(&x, 1), []);
        assert_eq!(index.within(&x, f64::INFINITY), []);
    }
    for radius in [-1.0, f64::NAN] {
        assert_eq!(index.within(&Point3::origin(), radius), []);
    }
    assert_eq!(index.within(&Point3::origin(), f64::INFINITY).len(), 1);
    assert_eq!(index.nearest_n(&Point3::origin(), usize::MAX).len(), 1);
    assert_eq!(index.nearest_n(&Point3::origin(), 0), []);
}

#[test]
fn many_equal_points_take_no_longer() {
    let mut points = vec![Point3::new(1.0, 2.0, 3.0); 100_000];
    points.extend((0..1000).map(|i| Point3::new(5.0, 5.0, f64::from(i))));
    let index = CloudIndex::new(&points).unwrap();
    let found = index.map_nearest_n(&points, 8, |_, near| near.iter().map(|n| n.index).collect::<Vec<_>>());
    assert!(found[..100_000].iter().all(|near| *near == [0, 1, 2, 3, 4, 5, 6, 7]));
    assert_eq!(found[100_500][..3], [100_500, 100_499, 100_501]);
}

#[test]
fn batches_equal_single_queries_far_from_the_origin() {
    let shift = Vector3::new(4.5e6, 5.2e6, 300.0);
    let points: Vec<_> = (0..3000)
        .map(f64::from)
        .map(|i| Point3::new((i * 0.618).fract(), (i * 0.755).fract(), (i * 0.123).fract()) + shift)
        .collect();
    let index = CloudIndex::new(&points).unwrap();
    let queries: Vec<_> = points.iter().map(|p| p + Vector3::new(0.01, 0.0, -0.02)).collect();
    let batch = index.nearest_many(&queries);
    let lists = index.map_nearest_n(&queries, 5, |_, near| near.to_vec());
    for (i, x) in queries.iter().enumerate() {
        assert_eq!(batch[i], index.nearest(x));
        assert_eq!(lists[i], index.nearest_n(x, 5));
        if i % 100 == 0 {
            assert_eq!(lists[i], brute(&points, x)[..5]);
        }
    }
}
