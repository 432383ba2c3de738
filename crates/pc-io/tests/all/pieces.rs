//! Text files that are read piece by piece: the points are those of the file in memory, or the file is read as a whole.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::fixture;
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
    let mixed = |i: u32| if i.is_multiple_of(10) { format!("# {i}\n\n{}", xyz(i)) } else { xyz(i) };
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

fn points_of(content: pc_io::Content) -> PointCloud {
    let pc_io::Content::Cloud(cloud) = content else { panic!("no cloud") };
    cloud
}

#[test]
fn samples_are_even_and_always_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scan.ply");
    let positions: Vec<_> = (0..300_000).map(|i| Point3::new(f64::from(i), 1.0, 2.0)).collect();
    let cloud = PointCloud::new(positions);
    let _ = pc_io::write_cloud(&path, &cloud, &pc_io::WriteOptions::default()).unwrap();
    let sample = |most| pc_io::read_sample(&path, &ReadOptions::default(), most).unwrap();
    let loaded = sample(1000).unwrap();
    assert_eq!(loaded.report.points, 300_000);
    let cloud = points_of(loaded.content);
    assert_eq!(cloud.len(), 1000);
    let places: Vec<f64> = cloud.positions().iter().map(|point| point.x).collect();
    assert!(places.windows(2).all(|pair| pair[0] < pair[1]));
    // As many in each tenth, give or take four standard deviations.
    for tenth in 0..10 {
        let low = f64::from(tenth) * 30_000.0;
        let count = places.iter().filter(|place| (low..low + 30_000.0).contains(*place)).count();
        assert!((60..=140).contains(&count), "{tenth}: {count}");
    }
    // A smaller sample is a part of a larger one.
    let smaller = points_of(sample(100).unwrap().content);
    assert!(smaller.positions().iter().all(|point| places.contains(&point.x)));
    // Nothing is left out where all are wanted.
    assert!(sample(300_000).is_none() && sample(usize::MAX).is_none());
}

/// A cloud with everything that a table holds, for a file of several pieces.
fn rich(count: u32) -> PointCloud {
    let positions =
        (0..count).map(|i| Point3::new(f64::from(i) * 0.5, -1.0, if i % 7 == 2 { f64::NAN } else { 2.5 }));
    let mut attributes = mesh_core::Attributes::default();
    attributes
        .set_normals(Some((0..count).map(|i| Vector3::new(0.0, 0.6, 0.8) * f64::from(i % 2)).collect()));
    let colour = |i: u32| [i % 256, i % 3, 255].map(|value| u8::try_from(value).unwrap());
    attributes.set_colours(Some(mesh_core::Colours::Rgb((0..count).map(colour).collect())));
    attributes.push_scalar("intensity", (0..count).map(|i| f64::from(i) * 0.25).collect()).unwrap();
    attributes.push_scalar("late", (0..count).map(|i| if i < 4000 { 0.0 } else { 3.0 }).collect()).unwrap();
    PointCloud::new(positions.collect()).with_attributes(attributes).unwrap()
}

