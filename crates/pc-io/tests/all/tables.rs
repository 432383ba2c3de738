//! Tables as spreadsheets, total stations, scanners and measuring machines write them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use pc_io::mesh_core::{Attributes, PointCloud};
use pc_io::{Content, Error, Format, Loaded, ReadOptions, WriteOptions, read_bytes};

fn load(name: &str, data: &[u8]) -> Result<Loaded<Content>, Error> {
    read_bytes(data, Format::from_path(name.as_ref()), &ReadOptions::default())
}

fn cloud(name: &str, data: &[u8]) -> PointCloud {
    match load(name, data)
        .unwrap_or_else(|error| panic!("{:?}: {error}", String::from_utf8_lossy(data)))
        .content
    {
        Content::Cloud(cloud) => cloud,
        other => panic!("{}", other.describe()),
    }
}

fn points(name: &str, data: &[u8]) -> Vec<[f64; 3]> {
    cloud(name, data).positions().iter().map(|&point| point.into()).collect()
}

fn names(attributes: &Attributes) -> Vec<&str> {
    attributes.names().map(|names| names.iter().collect()).unwrap_or_default()
}

fn refused(name: &str, data: &[u8]) -> String {
    load(name, data).map(|loaded| panic!("{}", loaded.report)).unwrap_err().to_string()
}

#[test]
fn decimal_commas_are_read_where_nothing_else_can_be_meant() {
    let right = [[1.5, 2.25, 3.0], [2.5, 3.25, -4.125]];
    for (name, text) in [
        ("header.csv", "x;y;z\n1,5;2,25;3,0\n2,5;3,25;-4,125\n"),
        ("plain.csv", "1,5;2,25;3,0\n2,5;3,25;-4,125\n"),
        ("tabs.txt", "x\ty\tz\n1,5\t2,25\t3,0\n2,5\t3,25\t-4,125\n"),
        ("bars.txt", "1,5 | 2,25 | 3,0\r\n2,5 | 3,25 | -4,125\r\n"),
        ("quoted.csv", "\"x\",\"y\",\"z\"\r\"1,5\",\"2,25\",\"3,0\"\r\"2,5\",\"3,25\",\"-4,125\"\r"),
        ("spaced.csv", "x ; y ; z ;\n1,5 ; 2,25 ; 3,0 ;\n2,5 ; 3,25 ; -4,125 ;\n"),
        ("exponent.csv", "1,5E0;2,25;30e-1\n0,25e1;3,25;-4,125\n"),
    ] {
        assert_eq!(points(name, text.as_bytes()), right, "{name}");
    }
    let mixed = cloud("mixed.csv", b"name;x;y;z\nP1;1,5;2;3\nP2;2,5;3,25;-4\n");
    assert_eq!(
        mixed.positions().iter().map(|&p| p.into()).collect::<Vec<[f64; 3]>>(),
        [[1.5, 2.0, 3.0], [2.5, 3.25, -4.0]]
    );
    assert_eq!(names(mixed.attributes()), ["P1", "P2"]);
    // A comma far down, behind lines without any.
    let mut text = "1;2;3\n".repeat(1000);
    text.push_str("1,5;2;3\n");
    assert_eq!(points("late.csv", text.as_bytes())[1000], [1.5, 2.0, 3.0]);
}

#[test]
fn signs_between_thousands_are_no_decimals() {
    let right = [[500_000.12, 4_500_000.5, 1234.0], [500_001.25, 4_500_000.0, 12.25]];
    for (name, text) in [
        ("german.csv", "500.000,12;4.500.000,50;1.234\n500.001,25;4.500.000;12,25\n"),
        ("english.csv", "500,000.12;4,500,000.50;1,234\n500,001.25;4,500,000;12.25\n"),
        ("quoted.csv", "\"500,000.12\",\"4,500,000.50\",\"1,234\"\n\"500,001.25\",\"4,500,000\",12.25\n"),
        ("french.csv", "500 000,12;4 500 000,50;1 234\n500 001,25;4 500 000;12,25\n"),
        ("narrow.csv", "500\u{202f}000,12;4\u{a0}500\u{a0}000,50;1234\n500001,25;4500000;12,25\n"),
        ("swiss.csv", "500'000.12;4'500'000.50;1'234\n500'001.25;4'500'000;12.25\n"),
        ("blanks.txt", "500,000.12 4,500,000.50 1,234\n500,001.25 4,500,000 12.25\n"),
    ] {
        assert_eq!(points(name, text.as_bytes()), right, "{name}");
    }
    for (name, text, line) in [
        // 2.125 may be 2125, and 1,234 may be 1234.
        ("a.csv", "1,5;2.25;3\n", "line 1"),
        ("b.csv", "1;2;3\n1,5;2.125;3\n", "line 2"),
        ("c.csv", "\"1,234\",\"2,345\",\"3,456\"\n", "line 1"),
        ("d.xyz", "1,5 2,25 3,0\n", "line 1"),
    ] {
        let message = refused(name, text.as_bytes());
        assert!(message.starts_with(line) && message.contains("comma"), "{name}: {message}");
    }
    let options = ReadOptions::default().with_decimal_comma(true);
    for text in ["1,5 2,25 3,0\n2,5 3,25 -4,125\n", "1,234 2,345 3,456\n"] {
        let loaded = read_bytes(text.as_bytes(), Some(Format::Xyz), &options).unwrap();
        let Content::Cloud(cloud) = loaded.content else { panic!() };
        assert!(cloud.positions()[0].x < 2.0 && cloud.dimension() == 3, "{text}");
    }
    let open = load("open.csv", b"1,234;2,345;3,456\n").unwrap();
    assert!(open.report.warnings.iter().any(|warning| warning.contains("decimal commas")), "{}", open.report);
}

