//! Recognising formats and columns, messages, and files on disk.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::io::Write;

use crate::common::fixture;
use mesh_core::{Colours, PointCloud};
use pc_io::{AtomicFile, Content, Format, Loaded, ReadOptions, read_bytes};

fn load(text: &str) -> Loaded<PointCloud> {
    let loaded = read_bytes(text.as_bytes(), None, &ReadOptions::default())
        .unwrap_or_else(|error| panic!("{error}: {text}"));
    let Content::Cloud(content) = loaded.content else { panic!("{}", loaded.report) };
    Loaded { content, report: loaded.report }
}

fn message(text: &str) -> String {
    read_bytes(text.as_bytes(), None, &ReadOptions::default())
        .map(|loaded| loaded.report.to_string())
        .unwrap_err()
        .to_string()
}

#[test]
fn rows_of_numbers_are_points_whatever_the_extension() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("queries.q");
    for (text, dimension) in
        [("1 2\n3 4\n", 2), ("1 2 3\n4 5 6", 3), ("-1.5,2e-3\r\n3,4\r\n", 2), ("1;2;3\n", 3)]
    {
        std::fs::write(&path, text).unwrap();
        let loaded = pc_io::read_cloud(&path, &ReadOptions::default()).unwrap();
        assert_eq!(loaded.content.dimension(), dimension, "{text}");
        assert!(loaded.report.warnings.is_empty(), "{}", loaded.report);
    }
}

#[test]
fn columns_without_names_are_guessed_and_told() {
    let names = |text: &str| load(text).report.warnings.first().cloned().unwrap_or_default();
    assert!(names("0 0 0 17\n1 1 1 300\n").ends_with("x y z intensity"));
    assert!(names("0 0 0 0 0 1\n1 1 1 0.6 0.8 0\n").ends_with("x y z nx ny nz"));
    assert!(names("0 0 0 10 20 30\n1 1 1 0 255 0\n").ends_with("x y z r g b"));
    assert!(names("0 0 0 -40 10 20 30\n1 1 1 5 0 255 0\n").ends_with("x y z intensity r g b"));
    assert!(names("0 0 0 10 20 30 255\n1 1 1 0 255 0 255\n").ends_with("x y z r g b a"));
    assert!(names("0 0 0 10 20 30 0 1 0\n1 1 1 0 255 0 1 0 0\n").ends_with("x y z r g b nx ny nz"));
    assert!(names("0 0 0 1.5 2.5\n").ends_with("x y z column_4 column_5"));
    assert_eq!(load("2\n0 0 0 7 1 2 3\n1 1 1 9 4 5 6\n").report.format, Format::Pts);
}

#[test]
fn headers_name_columns() {
    let loaded = load("\"X\";\"Y [mm]\";Z;Intensity;Red;Green;Blue\n1;2;3;0.5;255;0;7\n");
    assert_eq!(loaded.content.attributes().colours(), Some(&Colours::Rgb(vec![[255, 0, 7]])));
    assert_eq!(loaded.content.attributes().scalar("Intensity"), Some([0.5].as_slice()));
    assert!(loaded.report.warnings.is_empty(), "{}", loaded.report);
    assert_eq!(
        load("//X Y Z Nx Ny Nz\n1 2 3 0 0 5\n").content.attributes().normals().map(<[_]>::len),
        Some(1)
    );
    assert_eq!(load("# made by hand\n# x y t\n1 2 3\n").content.dimension(), 2);
    assert_eq!(load("x\ty\tz\n1\t2\t3\n").content.len(), 1);
    assert_eq!(load("x,y,z\n").content.len(), 0);
}

#[test]
fn columns_of_text_are_kept_apart_from_numbers() {
    let loaded = load("x,y,z,status,u\n1,2,3,converged,0.5\n4,5,6,on_boundary,\n7,8,9,7,0.25\n");
    assert_eq!(loaded.content.len(), 3);
    assert_eq!(loaded.content.attributes().scalars().len(), 1);
    assert_eq!(loaded.content.attributes().scalar("u").map(|u| (u[0], u[2])), Some((0.5, 0.25)));
    assert_eq!(loaded.report.warnings, ["read as NaN: 1 empty field"]);
    let status = &loaded.content.attributes().texts()[0];
    assert_eq!((status.name(), status.get(0), status.get(2)), ("status", Some("converged"), Some("7")));
    // Without names a separator at the end closes the last field.
    assert_eq!(load("1,2,3,\n4,5,6,\n").content.attributes().scalars().len(), 0);
    assert!(message("x,y,z,n,m\n1,2,3,4,5\n1,2,3,\n").starts_with("line 3: "));
    assert_eq!(load("x y label\n1 2 hole-7\n3 4 hole-8\n").content.dimension(), 2);
    // A coordinate is never text, and a column of numbers does not become one.
    assert!(message("x,y,z,n\n1,2,three,4\n").contains("\"three\" is not a number"));
    assert!(message("x,y,z,n\n1,2,3,4\n1,2,3,four\n").starts_with("line 3: \"four\" is not a number"));
}

