//! LAS, LAZ and E57: counts and coordinates against laspy 2.7 and pye57, ways there and back, choices of scans.

#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may panic")]

use crate::common::fixture;
use pc_io::mesh_core::nalgebra::Point3;
use pc_io::mesh_core::{Colours, PointCloud};
use pc_io::{Content, Format, Loaded, ReadOptions, read_bytes, read_cloud};

pub(crate) fn cloud(name: &str) -> Loaded<PointCloud> {
    read_cloud(fixture(&format!("formats/{name}")), &ReadOptions::default()).unwrap()
}

/// File, points, first point, middle point, sums of intensities and return numbers, all as laspy tells them.
type Reference = (&'static str, usize, [f64; 3], [f64; 3], f64, f64);

const REFERENCE: [Reference; 19] = [
    (
        "las/las-rs/32-1-472-150-76.laz",
        5658,
        [326451.79, 6724199.86, 170.1],
        [326404.72000000003, 6724179.21, 182.6],
        341864.0,
        8301.0,
    ),
    (
        "las/las-rs/autzen.copc.laz",
        107,
        [638433.0700000001, 849326.8, 425.51],
        [638773.02, 850471.56, 416.86],
        2454272.0,
        124.0,
    ),
    (
        "las/las-rs/autzen.las",
        106,
        [636083.3, 849398.65, 407.35],
        [637118.4400000001, 852409.84, 424.08],
        7510.0,
        128.0,
    ),
    (
        "las/las-rs/autzen.laz",
        106,
        [636083.3, 849398.65, 407.35],
        [637118.4400000001, 852409.84, 424.08],
        7510.0,
        128.0,
    ),
    (
        "las/las-rs/extrabytes.laz",
        1065,
        [637012.24, 849028.31, 431.66],
        [636817.75, 852041.27, 461.84000000000003],
        81361.0,
        1236.0,
    ),
    (
        "las/laspy/1_4_w_evlr.las",
        1000,
        [1694510.3869346841, 1816497.966263977, 5598.3596128149675],
        [1694349.7864932816, 1816494.9662393024, 5597.029578302081],
        38007.0,
        1030.0,
    ),
    (
        "las/laspy/1_4_w_evlr.laz",
        1000,
        [1694510.3869346841, 1816497.966263977, 5598.3596128149675],
        [1694349.7864932816, 1816494.9662393024, 5597.029578302081],
        38007.0,
        1030.0,
    ),
    (
        "las/laspy/autzen_geo_proj.las",
        106,
        [636083.3, 849398.65, 407.35],
        [637118.4400000001, 852409.84, 424.08],
        7510.0,
        128.0,
    ),
    (
        "las/laspy/extra.laz",
        1065,
        [637012.24, 849028.31, 431.66],
        [636817.75, 852041.27, 461.84000000000003],
        81361.0,
        1236.0,
    ),
    (
        "las/laspy/extrabytes.las",
        1065,
        [637012.24, 849028.31, 431.66],
        [636817.75, 852041.27, 461.84000000000003],
        81361.0,
        1236.0,
    ),
    (
        "las/laspy/plane.laz",
        28185,
        [1423216.76, 4189096.66, 67.87],
        [1423215.74, 4189098.27, 67.88],
        240588544.0,
        28185.0,
    ),
    (
        "las/laspy/simple.copc.laz",
        1065,
        [636145.6, 849170.4700000001, 428.15000000000003],
        [637342.85, 853240.3200000001, 423.92],
        81361.0,
        1236.0,
    ),
    (
        "las/laspy/simple.las",
        1065,
        [637012.24, 849028.31, 431.66],
        [636817.75, 852041.27, 461.84000000000003],
        81361.0,
        1236.0,
    ),
    (
        "las/laspy/simple.laz",
        1065,
        [637012.24, 849028.31, 431.66],
        [636817.75, 852041.27, 461.84000000000003],
        81361.0,
        1236.0,
    ),
    (
        "las/laspy/simple1_1.las",
        1065,
        [637012.24, 849028.31, 431.66],
        [636817.75, 852041.27, 461.84000000000003],
        81361.0,
        1236.0,
    ),
    (
        "las/laspy/simple1_3.las",
        999,
        [-234935.84100000001, 5800843.145, 265.094],
        [-235263.823, 5800911.155, 271.889],
        102386.0,
        999.0,
    ),
    (
        "las/laspy/test1_4.las",
        1000,
        [1694510.3869346841, 1816497.966263977, 5598.3596128149675],
        [1694349.7864932816, 1816494.9662393024, 5597.029578302081],
        38007.0,
        1030.0,
    ),
    ("las/laspy/unregistered_extra_bytes.las", 4, [1.0, 1.0, 1.0], [3.0, 3.0, 3.0], 0.0, 0.0),
    (
        "las/laspy/vegetation_1_3.las",
        10683,
        [-98449.688, -55970.553, -81458.594],
        [-98448.561, -55970.659, -81459.279],
        87645995.0,
        10683.0,
    ),
];

/// The fixtures that are read here.
pub(crate) fn known() -> Vec<String> {
    REFERENCE.iter().map(|(name, ..)| format!("formats/{name}")).chain([SCANS.to_owned()]).collect()
}

#[test]
fn las_and_laz_hold_what_laspy_reads() {
    for (name, points, first, middle, intensity, returns) in REFERENCE {
        let Loaded { content, report } = cloud(name);
        let expected = if name.ends_with("laz") { Format::Laz } else { Format::Las };
        assert_eq!((report.format, report.points), (expected, points), "{name}");
        // Bit for bit: the numbers are multiples of a scale, and nothing is taken away from them.
        assert_eq!(content.positions()[0], Point3::from(first), "{name}");
        assert_eq!(content.positions()[points / 2], Point3::from(middle), "{name}");
        let sum = |field: &str| content.attributes().scalar(field).map_or(0.0, |values| values.iter().sum());
        assert_eq!((sum("intensity"), sum("return_number")), (intensity, returns), "{name}");
    }
}

#[test]
fn las_keeps_colours_times_and_extra_bytes() {
    let simple = cloud("las/laspy/simple.las").content;
    let Some(Colours::Rgb(colours)) = simple.attributes().colours() else { panic!("simple.las has colours") };
    // laspy: (68, 77, 88), bytes in 16 bits, as many programs write them.
    assert_eq!(colours[0], [68, 77, 88]);
    assert_eq!(simple.attributes().scalar("gps_time").unwrap()[0], 245380.78254962614);
    let extra = cloud("las/laspy/extrabytes.las");
    let has = |name: &str| extra.content.attributes().scalar(name).is_some();
    for name in ["Colors_0", "Colors_1", "Colors_2", "Intensity", "Time", "intensity"] {
        assert!(
            has(name),
            "{name}: {:?}",
            extra.content.attributes().scalars().iter().map(|s| &s.name).collect::<Vec<_>>()
        );
    }
    let compressed = cloud("las/laspy/extra.laz").content;
    assert_eq!(compressed, extra.content);
    // Four bytes without a description; all of them are 0 in the file, and 7 in the last record here.
    let mut data = std::fs::read(fixture("formats/las/laspy/unregistered_extra_bytes.las")).unwrap();
    *data.last_mut().unwrap() = 7;
    let Content::Cloud(undescribed) = read_bytes(&data, None, &ReadOptions::default()).unwrap().content
    else {
        panic!("points");
    };
    assert_eq!(undescribed.attributes().scalar("extra_bytes_3"), Some([0.0, 0.0, 0.0, 7.0].as_slice()));
    assert_eq!(undescribed.attributes().scalar("extra_bytes_2"), None);
}

pub(crate) const SCANS: &str = "formats/e57/two_scans.e57";

#[test]
fn e57_moves_scans_by_their_poses() {
    // Written by pye57; the world coordinates by numpy from axis and angle, not from the quaternion.
    let Loaded { content, report } = read_cloud(fixture(SCANS), &ReadOptions::default()).unwrap();
    let expected = [
        (0, [10.021235580987511, 24.164410672654586, 4.256856918334961]),
        (17, [12.240488676409187, 16.079523870713366, 0.37631797790527344]),
        (59, [12.331764063205208, 23.128715230082676, -2.367950439453125]),
        (60, [-1.0059120475089003, 499999.0215209057, 4499995.13976324]),
        (77, [0.1064814685083526, 499998.93090542476, 4499996.831829153]),
        (119, [-6.140018219893799, 499997.0744395147, 4500000.691008357]),
    ];
    assert_eq!(content.len(), 120);
    for (index, point) in expected {
        assert!((content.positions()[index] - Point3::from(point)).amax() < 2e-9, "{index}");
    }
    assert_eq!(content.attributes().scalar("intensity").unwrap()[119], 2.0);
    let Some(Colours::Rgb(colours)) = content.attributes().colours() else { panic!("there are colours") };
    assert_eq!((colours[59], colours[119]), ([236, 0, 196], [236, 100, 196]));
    // The first scan has no rows and columns.
    let rows = content.attributes().scalar("row_index").unwrap();
    assert!(rows[0].is_nan() && rows[119] == 5.0);
    assert_eq!(content.attributes().scalar("scan").unwrap().iter().sum::<f64>(), 60.0);
    let names: Vec<_> = report.scans.iter().map(|scan| (scan.name.as_deref(), scan.points)).collect();
    assert_eq!(names, [(Some("front"), 60), (Some("rear side"), 60)]);
    let pose = report.scans[1].pose.unwrap();
    assert_eq!([pose[0][3], pose[1][3], pose[2][3]], [-4.25, 500000.125, 4500000.5]);
    assert!(report.warnings.iter().any(|warning| warning.contains("2 scans were put together")));
}

#[test]
fn one_scan_can_be_chosen() {
    let all = read_cloud(fixture(SCANS), &ReadOptions::default()).unwrap().content;
    for choice in ["rear side", "1"] {
        let options = ReadOptions::default().with_scan(Some(choice.to_owned()));
        let one = read_cloud(fixture(SCANS), &options).unwrap();
        assert_eq!(one.content.positions(), &all.positions()[60..], "{choice}");
        assert_eq!(one.report.scans.len(), 1);
    }
    for (file, choice, part) in [
        (SCANS, "left", "0 \"front\", 1 \"rear side\""),
        ("formats/las/las-rs/autzen.las", "0", "does not tell scans apart"),
    ] {
        let options = ReadOptions::default().with_scan(Some(choice.to_owned()));
        let error = read_cloud(fixture(file), &options).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    let head = |x: u8| {
        format!("1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n{x} 0 0 1\n1 2 3 0.5\n")
    };
    let ptx = [head(10), head(20)].concat();
    let read = |choice: &str| {
        read_bytes(ptx.as_bytes(), None, &ReadOptions::default().with_scan(Some(choice.to_owned())))
    };
    let Content::Cloud(second) = read("1").unwrap().content else { panic!("a cloud") };
    assert_eq!(second.positions(), [Point3::new(21.0, 2.0, 3.0)]);
    assert_eq!(read("all").unwrap().report.scans.len(), 2);
    assert!(read("2").unwrap_err().to_string().contains("the scans are: 0, 1"));
}

#[test]
fn bytes_and_files_read_alike() {
    for name in [SCANS, "formats/las/laspy/simple.laz"] {
        let whole = std::fs::read(fixture(name)).unwrap();
        let Content::Cloud(from_bytes) = read_bytes(&whole, None, &ReadOptions::default()).unwrap().content
        else {
            panic!("{name} is a cloud");
        };
        let options = ReadOptions::default();
        let from_file = read_cloud(fixture(name), &options).unwrap().content;
        assert_eq!(from_bytes.positions(), from_file.positions());
    }
}

#[test]
fn a_wrong_checksum_is_refused_with_its_page() {
    let mut data = std::fs::read(fixture(SCANS)).unwrap();
    data[2048 + 500] ^= 1;
    let error = read_bytes(&data, None, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("page 2") && error.contains("checksum"), "{error}");
}

#[test]
fn promises_that_do_not_fit_are_refused_at_once() {
    let las = std::fs::read(fixture("formats/las/laspy/simple.las")).unwrap();
    let laz = std::fs::read(fixture("formats/las/laspy/simple.laz")).unwrap();
    let extended = std::fs::read(fixture("formats/las/laspy/1_4_w_evlr.laz")).unwrap();
    let patched = |data: &[u8], at: usize, bytes: &[u8]| {
        let mut data = data.to_vec();
        data[at..at + bytes.len()].copy_from_slice(bytes);
        data
    };
    let start = u32::from_le_bytes(extended[96..100].try_into().unwrap()) as usize;
    for (what, data, part) in [
        ("points", patched(&las, 107, &u32::MAX.to_le_bytes()), "points are promised"),
        ("points of LAZ", patched(&laz, 107, &u32::MAX.to_le_bytes()), "are promised"),
        ("some more points of LAZ", patched(&laz, 107, &60_000u32.to_le_bytes()), "there are 1 chunks"),
        ("scale", patched(&las, 131, &0.0f64.to_le_bytes()), "multiples of 0"),
        ("version", patched(&las, 25, &[9]), "1.9"),
        ("offset", patched(&las, 96, &u32::MAX.to_le_bytes()), "begin at byte"),
        ("records", patched(&las, 100, &u32::MAX.to_le_bytes()), "does not fit"),
        (
            "extended record",
            patched(&extended, 235, &(extended.len() as u64 - 61).to_le_bytes()),
            "extended record",
        ),
        (
            "layer",
            patched(&extended, start + 8 + 30 + 4, &u32::MAX.to_le_bytes()),
            "bytes of a chunk of points",
        ),
        (
            "table",
            patched(
                &laz,
                u32::from_le_bytes(laz[96..100].try_into().unwrap()) as usize,
                &(laz.len() as u64 - 9).to_le_bytes(),
            ),
            "table of chunks",
        ),
    ] {
        let result = read_bytes(&data, None, &ReadOptions::default());
        let error = result.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(part), "{what}: {error:?}");
    }
}
