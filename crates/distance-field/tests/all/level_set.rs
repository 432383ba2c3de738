//! Level sets on grids, through the public interface.

#![allow(clippy::unwrap_used, reason = "a set-up that fails must fail the test")]

use distance_field::{
    DistanceField, Error, ErrorTerm, Grid, Hint, LevelSetField, PrincipalFrame, Saddles, Search,
};
use footpoint::Status;
use nalgebra::{Matrix3, Vector2, Vector3};
use proptest::prelude::*;
use std::sync::LazyLock;

fn plane(f: impl Fn(&Vector2<f64>) -> f64, n: usize) -> LevelSetField<2> {
    let h = 4.0 / (n - 1) as f64;
    LevelSetField::<2>::new(&Grid::sample(Vector2::repeat(-2.0), Vector2::repeat(h), [n, n], f).unwrap())
        .unwrap()
}

fn circle(p: &Vector2<f64>) -> f64 {
    // No distance: the gradient grows outwards.
    p.norm_squared() - 1.0
}

fn sphere() -> LevelSetField<3> {
    let f = |p: &Vector3<f64>| (p - Vector3::new(0.1, 0.2, -0.1)).norm_squared() - 1.0;
    let spacing = Vector3::new(0.11, 0.1, 0.12);
    LevelSetField::<3>::new(&Grid::sample(Vector3::repeat(-1.6), spacing, [31, 35, 28], f).unwrap()).unwrap()
}

fn global<const D: usize>(field: &impl DistanceField<D>, x: &nalgebra::SVector<f64, D>) -> PrincipalFrame<D> {
    field.frame(x, Search::Global, &Hint::NONE)
}

static CIRCLE: LazyLock<LevelSetField<2>> = LazyLock::new(|| plane(circle, 41));
static SPHERE: LazyLock<LevelSetField<3>> = LazyLock::new(sphere);

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    #[test]
    fn circles_have_their_distance_and_curvature(x in -3.0..3.0, y in -3.0..3.0) {
        let x = Vector2::new(x, y);
        prop_assume!(x.norm() > 0.05);
        let frame = global(&*CIRCLE, &x);
        prop_assert_eq!(frame.status, Status::Converged);
        prop_assert!((frame.distance - (x.norm() - 1.0)).abs() < 1e-11, "{:?}", frame);
        prop_assert!((frame.curvatures[0] + 1.0).abs() < 1e-10);
        prop_assert!((frame.foot + frame.normal() * frame.distance - x).norm() < 1e-11);
    }

    #[test]
    fn spheres_have_their_distance_and_curvatures(x in -2.0..2.0, y in -2.0..2.0, z in -2.0..2.0) {
        let x = Vector3::new(x, y, z);
        let centre = Vector3::new(0.1, 0.2, -0.1);
        prop_assume!((x - centre).norm() > 0.1);
        let frame = global(&*SPHERE, &x);
        prop_assert_eq!(frame.status, Status::Converged);
        prop_assert!((frame.distance - ((x - centre).norm() - 1.0)).abs() < 1e-11, "{:?}", frame);
        prop_assert!((frame.curvatures - Vector3::new(-1.0, -1.0, 0.0)).norm() < 1e-9);
        prop_assert!((frame.axes.tr_mul(&frame.axes) - Matrix3::identity()).norm() < 1e-12);
    }
}

/// The model of `d²` of a smooth level set is of third order (\[P05, eq. (5)\]).
#[test]
fn taylor_models_are_of_third_order() {
    let wavy = plane(|p| p.y - 0.4 * (1.5 * p.x).sin(), 161);
    let x = Vector2::new(0.3, 0.9);
    let model = ErrorTerm::Taylor.model(&global(&wavy, &x));
    let error = |h: f64| {
        (0..16)
            .map(|k| {
                let (s, c) = f64::from(k).sin_cos();
                let near = x + Vector2::new(c, s) * h;
                (model.value(&near) - wavy.distance(&near).powi(2)).abs()
            })
            .fold(0.0, f64::max)
    };
    let order = (error(0.04) / error(0.02)).log2();
    assert!(order > 2.9, "{order}");
}

#[test]
fn contours_are_traced_in_order() {
    // Two ovals and a branch that leaves the grid, negative inside the ovals and below the branch.
    let f = |p: &Vector2<f64>| {
        let oval = |x: f64| ((p.x - x) / 0.7).powi(2) + (p.y / 0.5).powi(2) - 1.0;
        oval(-0.9).min(oval(0.9)).min(p.y + 1.3)
    };
    let field = plane(f, 81);
    let contours = field.contours();
    assert_eq!(contours.iter().filter(|c| c.is_closed()).count(), 2);
    assert_eq!(contours.len(), 3);
    for contour in contours {
        let vertices = contour.vertices();
        assert!(vertices.windows(2).all(|w| (w[1] - w[0]).norm() < 0.08 && w[0] != w[1]));
        for k in 0..vertices.len() - 1 {
            let along = vertices[k + 1] - vertices[k];
            let left =
                nalgebra::center(&vertices[k], &vertices[k + 1]) + Vector2::new(-along.y, along.x) * 0.3;
            assert!(field.value(&left.coords) < 0.0, "{k}: {left}");
        }
    }
    let open = contours.iter().find(|c| !c.is_closed()).unwrap().vertices();
    assert!((open[0].x.abs() - 2.0).abs() < 1e-12 && (open[open.len() - 1].x.abs() - 2.0).abs() < 1e-12);
}

