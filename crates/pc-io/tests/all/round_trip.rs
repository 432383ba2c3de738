//! What is written comes back bit for bit, and what a format cannot hold is told.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use mesh_core::nalgebra::{Point2, Point3, Vector3};
use mesh_core::{Attributes, Colours, PointCloud, TriangleMesh};
use pc_io::{Content, Format, Model, ReadOptions, Shape, WriteOptions};
use proptest::prelude::*;

/// Doubles of every kind, but one NaN only: texts do not tell them apart.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1e4..1e4f64,
        2 => prop::num::f64::ANY.prop_map(|value| if value.is_nan() { f64::NAN } else { value }),
        1 => (-1000i32..1000).prop_map(f64::from),
        1 => Just(-0.0),
    ]
}

fn attributes(points: usize) -> impl Strategy<Value = Attributes> {
    let normals = prop::option::of(prop::collection::vec(
        [number(), number(), number()].prop_map(Vector3::from),
        points,
    ));
    let rgb = prop::collection::vec(any::<[u8; 3]>(), points).prop_map(Colours::Rgb);
    let rgba = prop::collection::vec(any::<[u8; 4]>(), points).prop_map(Colours::Rgba);
    let colours = prop::option::of(prop_oneof![rgb, rgba]);
    let names = prop::collection::btree_set("[a-zA-Z][a-z_0-9]{2,8}", 0..3);
    let values = prop::collection::vec(prop::collection::vec(number(), points), 3);
    (normals, colours, names, values).prop_map(|(normals, colours, names, values)| {
        let mut attributes = Attributes::default();
        attributes.set_normals(normals);
        attributes.set_colours(colours);
        for (name, values) in names.into_iter().zip(values) {
            if !["red", "green", "blue", "alpha", "rgb", "rgba"].contains(&name.to_lowercase().as_str()) {
                attributes.push_scalar(name, values).unwrap();
            }
        }
        attributes
    })
}

fn cloud(least: usize) -> impl Strategy<Value = PointCloud> {
    (least..20usize, any::<bool>()).prop_flat_map(|(points, planar)| {
        let position = [number(), number(), number()];
        (prop::collection::vec(position, points), attributes(points)).prop_map(
            move |(positions, attributes)| {
                let cloud = if planar {
                    PointCloud::planar(&positions.iter().map(|p| Point2::new(p[0], p[1])).collect::<Vec<_>>())
                } else {
                    PointCloud::new(positions.iter().map(|p| Point3::from(*p)).collect())
                };
                cloud.with_attributes(attributes).unwrap()
            },
        )
    })
}

fn mesh() -> impl Strategy<Value = TriangleMesh> {
    cloud(1)
        .prop_filter("meshes live in space", |cloud| cloud.dimension() == 3)
        .prop_flat_map(|cloud| {
            let index = 0..u32::try_from(cloud.len()).unwrap();
            (Just(cloud), prop::collection::vec([index.clone(), index.clone(), index], 1..20))
        })
        .prop_map(|(cloud, triangles)| TriangleMesh::from_cloud(cloud, triangles).unwrap())
}

/// The bits of everything a cloud holds; all NaN are the same.
fn bits(cloud: &PointCloud) -> Vec<u64> {
    let bit = |value: &f64| if value.is_nan() { u64::MAX } else { value.to_bits() };
    let attributes = cloud.attributes();
    let mut bits = vec![cloud.dimension() as u64];
    bits.extend(cloud.positions().iter().flat_map(|point| point.iter().map(bit).collect::<Vec<_>>()));
    bits.extend(
        attributes
            .normals()
            .into_iter()
            .flatten()
            .flat_map(|normal| normal.iter().map(bit).collect::<Vec<_>>()),
    );
    bits.extend(
        attributes.scalars().iter().flat_map(|field| field.values.iter().map(bit).collect::<Vec<_>>()),
    );
    bits
}

