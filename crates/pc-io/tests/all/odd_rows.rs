//! Rows and facets that are not as the header, or the format, says: what is read of them, and what is refused.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test may panic")]

use mesh_core::nalgebra::{Point3, Vector3};
use mesh_core::{Colours, PointCloud, TriangleMesh};
use pc_io::{Content, Format, Loaded, ReadOptions, read_bytes, write_number};

fn load(data: &[u8], format: Format) -> Loaded<Content> {
    read_bytes(data, None, &ReadOptions::default().with_format(format))
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(data)))
}

fn mesh(data: &[u8], format: Format) -> (TriangleMesh, Vec<String>) {
    let loaded = load(data, format);
    let Content::Mesh(mesh) = loaded.content else { panic!("{}", loaded.report) };
    (mesh, loaded.report.warnings)
}

fn cloud(data: &[u8], format: Format) -> (PointCloud, Vec<String>) {
    let loaded = load(data, format);
    let Content::Cloud(cloud) = loaded.content else { panic!("{}", loaded.report) };
    (cloud, loaded.report.warnings)
}

fn refused(data: &[u8], format: Format, part: &str) {
    let text = String::from_utf8_lossy(data);
    let error = read_bytes(data, None, &ReadOptions::default().with_format(format))
        .map(|loaded| loaded.report.to_string())
        .expect_err(&text)
        .to_string();
    assert!(error.contains(part), "{error}: {text}");
}

fn axes(order: [usize; 3]) -> Vec<Vector3<f64>> {
    order.map(|axis| Vector3::ith(axis, 1.0)).to_vec()
}

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const NORMALS: &str = "vn 1 0 0\nvn 0 1 0\nvn 0 0 1\n";

#[test]
fn normals_of_an_obj_file_belong_where_the_faces_say() {
    let normals = |text: &str| {
        let (mesh, warnings) = mesh(text.as_bytes(), Format::Obj);
        (mesh.attributes().normals().map(<[_]>::to_vec), warnings.join("; "))
    };
    // As many normals as vertices, but in another order.
    let permuted = format!("{CORNERS}{NORMALS}f 1//3 2//1 3//2\n");
    assert_eq!(normals(&permuted), (Some(axes([2, 0, 1])), String::new()));
    let in_order = format!("{CORNERS}{NORMALS}f 1//1 2//2 3//3\n");
    assert_eq!(normals(&in_order).0, Some(axes([0, 1, 2])));
    // Counted backwards.
    let backwards = format!("{CORNERS}{NORMALS}f -3//-1 -2//-3 -1//-2\n");
    assert_eq!(normals(&backwards).0, Some(axes([2, 0, 1])));
    // A second normal of the same vertex counts only if it is another one.
    let again = format!("{CORNERS}{NORMALS}vn 0 0 1\nf 1//3 2//1 3//2\nf 1//4 3//2 2//1\n");
    assert_eq!(normals(&again).0, Some(axes([2, 0, 1])));
    let several = format!("{CORNERS}{NORMALS}f 1//1 2//2 3//3\nf 1//2 3//3 2//2\n");
    let (none, warnings) = normals(&several);
    assert!(none.is_none() && warnings.contains("not read: 3 normals"), "{warnings}");
    // A vertex without a normal, and the others permuted.
    let missing = format!("{CORNERS}v 1 1 0\n{NORMALS}vn 1 0 0\nf 1//3 2//1 3//2\nf 2 4 3\n");
    let (none, warnings) = normals(&missing);
    assert!(none.is_none() && warnings.contains("not read: 4 normals"), "{warnings}");
}