/// Four corners of a chessboard: which of them are connected is decided by the middle of the cell.
#[test]
fn saddles_keep_their_sides() {
    for middle in [-0.2, 0.2] {
        let field = plane(|p| p.x * p.y - middle, 40);
        let contours = field.contours();
        assert_eq!(contours.len(), 2);
        for contour in contours {
            assert!(contour.vertices().iter().all(|v| (v.x * v.y - middle).abs() < 1e-10));
            let quadrant = contour.vertices()[0].x.signum();
            assert!(contour.vertices().iter().all(|v| v.x.signum() == quadrant), "branches are not mixed up");
        }
    }
}

/// Values without any relation to those of their neighbours: a zero set that bends within a cell.
fn rough(counts: [usize; 2]) -> Grid<2> {
    let value = |k: usize| ((k * 7919 + 13) % 1009) as f64 / 1009.0 - 0.45;
    let values = (0..counts[0] * counts[1]).map(value).collect();
    Grid::new(Vector2::zeros(), Vector2::repeat(1.0), counts, values).unwrap()
}

#[test]
fn feet_are_found_where_the_zero_set_bends_within_a_cell() {
    let grid = rough([16, 14]);
    let field = LevelSetField::<2>::with_detail(&grid, Saddles::Middle, 4).unwrap();
    // The same zero set traced finely, its chords within 1e-3 of it.
    let fine = LevelSetField::<2>::with_detail(&grid, Saddles::Middle, 32).unwrap();
    let points: Vec<Vector2<f64>> = fine.crossings().collect();
    for k in 0..600 {
        let x = Vector2::new(
            1.0 + 13.0 * ((k * 37) % 601) as f64 / 601.0,
            1.0 + 11.0 * ((k * 101) % 599) as f64 / 599.0,
        );
        let least = points.iter().map(|p| (x - p).norm()).fold(f64::INFINITY, f64::min);
        let frame = global(&field, &x);
        let distance = (x - frame.foot).norm();
        assert!(field.value(&frame.foot).abs() < 1e-7, "{x} {frame:?}");
        assert!(distance < least + 0.05, "{x}: {distance} instead of {least}, {:?}", frame.status);
    }
}

#[test]
fn what_enters_and_leaves_through_one_side_of_a_cell_is_traced() {
    let grid = rough([24, 20]);
    let length = |detail: usize| -> f64 {
        let field = LevelSetField::<2>::with_detail(&grid, Saddles::Middle, detail).unwrap();
        field.contours().iter().map(mesh_core::Polyline::length).sum()
    };
    let [coarse, fine, finest] = [1, 8, 32].map(length);
    // Chords of an eighth of a cell are shorter than the arcs by little; chords from side to side leave parts out.
    assert!((fine / finest - 1.0).abs() < 0.01 && coarse < 0.97 * finest, "{coarse} {fine} {finest}");
}

#[test]
fn the_zero_set_ends_at_the_border_of_the_grid() {
    let line = plane(|p| p.y - 0.25 * p.x, 21);
    let frame = global(&line, &Vector2::new(5.0, 0.3));
    assert!(frame.on_boundary && frame.status == Status::OnBoundary, "{frame:?}");
    assert!((frame.foot - Vector2::new(2.0, 0.5)).norm() < 1e-9, "{frame:?}");
    let inside = global(&line, &Vector2::new(0.0, 1.0));
    assert!((inside.distance - 1.0 / 1.0625f64.sqrt()).abs() < 1e-12 && !inside.on_boundary);
}

#[test]
fn bad_input_is_told() {
    let grid = Grid::sample(Vector2::zeros(), Vector2::repeat(1.0), [5, 5], |p| p.x + 1.0).unwrap();
    assert!(matches!(LevelSetField::<2>::new(&grid), Err(Error::NoPoints { count: 25 })));
    let field = plane(circle, 21);
    assert_eq!(global(&field, &Vector2::new(f64::NAN, 0.0)).status, Status::InvalidPoint);
    // The centre of a circle: all feet are as good, none is a failure.
    let frame = global(&field, &Vector2::zeros());
    assert!(frame.is_finite() && (frame.distance + 1.0).abs() < 1e-9, "{frame:?}");
    // A constant piece of the zero set has no normal.
    let flat =
        Grid::sample(Vector2::zeros(), Vector2::repeat(1.0), [9, 9], |p| if p.x < 7.5 { 0.0 } else { -1.0 });
    let field = LevelSetField::<2>::new(&flat.unwrap()).unwrap();
    let frame = global(&field, &Vector2::new(1.0, 4.0));
    assert!(frame.is_finite() || !frame.status.is_converged(), "{frame:?}");
}
