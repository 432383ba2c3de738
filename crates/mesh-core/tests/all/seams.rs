//! Open edges that are one edge but for rounding, and those that are not.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "a test may panic, and rounds on purpose"
)]

use mesh_core::{MeshProjector, TriangleMesh};
use nalgebra::Point3;
use proptest::prelude::*;

type Corners = [[f64; 3]; 3];

/// A prism over a polygon (counter-clockwise in x y), its base and top fanned, as triangles of their own.
fn prism(outline: &[[f64; 2]], height: f64) -> Vec<Corners> {
    let n = outline.len();
    let at = |i: usize, z: f64| [outline[i % n][0], outline[i % n][1], z];
    let mut triangles = Vec::new();
    for i in 1..n - 1 {
        triangles.push([at(0, 0.0), at(i + 1, 0.0), at(i, 0.0)]);
        triangles.push([at(0, height), at(i, height), at(i + 1, height)]);
    }
    for i in 0..n {
        triangles.push([at(i, 0.0), at(i + 1, 0.0), at(i + 1, height)]);
        triangles.push([at(i, 0.0), at(i + 1, height), at(i, height)]);
    }
    triangles
}

const RECTANGLE: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]];

fn soup(triangles: &[Corners]) -> TriangleMesh {
    let vertices = triangles.iter().flatten().map(|&corner| Point3::from(corner)).collect();
    let indices = (0u32..).take(triangles.len()).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(vertices, indices).unwrap()
}

/// Changes every number on its own.
fn changed(triangles: &[Corners], mut change: impl FnMut(f64) -> f64) -> TriangleMesh {
    let mut changed = triangles.to_vec();
    changed.iter_mut().flatten().flatten().for_each(|value| *value = change(*value));
    soup(&changed)
}

/// Signed distances are those of the exact mesh, and both are solids.
fn assert_like(exact: &TriangleMesh, mesh: &TriangleMesh, tolerance: f64) {
    let topology = mesh.welded_topology();
    assert!(topology.is_solid(), "{topology}");
    let (exact, mesh) = (MeshProjector::new(exact).unwrap(), MeshProjector::new(mesh).unwrap());
    for i in 0..500 {
        let at = |k: usize| f64::from(u32::try_from(i * k % 97).unwrap()) / 97.0 * 6.0 - 1.0;
        let x = Point3::new(at(13), at(31), at(59));
        let [one, other] = [&exact, &mesh].map(|mesh| mesh.project(&x).unwrap().signed_distance.unwrap());
        assert!((one - other).abs() <= tolerance, "{one} {other} at {x}");
    }
}

