//! Distances on grids against closed forms and against the distance of every node for itself.

use distance_field::grid::{Element, Lattice, Medium, Scene, carry, march, seeds, sweep};
use nalgebra::{SVector, Vector2, Vector3};

fn unit<const D: usize>(nodes: usize) -> Lattice<D> {
    Lattice::new(SVector::zeros(), SVector::repeat(1.0), [nodes; D]).unwrap()
}

/// Places in the unit square, evenly spread.
fn place(index: u32) -> Vector2<f64> {
    let share = |step: f64| (f64::from(index) * step + 0.1).fract();
    Vector2::new(share(0.754_877_666_246_693), share(0.569_840_290_998_053))
}

fn largest<const D: usize>(
    lattice: &Lattice<D>,
    values: &[f64],
    right: impl Fn(&SVector<f64, D>) -> f64,
) -> f64 {
    (0..lattice.len()).map(|node| (values[node] - right(&lattice.point(node))).abs()).fold(0.0, f64::max)
}

fn circle() -> Vec<Element<2>> {
    let at = |k: u32| {
        let (y, x) = (std::f64::consts::TAU * f64::from(k) / 4000.0).sin_cos();
        Vector2::new(0.5 + 0.2 * x, 0.5 + 0.2 * y)
    };
    (0..4000).map(|k| Element::Segment([at(k), at(k + 1)])).collect()
}

#[test]
fn sweeping_and_marching_have_their_orders() {
    // Outside of a circle the distance is smooth; inside it has a kink at the centre.
    let mut errors = Vec::new();
    for nodes in [65, 129, 257] {
        let lattice = unit::<2>(nodes);
        let near = seeds(&lattice, &circle(), 4.0 * lattice.spacing()[0]);
        let right = |x: &Vector2<f64>| (x - Vector2::new(0.5, 0.5)).norm() - 0.2;
        let outside = |values: &[f64]| {
            (0..lattice.len())
                .map(|node| (values[node], right(&lattice.point(node))))
                .filter(|(_, right)| *right > 0.0)
                .map(|(value, right)| (value - right).abs())
                .fold(0.0, f64::max)
        };
        let medium = Medium::default();
        let swept = sweep(&lattice, &near, &medium).0;
        let first = march(&lattice, &near, &medium, false);
        assert!(swept.iter().zip(&first).all(|(a, b)| (a - b).abs() < 1e-12));
        errors.push([outside(&first), outside(&march(&lattice, &near, &medium, true))]);
    }
    for (coarse, fine) in errors.iter().zip(&errors[1..]) {
        assert!((0.8..1.3).contains(&(coarse[0] / fine[0]).log2()), "{errors:?}");
        assert!((coarse[1] / fine[1]).log2() > 1.6, "{errors:?}");
    }
    assert!(errors[2][1] < 0.05 * errors[2][0], "{errors:?}");
}

#[test]
fn one_source_is_carried_exactly() {
    let lattice = unit::<3>(25);
    for element in [
        Element::Point(Vector3::new(0.3, 0.61, 0.2)),
        Element::Segment([Vector3::new(0.1, 0.2, 0.9), Vector3::new(0.8, 0.3, 0.1)]),
        Element::Triangle([
            Vector3::new(0.1, 0.2, 0.9),
            Vector3::new(0.8, 0.3, 0.1),
            Vector3::new(0.5, 0.9, 0.6),
        ]),
    ] {
        let near = seeds(&lattice, &[element], lattice.spacing().norm());
        let (values, rounds) = carry(&lattice, &[element], &near);
        assert_eq!(largest(&lattice, &values, |x| element.distance(x)), 0.0);
        assert!(rounds <= 3, "{rounds}");
    }
}

