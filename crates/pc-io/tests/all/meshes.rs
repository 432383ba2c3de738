//! Meshes as programs write them: corners apart by rounding, counts that are wrong, keywords left out.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::cast_possible_truncation,
    reason = "a test may panic, and rounds on purpose"
)]

use pc_io::mesh_core::{MeshProjector, TriangleMesh, nalgebra::Point3};
use pc_io::{Content, Error, Format, Loaded, ReadOptions, read_bytes};

fn load(name: &str, data: &[u8]) -> Result<Loaded<Content>, Error> {
    read_bytes(data, Format::from_path(name.as_ref()), &ReadOptions::default())
}

fn mesh(name: &str, data: &[u8]) -> TriangleMesh {
    match load(name, data).unwrap().content {
        Content::Mesh(mesh) => mesh,
        other => panic!("{name}: {}", other.describe()),
    }
}

fn refused(name: &str, data: &[u8]) -> String {
    load(name, data).map(|loaded| panic!("{name}: {}", loaded.report)).unwrap_err().to_string()
}

/// A box of 4 × 3 × 2 as triangles of their own; the sides begin at `z`, the base at 0.
fn box_soup(z: f64) -> Vec<[[f64; 3]; 3]> {
    let p =
        |i: usize, z: f64| [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]].map(|[x, y]| [x, y, z])[i % 4];
    let mut out = vec![
        [p(0, 0.0), p(2, 0.0), p(1, 0.0)],
        [p(0, 0.0), p(3, 0.0), p(2, 0.0)],
        [p(0, 2.0), p(1, 2.0), p(2, 2.0)],
        [p(0, 2.0), p(2, 2.0), p(3, 2.0)],
    ];
    for i in 0..4 {
        out.push([p(i, z), p(i + 1, z), p(i + 1, 2.0)]);
        out.push([p(i, z), p(i + 1, 2.0), p(i, 2.0)]);
    }
    out
}

fn binary_stl(triangles: &[[[f64; 3]; 3]], count: u32) -> Vec<u8> {
    let mut data = vec![b' '; 80];
    data.extend(count.to_le_bytes());
    for corners in triangles {
        data.extend([0; 12]);
        corners.iter().flatten().for_each(|&value| data.extend((value as f32).to_le_bytes()));
        data.extend([0; 2]);
    }
    data
}

fn text_stl(triangles: &[[[f64; 3]; 3]], digits: usize) -> String {
    let mut text = String::from("solid part\n");
    for corners in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        corners.iter().for_each(|[x, y, z]| {
            text.push_str(&format!("vertex {x:.digits$e} {y:.digits$e} {z:.digits$e}\n"));
        });
        text.push_str("endloop\nendfacet\n");
    }
    text + "endsolid part\n"
}

#[test]
fn corners_of_an_stl_that_differ_by_rounding_are_one() {
    let soup = box_soup(-2.5e-16);
    let exact = mesh("exact.stl", &binary_stl(&box_soup(0.0), 12));
    for data in [binary_stl(&soup, 12), text_stl(&soup, 8).into_bytes()] {
        let loaded = load("box.stl", &data).unwrap();
        assert_eq!((loaded.report.points, loaded.report.triangles), (8, 12));
        let told = |warning: &String| {
            warning.contains("4 corners that differ from others by rounding (2.5e-16 at most)")
        };
        assert!(loaded.report.warnings.iter().any(told), "{}", loaded.report);
        let Content::Mesh(mesh) = loaded.content else { panic!() };
        assert!(mesh.topology().is_solid());
        assert_eq!(mesh.signed_volume(), exact.signed_volume());
        assert!((mesh.signed_volume() - 24.0).abs() < 1e-12);
        let projector = MeshProjector::new(&mesh).unwrap();
        for (x, distance) in [
            ([2.0, 1.5, -0.25], 0.25),
            ([2.0, 1.5, 0.25], -0.25),
            ([4.5, 1.5, 0.0], 0.5),
            ([2.0, 1.5, 1.5], -0.5),
            ([-0.1, 1.5, 0.0], 0.1),
            ([0.1, 1.5, 1.0], -0.1),
        ] {
            let found = projector.project(&Point3::from(x)).unwrap().signed_distance.unwrap();
            assert!((found - distance).abs() < 1e-12, "{x:?}: {found}");
        }
    }
}

#[test]
fn corners_repeated_for_texture_are_one() {
    let mut text = String::from("mtllib a.mtl\n");
    let (mut vertices, mut faces) = (String::new(), String::new());
    for (number, corners) in box_soup(-0.0).iter().enumerate() {
        for (corner, [x, y, z]) in corners.iter().enumerate() {
            // The last digit of a text, as a program writes it that computes each corner anew.
            let x = x / 3.0 + if number % 2 == 0 { 4e-7 } else { 0.0 };
            vertices.push_str(&format!("v {x:.6} {:.6} {z:.6}\nvt 0.{corner} 0.{number}\n", y / 7.0));
        }
        let first = 3 * number + 1;
        faces.push_str(&format!("f {0}/{0} {1}/{1} {2}/{2}\n", first, first + 1, first + 2));
    }
    text.push_str(&vertices);
    text.push_str(&faces);
    let mesh = mesh("box.obj", text.as_bytes());
    // The vertices stay those of the file, so that row i of a result belongs to line i.
    assert_eq!(mesh.vertices().len(), 36);
    assert!(mesh.welded_topology().is_solid(), "{}", mesh.welded_topology());
    assert!(mesh.weld().joined > 0);
}