#[test]
fn residues_beside_zero_leave_no_slit() {
    let acute = [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0 * 20f64.to_radians().tan()]];
    let knife = [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0 * 0.5f64.to_radians().tan()]];
    for (outline, residue) in [
        (RECTANGLE.as_slice(), -2.5e-16),
        (&acute, 3.1e-16),
        (&knife, 3.1e-16),
        // What the sine of 180 degrees leaves in single precision.
        (&RECTANGLE, f64::from(4.0f32 * -8.742_278e-8f32)),
    ] {
        let as_single = |value: f64| f64::from(value as f32);
        let triangles: Vec<Corners> =
            prism(outline, 2.0).iter().map(|corners| corners.map(|corner| corner.map(as_single))).collect();
        let exact = soup(&triangles);
        let mut turn = 0;
        let mesh = changed(&triangles, |value| {
            turn += 1;
            if value == 0.0 && turn % 7 < 3 { as_single(residue) } else { value }
        });
        assert!(exact.welded_topology().is_solid());
        let weld = mesh.weld();
        assert!(weld.joined > 0 && weld.largest_gap == as_single(residue).abs(), "{weld:?}");
        assert_like(&exact, &mesh, 1e-6);
        let (welded, _) = mesh.welded();
        assert_eq!(welded.vertices().len(), 2 * outline.len());
        assert!(welded.topology().is_solid());
        assert!((welded.signed_volume() / exact.signed_volume() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn last_digits_of_a_text_leave_no_slit() {
    let outline: Vec<[f64; 2]> = (0..17)
        .map(|i| f64::from(i) / 17.0 * std::f64::consts::TAU)
        .map(|t| [3.0 + 2.0 * t.cos(), 2.5 + 2.0 * t.sin()])
        .collect();
    let exact = prism(&outline, 7.0 / 3.0);
    let as_text = |decimals: usize, scientific: bool| {
        let mut turn = 0;
        changed(&exact, move |value| {
            turn += 1;
            let value = value * (1.0 + 1e-13 * f64::from(turn % 3));
            if scientific {
                format!("{value:.decimals$e}").parse().unwrap()
            } else {
                // Some programs cut digits off instead of rounding.
                let unit = 10f64.powi(i32::try_from(decimals).unwrap());
                let whole = if turn % 2 == 0 { (value * unit).floor() } else { (value * unit).round() };
                format!("{:.decimals$}", whole / unit).parse().unwrap()
            }
        })
    };
    for (mesh, unit) in [(as_text(6, false), 2e-6), (as_text(6, true), 2e-6), (as_text(5, true), 2e-5)] {
        assert_like(&soup(&exact), &mesh, unit);
    }
}

#[test]
fn what_is_apart_stays_apart() {
    // Two plates that face each other, a hair apart, in singles and in doubles: four open sides each.
    for (gap, far) in [(f64::from(f32::EPSILON) * 4.0, 4.0), (3e-9, 0.0), (1e-6, 0.0), (1e-4, 0.0)] {
        let mut plates = Vec::new();
        for (z, order) in [(far, [0, 2, 1]), (far + gap, [0, 1, 2])] {
            let at = |i: usize| [RECTANGLE[i][0], RECTANGLE[i][1], z];
            for corners in [[at(0), at(1), at(2)], [at(0), at(2), at(3)]] {
                plates.push(order.map(|corner| corners[corner]));
            }
        }
        let mesh = soup(&plates);
        assert_eq!((mesh.weld().joined, mesh.welded_topology().boundary_edges), (0, 8), "{gap}");
    }
    // A closed sheet as thin as rounding, and a closed speck: nothing is open, nothing is joined.
    for size in [[4.0, 3.0, 4e-9], [1e-9, 1e-9, 1e-9]] {
        let outline = RECTANGLE.map(|[x, y]| [x / 4.0 * size[0], y / 3.0 * size[1]]);
        let mut triangles = prism(&outline, size[2]);
        let far = prism(&RECTANGLE.map(|[x, y]| [x + 100.0, y]), 2.0);
        triangles.extend(far);
        let mesh = soup(&triangles);
        assert_eq!(mesh.weld().joined, 0);
        assert_eq!(mesh.welded().0.vertices().len(), 16);
    }
    // A slit that is wider than rounding, in a box with one side moved out.
    let mut open = prism(&RECTANGLE, 2.0);
    open.iter_mut()
        .filter(|corners| corners.iter().all(|corner| corner[2] == 2.0))
        .flatten()
        .for_each(|corner| corner[2] += 1e-6);
    let topology = soup(&open).welded_topology();
    assert_eq!((topology.is_closed(), topology.boundary_edges), (false, 8));
    // The same with a small triangle whose side is within rounding: it must not vanish.
    let tiny = [[0.0, 0.0], [4.0, 0.0], [4.0, 1e-12], [4.0, 3.0], [0.0, 3.0]];
    let triangles = prism(&tiny, 2.0);
    let mesh = changed(&triangles, |value| if value == 0.0 { -1e-16 } else { value });
    let topology = mesh.welded_topology();
    assert_eq!((topology.degenerate_triangles, topology.triangles), (0, triangles.len()));
}

#[test]
fn strange_coordinates_end_in_an_answer() {
    for value in [f64::NAN, f64::INFINITY, 1e300, f64::MAX, 1e-300, -0.0] {
        let mut triangles = prism(&RECTANGLE, 2.0);
        triangles[3][1][2] = value;
        triangles.pop();
        let weld = soup(&triangles).weld();
        assert!(weld.first.iter().zip(0u32..).all(|(&first, vertex)| first <= vertex));
        let all = changed(&triangles, |old| old * value);
        assert_eq!(all.weld().first.len(), 3 * triangles.len());
    }
    assert_eq!(soup(&[]).weld().joined, 0);
    assert_eq!(soup(&[]).area().to_bits(), 0);
}

proptest! {
    #[test]
    fn a_closed_prism_is_closed_after_rounding_noise(
        sides in 3usize..12, height in 0.1f64..10.0, noise in prop::collection::vec(-1.0f64..1.0, 300),
    ) {
        let outline: Vec<[f64; 2]> = (0..sides)
            .map(|i| (i as f64) / (sides as f64) * std::f64::consts::TAU)
            .map(|t| [2.0 * t.cos(), 2.0 * t.sin()])
            .collect();
        let mut turn = 0;
        let mesh = changed(&prism(&outline, height), |value| {
            turn += 1;
            value + 4e-16 * noise[turn % noise.len()]
        });
        prop_assert!(mesh.welded_topology().is_solid());
        // The order of the triangles does not decide what is one corner.
        let corners: Vec<[u32; 3]> = mesh.triangles().iter().rev().copied().collect();
        let turned = TriangleMesh::new(mesh.vertices().to_vec(), corners).unwrap();
        prop_assert_eq!(turned.weld().joined, mesh.weld().joined);
    }
}
