//! Text files that are read piece by piece: the points are those of the file in memory, or the file is read as a whole.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mesh_core::PointCloud;
use nalgebra::{Point3, Vector3};
use pc_io::{ReadOptions, ReadReport};
use std::path::Path;

type Points = (Vec<Point3<f64>>, Option<Vec<Vector3<f64>>>);

fn in_memory(path: &Path, options: &ReadOptions) -> (Points, ReadReport) {
    let loaded = pc_io::read_cloud(path, options).unwrap();
    let cloud: PointCloud = loaded.content;
    let normals = cloud.attributes().normals().map(<[_]>::to_vec);
    ((cloud.positions().to_vec(), normals), loaded.report)
}

/// The points in pieces; `None` where the file is not read so.
fn in_pieces(path: &Path, options: &ReadOptions, limit: usize) -> Option<(Points, ReadReport)> {
    let (mut positions, mut normals) = (Vec::new(), None);
    let report = pc_io::read_pieces(path, options, limit, |piece| {
        assert!(!piece.positions.is_empty() && piece.positions.len() <= limit);
        positions.extend(piece.positions);
        if let Some(more) = piece.normals {
            normals.get_or_insert_with(Vec::new).extend(more);
        }
        Ok::<(), pc_io::Error>(())
    });
    report.unwrap().map(|report| ((positions, normals), report))
}

fn bits(points: &Points) -> Vec<u64> {
    let normals = points.1.iter().flatten().flat_map(|normal| normal.iter().map(|value| value.to_bits()));
    points.0.iter().flat_map(|point| point.iter().map(|value| value.to_bits())).chain(normals).collect()
}

/// A table of `count` rows, each by `row`.
fn table(head: &str, count: u32, end: &str, row: impl Fn(u32) -> String) -> String {
    let rows = (0..count).map(|i| row(i) + end);
    std::iter::once(head.to_owned()).chain(rows).collect()
}

fn xyz(i: u32) -> String {
    let s = f64::from(i) * 0.731;
    format!("{} {} {}", s.sin(), s.cos() * 1e5, if i % 71 == 3 { f64::NAN } else { s })
}

fn cases() -> Vec<(&'static str, String)> {
    let comma = |i: u32| xyz(i).replace(' ', ",");
    let normal = |i: u32| format!("{} 0.6 0 -0.8", xyz(i));
    let colour =
        |i: u32| format!("{} {} {} {} {}", xyz(i), -i32::try_from(i % 2048).unwrap(), i % 256, i % 7, 255);
    let mixed = |i: u32| if i % 10 == 0 { format!("# {i}\n\n{}", xyz(i)) } else { xyz(i) };
    vec![
        ("few.xyz", table("", 5, "\n", xyz)),
        ("plain.xyz", table("", 9000, "\n", xyz)),
        ("windows.xyz", table("\u{feff}", 9000, "\r\n", xyz)),
        ("old.xyz", table("", 300, "\r", xyz)),
        ("comments.txt", table("# made for a test\n", 9000, "\n", mixed)),
        ("no_end.xyz", table("", 9000, "\n", xyz).trim_end().to_owned()),
        ("normals.xyz", table("", 30_000, "\n", normal)),
        ("named.csv", table("x,y,z\n", 9000, "\n", comma)),
        ("units.csv", table("z,y,x\nmm,mm,mm\n", 9000, "\n", comma)),
        ("blank_column.csv", table("x,y,z,\n", 9000, ",\n", comma)),
        (
            "empty_cells.csv",
            table("x;y;z\n", 9000, "\n", |i| if i % 9 == 2 { "1;;3".to_owned() } else { "4;5;6".to_owned() }),
        ),
        ("scan.pts", table("9000\n", 9000, "\n", colour)),
        ("wrong_count.pts", table("9001\n", 9000, "\n", colour)),
        ("two.pts", table("9000\n", 9000, "\n", colour) + &table("500\n", 500, "\n", colour)),
    ]
}

/// PTX of scans with so many points.
fn ptx(scans: &[u32]) -> String {
    let scan = |(number, &count): (usize, &u32)| {
        let head =
            format!("{count}\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n{number} 5 6 1\n");
        table(&head, count, "\n", |i| {
            if i % 5 == 4 { "0 0 0 0.5 0 0 0".to_owned() } else { format!("{} 0.25 1 2 3", xyz(i)) }
        })
    };
    scans.iter().enumerate().map(scan).collect()
}

