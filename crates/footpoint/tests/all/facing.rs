//! Feet where the normal agrees with a direction: against local minima on dense grids, and by hand.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use footpoint::{Facing, ProjectionOptions, Status, SurfaceFootpoint, SurfaceProjector};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Cylinder, Frame, Interval, KnotVector, ParametricSurface, Sphere};

fn find(
    projector: &SurfaceProjector,
    x: Vector3<f64>,
    direction: Vector3<f64>,
    degrees: f64,
) -> SurfaceFootpoint {
    let facing = Facing::new(&direction, degrees.to_radians()).unwrap();
    projector.facing_foot(&x, &projector.project(&x), &facing, &ProjectionOptions::default())
}

/// The sheet `z = height + wave(x, y)` over the unit square, facing up or down.
fn sheet(height: f64, up: bool) -> BsplineSurface {
    let knots = KnotVector::uniform_clamped(3, 8).unwrap();
    let point = |i: usize, j: usize| {
        let wave = 0.06 * ((1.3 * i as f64).sin() + (1.7 * j as f64 + 0.4).cos());
        Vector3::new(i as f64 / 7.0, j as f64 / 7.0, height + wave)
    };
    let net = (0..64).map(|k| if up { point(k / 8, k % 8) } else { point(k % 8, k / 8) }).collect();
    BsplineSurface::new(knots.clone(), knots, net, None).unwrap()
}

const SAMPLES: usize = 300;

/// Points of a grid on a surface, with their normals.
fn grid(surface: &BsplineSurface) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let at = |i: usize| i as f64 / SAMPLES as f64;
    let jets = (0..=SAMPLES).flat_map(|i| (0..=SAMPLES).map(move |j| surface.jet(at(i), at(j))));
    jets.map(|jet| (jet.point, jet.normal_direction().normalize())).collect()
}

/// Distances of the local minima on a grid, with their normals.
fn minima(grid: &[(Vector3<f64>, Vector3<f64>)], x: &Vector3<f64>) -> Vec<(f64, Vector3<f64>)> {
    let distances: Vec<f64> = grid.iter().map(|(point, _)| (point - x).norm()).collect();
    let index = |i: usize, j: usize| i * (SAMPLES + 1) + j;
    let around = |i: usize| i.saturating_sub(1)..=(i + 1).min(SAMPLES);
    let is_least = |&(i, j): &(usize, usize)| {
        around(i).all(|k| around(j).all(|l| distances[index(k, l)] >= distances[index(i, j)]))
    };
    let places = (0..=SAMPLES).flat_map(|i| (0..=SAMPLES).map(move |j| (i, j)));
    places.filter(is_least).map(|(i, j)| (distances[index(i, j)], grid[index(i, j)].1)).collect()
}

#[test]
fn walls_are_measured_on_the_face_that_agrees() {
    let sheets = [sheet(0.0, true), sheet(-0.05, false), sheet(-0.3, true)];
    let projector = SurfaceProjector::for_model(&sheets).unwrap();
    let grids = sheets.each_ref().map(grid);
    let mut moved = 0;
    for k in 0..60 {
        let s = f64::from(k);
        let at = |step: f64| 0.1 + 0.8 * (s * step).fract();
        let x = Vector3::new(at(0.618), at(0.414), 0.5 * (s * 0.732).fract() - 0.45);
        let direction =
            Vector3::new(0.4 * (s * 0.9).sin(), 0.3 * s.cos(), if k % 3 == 0 { -1.0 } else { 1.0 });
        let facing = Facing::new(&direction, 1.0).unwrap();
        let listed = grids.iter().flat_map(|grid| minima(grid, &x));
        let best = listed.filter(|(_, n)| facing.agrees(n)).map(|(d, _)| d).fold(f64::INFINITY, f64::min);
        let found = find(&projector, x, direction, 1f64.to_degrees());
        // Samples are 1/300 apart, so that the nearest one is little farther than the foot.
        assert!((found.distance - best).abs() < 2e-4 + 1e-4 / best, "{k}: {found} {best}");
        assert!(found.status.is_converged(), "{k}: {found}");
        assert!(found.lower_bound <= found.distance && found.gap() <= 1e-6 * found.distance + 1e-9, "{k}");
        let [u, v] = found.parameter;
        assert!(facing.agrees(&sheets[found.shape].jet(u, v).normal_direction()));
        moved += usize::from(found.distance > projector.project(&x).distance + 1e-9);
    }
    assert!(moved > 20, "{moved}");
}

#[test]
fn a_nearest_point_that_agrees_stays_as_it_is() {
    let projector = SurfaceProjector::for_model(&[sheet(0.0, true), sheet(-0.05, false)]).unwrap();
    let x = Vector3::new(0.4, 0.6, 0.3);
    assert_eq!(find(&projector, x, Vector3::z(), 90.0), projector.project(&x));
}