fn assert_same(read: &PointCloud, written: &PointCloud) {
    assert_eq!(bits(read), bits(written));
    assert_eq!(read.attributes().colours(), written.attributes().colours());
    let names = |cloud: &PointCloud| {
        cloud.attributes().scalars().iter().map(|field| field.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(names(read), names(written));
}

/// Writes and reads again; the format must be recognised without the extension.
fn through(content: &Content, format: Format, ascii: bool) -> (Content, Vec<String>) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("file.bin");
    let options = WriteOptions::default().with_format(format).with_ascii(ascii);
    let report = pc_io::write(&path, content, &options).unwrap();
    assert_eq!(report.bytes, std::fs::metadata(&path).unwrap().len());
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "a temporary file is left");
    let loaded = pc_io::read(&path, &ReadOptions::default()).unwrap();
    (loaded.content, report.warnings)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: prop::test_runner::RngSeed::Fixed(10), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn clouds_with_everything(cloud in cloud(0)) {
        for (format, ascii) in [(Format::Ply, false), (Format::Ply, true), (Format::Csv, false), (Format::Pcd, false)] {
            let (content, warnings) = through(&Content::Cloud(cloud.clone()), format, ascii);
            let Content::Cloud(read) = content else { panic!("{format} became {}", content.describe()) };
            assert_same(&read, &cloud);
            prop_assert!(warnings.is_empty(), "{:?}", warnings);
        }
    }

    #[test]
    fn clouds_as_plain_text(cloud in cloud(1)) {
        let (content, warnings) = through(&Content::Cloud(cloud.clone()), Format::Xyz, false);
        let Content::Cloud(read) = content else { panic!("{}", content.describe()) };
        assert_same(&read, &cloud);
        prop_assert!(warnings.is_empty(), "{:?}", warnings);
    }

    #[test]
    fn meshes(mesh in mesh()) {
        for (format, ascii) in [(Format::Ply, false), (Format::Ply, true), (Format::Obj, false), (Format::Off, false)] {
            let (content, warnings) = through(&Content::Mesh(mesh.clone()), format, ascii);
            let Content::Mesh(read) = content else { panic!("{format} became {}", content.describe()) };
            prop_assert_eq!(read.triangles(), mesh.triangles());
            if format == Format::Ply {
                assert_same(read.cloud(), mesh.cloud());
            } else {
                // OBJ and OFF have no scalars, which is told.
                let mut kept = Attributes::default();
                kept.set_normals(mesh.attributes().normals().map(<[_]>::to_vec));
                kept.set_colours(mesh.attributes().colours().cloned());
                let kept = PointCloud::new(mesh.vertices().to_vec()).with_attributes(kept).unwrap();
                assert_same(read.cloud(), &kept);
                prop_assert_eq!(warnings.len(), usize::from(!mesh.attributes().scalars().is_empty()));
            }
        }
    }

    #[test]
    fn stl_keeps_single_precision(values in prop::collection::vec(prop::num::f32::NORMAL, 9)) {
        let corners: Vec<_> = values.chunks_exact(3).map(|v| Point3::new(v[0], v[1], v[2]).map(f64::from)).collect();
        let mesh = TriangleMesh::new(corners.clone(), vec![[0, 1, 2]]).unwrap();
        let (content, warnings) = through(&Content::Mesh(mesh), Format::Stl, false);
        let Content::Mesh(read) = content else { panic!("{}", content.describe()) };
        prop_assert_eq!(read.corners(0).unwrap().to_vec(), corners);
        prop_assert!(warnings.is_empty());
    }

    #[test]
    fn nurbs(points in prop::collection::vec([-1e6..1e6f64, -1e-6..1e-6, -1.0..1.0], 4..9), weight in 0.1..10.0f64) {
        let knots = nurbs_core::KnotVector::uniform_clamped(3, points.len()).unwrap();
        let weights: Vec<_> = (0..points.len()).map(|i| if i % 2 == 0 { 1.0 } else { weight }).collect();
        let space: Vec<_> = points.iter().map(|p| Vector3::from(*p)).collect();
        let curve3 = nurbs_core::BsplineCurve::<3>::new(knots.clone(), space.clone(), Some(weights)).unwrap();
        let plane = space.iter().map(|p| p.xy()).collect();
        let curve2 = nurbs_core::BsplineCurve::<2>::new(knots.clone(), plane, None).unwrap();
        let line = nurbs_core::KnotVector::uniform_clamped(1, 2).unwrap();
        let net = space.iter().flat_map(|p| [*p, p + Vector3::z()]).collect();
        let surface = nurbs_core::BsplineSurface::new(knots, line, net, None).unwrap();
        let mut model = Model::new(vec![Shape::Curve3(curve3)]);
        prop_assert_eq!(through(&Content::Nurbs(model.clone()), Format::Json, false).0, Content::Nurbs(model.clone()));
        model.push(curve2, Some("profile \"A\"\n".to_owned()));
        model.push(surface, None);
        prop_assert_eq!(through(&Content::Nurbs(model.clone()), Format::Json, false).0, Content::Nurbs(model));
    }
}