#[test]
fn strips_are_cut_at_triangles_without_area() {
    let text = |strip: &str| {
        let count = strip.split(' ').count();
        format!(
            "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
             element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
             0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n{count} {strip}\n"
        )
    };
    let triangles = |strip: &str| mesh(text(strip).as_bytes(), Format::Ply).0.triangles().to_vec();
    assert_eq!(triangles("0 1 2 3 4"), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    // Repeated at the beginning, at the end, and around a corner.
    assert_eq!(triangles("0 0 1 2"), [[0, 2, 1]]);
    assert_eq!(triangles("0 1 2 2"), [[0, 1, 2]]);
    assert_eq!(triangles("0 1 0 2"), [[1, 2, 0]]);
    assert_eq!(triangles("0 1 2 -1 2 3 4"), [[0, 1, 2], [2, 3, 4]]);
}

const FACET: &str =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

#[test]
fn text_stl_that_ends_within_a_facet_is_refused() {
    let whole = format!("solid part\n{FACET}endsolid part\n");
    assert_eq!(mesh(whole.as_bytes(), Format::Stl).0.triangles().len(), 1);
    let lines: Vec<&str> = FACET.lines().collect();
    for cut in 1..lines.len() {
        let part = lines[..cut].join("\n");
        refused(format!("solid part\n{FACET}{part}\n").as_bytes(), Format::Stl, "ends within a facet");
        for end in ["endsolid part", "solid next"] {
            let text = format!("solid part\n{FACET}{part}\n{end}\n{FACET}endsolid\n");
            refused(text.as_bytes(), Format::Stl, "ends within a facet");
        }
    }
    for vertices in [2, 4] {
        let corners = "vertex 0 0 1\n".repeat(vertices);
        let text = format!("solid\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid\n");
        refused(text.as_bytes(), Format::Stl, "vertices");
    }
}

#[test]
fn normals_of_text_stl_may_be_anything() {
    for normal in ["0 0 1", "nan nan nan", "0 0", "", "-0 1e-30 inf", "1 2 3"] {
        // All on one line, so that what is not passed over would be taken for a statement.
        let text = format!("solid\nfacet normal {normal} {}\nendsolid\n", FACET[19..].replace('\n', " "));
        assert_eq!(mesh(text.as_bytes(), Format::Stl).0.triangles(), [[0, 1, 2]], "{normal:?}");
    }
    let four = format!("solid\nfacet normal 1 2 3 4 {}\nendsolid\n", FACET[19..].replace('\n', " "));
    refused(four.as_bytes(), Format::Stl, "\"4\" is not part of an STL file");
}

#[test]
fn binary_stl_may_begin_like_text() {
    let binary = |title: &[u8], fill: u8, corner: f32, trailing: usize| {
        let mut data = vec![fill; 80];
        data[..title.len()].copy_from_slice(title);
        data.extend_from_slice(&1u32.to_le_bytes());
        let numbers = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, corner, 0.0, 0.0, 0.0, corner, 0.0];
        data.extend(numbers.iter().flat_map(|number: &f32| number.to_le_bytes()));
        data.extend_from_slice(&[0, 0]);
        data.extend(std::iter::repeat_n(b'x', trailing));
        data
    };
    for fill in [0, b' '] {
        // 2.0 is made of ASCII bytes only; 1.0 is not.
        for corner in [1.0, 2.0] {
            for trailing in [0, 7] {
                let (mesh, warnings) = mesh(&binary(b"solid part", fill, corner, trailing), Format::Stl);
                let corner = f64::from(corner);
                let expected = [[0.0; 3], [corner, 0.0, 0.0], [0.0, corner, 0.0]].map(Point3::from);
                assert_eq!(mesh.vertices(), expected, "{fill} {corner} {trailing}");
                assert_eq!(mesh.triangles(), [[0, 1, 2]]);
                assert_eq!(warnings.iter().any(|w| w.starts_with("7 bytes follow")), trailing == 7);
            }
        }
    }
}

fn pcd(fields: &str, sizes: &str, types: &str, rows: &[&str]) -> Vec<u8> {
    let (count, points) = ("1 ".repeat(fields.split(' ').count()), rows.len());
    let data = rows.join("\n");
    format!(
        "VERSION 0.7\nFIELDS {fields}\nSIZE {sizes}\nTYPE {types}\nCOUNT {count}\nWIDTH {points}\nHEIGHT 1\n\
         POINTS {points}\nDATA ascii\n{data}\n"
    )
    .into_bytes()
}

#[test]
fn rows_of_a_pcd_file_have_as_many_numbers_as_fields() {
    let xyz = |rows: &[&str]| pcd("x y z", "4 4 4", "F F F", rows);
    assert_eq!(cloud(&xyz(&["1 2 3", "4 5 6"]), Format::Pcd).0.positions()[1], Point3::new(4.0, 5.0, 6.0));
    refused(&xyz(&["1 2 3", "4 5 6 7"]), Format::Pcd, "line 11: \"4 5 6 7\" has more than 3 numbers");
    refused(&xyz(&["1.5 2.5 3.5", "4 5"]), Format::Pcd, "line 11: \"4 5\" has fewer than 3 numbers");
}

#[test]
fn packed_colours_in_text_are_integers_or_the_bits_of_floats() {
    let colours = |kind: &str, words: &[&str]| {
        let rows: Vec<String> = words.iter().map(|word| format!("0 0 0 {word}")).collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let data = pcd("x y z rgb", "4 4 4 4", &format!("F F F {kind}"), &rows);
        cloud(&data, Format::Pcd).0.attributes().colours().cloned().unwrap()
    };
    // 0 is black as either; 255 is no float that a colour makes; 1.0f32 has the bits 3f800000.
    let expected = vec![[0, 0, 0], [0, 0, 255], [0x80, 0, 0], [0xff, 0x80, 0x01], [0, 0, 1]];
    let bits = format!("{:e}", f32::from_bits(0x00ff_8001));
    assert_eq!(colours("F", &["0", "255", "1.0", &bits, "1"]), Colours::Rgb(expected.clone()));
    let words = ["0", "255", "8388608", "16744449", "1"];
    for kind in ["U", "I"] {
        assert_eq!(colours(kind, &words), Colours::Rgb(expected.clone()));
    }
}