#[test]
fn where_nothing_agrees_there_is_no_foot() {
    let sphere = SurfaceProjector::new(&Sphere::new(Frame::WORLD, 2.0).unwrap().to_nurbs().unwrap());
    for x in [Vector3::new(0.0, 0.0, 3.0), Vector3::new(0.3, -0.2, 0.7)] {
        let found = find(&sphere, x, -x, 60.0);
        assert_eq!(found.status, Status::NoMatchingFoot);
        assert!(found.distance.is_nan());
        assert!((find(&sphere, x, x, 60.0).distance - (x.norm() - 2.0).abs()).abs() < 1e-12);
    }
}

/// All points of a circle are as near to a point of its axis: the one that faces the direction is there.
#[test]
fn on_an_axis_the_direction_chooses() {
    let cylinder = Cylinder::new(Frame::WORLD, 1.5, Interval::new(-2.0, 2.0).unwrap()).unwrap();
    let projector = SurfaceProjector::new(&cylinder.to_nurbs().unwrap());
    for k in 0..12 {
        let (sine, cosine) = (0.1 + f64::from(k)).sin_cos();
        let direction = Vector3::new(cosine, sine, 0.1);
        let found = find(&projector, Vector3::new(0.0, 0.0, 0.25), direction, 10.0);
        assert!((found.distance - 1.5).abs() < 1e-9 && found.status.is_converged(), "{k} {found}");
        let angle = found.point.xy().angle(&direction.xy());
        assert!(angle < 10f64.to_radians(), "{k} {angle}");
    }
    let along = find(&projector, Vector3::new(0.0, 0.0, 0.25), Vector3::z(), 10.0);
    assert_eq!(along.status, Status::NoMatchingFoot);
}

/// A ridge: the nearest point lies on a kink, where the normal of either side will do.
#[test]
fn on_a_kink_any_side_counts() {
    let knots = KnotVector::new(1, vec![0.0, 0.0, 0.5, 1.0, 1.0]).unwrap();
    let line = KnotVector::bezier(1, Interval::UNIT).unwrap();
    let section = [[-1.0, -1.0], [0.0, 0.0], [1.0, -1.0]];
    let net = section.iter().flat_map(|[x, z]| [0.0, 1.0].map(|y| Vector3::new(*x, y, *z))).collect();
    let roof = BsplineSurface::new(knots, line, net, None).unwrap();
    let projector = SurfaceProjector::new(&roof);
    let x = Vector3::new(0.0, 0.5, 0.7);
    for direction in [Vector3::new(1.0, 0.0, 1.0), Vector3::new(-1.0, 0.0, 1.0)] {
        let found = find(&projector, x, direction, 5.0);
        assert_eq!(
            (found.point, found.distance, found.status),
            (Vector3::new(0.0, 0.5, 0.0), 0.7, Status::Converged)
        );
        assert!(found.lower_bound > 0.699);
    }
    assert_eq!(find(&projector, x, Vector3::z(), 5.0).status, Status::NoMatchingFoot);
    // Inside, both slopes have feet.
    let inside = Vector3::new(0.1, 0.5, -0.5);
    let left = find(&projector, inside, Vector3::new(-1.0, 0.0, 1.0), 5.0);
    assert!((left.distance - 0.6 / 2f64.sqrt()).abs() < 1e-12 && left.signed_distance < 0.0, "{left}");
}

/// Two faces of a box meet in an edge, each a surface of its own.
#[test]
fn on_the_edge_of_two_surfaces_both_count() {
    let patch = |corners: [[f64; 3]; 4]| {
        let line = || KnotVector::bezier(1, Interval::UNIT).unwrap();
        BsplineSurface::new(line(), line(), corners.map(Vector3::from).to_vec(), None).unwrap()
    };
    // The top faces up, the side towards x.
    let top = patch([[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [1., 1., 0.]]);
    let side = patch([[1., 0., 0.], [1., 1., 0.], [1., 0., -1.], [1., 1., -1.]]);
    let projector = SurfaceProjector::for_model(&[top, side]).unwrap();
    let x = Vector3::new(1.3, 0.5, 0.4);
    for (direction, shape) in [(Vector3::z(), 0), (Vector3::x(), 1)] {
        let found = find(&projector, x, direction, 30.0);
        assert_eq!(found.shape, shape);
        assert!((found.point - Vector3::new(1.0, 0.5, 0.0)).norm() < 1e-14, "{found}");
        assert!((found.signed_distance - 0.5).abs() < 1e-14 && found.lower_bound > 0.4999);
    }
    // Below the top, beyond its border: its boundary foot counts.
    let below = find(&projector, Vector3::new(1.1, 0.5, -0.3), Vector3::z(), 30.0);
    assert_eq!((below.shape, below.status), (0, Status::OnBoundary));
    assert!((below.signed_distance + 0.1f64.hypot(0.3)).abs() < 1e-12, "{below}");
}
