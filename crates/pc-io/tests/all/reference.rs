//! Every fixture against what reference readers found in it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use crate::common::{fixture, fixtures};
use pc_io::{Content, Format, ReadOptions};

/// What a file must turn out to hold.
enum Expected {
    /// Points and triangles.
    Holds(usize, usize),
    /// An error whose message contains this.
    Reject(&'static str),
}
use Expected::{Holds, Reject};

/// Vertices are those of the file; where reference readers merge or split some, the counts of triangles agree.
///
/// Four files that generic readers accept have no coordinates, or none named y, and are no points here; one PCD file
/// whose rows are missing is truncated here.
#[rustfmt::skip]
const TABLE: &[(&str, Expected)] = &[
    ("formats/malformed/assimp/OutOfMemory.off", Reject(":3: 353535235358 vertices and 6 faces are promised")),
    ("formats/malformed/assimp/empty.obj", Reject("empty")),
    ("formats/malformed/assimp/empty.off", Reject("empty")),
    ("formats/malformed/assimp/empty.ply", Reject("empty")),
    ("formats/malformed/assimp/malformed.obj", Reject(":28: \"0\" is no index")),
    ("formats/malformed/assimp/malformed2.obj", Holds(8, 10)),
    ("formats/obj/assimp/box.obj", Holds(8, 12)),
    ("formats/obj/assimp/box_UTF16BE.obj", Holds(8, 12)),
    ("formats/obj/assimp/box_longline.obj", Holds(8, 944)),
    ("formats/obj/assimp/box_mat_with_spaces.obj", Holds(8, 12)),
    ("formats/obj/assimp/box_without_lineending.obj", Holds(8, 12)),
    ("formats/obj/assimp/concave_polygon.obj", Holds(64, 64)),
    ("formats/obj/assimp/cube_mtllib_after_g.obj", Holds(8, 12)),
    ("formats/obj/assimp/cube_usemtl.obj", Holds(8, 12)),
    ("formats/obj/assimp/cube_with_vertexcolors.obj", Holds(8, 12)),
    ("formats/obj/assimp/cube_with_vertexcolors_uni.obj", Holds(8, 12)),
    ("formats/obj/assimp/empty_mat.obj", Holds(130, 256)),
    ("formats/obj/assimp/multiple_spaces.obj", Holds(4, 1)),
    ("formats/obj/assimp/number_formats.obj", Holds(15, 1)),
    ("formats/obj/assimp/point_cloud.obj", Holds(3, 0)),
    ("formats/obj/assimp/regr_3429812.obj", Holds(4, 4)),
    ("formats/obj/assimp/space_in_material_name.obj", Holds(64, 64)),
    ("formats/obj/assimp/testline.obj", Holds(8, 0)),
    ("formats/obj/assimp/testmixed.obj", Holds(8, 12)),
    ("formats/obj/assimp/testpoints.obj", Holds(8, 0)),
    ("formats/obj/draco/cube_quads.obj", Holds(8, 12)),
    ("formats/obj/draco/deg_faces.obj", Holds(6, 4)),
    ("formats/obj/draco/degenerate_mesh.obj", Holds(3, 1)),
    ("formats/obj/draco/eof_test.obj", Holds(3, 1)),
    ("formats/obj/draco/extra_vertex.obj", Holds(10, 3)),
    ("formats/obj/draco/inf_nan.obj", Holds(3, 1)),
    ("formats/obj/draco/test_wrong_attribute_mapping.obj", Holds(3, 1)),
    ("formats/off/assimp/Cube.off", Holds(8, 12)),
    ("formats/off/assimp/invalid.off", Reject(":7: \"2\" is not a face")),
    ("formats/pcd/pcd-rs/ascii.pcd", Holds(213, 0)),
    ("formats/pcd/pcd-rs/binary.pcd", Holds(28944, 0)),
    ("formats/pcd/pcd-rs/bunny_v05.pcd", Holds(397, 0)),
    ("formats/pcd/pcd-rs/columns_keyword.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/comments_in_header.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/corrupt_compressed.pcd", Reject(": byte 181: 100 bytes of compressed data are promised")),
    ("formats/pcd/pcd-rs/count_zero.pcd", Reject(":2: SIZE, TYPE and COUNT of the field \"x\"")),
    ("formats/pcd/pcd-rs/demo_compressed.pcd", Holds(3, 0)),
    ("formats/pcd/pcd-rs/dump_ascii_static.pcd", Reject("no column is named x")),
    ("formats/pcd/pcd-rs/dump_ascii_untyped.pcd", Reject("no column is named y")),
    ("formats/pcd/pcd-rs/header_only_ascii.pcd", Reject(":12: 100 points are promised")),
    ("formats/pcd/pcd-rs/header_only_compressed.pcd", Reject(": byte 151: the file ends")),
    ("formats/pcd/pcd-rs/header_only_v05.pcd", Reject(":10: 1 points are promised")),
    ("formats/pcd/pcd-rs/header_only_v06.pcd", Reject(":10: 1 points are promised")),
    ("formats/pcd/pcd-rs/header_only_v07.pcd", Reject(":11: 1 points are promised")),
    ("formats/pcd/pcd-rs/i64_u64_ascii.pcd", Reject("no column is named x")),
    ("formats/pcd/pcd-rs/legacy_v05.pcd", Holds(3, 0)),
    ("formats/pcd/pcd-rs/legacy_v06.pcd", Holds(2, 0)),
    ("formats/pcd/pcd-rs/missing_count.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/missing_viewpoint.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/multiple_padding.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/padding_ascii.pcd", Holds(2, 0)),
    ("formats/pcd/pcd-rs/padding_binary.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/padding_metadata.pcd", Reject("no column is named y")),
    ("formats/pcd/pcd-rs/reordered_header.pcd", Holds(2, 0)),
    ("formats/pcd/pcd-rs/unknown_entries.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/unsupported_v04.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/v05_ascii.pcd", Holds(2, 0)),
    ("formats/pcd/pcd-rs/v05_binary_compressed.pcd", Reject(": byte 107: the file ends")),
    ("formats/pcd/pcd-rs/v05_no_viewpoint.pcd", Reject("no column is named y")),
    ("formats/pcd/pcd-rs/v06_binary.pcd", Holds(1, 0)),
    ("formats/pcd/pcd-rs/v06_binary_compressed.pcd", Reject(": byte 107: the file ends")),
    ("formats/pcd/pcd-rs/v06_mixed_types_binary.pcd", Reject("no column is named x")),
    ("formats/pcd/pcd-rs/xyz_2pts.pcd", Holds(2, 0)),
    ("formats/pcd/pypcd4/ascii.pcd", Holds(213, 0)),
    ("formats/pcd/pypcd4/ascii_empty.pcd", Reject("empty")),
    ("formats/pcd/pypcd4/ascii_invalid_header.pcd", Reject("does not end with a line \"DATA\"")),
    ("formats/pcd/pypcd4/ascii_multi_count.pcd", Holds(8, 0)),
    ("formats/pcd/pypcd4/ascii_organized.pcd", Holds(8, 0)),
    ("formats/pcd/pypcd4/ascii_with_empty_points.pcd", Holds(0, 0)),
    ("formats/pcd/pypcd4/ascii_with_underscore.pcd", Holds(213, 0)),
    ("formats/pcd/pypcd4/binary.pcd", Holds(213, 0)),
    ("formats/pcd/pypcd4/binary_compressed.pcd", Holds(213, 0)),
    ("formats/pcd/pypcd4/binary_compressed_organized.pcd", Holds(8, 0)),
    ("formats/ply/assimp/cube.ply", Holds(8, 12)),
    ("formats/ply/assimp/cube_binary.ply", Holds(8, 12)),
    ("formats/ply/assimp/cube_uv.ply", Holds(24, 12)),
    ("formats/ply/assimp/float-color.ply", Holds(3, 1)),
    ("formats/ply/assimp/issue623.ply", Reject(":13: the line ends where the number vertex_indices is expected")),
    ("formats/ply/assimp/points.ply", Holds(4, 0)),
    ("formats/ply/draco/Box.ply", Holds(24, 12)),
    ("formats/ply/draco/cube_att.ply", Holds(24, 12)),
    ("formats/ply/draco/cube_quads.ply", Holds(8, 12)),
    ("formats/ply/draco/delim_test.ply", Holds(24, 12)),
    ("formats/ply/draco/float_inf_point_cloud.ply", Holds(16, 0)),
    ("formats/ply/draco/float_two_att_point_cloud.ply", Holds(3, 0)),
    ("formats/ply/draco/int_point_cloud.ply", Holds(16, 0)),
    ("formats/ply/draco/point_cloud_test_pos.ply", Holds(4, 0)),
    ("formats/ply/draco/point_cloud_test_pos_norm.ply", Holds(4, 0)),
    ("formats/ply/draco/test_extra_whitespace.ply", Holds(3, 1)),
    ("formats/ply/draco/test_generic.ply", Holds(114, 224)),
    ("formats/ply/draco/test_more_datatypes.ply", Holds(3, 1)),
    ("formats/ply/draco/test_pos_color.ply", Holds(114, 224)),
    ("formats/ply/draco/test_pos_color_ascii.ply", Holds(114, 224)),
    ("formats/ply/geometry-central/fox.ply", Holds(313, 622)),
    ("formats/ply/geometry-central/lego.ply", Holds(1649, 3072)),
    ("formats/ply/happly/platonic_shelf.ply", Holds(50, 80)),
    ("formats/ply/happly/platonic_shelf_ascii.ply", Holds(50, 80)),
    ("formats/ply/happly/platonic_shelf_big_endian.ply", Holds(50, 80)),
    ("formats/ply/ply-rs-bw/all_atomic_types_ok_ascii.ply", Reject("no element has the properties x and y")),
    ("formats/ply/ply-rs-bw/doubles_ints.ply", Holds(3, 1)),
    ("formats/ply/ply-rs-bw/doubles_shorts.ply", Holds(3, 1)),
    ("formats/ply/ply-rs-bw/empty_2_ok_ascii.ply", Holds(0, 0)),
    ("formats/ply/ply-rs-bw/empty_2_ok_little_endian.ply", Holds(0, 0)),
    ("formats/ply/ply-rs-bw/empty_ok_ascii.ply", Holds(0, 0)),
    ("formats/ply/ply-rs-bw/exponent_values_ok_ascii.ply", Holds(1, 0)),
    ("formats/ply/ply-rs-bw/floats_ints.ply", Holds(3, 1)),
    ("formats/ply/ply-rs-bw/floats_shorts.ply", Holds(3, 1)),
    ("formats/ply/ply-rs-bw/greg_turk_example1_ok_ascii.ply", Holds(8, 12)),
    ("formats/ply/ply-rs-bw/greg_turk_example2_ok_ascii.ply", Holds(8, 12)),
    ("formats/ply/ply-rs-bw/header_min_ok_ascii.ply", Holds(0, 0)),
    ("formats/ply/ply-rs-bw/house_2_ok_ascii.ply", Holds(5, 3)),
    ("formats/ply/ply-rs-bw/house_2_ok_little_endian.ply", Holds(5, 3)),
    ("formats/ply/ply-rs-bw/house_ok_ascii.ply", Holds(5, 3)),
    ("formats/ply/ply-rs-bw/leading_spaces_ok_ascii.ply", Holds(4, 0)),
    ("formats/ply/ply-rs-bw/single_elements_err_ascii.ply", Reject(":9: 2 rows of the element \"point\" are promised")),
    ("formats/ply/ply-rs-bw/single_elements_ok_ascii.ply", Holds(1, 0)),
    ("formats/ply/ply-rs-bw/tetrahedron_ascii.ply", Holds(4, 4)),
    ("formats/ply/ply-rs-bw/tetrahedron_big_endian.ply", Holds(4, 4)),
    ("formats/ply/ply-rs-bw/tetrahedron_little_endian.ply", Holds(4, 4)),
    ("formats/stl/assimp/sphereWithHole.stl", Holds(146, 285)),
    ("formats/stl/assimp/triangle.stl", Holds(3, 1)),
    ("formats/stl/assimp/triangle_with_empty_solid.stl", Holds(3, 1)),
    ("formats/stl/assimp/triangle_with_two_solids.stl", Holds(6, 2)),
    ("formats/stl/draco/test_sphere.stl", Holds(114, 224)),
    ("formats/stl/draco/test_sphere_ascii.stl", Holds(114, 224)),
    ("formats/stl/geometry-central/stl_box_ascii.stl", Holds(8, 12)),
    ("formats/stl/geometry-central/stl_box_binary.stl", Holds(8, 12)),
    ("formats/json/model.json", Holds(0, 0)),
    ("mesh/bunny.obj", Holds(1839, 3674)),
    ("mesh/bunny_99.stl", Holds(54, 99)),
    ("mesh/bunny_99_ascii.stl", Holds(54, 99)),
    ("mesh/teapot.obj", Holds(792, 992)),
    ("scans/engine-blade.ply", Holds(21795, 43586)),
    ("scans/sample-clip.ply", Holds(41706, 82275)),
    ("scans/stud-bolt.ply", Holds(8565, 16957)),
];

#[test]
fn every_file_holds_what_the_reference_says() {
    for (name, expected) in TABLE {
        let result = pc_io::read(fixture(name), &ReadOptions::default());
        match (expected, result) {
            (&Holds(points, triangles), Ok(loaded)) => {
                let report = loaded.report;
                assert_eq!((report.points, report.triangles), (points, triangles), "{report}");
                assert_eq!(Some(report.format), Format::from_path(name.as_ref()), "{report}");
                assert_eq!(triangles > 0, matches!(loaded.content, Content::Mesh(_)), "{name}");
            }
            (Reject(part), Err(error)) => {
                let message = error.to_string();
                assert!(message.contains(part), "{name}: {message}");
                assert!(message.contains(name), "the message does not name the file: {message}");
            }
            (Holds(..), Err(error)) => panic!("{error}"),
            (Reject(_), Ok(loaded)) => panic!("{} should be refused", loaded.report),
        }
    }
}

#[test]
fn no_fixture_is_left_out() {
    let known: Vec<_> = TABLE.iter().map(|(name, _)| fixture(name)).collect();
    // Those of scanners have a table of their own.
    let of_scanner: Vec<_> = crate::scanners::known().iter().map(|name| fixture(name)).collect();
    let is_unknown = |path: &std::path::PathBuf| !known.contains(path) && !of_scanner.contains(path);
    let formats: Vec<_> = fixtures("formats").into_iter().filter(is_unknown).collect();
    assert!(formats.is_empty(), "{formats:?}");
}

#[test]
fn the_same_mesh_in_three_encodings_is_the_same() {
    let read = |name: &str| pc_io::read_mesh(fixture(name), &ReadOptions::default()).unwrap().content;
    let little = read("formats/ply/ply-rs-bw/tetrahedron_little_endian.ply");
    assert_eq!(read("formats/ply/ply-rs-bw/tetrahedron_big_endian.ply"), little);
    assert_eq!(read("formats/ply/ply-rs-bw/tetrahedron_ascii.ply"), little);
    let shelf = read("formats/ply/happly/platonic_shelf.ply");
    let big = read("formats/ply/happly/platonic_shelf_big_endian.ply");
    assert_eq!(big.triangles(), shelf.triangles());
    // The text has six decimals.
    for (a, b) in shelf.vertices().iter().zip(read("formats/ply/happly/platonic_shelf_ascii.ply").vertices())
    {
        assert!((a - b).norm() < 1e-5);
    }
    assert!(
        (read("formats/stl/draco/test_sphere.stl").area()
            - read("formats/stl/draco/test_sphere_ascii.stl").area())
        .abs()
            < 1e-4
    );
    assert!(read("scans/engine-blade.ply").topology().is_solid());
}

#[test]
fn packed_colours_are_unpacked() {
    let read = |name: &str| pc_io::read_cloud(fixture(name), &ReadOptions::default()).unwrap().content;
    let text = read("formats/pcd/pypcd4/ascii.pcd");
    let binary = read("formats/pcd/pypcd4/binary.pcd");
    let compressed = read("formats/pcd/pypcd4/binary_compressed.pcd");
    assert_eq!(text.attributes().colours().map(mesh_core::Colours::len), Some(213));
    assert_eq!(binary, compressed);
    assert_eq!(text.attributes().colours(), binary.attributes().colours());
}