/// Literal runs only: what LZF makes of data that does not repeat.
fn unpacked_lzf(data: &[u8]) -> Vec<u8> {
    data.chunks(32)
        .flat_map(|run| std::iter::once(u8::try_from(run.len() - 1).unwrap()).chain(run.iter().copied()))
        .collect()
}

#[test]
fn the_size_of_compressed_points_is_that_of_all_points() {
    let file = |points: usize, numbers: &[f32], stated: usize| {
        let raw: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let packed = unpacked_lzf(&raw);
        let mut data = pcd("x y z", "4 4 4", "F F F", &vec!["0 0 0"; points]);
        let end = data.windows(5).position(|part| part == b"ascii").unwrap();
        data.truncate(end);
        data.extend_from_slice(b"binary_compressed\n");
        data.extend_from_slice(&u32::try_from(packed.len()).unwrap().to_le_bytes());
        data.extend_from_slice(&u32::try_from(stated).unwrap().to_le_bytes());
        data.extend_from_slice(&packed);
        data
    };
    let numbers = [1.0, 4.0, 2.0, 5.0, 3.0, 6.0];
    let (read, _) = cloud(&file(2, &numbers, 24), Format::Pcd);
    assert_eq!(read.positions(), [Point3::new(1.0, 2.0, 3.0), Point3::new(4.0, 5.0, 6.0)]);
    // One point more or less than the data holds, and a size that is no whole number of points.
    for (points, stated) in [(1, 24), (3, 24), (2, 23), (2, 25), (2, 12), (2, 48), (2, 0)] {
        refused(&file(points, &numbers, stated), Format::Pcd, "");
    }
    refused(&file(1, &numbers, 24), Format::Pcd, "1 points of 12 bytes do not make the 24 bytes stated");
    refused(&file(3, &numbers, 24), Format::Pcd, "3 points of 12 bytes do not make the 24 bytes stated");
}

fn ply(rows: &str) -> Vec<u8> {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list int int vertex_indices\nend_header\n{rows}"
    )
    .into_bytes()
}

#[test]
fn lists_of_a_ply_file_have_a_whole_length_that_is_not_negative() {
    let rows = "0 0 0\n1 0 0\n0 1 0\n";
    assert_eq!(mesh(&ply(&format!("{rows}3 0 1 2\n")), Format::Ply).0.triangles(), [[0, 1, 2]]);
    for length in ["2.5", "-3", "-1", "nan", "inf", "1e30", "4", "3.0000001"] {
        refused(&ply(&format!("{rows}{length} 0 1 2\n")), Format::Ply, "line 13: ");
    }
    for (bytes, order) in [(true, "little"), (false, "big")] {
        let head = format!(
            "ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\n\
             element face 2\nproperty list short uchar vertex_indices\nend_header\n"
        );
        let file = |length: i16| {
            let length = if bytes { length.to_le_bytes() } else { length.to_be_bytes() };
            let mut data = head.clone().into_bytes();
            data.extend_from_slice(&[0, 0, 1, 0, 0, 1]);
            for list in [[0, 1, 2], [2, 1, 0]] {
                data.extend_from_slice(&length);
                data.extend_from_slice(&list);
            }
            data
        };
        assert_eq!(mesh(&file(3), Format::Ply).0.triangles(), [[0, 1, 2], [2, 1, 0]]);
        refused(&file(-1), Format::Ply, "has the length -1");
        refused(&file(-3), Format::Ply, "has the length -3");
        refused(&file(i16::MIN), Format::Ply, "has the length -32768");
        refused(&file(i16::MAX), Format::Ply, "32767 items");
    }
}