#[test]
fn names_of_points_are_kept() {
    let two = [[1.0, 2.0, 3.0], [2.0, 3.0, 4.0]];
    for (name, text, right) in [
        ("names.txt", "P1 1.0 2.0 3.0\nP2 2.0 3.0 4.0\n", ["P1", "P2"]),
        ("named.csv", "name,x,y,z\nbore 1,1,2,3\nbore 2,2,3,4\n", ["bore 1", "bore 2"]),
        ("comma.csv", "x,y,z,name\n1,2,3,\"bore 1, left\"\n2,3,4,bore 2\n", ["bore 1, left", "bore 2"]),
        ("quote.csv", "Point ID;X [mm];Y [mm];Z [mm]\n\"3\"\" pipe\";1;2;3\n;2;3;4\n", ["3\" pipe", ""]),
        ("altair.csv", "x,y,z,ID,label\n1,2,3,7,a\n2,3,4,8,b\n", ["a", "b"]),
        ("numbers.csv", "Nr;x;y;z\n007;1;2;3\n008;2;3;4\n", ["007", "008"]),
        ("before.csv", "Bohrung;x;y;z;rest\nlinks;1;2;3;u\nrechts;2;3;4;v\n", ["links", "rechts"]),
        ("last.txt", "1.0 2.0 3.0 top left corner\n2.0 3.0 4.0 P#2 # seen\n", ["top left corner", "P#2"]),
        ("latin.csv", "Punkt;x;y;z\nH\u{f6}he;1;2;3\nTief;2;3;4\n", ["H\u{f6}he", "Tief"]),
        ("mixed.csv", "label,x,y,z\n101,1,2,3\nA2,2,3,4\n", ["101", "A2"]),
    ] {
        let found = cloud(name, text.as_bytes());
        assert_eq!(found.positions().iter().map(|&p| p.into()).collect::<Vec<[f64; 3]>>(), two, "{name}");
        assert_eq!(names(found.attributes()), right, "{name}");
    }
    // The bytes of Western Windows.
    let windows = cloud("windows.csv", b"Punkt;x;y;z\nH\xf6he;1;2;3\n\x80;2;3;4\n");
    assert_eq!(names(windows.attributes()), ["Höhe", "€"]);
    // A text that turns up behind numbers alone.
    let mut late = "name,x,y,z,code\n".to_owned();
    (0..500).for_each(|i| late.push_str(&format!("{i},{i},1,2,{i}\n")));
    late.push_str("last,1,2,3,4\n");
    assert_eq!(names(cloud("late.csv", late.as_bytes()).attributes())[500], "last");
}