#[test]
fn ascii_stl_is_read_without_its_name_and_with_words_apart() {
    let whole = text_stl(&box_soup(0.0), 3);
    let variants = [
        whole
            .replace("endsolid", "end solid")
            .replace("endfacet", "end facet")
            .replace("endloop", "end loop"),
        whole.replacen("solid part\n", "", 1),
        whole.lines().filter(|line| !line.contains("solid")).map(|line| format!("{line}\r\n")).collect(),
        whole.to_uppercase(),
        whole.replace("outer loop", "outerloop").replace("solid part", "solid facet vertex"),
        whole.replace("endloop\n", "endloop\ncolor 1 0 0\n"),
        format!("\n  {}", whole.replace('\n', "\n   ")),
        whole.replace("solid part\n", "solid a\nendsolid a\nsolid b\n"),
    ];
    for text in variants {
        for name in ["a.stl", "a.txt"] {
            let loaded = load(name, text.as_bytes()).unwrap_or_else(|error| panic!("{error}\n{text}"));
            assert_eq!(
                (loaded.report.points, loaded.report.triangles, loaded.report.format),
                (8, 12, Format::Stl),
                "{text}"
            );
        }
    }
    let nested = whole.replacen("endfacet\n", "", 1);
    assert!(refused("a.stl", nested.as_bytes()).contains("a facet begins within another"));
}

