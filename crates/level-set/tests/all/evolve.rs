//! Level sets that move, against closed forms.

use crate::coverage;
use distance_field::{Grid, LevelSetField};
use level_set::evolve::{
    ChanVeseOptions, Evolution, EvolutionOptions, GeodesicOptions, Motion, chan_vese, geodesic_contour,
    inset_box,
};
use level_set::region::topology;
use level_set::{Error, Image, Inside};
use nalgebra::{SVector, Vector2, Vector3};

fn plane(n: usize, f: impl Fn(&Vector2<f64>) -> f64) -> Grid<2> {
    let h = 4.0 / (n - 1) as f64;
    Grid::sample(Vector2::repeat(-2.0), Vector2::repeat(h), [n, n], f).unwrap()
}

/// Largest distance of the points of a level set from a circle.
fn off_circle(grid: &Grid<2>, centre: Vector2<f64>, radius: f64) -> f64 {
    let field = LevelSetField::<2>::new(grid).unwrap();
    field.crossings().map(|p| ((p - centre).norm() - radius).abs()).fold(0.0, f64::max)
}

#[test]
fn circles_grow_shrink_and_are_carried() {
    let n = 61;
    let start = plane(n, |p| p.norm_squared() - 0.64);
    let options = EvolutionOptions::default();
    let run = |motion: &Motion<'_, 2>, time: f64| {
        let mut evolution = Evolution::new(&start, &options).unwrap();
        evolution.run(motion, time).unwrap();
        evolution.grid().clone()
    };
    let (ones, minus) = (vec![1.0; n * n], vec![-0.5; n * n]);
    let grown = run(&Motion::default().with_propagation(&ones), 0.5);
    assert!(off_circle(&grown, Vector2::zeros(), 1.3) < 2e-4);
    let shrunk = run(&Motion::default().with_propagation(&minus), 0.6);
    assert!(off_circle(&shrunk, Vector2::zeros(), 0.5) < 5e-4);
    // By its curvature: r² falls by twice the time.
    let bent = run(&Motion::default().with_curvature(&ones), 0.14);
    assert!(off_circle(&bent, Vector2::zeros(), (0.64f64 - 0.28).sqrt()) < 4e-3);
    let wind = vec![Vector2::new(0.8, -0.6); n * n];
    let carried = run(&Motion::default().with_flow(&wind), 0.7);
    assert!(off_circle(&carried, Vector2::new(0.56, -0.42), 0.8) < 2e-4);
}

/// A turn of a circle by the velocity field of a rotation, at two spacings.
#[test]
fn flows_are_followed_to_a_high_order() {
    let error = |n: usize| {
        let start = plane(n, |p| (p - Vector2::new(0.7, 0.0)).norm_squared() - 0.36);
        let turn: Vec<Vector2<f64>> =
            (0..n * n).map(|k| start.position(k)).map(|p| Vector2::new(-p.y, p.x)).collect();
        let mut evolution = Evolution::new(&start, &EvolutionOptions::default()).unwrap();
        evolution.run(&Motion::default().with_flow(&turn), std::f64::consts::FRAC_PI_2).unwrap();
        off_circle(evolution.grid(), Vector2::new(0.0, 0.7), 0.6)
    };
    let (coarse, fine) = (error(41), error(81));
    let order = (coarse / fine).log2();
    assert!(order > 2.5 && fine < 1e-4, "{coarse} {fine}: {order}");
}

#[test]
fn spheres_shrink_by_their_mean_curvature() {
    let n = 25;
    let start =
        Grid::sample(Vector3::repeat(-1.44), Vector3::repeat(0.12), [n; 3], |p| p.norm_squared() - 1.0)
            .unwrap();
    let mut evolution = Evolution::new(&start, &EvolutionOptions::default()).unwrap();
    evolution.run(&Motion::default().with_curvature(&vec![1.0; n * n * n]), 0.06).unwrap();
    // r² falls by four times the time.
    let field = LevelSetField::<3>::new(evolution.grid()).unwrap();
    let off = field
        .crossings()
        .map(|p: SVector<f64, 3>| (p.norm() - (1.0f64 - 0.24).sqrt()).abs())
        .fold(0.0, f64::max);
    assert!(off < 8e-3, "{off}");
}

