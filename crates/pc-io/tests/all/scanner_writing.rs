//! Clouds written as LAS, LAZ and E57 and read again, as a whole and piece by piece.

#![allow(clippy::unwrap_used, clippy::panic, clippy::cast_possible_truncation, reason = "tests may panic")]

use std::path::Path;

use crate::common::fixture;
use crate::scanners::{SCANS, cloud};
use pc_io::mesh_core::nalgebra::{Point3, Vector3};
use pc_io::mesh_core::{Colours, PointCloud};
use pc_io::{Format, ReadOptions, WriteOptions, read_bytes, read_cloud};

/// Writes a cloud and reads it again.
fn there_and_back(cloud: &PointCloud, name: &str) -> (PointCloud, Vec<String>, Vec<u8>) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    let written = pc_io::write_cloud(&path, cloud, &WriteOptions::default()).unwrap();
    let read = read_cloud(&path, &ReadOptions::default()).unwrap();
    assert_eq!(read.report.format, Format::from_path(Path::new(name)).unwrap());
    (read.content, written.warnings, std::fs::read(&path).unwrap())
}

#[test]
fn las_and_laz_come_back_bit_for_bit() {
    for name in [
        "las/laspy/simple.las",
        "las/laspy/extra.laz",
        "las/las-rs/autzen.copc.laz",
        "las/las-rs/32-1-472-150-76.laz",
    ] {
        let before = cloud(name).content;
        for target in ["a.las", "a.laz"] {
            let (after, warnings, bytes) = there_and_back(&before, target);
            assert!(warnings.is_empty(), "{name} {target}: {warnings:?}");
            assert_eq!(after.positions(), before.positions(), "{name} {target}");
            assert_eq!(after.attributes().colours(), before.attributes().colours(), "{name} {target}");
            assert_eq!(
                after.attributes().scalars().len(),
                before.attributes().scalars().len(),
                "{name} {target}"
            );
            for field in before.attributes().scalars() {
                assert_eq!(
                    after.attributes().scalar(&field.name),
                    Some(field.values.as_slice()),
                    "{name} {target}"
                );
            }
            // The same points make the same bytes.
            assert_eq!(there_and_back(&before, target).2, bytes);
        }
    }
}

/// A cloud with coordinates far out that are no multiples of anything.
fn odd_cloud() -> PointCloud {
    let positions: Vec<Point3<f64>> = (0..2000u32)
        .map(|index| {
            let t = f64::from(index) * 0.37;
            Point3::new(500_000.0 + t.sin(), 4_500_000.0 + t.cos(), t.sqrt())
        })
        .collect();
    let normals =
        positions.iter().map(|point| (point.coords - Vector3::new(500_000.0, 4_500_000.0, 0.0)).normalize());
    let deviation = positions.iter().map(|point| point.z.ln()).collect();
    PointCloud::new(positions.clone())
        .with_normals(normals.collect())
        .and_then(|cloud| {
            cloud.with_colours(Colours::Rgb((0..2000u32).map(|i| [(i % 251) as u8, 7, 255]).collect()))
        })
        .and_then(|cloud| cloud.with_scalar("deviation from model", deviation))
        .and_then(|cloud| cloud.with_scalar("intensity", (0..2000u32).map(|i| f64::from(i) / 7.0).collect()))
        .and_then(|cloud| {
            cloud.with_scalar("return_number", (0..2000u32).map(|i| f64::from(i % 3)).collect())
        })
        .and_then(|cloud| cloud.with_scalar("number_of_returns", vec![3.0; 2000]))
        .unwrap()
}