#[test]
fn pts_keeps_intensity_and_colour_and_tells_the_rest() {
    let cloud = PointCloud::new(vec![Point3::new(0.1, 2.0, 3.0), Point3::new(4.0, 5.0, 1e-9)])
        .with_scalar("intensity", vec![-1035.0, 12.5])
        .and_then(|cloud| cloud.with_colours(Colours::Rgb(vec![[1, 2, 3], [255, 0, 7]])))
        .unwrap();
    let (content, warnings) = through(&Content::Cloud(cloud.clone()), Format::Pts, false);
    assert_eq!((content, warnings.len()), (Content::Cloud(cloud.clone()), 0));
    let more = cloud
        .with_normals(vec![Vector3::x(); 2])
        .and_then(|cloud| cloud.with_scalar("time", vec![0.0; 2]))
        .unwrap();
    let (_, warnings) = through(&Content::Cloud(more), Format::Pts, false);
    assert!(warnings.iter().any(|warning| warning.contains("normals")), "{warnings:?}");
    assert!(warnings.iter().any(|warning| warning.contains("\"time\"")), "{warnings:?}");
}

#[test]
fn awkward_names_are_changed_and_told() {
    let names = ["x", "two words", "two_words", "a,b", "", "1e5", "Red"];
    let cloud =
        names.iter().enumerate().fold(PointCloud::new(vec![Point3::origin()]), |cloud, (index, name)| {
            cloud.with_scalar(*name, vec![index as f64]).unwrap()
        });
    for format in [Format::Ply, Format::Csv, Format::Pcd, Format::Xyz] {
        let (content, warnings) = through(&Content::Cloud(cloud.clone()), format, false);
        let Content::Cloud(read) = content else { panic!("{}", content.describe()) };
        let values: Vec<_> = read.attributes().scalars().iter().map(|field| field.values[0]).collect();
        assert_eq!(values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{format}");
        assert_eq!(warnings.len(), 7, "{format}: {warnings:?}");
    }
}

#[test]
fn what_does_not_fit_is_told_or_refused() {
    let dir = tempfile::tempdir().unwrap();
    let options = WriteOptions::default();
    let mesh = TriangleMesh::new(
        vec![
            Point3::origin(),
            Point3::new(0.1, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
            Point3::new(9.0, 9.0, 9.0),
        ],
        vec![[0, 1, 2]],
    )
    .unwrap();
    let report = pc_io::write_mesh(dir.path().join("a.pcd"), &mesh, &options).unwrap();
    assert_eq!((report.triangles, report.points), (0, 4));
    assert!(report.warnings[0].contains("1 triangle"), "{report}");
    let report = pc_io::write_mesh(dir.path().join("a.stl"), &mesh, &options).unwrap();
    assert!(report.warnings.iter().any(|warning| warning.contains("single precision")), "{report}");
    assert!(report.warnings.iter().any(|warning| warning.contains("1 vert")), "{report}");
    let planar = PointCloud::planar(&[Point2::new(1.0, 2.0)]);
    let report = pc_io::write_cloud(dir.path().join("a.obj"), &planar, &options).unwrap();
    assert!(report.warnings[0].contains("two-dimensional"), "{report}");

    for (name, part) in [
        ("b.stl", "cannot hold points without triangles"),
        ("b.json", "cannot hold"),
        ("b.docx", "extension"),
    ] {
        let error = pc_io::write_cloud(dir.path().join(name), &planar, &options).unwrap_err().to_string();
        assert!(error.contains(part) && error.contains(name), "{error}");
        assert!(!dir.path().join(name).exists());
    }
    let error = pc_io::write_model(dir.path().join("b.ply"), &Model::default(), &options).unwrap_err();
    assert!(error.to_string().contains("NURBS"), "{error}");
}