#[test]
fn counts_that_say_less_than_follows_are_errors() {
    let soup = box_soup(0.0);
    for count in [0, 3, 11] {
        let message = refused("box.stl", &binary_stl(&soup, count));
        assert!(message.starts_with("byte 80") && message.contains("bytes follow"), "{message}");
    }
    for (name, text, place) in [
        ("a.off", "OFF\n0 0 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "line 3"),
        ("b.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n# faces\n3 0 1 2\n", "line 7"),
        ("c.off", "OFF\n2 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "line"),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nend_header\n1 2\n",
            "line 7",
        ),
        (
            "a.pcd",
            "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n1 2 3\n",
            "line 10",
        ),
    ] {
        let message = refused(name, text.as_bytes());
        assert!(message.starts_with(place), "{name}: {message}");
    }
    // Nothing at all is told, not refused.
    for (name, data) in [
        ("a.stl", binary_stl(&[], 0)),
        ("b.stl", b"solid a\nendsolid a\n".to_vec()),
        ("a.off", b"OFF\n0 0 0\n".to_vec()),
        ("a.obj", b"# nothing\no thing\n".to_vec()),
    ] {
        let loaded = load(name, &data).unwrap();
        assert!(
            loaded.report.warnings.iter().any(|warning| warning.contains("holds no")),
            "{name}: {}",
            loaded.report
        );
        if let Content::Mesh(mesh) = loaded.content {
            assert!(mesh.area().is_sign_positive());
        }
    }
}

/// Three points as binary PLY with the line ends given.
fn ply(ending: &str, little: bool) -> Vec<u8> {
    let order = if little { "little" } else { "big" };
    let header = [
        "ply",
        &format!("format binary_{order}_endian 1.0"),
        "element vertex 3",
        "property float x",
        "property float y",
        "property float z",
        "end_header",
    ];
    let mut data: Vec<u8> = header.iter().flat_map(|line| format!("{line}{ending}").into_bytes()).collect();
    for value in [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0] {
        data.extend(if little { value.to_le_bytes() } else { value.to_be_bytes() });
    }
    data
}

#[test]
fn binary_ply_is_read_whatever_its_line_ends_are() {
    for ending in ["\n", "\r\n", "\r", "\n\r"] {
        for little in [true, false] {
            let Content::Cloud(cloud) = load("a.ply", &ply(ending, little)).unwrap().content else {
                panic!()
            };
            assert_eq!(cloud.positions()[2], Point3::new(7.0, 8.0, 9.0), "{ending:?}");
            assert_eq!(cloud.positions()[0], Point3::new(1.0, 2.0, 3.0), "{ending:?}");
            let mut more = ply(ending, little);
            more.push(7);
            let message = refused("a.ply", &more);
            assert!(message.contains("1 bytes follow after the last row"), "{message}");
            more.pop();
            more.extend(b"\n");
            assert!(load("a.ply", &more).is_ok());
        }
    }
    // A byte between header and data that no line end explains.
    let mut shifted = ply("\n", true);
    let at = shifted.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    shifted.insert(at, b' ');
    assert!(refused("a.ply", &shifted).contains("bytes follow"));
}

#[test]
fn off_is_read_in_free_format() {
    let lines = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    let right = mesh("a.off", lines.as_bytes());
    assert!(right.topology().is_solid());
    for text in [
        lines.replace('\n', " "),
        lines.replace(' ', "\n"),
        lines.replace('\n', "\n# a remark 1 2 3\n\n"),
        lines.replace("0 0 0\n1 0 0\n", "0 0 0 1 0 0\n").replace("4 4 6", "4 # vertices\n4 # faces\n6"),
        lines.replace("0 0 1\n3 0", "0 0 1 3 0").replace("OFF\n", "# first\nOFF "),
        lines.replace("4 4 6", "4 4"),
        lines.replace("3 0 2 1\n", "3 0 2 1 255 0 0\n"),
        lines.replace("0 0 0\n1 0 0\n", "0 0 0 1 0 0\n").replace("3 0 2 1\n", "3 0 2 1 0.5 0 0\n"),
    ] {
        let found = mesh("a.off", text.as_bytes());
        assert_eq!((found.vertices(), found.triangles()), (right.vertices(), right.triangles()), "{text}");
    }
    let coloured = "COFF 3 1 0 0 0 0 255 0 0 255 1 0 0 0 255 0 255 0 1 0 0 0 255 128 3 0 1 2";
    assert_eq!(
        mesh("a.off", coloured.as_bytes()).attributes().colours().unwrap().rgba(2),
        Some([0, 0, 255, 128])
    );
    assert!(refused("a.off", lines.replace("3 2 0 3", "3 2 0 4").as_bytes()).starts_with("line 10"));
}

#[test]
fn text_without_statements_is_no_obj() {
    for text in [
        "this is a note, not a mesh\nsecond line\n",
        "version https://git-lfs.github.com/spec/v1\noid sha256:0000000000000000\nsize 12345\n",
        "o my, what a file\nnothing here\n",
        "<html>\n<body>\n",
    ] {
        let message = refused("a.obj", text.as_bytes());
        assert!(message.contains("no statement of an OBJ file") || message.contains("not read"), "{message}");
    }
    let upper = mesh("upper.obj", b"V 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n");
    assert_eq!((upper.vertices().len(), upper.triangles()), (3, [[0, 1, 2]].as_slice()));
    let odd = load("odd.obj", b"v 0 0 0\nfancy 1 2\nv 1 0 0\n").unwrap();
    assert!(odd.report.warnings.iter().any(|warning| warning.contains("first in line 2")), "{}", odd.report);
}

/// A scan of two columns and two rows at the pose given by a shift and a turn about z.
fn ptx(shift: [f64; 3], turn: [f64; 2], rows: &[&str]) -> String {
    let [c, s] = turn;
    let [x, y, z] = shift;
    format!(
        "2\n{}\n{x} {y} {z}\n{c} {s} 0\n{} {c} 0\n0 0 1\n{c} {s} 0 0\n{} {c} 0 0\n0 0 1 0\n{x} {y} {z} 1\n{}\n",
        rows.len() / 2,
        -s,
        -s,
        rows.join("\n")
    )
}

#[test]
fn ptx_scans_are_put_at_their_poses() {
    let first = ptx([10.0, 0.0, 0.0], [1.0, 0.0], &["1 2 3 0.5", "0 0 0 0.5", "4 5 6 0.25", "0 0 1 1"]);
    let second = ptx([0.0, 0.0, 100.0], [0.0, 1.0], &["1 2 3 0.75", "0 0 0 0"]);
    let loaded = load("a.txt", (first.clone() + &second).as_bytes()).unwrap();
    assert_eq!(loaded.report.format, Format::Ptx);
    assert!(
        loaded.report.warnings.iter().any(|warning| warning.starts_with("left out: 2 places")),
        "{}",
        loaded.report
    );
    let Content::Cloud(cloud) = loaded.content else { panic!() };
    let right = [[11.0, 2.0, 3.0], [14.0, 5.0, 6.0], [10.0, 0.0, 1.0], [-2.0, 1.0, 103.0]];
    assert_eq!(cloud.positions(), right.map(Point3::from));
    assert_eq!(cloud.attributes().scalar("intensity"), Some([0.5, 0.25, 1.0, 0.75].as_slice()));
    assert_eq!(cloud.attributes().scalar("scan"), Some([0.0, 0.0, 0.0, 1.0].as_slice()));
    let coloured = ptx([0.0; 3], [1.0, 0.0], &["1 2 3 0.5 10 20 30", "0 0 0 0.5 0 0 0"]);
    let Content::Cloud(cloud) = load("a.ptx", coloured.as_bytes()).unwrap().content else { panic!() };
    assert_eq!(cloud.attributes().colours().unwrap().rgba(0), Some([10, 20, 30, 255]));
    for (text, message) in [
        (first.replace("4 5 6 0.25\n0 0 1 1\n", ""), "line 11: 4 points are promised"),
        (first.replace("4 5 6 0.25", "4 5 0.25 1 2"), "line 13"),
        (first.replace("0 0 1 0\n", "0 0 1 1\n"), "line 9"),
        (first.replace("2\n2\n10", "2\n1000000000000\n10"), "promised"),
    ] {
        let found = refused("a.ptx", text.as_bytes());
        assert!(found.contains(message), "{found}");
    }
}