#[test]
fn lists_of_surveyors_keep_numbers_apart_from_coordinates() {
    let right = [[500_000.12, 4_500_000.5, 12.1], [500_001.12, 4_500_000.5, 12.2]];
    for (name, text) in [
        ("survey.csv", "101,500000.12,4500000.50,12.10,TREE\n102,500001.12,4500000.50,12.20,POLE\n"),
        ("bare.csv", "101,500000.12,4500000.50,12.10\n102,500001.12,4500000.50,12.20\n"),
        ("bare.txt", "101 500000.12 4500000.50 12.10\n102 500001.12 4500000.50 12.20\n"),
        ("german.csv", "101;500000,12;4500000,50;12,10;Baum\n102;500001,12;4500000,50;12,20;\n"),
        ("words.txt", "101 500000.12 4500000.50 12.10 OLD TREE\n102 500001.12 4500000.50 12.20\n"),
        (
            "header.csv",
            "Point,Northing (m),Easting (m),Elev.,Desc\n101,4500000.50,500000.12,12.10,TREE\n102,4500000.50,500001.12,12.20,POLE\n",
        ),
        (
            "letters.csv",
            "P,E,N,H,Code\n101,500000.12,4500000.50,12.10,TREE\n102,500001.12,4500000.50,12.20,POLE\n",
        ),
        (
            "gauss.txt",
            "Nr\tRechtswert\tHochwert\tHöhe\n101\t500000,12\t4500000,50\t12,10\n102\t500001,12\t4500000,50\t12,20\n",
        ),
    ] {
        let found = cloud(name, text.as_bytes());
        assert_eq!(found.positions().iter().map(|&p| p.into()).collect::<Vec<[f64; 3]>>(), right, "{name}");
        if name != "letters.csv" {
            assert_eq!(names(found.attributes()), ["101", "102"], "{name}");
        }
    }
    let text = cloud("survey.csv", b"101,1.5,2.5,3.5,TREE\n102,1.5,2.5,3.5,POLE\n");
    assert_eq!(text.attributes().texts()[0].iter().collect::<Vec<_>>(), ["TREE", "POLE"]);
    // Coordinates and an intensity stay what they are.
    for text in
        ["1 2.5 3.5 4\n2 2.5 3.5 5\n", "1.0 2.5 3.5 4.5\n2.0 2.5 3.5 5.5\n", "7 2.5 3.5 4.5\n7 2.5 3.5 5.5\n"]
    {
        let found = cloud("scan.xyz", text.as_bytes());
        assert!(
            found.attributes().scalar("intensity").is_some() && found.attributes().names().is_none(),
            "{text}"
        );
    }
}

#[test]
fn oddities_of_tables_are_passed_over() {
    let right = [[1.0, 2.0, 3.0], [2.0, 3.0, 4.0]];
    for (name, text) in [
        ("units.csv", "x;y;z\nmm;mm;mm\n1;2;3\n2;3;4\n"),
        ("units.txt", "# exported\nName X Y Z\n- [mm] [mm] [mm]\na 1 2 3\nb 2 3 4\n"),
        ("types.csv", "x,y,z\nfloat,float,float\n1,2,3\n2,3,4\n"),
        ("rule.txt", "x   y   z\n--- --- ---\n1 2 3\n2 3 4\n"),
        ("comment.xyz", "1 2 3 # first\n2 3 4 // second\n"),
        ("percent.txt", "% of a program\n1 2 3 % first\n! and\n2 3 4\n"),
        ("comment.csv", "x,y,z // names\n1,2,3 # one, two\n2,3,4\n"),
        (
            "preamble.csv",
            "Export of 2024-05-06\r\nOperator: Müller; Meier\r\n\r\nx;y;z\r\n1;2;3\r\n2;3;4\r\n",
        ),
        ("brackets.csv", "x[mm],y[mm],z[mm]\n1,2,3\n2,3,4\n"),
        ("coordinates.csv", "X-Koordinate;Y-Koordinate;Z-Koordinate\n1;2;3\n2;3;4\n"),
        ("slash.csv", "X/mm;Y/mm;Z/mm\n1;2;3\n2;3;4\n"),
        ("trailing.csv", "x,y,z,,\n1,2,3,,\n2,3,4,,\n"),
        ("trailing.xyz", "1;2;3;\n2;3;4;\n"),
        ("double.txt", "1\t\t2\t\t3\n2\t\t3\t\t4\n"),
        ("aligned.txt", "1\t\t2\t3\n2.000000\t3\t4\n"),
        ("bom.csv", "\u{feff}x,y,z\n1,2,3\n2,3,4\n"),
        ("cloudcompare.txt", "//X Y Z\n1.00000000 2.00000000 3.00000000\n2.00000000 3.00000000 4.00000000\n"),
    ] {
        assert_eq!(points(name, text.as_bytes()), right, "{name}");
    }
    // UTF-16 of both orders, with and without a mark.
    let wide = |order: fn(u16) -> [u8; 2], mark: bool| -> Vec<u8> {
        let mark = mark.then_some(0xfeff);
        mark.into_iter()
            .chain("x\ty\tz\r\n1,0\t2,0\t3,0\r\n2,0\t3,0\t4,0\r\n".encode_utf16())
            .flat_map(order)
            .collect()
    };
    for mark in [true, false] {
        assert_eq!(points("a.txt", &wide(u16::to_le_bytes, mark)), right);
        assert_eq!(points("a.txt", &wide(u16::to_be_bytes, mark)), right);
    }
}