#[test]
fn e57_keeps_doubles_and_las_says_what_it_rounds() {
    let before = odd_cloud();
    let (after, _, bytes) = there_and_back(&before, "a.e57");
    assert_eq!(after.positions(), before.positions());
    assert_eq!(after.attributes().normals(), before.attributes().normals());
    assert_eq!(after.attributes().colours(), before.attributes().colours());
    assert_eq!(
        after.attributes().scalar("deviation_from_model"),
        before.attributes().scalar("deviation from model")
    );
    for name in ["intensity", "return_number", "number_of_returns"] {
        assert_eq!(after.attributes().scalar(name), before.attributes().scalar(name), "{name}");
    }
    assert_eq!(there_and_back(&before, "a.e57").2, bytes);

    let (after, warnings, _) = there_and_back(&before, "a.laz");
    let told = warnings.iter().any(|warning| warning.contains("rounded by up to"));
    assert!(told, "{warnings:?}");
    for (after, before) in after.positions().iter().zip(before.positions()) {
        // Steps of 1e-9 for a size of 2, and the digits of doubles at 4.5 million.
        assert!((after - before).amax() <= 1e-8, "{after} {before}");
    }
    assert_eq!(after.attributes().normals(), before.attributes().normals());
    assert_eq!(
        after.attributes().scalar("deviation_from_model"),
        before.attributes().scalar("deviation from model")
    );
    // Other programs cannot tell extra bytes from a field of the same name.
    assert_eq!(after.attributes().scalar("extra_intensity"), before.attributes().scalar("intensity"));
    assert!(warnings.iter().any(|warning| warning.contains("extra_intensity")), "{warnings:?}");
}

#[test]
fn points_that_are_not_finite_are_told() {
    let cloud = PointCloud::new(vec![Point3::new(1.0, 2.0, 3.0), Point3::new(f64::NAN, 0.0, 0.0)]);
    for name in ["a.las", "a.e57"] {
        let (after, warnings, _) = there_and_back(&cloud, name);
        assert_eq!(after.positions(), &cloud.positions()[..1], "{name}");
        assert!(warnings.iter().any(|warning| warning.contains("not finite")), "{name}: {warnings:?}");
    }
    for name in ["a.las", "a.laz", "a.e57"] {
        let (after, ..) = there_and_back(&PointCloud::new(Vec::new()), name);
        assert!(after.is_empty(), "{name}");
    }
}

#[test]
fn pieces_have_the_bits_of_the_whole() {
    let dir = tempfile::tempdir().unwrap();
    let odd = odd_cloud();
    let mut files: Vec<_> = [
        SCANS,
        "formats/las/laspy/simple.laz",
        "formats/las/las-rs/autzen.copc.laz",
        "formats/las/laspy/simple1_3.las",
    ]
    .map(fixture)
    .to_vec();
    for name in ["odd.las", "odd.laz", "odd.e57", "odd.ply"] {
        let path = dir.path().join(name);
        let _ = pc_io::write_cloud(&path, &odd, &WriteOptions::default()).unwrap();
        files.push(path);
    }
    for path in files {
        let whole = read_cloud(&path, &ReadOptions::default()).unwrap();
        for limit in [7, 100, 1_000_000] {
            let (mut positions, mut normals) = (Vec::new(), Vec::new());
            let report = pc_io::read_pieces(&path, &ReadOptions::default(), limit, |piece| {
                assert!(piece.positions.len() <= limit);
                positions.extend(piece.positions);
                normals.extend(piece.normals.into_iter().flatten());
                Ok::<(), pc_io::Error>(())
            });
            let report = report.unwrap().unwrap_or_else(|| panic!("{} is read in pieces", path.display()));
            assert_eq!(positions, whole.content.positions(), "{}", path.display());
            assert_eq!(
                normals,
                whole.content.attributes().normals().unwrap_or_default(),
                "{}",
                path.display()
            );
            assert_eq!(
                (report.format, report.points, report.scans),
                (whole.report.format, whole.report.points, whole.report.scans.clone())
            );
        }
    }
    // An error of the taker ends the reading and comes back.
    let mut calls = 0;
    let ended = pc_io::read_pieces(fixture(SCANS), &ReadOptions::default(), 10, |_| {
        calls += 1;
        Err(read_bytes(b"", None, &ReadOptions::default()).unwrap_err())
    });
    assert!(ended.unwrap_err().to_string().contains("empty") && calls == 1);
    // What has to be read as a whole is left alone.
    let mesh = fixture("mesh/bunny_99.stl");
    let none = pc_io::read_pieces(mesh, &ReadOptions::default(), 10, |_| Ok::<(), pc_io::Error>(())).unwrap();
    assert!(none.is_none());
}
