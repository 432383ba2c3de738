//! What pictures show.

#![allow(clippy::unwrap_used, reason = "a set-up that fails must fail the test")]

use mesh_core::TriangleMesh;
use nalgebra::Point3;
use picture::{Curve, FieldScene, Line, MeshScene, Paint, Raster, Sheet, View};

const FROM_ABOVE: View = View { turn: 0.0, height: std::f64::consts::FRAC_PI_2 };
const RED: [f32; 3] = [1.0, 0.0, 0.0];

/// Two squares in the planes z = 0 and, smaller, z = 1.
fn squares() -> TriangleMesh {
    let square = |side: f64, z: f64| [[0.0, 0.0, z], [side, 0.0, z], [side, side, z], [0.0, side, z]];
    let corners = square(2.0, 0.0).into_iter().chain(square(1.0, 1.0)).map(Point3::from).collect();
    TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]).unwrap()
}

fn at(raster: &Raster, x: f64, y: f64) -> [u8; 3] {
    let place = |share: f64, count: usize| {
        let far = |k: &usize| (*k as f64 / count as f64 - share).abs();
        (0..count).min_by(|a, b| far(a).total_cmp(&far(b)))
    };
    let k = place(y, raster.height).unwrap() * raster.width + place(x, raster.width).unwrap();
    raster.colours[3 * k..3 * k + 3].try_into().unwrap()
}

#[test]
fn what_is_nearer_hides_what_is_behind() {
    let mesh = squares();
    let labels = [0, 0, 0, 0, 1, 1, 1, 1];
    let scene = MeshScene { view: FROM_ABOVE, ..MeshScene::new(&mesh, Paint::Labels(&labels)) };
    let drawn = scene.draw(200);
    let (upper, lower) = (at(&drawn, 0.25, 0.75), at(&drawn, 0.75, 0.25));
    assert_ne!(upper, lower);
    // Both have even colours, and the room around is white.
    assert_eq!(upper, at(&drawn, 0.4, 0.6));
    assert_eq!(lower, at(&drawn, 0.3, 0.3));
    assert_eq!(at(&drawn, 0.0, 0.0), [255; 3]);
}

#[test]
fn curves_behind_a_surface_are_hidden() {
    let mesh = squares();
    let line = |z: f64| Curve {
        points: vec![Point3::new(0.1, 0.5, z), Point3::new(1.9, 0.5, z)],
        colour: RED,
        width: 6.0,
    };
    let mut scene = MeshScene { view: FROM_ABOVE, ..MeshScene::new(&mesh, Paint::Plain([0.5; 3])) };
    scene.curves = vec![line(0.0)];
    let drawn = scene.draw(200);
    assert_eq!(at(&drawn, 0.75, 0.735), [255, 0, 0], "before the lower square");
    assert_ne!(at(&drawn, 0.25, 0.735), [255, 0, 0], "behind the upper square");
}

#[test]
fn isolines_lie_where_the_values_say() {
    let mesh = squares();
    let values = [0.0, 2.0, 2.0, 0.0, f64::NAN, f64::NAN, f64::NAN, f64::NAN];
    let paint = Paint::Values { values: &values, range: [0.0, 2.0], lines: 2 };
    let drawn = MeshScene { view: FROM_ABOVE, ..MeshScene::new(&mesh, paint) }.draw(400);
    let light = |x: f64| at(&drawn, x, 0.2).iter().map(|c| u32::from(*c)).sum::<u32>();
    assert!(light(0.5) + 60 < light(0.47) && light(0.5) + 60 < light(0.53), "{} {}", light(0.5), light(0.47));
}

#[test]
fn fields_are_drawn_upright() {
    let values: Vec<f64> = (0..30).map(|k| f64::from(k % 5) / 4.0).collect();
    let hole = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let scene = FieldScene {
        counts: [6, 5],
        bounds: [[0.0, 0.0], [5.0, 4.0]],
        values: &values,
        range: [0.0, 1.0],
        lines: 0,
        filled: &[hole],
        curves: vec![Line { points: vec![[2.0, 2.0], [4.0, 2.0]], colour: RED, width: 5.0 }],
        points: vec![([4.5, 3.5], [0.0, 0.0, 1.0], 4.0)],
    };
    let drawn = scene.draw(250);
    assert_eq!([drawn.width, drawn.height], [250, 200]);
    let (low, high) = (at(&drawn, 0.5, 0.97), at(&drawn, 0.5, 0.03));
    assert!(low[1] < 60 && high[0] > 200, "dark below, yellow above: {low:?} {high:?}");
    assert_eq!(at(&drawn, 0.1, 0.9), [92, 97, 105]);
    assert_eq!(at(&drawn, 0.6, 0.5), [255, 0, 0]);
    assert_eq!(at(&drawn, 0.9, 0.125), [0, 0, 255]);
}

#[test]
fn the_same_scene_has_the_same_bytes() {
    let mesh = squares();
    let draw = || {
        Sheet::new().with("a", MeshScene::new(&mesh, Paint::Plain([0.4; 3])).draw(120)).with_bar([0.0, 5.0])
    };
    assert_eq!(draw().to_png(), draw().to_png());
    assert_eq!(draw().to_svg(), draw().to_svg());
}