#[test]
fn topology_is_free_or_held() {
    let n = 61;
    let two = |p: &Vector2<f64>| {
        (p - Vector2::new(-0.8, 0.0)).norm().min((p - Vector2::new(0.8, 0.1)).norm()) - 0.5
    };
    let start = plane(n, two);
    let ones = vec![1.0; n * n];
    let grow = |held: bool| {
        let options = EvolutionOptions::default().with_fixed_topology(held);
        let mut evolution = Evolution::new(&start, &options).unwrap();
        evolution.run(&Motion::default().with_propagation(&ones), 0.6).unwrap();
        topology(&[n, n], evolution.grid().values())
    };
    assert_eq!((grow(false).components, grow(false).holes), (1, 0));
    assert_eq!((grow(true).components, grow(true).holes), (2, 0));
}

fn blobs() -> Image {
    let inside = |x: f64, y: f64| (x - 30.0).hypot(y - 32.0) < 14.0 || (x - 66.0).hypot(y - 30.0) < 12.0;
    let noise = |k: usize| ((k * 7919) % 101) as f64 / 101.0 - 0.5;
    let values = coverage(96, 64, 8, inside);
    Image::new(
        96,
        64,
        values.iter().enumerate().map(|(k, share)| 40.0 + 100.0 * share + 60.0 * noise(k)).collect(),
    )
    .unwrap()
}

fn areas(grid: &Grid<2>) -> Vec<f64> {
    let field = LevelSetField::<2>::new(grid).unwrap();
    let mut areas: Vec<f64> = field.contours().iter().map(level_set::signed_area).collect();
    areas.sort_by(|a, b| b.total_cmp(a));
    areas
}

#[test]
fn regions_are_found_in_noise() {
    let image = blobs();
    let values = image.smoothed(1.0).unwrap();
    let start = image.level_function(90.0, Inside::Bright, 1.0).unwrap();
    let found = chan_vese(&values, &start, &ChanVeseOptions::default().with_length_weight(1.0)).unwrap();
    assert!(found.is_settled, "{}", found.speed);
    assert_eq!((found.after.components, found.after.holes), (2, 0));
    let areas = areas(&found.grid);
    let pi = std::f64::consts::PI;
    assert!((areas[0] - 196.0 * pi).abs() < 25.0 && (areas[1] - 144.0 * pi).abs() < 25.0, "{areas:?}");
    // From one circle around both, held to one component, there is one.
    let circle = start
        .with_values(
            (0..96 * 64).map(|k| (start.position(k) - Vector2::new(48.0, 32.0)).norm() - 29.0).collect(),
        )
        .unwrap();
    let held = chan_vese(&values, &circle, &ChanVeseOptions::default().with_fixed_topology(true)).unwrap();
    assert_eq!((held.before.components, held.after.components), (1, 1));
    let free = chan_vese(&values, &circle, &ChanVeseOptions::default().with_length_weight(1.0)).unwrap();
    assert_eq!(free.after.components, 2);
}

#[test]
fn contours_shrink_onto_edges() {
    let image = blobs();
    let values = image.smoothed(1.5).unwrap();
    let start = inset_box(&image, 3.0).unwrap();
    let found = geodesic_contour(&values, &start, &GeodesicOptions::default()).unwrap();
    assert_eq!(found.after.components, 2);
    let areas = areas(&found.grid);
    let pi = std::f64::consts::PI;
    assert!(
        (areas[0] / (196.0 * pi) - 1.0).abs() < 0.12 && (areas[1] / (144.0 * pi) - 1.0).abs() < 0.12,
        "{areas:?}"
    );
}

#[test]
fn even_images_and_odd_options_are_refused() {
    let flat = Image::new(20, 20, vec![1.0; 400]).unwrap();
    let start = inset_box(&flat, 3.0).unwrap();
    let values = flat.grid().unwrap();
    assert!(matches!(
        geodesic_contour(&values, &start, &GeodesicOptions::default()),
        Err(Error::NoContrast { .. })
    ));
    assert!(matches!(chan_vese(&values, &start, &ChanVeseOptions::default()), Err(Error::NoContrast { .. })));
    let bad = ChanVeseOptions::default().with_length_weight(f64::NAN);
    assert!(matches!(chan_vese(&values, &start, &bad), Err(Error::Option { .. })));
    let bad = GeodesicOptions::default().with_balloon(f64::INFINITY);
    assert!(matches!(geodesic_contour(&values, &start, &bad), Err(Error::Option { .. })));
    assert!(inset_box(&flat, 10.0).is_err() && inset_box(&flat, f64::NAN).is_err());
}
