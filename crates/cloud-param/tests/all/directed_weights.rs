//! Directed projection against its formulas, evaluated here for every point of a cloud: the weights as printed in
//! [MPK, eqs. (15), (16), (19)], the foot of eqs. (12)-(13), and the bound on what points that were not asked can change.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use cloud_param::{DirectedFoot, DirectedOptions, DirectedWeight, Neighbourhood, project_directed};
use nalgebra::Vector3;

const WEIGHTS: [DirectedWeight; 3] = [DirectedWeight::Near, DirectedWeight::Axis, DirectedWeight::NearAxis];

/// A bent grid whose points have their nearest neighbours at a distance of exactly 1, along straight lines.
fn gutter() -> Vec<Vector3<f64>> {
    let point = |i: u8| {
        let (row, column) = (f64::from(i / 15), f64::from(i % 15) - 7.0);
        Vector3::new(2.0 * column, row, 0.1 * column * column)
    };
    (0..225).map(point).collect()
}

/// The weights as the paper prints them, `n` of length 1; `ε` takes the place of distances that are smaller.
fn printed(weight: DirectedWeight, p: &Vector3<f64>, point: &Vector3<f64>, n: &Vector3<f64>, e: f64) -> f64 {
    let distance = ((p - point).norm_squared() + e * e).sqrt();
    let across = (point - p).cross(n).norm();
    match weight {
        DirectedWeight::Near => 1.0 / distance.powi(4),
        DirectedWeight::Axis => 1.0 / (1.0 + (p - point).norm().powi(2) * across.powi(2)),
        DirectedWeight::NearAxis => 1.0 / (distance.powi(4) * (across.powi(2) + e * e)),
    }
}

/// Eqs. (8), (12), (13) over the `count` nearest points: `t`, and the sum of the weights.
fn by_hand(
    points: &[Vector3<f64>],
    place: &Vector3<f64>,
    n: &Vector3<f64>,
    options: &DirectedOptions,
) -> (f64, f64) {
    let mut points = points.to_vec();
    points.sort_by(|a, b| (a - place).norm().total_cmp(&(b - place).norm()));
    points.truncate(options.neighbours);
    let a = |point: &Vector3<f64>| printed(options.weight, place, point, n, options.regularisation);
    let c0: f64 = points.iter().map(a).sum();
    let c: Vector3<f64> = points.iter().map(|point| point * a(point)).sum();
    (c.dot(n) / c0 - place.dot(n), c0)
}

fn foot(
    points: &[Vector3<f64>],
    place: &Vector3<f64>,
    n: &Vector3<f64>,
    options: &DirectedOptions,
) -> DirectedFoot {
    let cloud = Neighbourhood::new(points).unwrap();
    project_directed(&cloud, place, n, options).unwrap().unwrap()
}

/// Places that have no two points at the same distance.
fn places() -> Vec<(Vector3<f64>, Vector3<f64>)> {
    (0..12u8)
        .map(|i| {
            let i = f64::from(i);
            let place = Vector3::new(1.3137 * i - 7.1313, 3.1 + 0.7351 * i, 0.4113 * i - 1.0171);
            (place, Vector3::new(0.2 * i.sin(), 0.3 * i.cos(), 1.0).normalize())
        })
        .collect()
}

#[test]
fn weights_are_those_of_the_printed_equations() {
    let points = gutter();
    assert_eq!(Neighbourhood::new(&points).unwrap().spacing().to_bits(), 1.0f64.to_bits());
    for weight in WEIGHTS {
        for regularisation in [1e-9, 0.1, 0.7] {
            for neighbours in [1, 3, 20, 225] {
                let options = DirectedOptions::default()
                    .with_weight(weight)
                    .with_neighbours(neighbours)
                    .with_regularisation(regularisation);
                for (place, n) in places() {
                    let (t, _) = by_hand(&points, &place, &n, &options);
                    // The length of the direction makes no difference, nor does the unit.
                    let found = foot(&points, &place, &(n * 3.0), &options);
                    assert!((found.offset - t).abs() < 1e-11, "{options:?}: {} {t}", found.offset);
                    assert!((found.point - place - n * found.offset).norm() < 1e-13);
                    let inches: Vec<_> = points.iter().map(|p| p / 25.4).collect();
                    let inch = foot(&inches, &(place / 25.4), &n, &options);
                    assert!((inch.offset * 25.4 - t).abs() < 1e-11, "{options:?}: {} {t}", inch.offset);
                }
            }
        }
    }
}

#[test]
fn the_bound_is_what_the_other_points_can_weigh_and_it_holds() {
    let points = gutter();
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let radius = points.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
    for weight in WEIGHTS {
        for neighbours in [4, 12, 60, 224, 225, 1000] {
            let options = DirectedOptions::default().with_weight(weight).with_neighbours(neighbours);
            for (place, n) in places() {
                let (t, total) = by_hand(&points, &place, &n, &options);
                let mut distances: Vec<f64> = points.iter().map(|p| (p - place).norm()).collect();
                distances.sort_by(f64::total_cmp);
                let others = points.len().saturating_sub(neighbours) as f64;
                let farthest = distances[neighbours.min(points.len()) - 1];
                // The heaviest that a point out there can be: as far as the last neighbour, on the line.
                let heaviest = printed(weight, &place, &(place + n * farthest), &n, options.regularisation);
                let reach =
                    if weight == DirectedWeight::Axis { (place - middle).norm() + radius } else { farthest };
                let expected = others * heaviest * (reach + t.abs()) / total;
                let found = foot(&points, &place, &n, &options);
                assert!((found.bound - expected).abs() <= 1e-9 * expected, "{} {expected}", found.bound);
                assert_eq!(found.bound == 0.0, neighbours >= points.len());
                let full = by_hand(&points, &place, &n, &options.with_neighbours(points.len())).0;
                assert!(
                    (full - t).abs() <= expected + 1e-12,
                    "{weight:?} {neighbours}: {full} {t} {expected}"
                );
                // A length, in the unit of the cloud.
                let microns: Vec<_> = points.iter().map(|p| p * 1e3).collect();
                let micron = foot(&microns, &(place * 1e3), &n, &options);
                assert!((micron.bound - 1e3 * expected).abs() <= 1e-3 * expected, "{}", micron.bound);
            }
        }
    }
}

#[test]
fn without_any_weight_the_place_stays_and_nothing_is_promised() {
    let points = gutter();
    let stays = |place: Vector3<f64>, options: &DirectedOptions| {
        let found = foot(&points, &place, &Vector3::z(), options);
        assert_eq!((found.point, found.offset, found.bound), (place, 0.0, f64::INFINITY), "{options:?}");
    };
    for weight in WEIGHTS {
        // So far away that every weight is 0.
        stays(Vector3::new(0.0, 1e160, 0.0), &DirectedOptions::default().with_weight(weight));
    }
    for weight in [DirectedWeight::Near, DirectedWeight::NearAxis] {
        // At a point of the cloud, with a regularisation whose square is 0: one weight is infinite.
        let options = DirectedOptions::default().with_weight(weight).with_regularisation(1e-200);
        stays(points[17], &options);
    }
}