#[test]
fn clouds_in_pieces_have_the_attributes_and_the_bytes_of_the_whole() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let mut names = vec![
        "rich.ply".to_owned(),
        "rich.csv".to_owned(),
        "rich.xyz".to_owned(),
        "rich.las".to_owned(),
        "rich.laz".to_owned(),
        "rich.e57".to_owned(),
    ];
    let mut finite = rich(5000);
    finite.retain_finite();
    for name in names.iter().filter(|name| name.starts_with("rich")) {
        let cloud = if name.contains(".la") { &finite } else { &rich(5000) };
        let _ = pc_io::write_cloud(path(name), cloud, &pc_io::WriteOptions::default()).unwrap();
    }
    for (name, text) in cases() {
        std::fs::write(path(name), text).unwrap();
        names.push(name.to_owned());
    }
    for (name, scans) in [("scans.ptx", &[700, 0, 4000][..]), ("one.ptx", &[900])] {
        std::fs::write(path(name), ptx(scans)).unwrap();
        names.push(name.to_owned());
    }
    for name in ["laspy/simple.las", "laspy/simple1_3.las", "laspy/vegetation_1_3.las", "las-rs/autzen.laz"] {
        names.push(fixture(&format!("formats/las/{name}")).display().to_string());
    }
    for (name, drop) in names.iter().flat_map(|name| [(name, false), (name, true)]) {
        let options = ReadOptions::default().with_drop_non_finite(drop);
        let whole = pc_io::read_cloud(path(name), &options).unwrap();
        for limit in [37, 4096] {
            let mut pieces = Vec::new();
            let report = pc_io::read_cloud_pieces(path(name), &options, limit, |cloud| {
                pieces.push(cloud);
                Ok::<(), pc_io::Error>(())
            });
            let report = report.unwrap().unwrap_or_else(|| panic!("{name}"));
            assert_eq!(report, whole.report, "{name}");
            assert!(pieces.iter().all(|cloud| cloud.len() <= limit));
            for extension in ["ply", "csv", "xyz", "pts"] {
                let (one, many) = (path(&format!("one.{extension}")), path(&format!("many.{extension}")));
                for ascii in [false, true] {
                    let written = pc_io::WriteOptions::default().with_ascii(ascii);
                    let of_one = pc_io::write_cloud(&one, &whole.content, &written).unwrap();
                    let of_many = pc_io::write_cloud_pieces(&many, &written, whole.content.len(), |write| {
                        pieces.iter().try_for_each(write)
                    });
                    let of_many: pc_io::WriteReport = of_many.map_err(|error: pc_io::Error| error).unwrap();
                    assert!(
                        std::fs::read(&one).unwrap() == std::fs::read(&many).unwrap(),
                        "{name} {limit} {extension}"
                    );
                    assert_eq!(
                        (of_one.points, of_one.bytes, of_one.warnings),
                        (of_many.points, of_many.bytes, of_many.warnings)
                    );
                }
            }
        }
    }
    // Scans that carry different things are put together in memory, each by itself is not.
    let scans = fixture("formats/e57/two_scans.e57");
    for (scan, is_in_pieces) in [("0", true), ("1", true), ("all", false)] {
        let options = ReadOptions::default().with_scan(Some(scan.to_owned()));
        let whole = pc_io::read_cloud(&scans, &options).unwrap();
        let mut pieces = Vec::new();
        let report = pc_io::read_cloud_pieces(&scans, &options, 100, |cloud| {
            pieces.push(cloud);
            Ok::<(), pc_io::Error>(())
        });
        assert_eq!(report.unwrap(), is_in_pieces.then(|| whole.report.clone()), "{scan}");
        let count = pieces.iter().map(PointCloud::len).sum::<usize>();
        assert_eq!(count, if is_in_pieces { whole.content.len() } else { 0 });
        if let Some(first) = pieces.first() {
            let names = |cloud: &PointCloud| -> Vec<String> {
                cloud.attributes().scalars().iter().map(|field| field.name.clone()).collect()
            };
            assert_eq!(names(first), names(&whole.content));
            assert_eq!(first.positions(), &whole.content.positions()[..first.len()]);
        }
    }
    // Integers that doubles may not hold are looked at as a whole.
    let wide = fixture("formats/las/laspy/extrabytes.las");
    let none = pc_io::read_cloud_pieces(wide, &ReadOptions::default(), 10, |_| Ok::<(), pc_io::Error>(()));
    assert!(none.unwrap().is_none());
    // An error on the way leaves nothing.
    let failed = pc_io::write_cloud_pieces(path("none.ply"), &pc_io::WriteOptions::default(), 3, |_| {
        Err(pc_io::read_bytes(b"", None, &ReadOptions::default()).unwrap_err())
    });
    assert!(failed.is_err() && !path("none.ply").exists());
    assert!(!pc_io::is_written_in_pieces("a.las", &pc_io::WriteOptions::default()));
}