#[test]
fn empty_cells_are_nan_and_told() {
    for (name, text) in [
        ("tabs.tsv", "x\ty\tz\n1\t\t3\n1\t2\t3\n"),
        ("commas.csv", "x,y,z\n1,,3\n1,2,3\n"),
        ("error.csv", "x;y;z\n1;#N/A;3\n1;2;3\n"),
        ("words.csv", "x;y;z\n1;-;3\n1;2;3\n"),
        ("blanks.csv", "x;y;z\n1; ;3\n1;2;3\n"),
    ] {
        let loaded = load(name, text.as_bytes()).unwrap();
        assert_eq!((loaded.report.points, loaded.report.non_finite), (2, 1), "{name}");
        assert!(
            loaded.report.warnings.iter().any(|warning| warning.contains("1 empty")),
            "{}",
            loaded.report
        );
    }
}

#[test]
fn broken_lines_are_errors_with_their_line() {
    for (name, text, message) in [
        ("a.xyz", "1 2 3\n1 2 abc\n", "line 2: \"abc\" is not a number"),
        ("b.xyz", "1 2 abc\n", "\"1 2 abc\""),
        ("c.csv", "x,y,z\n1,2,3\n1,2\n", "line 3: \"1,2\" has 2 columns where 3 are expected"),
        ("d.csv", "x,y,z,intensity\n1,2,3,4\n1,2,3,5\n1,2,3,bad\n", "line 4: \"bad\" is not a number"),
        ("e.csv", "x;y;z\nmm;m;mm\n1;2;3\n", "line 2: \"mm\" is not a number"),
        ("f.csv", "a;b;c\n1;2;3\n", "line 1: \"a;b;c\" holds neither numbers nor names"),
        ("g.csv", "x,y,z\n1,\"2,3\n1,2,3\n", "line 2"),
        ("h.csv", "name,x,y,z\nP1,1,2,3\nP2,1,two,3\n", "line 3: \"two\" is not a number"),
        ("i.xyz", "1 2 3\n1 2 3 4\n", "line 2"),
        ("j.csv", "E,N,north\n1,2,3\n", "neither numbers nor names"),
    ] {
        let found = refused(name, text.as_bytes());
        assert!(found.contains(message), "{name}: {found}");
    }
}

#[test]
fn names_survive_where_a_format_can_hold_them() {
    let text =
        "name;x;y;z;intensity;code\n\"a;b\";1;2;3;5;\n;2;3;4;6;two words\n\"q\"\"q\";0,5;1e-3;-2;7;x#y\n";
    let scan = cloud("scan.csv", text.as_bytes());
    let right = (vec!["a;b", "", "q\"q"], vec!["", "two words", "x#y"]);
    let dir = tempfile::tempdir().unwrap();
    for (name, ascii) in [("a.csv", false), ("a.xyz", false), ("a.ply", false), ("b.ply", true)] {
        let path = dir.path().join(name);
        let written = pc_io::write_cloud(&path, &scan, &WriteOptions::default().with_ascii(ascii)).unwrap();
        assert_eq!(written.warnings, [""; 0], "{name}");
        let read = pc_io::read_cloud(&path, &ReadOptions::default()).unwrap().content;
        assert_eq!(read.positions(), scan.positions(), "{name}");
        let texts = read.attributes().texts();
        assert_eq!((names(read.attributes()), texts[0].iter().collect()), right, "{name}");
        assert_eq!(read.attributes().scalar("intensity"), Some([5.0, 6.0, 7.0].as_slice()));
    }
    for name in ["a.pcd", "a.pts", "a.obj", "a.off"] {
        let written = pc_io::write_cloud(dir.path().join(name), &scan, &WriteOptions::default()).unwrap();
        assert!(
            written.warnings.iter().any(|warning| warning.contains("names of the points")),
            "{name}: {written}"
        );
    }
    // Points that are dropped take their names with them.
    let options = ReadOptions::default().with_drop_non_finite(true);
    let loaded = read_bytes(b"name,x,y,z\na,1,2,3\nb,nan,2,3\nc,1,2,4\n", None, &options).unwrap();
    let Content::Cloud(cloud) = loaded.content else { panic!() };
    assert_eq!(names(cloud.attributes()), ["a", "c"]);
}