#[test]
fn of_many_sources_hardly_a_node_misses_the_nearest() {
    let sources: Vec<Element<2>> = (0..1000).map(|k| Element::Point(place(k))).collect();
    let lattice = unit::<2>(129);
    let near = seeds(&lattice, &sources, lattice.spacing().norm());
    let (values, _) = carry(&lattice, &sources, &near);
    let right = |x: &Vector2<f64>| sources.iter().map(|e| e.distance(x)).fold(f64::INFINITY, f64::min);
    let wrong = (0..lattice.len()).filter(|&node| values[node] > right(&lattice.point(node)) + 1e-14).count();
    assert!(wrong <= lattice.len() / 1000, "{wrong} of {}", lattice.len());
}

#[test]
fn a_slow_half_takes_longer() {
    let lattice = unit::<2>(65);
    let near = seeds(&lattice, &[Element::Segment([Vector2::zeros(), Vector2::y()])], lattice.spacing()[0]);
    let speed = (0..lattice.len()).map(|node| if lattice.point(node).x > 0.5 { 0.25 } else { 1.0 }).collect();
    let medium = Medium { speed, ..Medium::default() };
    let right = |x: &Vector2<f64>| if x.x > 0.5 { 0.5 + 4.0 * (x.x - 0.5) } else { x.x };
    assert!(largest(&lattice, &sweep(&lattice, &near, &medium).0, right) < 1e-12);
    assert!(largest(&lattice, &march(&lattice, &near, &medium, false), right) < 1e-12);
}

#[test]
fn the_field_of_a_scene_is_the_least_over_all_ways_through_its_corners() {
    // Slanted and round obstacles; the reference tries all corners, with a test of sight of its own, by samples.
    let polygon = |centre: [f64; 2], radius: f64, count: u32, turn: f64| -> Vec<Vector2<f64>> {
        (0..count)
            .map(|k| {
                let (y, x) = (turn + std::f64::consts::TAU * f64::from(k) / f64::from(count)).sin_cos();
                Vector2::new(centre[0] + radius * x, centre[1] + radius * y)
            })
            .collect()
    };
    let obstacles = [
        polygon([0.35, 0.4], 0.15, 3, 0.3),
        polygon([0.7, 0.3], 0.12, 24, 0.1),
        polygon([0.6, 0.75], 0.17, 4, 0.2),
    ];
    let source = Vector2::new(0.1, 0.15);
    let scene = Scene::new(Vector2::zeros(), Vector2::new(1.0, 1.0), source, &obstacles).unwrap();
    let inside = |p: &Vector2<f64>, slack: f64| {
        obstacles.iter().any(|polygon| {
            (0..polygon.len()).all(|k| {
                let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
                (b - a).perp(&(p - a)) > slack * (b - a).norm()
            })
        })
    };
    let sees = |p: &Vector2<f64>, q: &Vector2<f64>| {
        !(1..400).any(|k| inside(&(p + (q - p) * (f64::from(k) / 400.0)), 1e-9))
    };
    let mut points = vec![source];
    points.extend(obstacles.iter().flatten());
    let mut length = vec![f64::INFINITY; points.len()];
    length[0] = 0.0;
    for _ in 0..points.len() {
        for i in 0..points.len() {
            for j in 0..points.len() {
                let through = length[i] + (points[j] - points[i]).norm();
                if through < length[j] && sees(&points[i], &points[j]) {
                    length[j] = through;
                }
            }
        }
    }
    let lattice = unit::<2>(24);
    let values = scene.distances(&lattice);
    for node in 0..lattice.len() {
        let x = lattice.point(node);
        if inside(&x, 0.0) {
            assert_eq!(values[node], -1.0);
            continue;
        }
        let ways = points.iter().zip(&length).filter(|(p, _)| sees(p, &x)).map(|(p, l)| l + (x - p).norm());
        let right = ways.fold(f64::INFINITY, f64::min);
        // Samples may miss a corner that is cut by less than their distance.
        assert!(
            (values[node] - right).abs() < 2e-3 && values[node] >= right - 1e-12,
            "{x}: {} {right}",
            values[node]
        );
    }
}