#[test]
fn rows_of_a_ply_file_with_text_or_surplus_numbers() {
    let end = "0 1 0\n3 0 1 2\n";
    for row in ["1 0 0mm", "1 0 0,", "1 0 0;5", "1 0 1.2.3", "1 0 0x10", "1 0 --0", "1 0", "1 0 zero"] {
        refused(&ply(&format!("0 0 0\n{row}\n{end}")), Format::Ply, "line 11: ");
    }
    // More numbers than properties: read, and told.
    let (read, warnings) = mesh(&ply(&format!("0 0 0 9\n1 0 0 8 7\n{end}")), Format::Ply);
    assert_eq!(read.vertices()[1], Point3::new(1.0, 0.0, 0.0));
    assert!(warnings.iter().any(|warning| warning.ends_with(" 2 rows")), "{warnings:?}");
    // Blanks at the end are none.
    let (_, warnings) = mesh(&ply(&format!("0 0 0  \n1 0 0\t\n{end}")), Format::Ply);
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn vertices_of_an_off_file_have_what_the_first_word_says() {
    let off =
        |word: &str, rows: &[&str]| format!("{word}\n3 1 0\n{}\n3 0 1 2\n", rows.join("\n")).into_bytes();
    let plain = ["0 0 0", "1 0 0", "0 1 0"];
    refused(&off("NOFF", &plain), Format::Off, "");
    refused(&off("NOFF", &["0 0 0 0 0 1", "1 0 0 0 0", "0 1 0 0 0 1"]), Format::Off, "");
    let (read, _) = mesh(&off("NOFF", &["0 0 0 1 0 0", "1 0 0 0 1 0", "0 1 0 0 0 1"]), Format::Off);
    assert_eq!(read.attributes().normals().unwrap(), axes([0, 1, 2]));
    // Texture coordinates stand after the colours, and are not among them.
    let textured = ["0 0 0 10 20 30 0.25 0.5", "1 0 0 40 50 60 0.75 1", "0 1 0 70 80 90 0 0"];
    let (read, _) = mesh(&off("STCOFF", &textured), Format::Off);
    let expected = vec![[10, 20, 30], [40, 50, 60], [70, 80, 90]];
    assert_eq!(read.attributes().colours(), Some(&Colours::Rgb(expected)));
    assert_eq!(read.vertices()[2], Point3::new(0.0, 1.0, 0.0));
    // Four numbers after three, and the other way round: no colours rather than shifted ones.
    for rows in [
        ["0 0 0 1 2 3", "1 0 0 4 5 6 7", "0 1 0 8 9 10"],
        ["0 0 0 1 2 3 4", "1 0 0 5 6 7", "0 1 0 8 9 10 11"],
    ] {
        let (read, warnings) = mesh(&off("COFF", &rows), Format::Off);
        assert!(read.attributes().colours().is_none());
        assert!(warnings.iter().any(|warning| warning.contains("colours were not read")), "{warnings:?}");
        assert_eq!(read.vertices().len(), 3);
    }
}

#[test]
fn a_bracket_that_nothing_closes_is_no_number() {
    let closed = b"1 2 nan(ind)\n3 4 -nan(0x7ff)\n".as_slice();
    assert_eq!(cloud(closed, Format::Xyz).0.count_non_finite(), 2);
    for text in ["1 2 nan(", "1 2 3\n1 2 nan(\n", "1 nan( 3\n", "nan(\t2 3\n", "1 2 nan(ind\n"] {
        let ascii = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nend_header\n{text}",
            text.lines().count()
        );
        refused(ascii.as_bytes(), Format::Ply, "nan(");
        let rows: Vec<&str> = text.lines().collect();
        refused(&pcd("x y z", "4 4 4", "F F F", &rows), Format::Pcd, "nan(");
    }
}

#[test]
fn numbers_are_written_with_an_exponent_only_where_they_would_grow_long() {
    let text = |value: f64| {
        let mut out = Vec::new();
        write_number(&mut out, value).unwrap();
        String::from_utf8(out).unwrap()
    };
    for (value, expected) in [
        (0.0, "0"),
        (-0.0, "-0"),
        (1e-5, "0.00001"),
        (-9.999e-6, "-9.999e-6"),
        (9_999_999_999_999_998.0, "9999999999999998"),
        (1e16, "1e16"),
        (-1e16, "-1e16"),
        (f64::MAX, "1.7976931348623157e308"),
        (5e-324, "5e-324"),
        (f64::NAN, "nan"),
        (f64::INFINITY, "inf"),
        (f64::NEG_INFINITY, "-inf"),
    ] {
        assert_eq!(text(value), expected);
    }
}

#[test]
fn integers_from_two_to_the_53rd_on_are_told_of() {
    let warnings = |value: &str| {
        let rows = [format!("0 0 0 {value}")];
        let data = pcd("x y z id", "4 4 4 8", "F F F I", &[rows[0].as_str()]);
        cloud(&data, Format::Pcd).1
    };
    for value in ["9007199254740991", "-9007199254740991", "0"] {
        assert!(warnings(value).is_empty(), "{value}: {:?}", warnings(value));
    }
    // 2⁵³ is what 2⁵³ + 1 is read as, so that nobody knows any more.
    for value in ["9007199254740992", "9007199254740993", "-9007199254740992", "9223372036854775807"] {
        assert!(warnings(value).iter().any(|warning| warning.contains("\"id\"")), "{value}");
    }
}
