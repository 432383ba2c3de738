//! The coordinates of every fixture against those that readers of others find in it (`fixtures/reference`).

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use crate::common::{fixture, fixtures};
use mesh_core::nalgebra::Point3;
use pc_io::{Content, ReadOptions, read};
use std::collections::BTreeMap;
use std::path::Path;

/// Files of which no other reader tells the coordinates, and the coordinates.
const BY_HAND: &[(&str, &[[f64; 3]])] = &[
    (
        // A number ends where it is none any more: `3.1+e2` is 3.1.
        "formats/obj/assimp/number_formats.obj",
        &[
            [0.0, 0.0, 0.0],
            [1.0, 2.0, 3.0],
            [1.0, 2.0, 3.0],
            [-1.0, -2.0, -3.0],
            [100.0, 20.0, 310.0],
            [100.0, 20.0, 310.0],
            [-100.0, -20.0, -310.0],
            [100.0, 20.0, 3.1],
            [100.0, 20.0, 3.1],
            [-100.0, -20.0, -3.1],
            [0.01, 0.2, 3.1],
            [0.01, 0.2, 3.1],
            [-0.01, -0.2, -3.1],
            [1e10, 20.0, 3.1e10],
            [100.0, 20.0, 310.0],
        ],
    ),
    ("formats/pcd/pcd-rs/columns_keyword.pcd", &[[1.0, 2.0, 3.0]]),
    ("formats/pcd/pcd-rs/missing_count.pcd", &[[1.0, 2.0, 3.0]]),
    ("formats/pcd/pcd-rs/unknown_entries.pcd", &[[1.0, 2.0, 3.0]]),
];

/// Files whose points are good but whose faces are not, so that they are refused.
const BAD_FACES: [&str; 2] = ["formats/malformed/assimp/malformed.obj", "formats/off/assimp/invalid.off"];

/// The points in the order of the file; of STL files the corners of the triangles.
fn points(path: &Path) -> Option<Vec<Point3<f64>>> {
    match read(path, &ReadOptions::default()).ok()?.content {
        Content::Cloud(cloud) => Some(cloud.positions().to_vec()),
        Content::Mesh(mesh) if path.extension().is_some_and(|ext| ext == "stl") => {
            let corner = |&index: &u32| mesh.vertices()[index as usize];
            Some(mesh.triangles().iter().flatten().map(corner).collect())
        }
        Content::Mesh(mesh) => Some(mesh.vertices().to_vec()),
        Content::Nurbs(_) => None,
    }
}

/// A row of the table: the number of points, the sums of the coordinates, of the coordinates times their place in the file,
/// and of their magnitudes.
struct Sums {
    points: usize,
    plain: [f64; 3],
    placed: [f64; 3],
    sizes: [f64; 3],
}

fn reference() -> BTreeMap<String, Sums> {
    let table = std::fs::read_to_string(fixture("reference/coordinates.csv")).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let three = |first: usize| [0, 1, 2].map(|axis| cells[first + axis].parse().unwrap());
        let sums =
            Sums { points: cells[2].parse().unwrap(), plain: three(3), placed: three(6), sizes: three(9) };
        (cells[0].to_owned(), sums)
    };
    table.lines().skip(1).map(row).collect()
}

#[test]
fn every_file_has_the_coordinates_that_other_readers_find() {
    let reference = reference();
    assert!(reference.len() > 100);
    for (name, expected) in &reference {
        let Some(found) = points(&fixture(name)) else {
            assert!(
                expected.points == 0 || BAD_FACES.contains(&name.as_str()),
                "{name} is not read, but holds {} points",
                expected.points
            );
            continue;
        };
        assert_eq!(found.len(), expected.points, "{name}");
        for axis in 0..3 {
            let values: Vec<f64> =
                found.iter().map(|point| if point[axis].is_finite() { point[axis] } else { 0.0 }).collect();
            let plain: f64 = values.iter().sum();
            let placed: f64 = values.iter().zip(1u32..).map(|(value, place)| value * f64::from(place)).sum();
            // Others compute with single precision where the file has no more.
            let tolerance = 1e-7 * expected.sizes[axis];
            assert!((plain - expected.plain[axis]).abs() <= tolerance, "{name}, axis {axis}: {plain}");
            assert!(
                (placed - expected.placed[axis]).abs() <= tolerance * found.len() as f64,
                "{name}, axis {axis}: {placed}"
            );
        }
    }
}

#[test]
fn files_that_others_do_not_read_are_known_by_hand() {
    for (name, expected) in BY_HAND {
        let found = points(&fixture(name)).unwrap();
        assert_eq!(found, expected.iter().map(|&point| point.into()).collect::<Vec<Point3<f64>>>(), "{name}");
    }
    // No file with points is left out.
    let reference = reference();
    for folder in ["formats", "mesh", "scans"] {
        for path in fixtures(folder) {
            let name = path.strip_prefix(fixture("")).unwrap().to_str().unwrap().replace('\\', "/");
            let known = reference.contains_key(&name) || BY_HAND.iter().any(|(known, _)| *known == name);
            let formats = ["ply", "obj", "stl", "off", "pcd"];
            if path.extension().is_some_and(|ext| formats.iter().any(|format| ext == *format)) && !known {
                let count = points(&path).map_or(0, |points| points.len());
                assert_eq!(count, 0, "{name} has no row in fixtures/reference/coordinates.csv");
            }
        }
    }
}