#[test]
fn pieces_of_tables_have_the_bits_of_the_whole() {
    let dir = tempfile::tempdir().unwrap();
    for (name, text) in cases() {
        let path = dir.path().join(name);
        std::fs::write(&path, text).unwrap();
        for drop in [false, true] {
            let options = ReadOptions::default().with_drop_non_finite(drop);
            let (whole, of_whole) = in_memory(&path, &options);
            for limit in [7, 4096, 1 << 20] {
                let (points, report) = in_pieces(&path, &options, limit).expect(name);
                assert_eq!(bits(&points), bits(&whole), "{name} {limit}");
                assert_eq!(points.1.is_some(), whole.1.is_some(), "{name}");
                assert_eq!(report, of_whole, "{name}");
            }
        }
    }
}

#[test]
fn pieces_of_grids_have_the_bits_of_the_whole() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scans.ptx");
    std::fs::write(&path, ptx(&[700, 0, 4000])).unwrap();
    for scan in [None, Some("0"), Some("2"), Some("all")] {
        let options = ReadOptions::default().with_scan(scan.map(str::to_owned));
        let (whole, of_whole) = in_memory(&path, &options);
        for limit in [13, 1 << 20] {
            let (points, report) = in_pieces(&path, &options, limit).unwrap();
            assert_eq!((bits(&points), &report), (bits(&whole), &of_whole), "{scan:?}");
        }
    }
    // What is wrong is said when the file is read as a whole.
    let good = ptx(&[50, 50]);
    for damaged in [
        good.replace("0 0 1 0\n", "0 0 1\n"),
        good[..good.len() - 40].to_owned(),
        good.replacen(" 1 2 3\n", " 1 2 300\n", 1),
    ] {
        std::fs::write(&path, damaged).unwrap();
        assert!(in_pieces(&path, &ReadOptions::default(), 10).is_none());
        assert!(pc_io::read(&path, &ReadOptions::default()).is_err());
    }
    std::fs::write(&path, good).unwrap();
    let missing = ReadOptions::default().with_scan(Some("7".to_owned()));
    assert!(in_pieces(&path, &missing, 10).is_none());
}

#[test]
fn other_texts_are_read_as_a_whole() {
    let dir = tempfile::tempdir().unwrap();
    let utf_16: Vec<u8> = table("", 400, "\n", xyz).encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (name, bytes) in [
        ("names.csv", table("name,x,y,z\n", 400, "\n", |i| format!("P{i},1,2,3")).into_bytes()),
        ("plane.xyz", table("", 400, "\n", |i| format!("{i}.5 2.5")).into_bytes()),
        (
            "late_text.csv",
            table("x,y,z\n", 9000, "\n", |i| if i == 8999 { "a,b,c".to_owned() } else { "1,2,3".to_owned() })
                .into_bytes(),
        ),
        (
            "late_width.xyz",
            table("", 9000, "\n", |i| if i == 8999 { "1 2".to_owned() } else { xyz(i) }).into_bytes(),
        ),
        (
            "late_comma.csv",
            table(
                "x;y;z\n",
                9000,
                "\n",
                |i| if i < 8000 { "1;2;3".to_owned() } else { "1,5;2;3".to_owned() },
            )
            .into_bytes(),
        ),
        ("colours.csv", table("x,y,z,r,g,b\n", 400, "\n", |_| "1,2,3,0.5,0,1".to_owned()).into_bytes()),
        ("utf_16.xyz", utf_16),
        ("empty.xyz", Vec::new()),
        ("part.json", b"{}".to_vec()),
    ] {
        let path = dir.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        assert!(in_pieces(&path, &ReadOptions::default(), 100).is_none(), "{name}");
    }
}

#[test]
fn ranges_are_those_of_the_whole() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.xyz");
    std::fs::write(&path, table("", 1000, "\n", xyz)).unwrap();
    let (whole, _) = in_memory(&path, &ReadOptions::default());
    for range in [0..1000, 0..1, 10..500, 999..1000, 990..2000, 1000..1001] {
        let mut positions = Vec::new();
        let (report, total) = pc_io::read_range(&path, &ReadOptions::default(), range.clone(), 64, |piece| {
            positions.extend(piece.positions);
            Ok::<(), pc_io::Error>(())
        })
        .unwrap()
        .unwrap();
        let (start, end) = (range.start.min(1000) as usize, range.end.min(1000) as usize);
        assert_eq!(bits(&(positions, None)), bits(&(whole.0[start..end].to_vec(), None)), "{range:?}");
        assert_eq!((report.points, total), (end - start, 1000));
    }
}