#[test]
fn errors_say_where_what_and_what_to_do() {
    for (text, parts) in [
        ("1 2 3\n4 5 six\n", ["line 2:", "\"six\" is not a number", "correct"]),
        ("1 2 3\n4 5\n", ["line 2:", "has 2 columns where 3 are expected", "correct"]),
        ("1,5 2,5 3,5\n", ["line 1:", "decimal commas", "replace"]),
        ("x;y;z\n1,5;2.5;3,5\n", ["line 2:", "its meaning is open", "same decimal sign"]),
        ("x,y,x\n1,2,3\n", ["input:", "several columns are named x", "each once"]),
        ("name,size\n1,2\n", ["line 1:", "neither numbers nor names", "x,y,z"]),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", ["line 4:", "vertex 7, but there are 3", "correct"]),
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ["line 6:", "not a face over 3 vertices", "export"]),
        ("solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", ["line 4:", "vertex X Y Z", "export"]),
        (
            "ply\nformat ascii 2.0\nelement vertex x\nend_header\n",
            ["line 3:", "element NAME COUNT", "header"],
        ),
        (
            "{\"kind\":\"curve\",\n\"degree\":1,\"knots\":[0,0,1,true],\"control_points\":[[0,0],[1,1]]}",
            ["line 2:", "knots", "bool"],
        ),
        (
            "{\"kind\":\"curve\",\"degree\":1,\"knots\":[0,0,1,0],\"control_points\":[[0,0],[1,1]]}",
            ["line 1:", "knot 3", "correct"],
        ),
        (
            "{\"kind\":\"curve\",\"degree\":-1,\"knots\":[0,0,1,1],\"control_points\":[[0,0],[1,1]]}",
            ["line 1: degree: ", "expected an integer that is not negative", "correct"],
        ),
        (
            "{\"kind\":\"model\",\n\"shapes\":[\n[1,2]]}",
            ["line 3: shape 0: ", "an object with the field \"kind\" is expected", "correct"],
        ),
        ("{\"kind\":\"sphere\"}", ["line 1:", "\"sphere\"", "surface"]),
        ("{\"shapes\":[]}", ["line 1:", "kind", "correct"]),
        ("LASF\0\0\0\0", ["input:", "LAS", "export"]),
        ("\x01\x02\x03", ["input:", "recognised", "PLY"]),
    ] {
        let message = message(text);
        for part in parts {
            assert!(message.contains(part), "{message:?} lacks {part:?}");
        }
    }
}

#[test]
fn a_model_keeps_names_and_leaves_out_what_it_does_not_know() {
    let model =
        pc_io::read_model(fixture("formats/json/model.json"), &ReadOptions::default()).unwrap().content;
    assert_eq!(
        (0..4).map(|index| model.name(index)).collect::<Vec<_>>(),
        [Some("profile"), None, None, Some("saddle")]
    );
    assert!(matches!(model.shapes()[1], pc_io::Shape::Curve3(_)));
    let pc_io::Shape::Curve2(closed) = &model.shapes()[2] else { panic!("a curve in the plane") };
    assert!(closed.knots().is_periodic());
    let error = pc_io::read_cloud(fixture("formats/json/model.json"), &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("a point cloud is needed, but this file holds 4 NURBS"), "{error}");
}

#[test]
fn points_that_are_not_finite_are_counted_and_dropped_on_demand() {
    let text = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_index\nend_header\n0 0 0\nnan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    let kept = read_bytes(text, None, &ReadOptions::default()).unwrap();
    assert_eq!((kept.report.non_finite, kept.report.dropped), (1, 0));
    let dropped = read_bytes(text, None, &ReadOptions::default().with_drop_non_finite(true)).unwrap();
    assert_eq!((dropped.report.non_finite, dropped.report.dropped), (1, 1));
    let Content::Mesh(mesh) = dropped.content else { panic!("a mesh") };
    assert_eq!((mesh.vertices().len(), mesh.triangles()), (3, [[0, 1, 2]].as_slice()));
}

#[test]
fn a_file_that_is_not_committed_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("target.txt");
    std::fs::write(&path, "old").unwrap();
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(b"new").unwrap();
    drop(file);
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    let error = AtomicFile::create(dir.path().join("missing/file.txt")).unwrap_err();
    assert!(error.to_string().contains("cannot create"), "{error}");
    assert!(AtomicFile::create(dir.path()).is_err());
}

#[cfg(unix)]
#[test]
fn links_and_devices_stay_what_they_are() {
    let dir = tempfile::tempdir().unwrap();
    let (target, link) = (dir.path().join("target.xyz"), dir.path().join("link.xyz"));
    std::fs::write(&target, "old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    let cloud = load("1 2 3\n").content;
    let _ = pc_io::write_cloud(&link, &cloud, &pc_io::WriteOptions::default()).unwrap();
    assert!(link.symlink_metadata().unwrap().is_symlink());
    assert_eq!(std::fs::read(&target).unwrap(), b"1 2 3\n");
    let options = pc_io::WriteOptions::default().with_format(Format::Xyz);
    let _ = pc_io::write_cloud("/dev/null", &cloud, &options).unwrap();
    assert!(!std::path::Path::new("/dev/null").symlink_metadata().unwrap().is_file());
}
