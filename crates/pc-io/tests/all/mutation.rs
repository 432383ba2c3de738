//! Damaged files: every fixture cut off and with flipped bytes must end in an answer or an error, quickly and without
//! memory out of proportion.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::{Duration, Instant};

use crate::common::{fixture, fixtures};
use pc_io::{Format, ReadOptions, read_bytes};

/// Counts what is allocated, so that a test can tell how much one reading took. It serves the whole binary and costs the other tests little.
struct Counting;

thread_local! {
    // Per thread, so that tests that run at the same time do not count for each other.
    static LIVE: Cell<usize> = const { Cell::new(0) };
    static PEAK: Cell<usize> = const { Cell::new(0) };
}

#[allow(
    unsafe_code,
    reason = "an allocator cannot be written without; it only counts and hands over to the system's"
)]
// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        LIVE.set(LIVE.get().wrapping_add(layout.size()));
        PEAK.set(PEAK.get().max(LIVE.get()));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        LIVE.set(LIVE.get().saturating_sub(layout.size()));
        // SAFETY: the caller's promises are passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What `work` gives, and the bytes it took at most at one time.
pub(crate) fn peak_of<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = LIVE.get();
    PEAK.set(before);
    let result = work();
    (result, PEAK.get().saturating_sub(before))
}

/// Memory beyond this is out of proportion to the file: packed colours, one byte per number, compressed zeros.
const FACTOR: usize = 150;
const FLOOR: usize = 1 << 16;

/// xorshift64*: the same bytes are flipped in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        usize::try_from(self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33).unwrap() % limit.max(1)
    }
}

/// Reads the bytes with and without a hint and as every format, and checks memory and time.
fn read_all_ways(name: &str, data: &[u8], formats: &[Format]) {
    let options = ReadOptions::default().with_drop_non_finite(true);
    let hint = Format::from_path(name.as_ref());
    let ways = formats.iter().map(|&format| options.clone().with_format(format)).chain([options.clone()]);
    for options in ways {
        PEAK.set(LIVE.get());
        let before = LIVE.get();
        let start = Instant::now();
        let result = read_bytes(data, hint, &options);
        let took = start.elapsed();
        let peak = PEAK.get().saturating_sub(before);
        assert!(peak <= FLOOR + FACTOR * data.len(), "{name}: {peak} bytes for {} ({options:?})", data.len());
        let allowed = Duration::from_secs(2) + Duration::from_micros(50 * data.len() as u64);
        assert!(took < allowed, "{name}: {took:?} for {} bytes ({options:?})", data.len());
        if let Ok(loaded) = result {
            assert!(loaded.report.points <= 64 * data.len() + 8, "{name}: {}", loaded.report);
        }
    }
}

#[test]
fn damaged_files_end_in_an_answer_or_an_error() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let json = [fixture("formats/json/model.json")];
    // Those of scanners have a test of their own.
    let small = fixtures("formats").into_iter().chain(json).filter(|path| {
        let is_of_scanner = Format::from_path(path).is_some_and(Format::is_of_scanner);
        !is_of_scanner && path.metadata().unwrap().len() <= 16 << 10
    });
    for path in small.chain([fixture("mesh/bunny_99.stl")]) {
        let name = path.to_string_lossy().into_owned();
        let whole = std::fs::read(&path).unwrap();
        let own: Vec<Format> = Format::from_path(&path).into_iter().collect();
        // Read as what it is not, too.
        read_all_ways(&name, &whole, &Format::ALL);
        // At every length where headers are, then here and there.
        let head = whole.len().min(1200);
        let parts = (0..24).map(|part| whole.len() * part / 24);
        for cut in (0..head).chain(parts).chain((1..9).map(|back| whole.len().saturating_sub(back))) {
            read_all_ways(&name, &whole[..cut], &own);
        }
        for round in 0..500 {
            let mut data = whole.clone();
            for _ in 0..=round % 4 {
                // The headers are where damage does most.
                let limit = if round % 3 == 0 { data.len() } else { data.len().min(400) };
                let at = random.below(limit);
                let value = random.below(256);
                match (data.get_mut(at), round % 5) {
                    (None, _) => {}
                    (Some(byte), 0) => *byte = b'9',
                    (Some(byte), 1) => *byte = 0xff,
                    (Some(byte), 2) => *byte = b' ',
                    (Some(byte), _) => *byte = u8::try_from(value).unwrap(),
                }
            }
            if round % 7 == 0 && !data.is_empty() {
                // Repeat a part, which makes numbers and lines longer.
                let (from, to) = (random.below(data.len()), random.below(data.len()));
                let part = data[from.min(to)..from.max(to)].to_vec();
                let at = random.below(data.len());
                data.splice(at..at, part);
            }
            read_all_ways(&name, &data, &own);
        }
    }
}

#[test]
fn huge_promises_fail_fast() {
    let lists = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty list uint double v\nproperty float x\nproperty float y\nend_header\n";
    let mut list = lists.as_bytes().to_vec();
    list.extend(u32::MAX.to_le_bytes());
    let mut stl = vec![0; 80];
    stl.extend(u32::MAX.to_le_bytes());
    let pcd = |encoding: &str, points: &str| {
        format!("VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {points}\nHEIGHT 1\nDATA {encoding}\n1 2 3\n12345")
            .into_bytes()
    };
    let ply = |encoding: &str, count: &str| {
        format!("ply\nformat {encoding} 1.0\nelement vertex {count}\nproperty double x\nproperty double y\nend_header\n1 2\n")
            .into_bytes()
    };
    let text = |text: &str| text.as_bytes().to_vec();
    let cases = [
        ("list.ply", list),
        ("a.ply", ply("ascii", "1000000000000")),
        ("b.ply", ply("binary_little_endian", "1000000000000")),
        ("c.ply", ply("binary_big_endian", "18446744073709551615")),
        (
            "d.ply",
            text(
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0\n1e18 0\n",
            ),
        ),
        ("a.stl", stl),
        ("a.pcd", pcd("ascii", "1000000000000")),
        ("b.pcd", pcd("binary", "1000000000000")),
        ("c.pcd", pcd("binary_compressed", "1000000000000")),
        (
            "d.pcd",
            text(
                "VERSION .7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1000000000 1000000000\nPOINTS 1\nDATA ascii\n1 2\n",
            ),
        ),
        ("a.off", text("OFF\n1000000000000 1000000000000 0\n0 0 0\n")),
        ("b.off", text("OFF\n1 1 0\n0 0 0\n4000000000 0 0 0\n")),
        ("a.obj", text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4000000000\n")),
        ("a.pts", text("1000000000000\n")),
    ];
    for (name, data) in cases {
        let start = Instant::now();
        let before = LIVE.get();
        PEAK.set(before);
        let result = read_bytes(&data, Format::from_path(name.as_ref()), &ReadOptions::default());
        assert!(result.is_err(), "{name}: {result:?}");
        assert!(start.elapsed() < Duration::from_secs(1), "{name}");
        assert!(PEAK.get() - before < FLOOR, "{name}");
    }
    // An element without properties takes no bytes, however often it is promised.
    let nothing = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nelement void 1000000000000\nend_header\n1 2\n";
    assert_eq!(read_bytes(nothing, None, &ReadOptions::default()).unwrap().report.points, 1);
}

/// A small file of every format and variant, so that damage meets all of its parts.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let text = |text: &str| text.as_bytes().to_vec();
    let cube = "v 0 0 0\nv 0 2 1\nv 2 0 1\nv 2 2 2\n";
    let mut stl = vec![b' '; 80];
    stl.extend(2u32.to_le_bytes());
    for value in [0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, -2.5e-16] {
        stl.extend(value.to_le_bytes());
    }
    stl.extend([0; 2]);
    let facet = stl[84..].to_vec();
    stl.extend(facet);
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty double y\nproperty uchar red\n\
        property uchar green\nproperty uchar blue\nproperty list uchar uchar name\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n";
    let mut binary_ply = text(ply);
    for name in ["P1", "second"] {
        binary_ply.extend(1.5f32.to_le_bytes());
        binary_ply.extend(2.5f64.to_le_bytes());
        binary_ply.extend([1, 2, 3, u8::try_from(name.len()).unwrap()]);
        binary_ply.extend(name.as_bytes());
    }
    binary_ply.push(3);
    [0u32, 1, 0].iter().for_each(|index| binary_ply.extend(index.to_le_bytes()));
    let scan = "2\n1\n0 0 9\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 9 1\n1 2 3 0.5 1 2 3\n0 0 0 0.5 0 0 0\n";
    vec![
        ("a.xyz", text("# x y z nx ny nz name\n1 2 3 0 0 1 \"P 1\" # seen\n4 5e-3 nan 0 1 0 P2\n")),
        ("b.xyz", text("P1 1.0 2.0 3.0 top left\nP2 2.0 3.0 4.0\n")),
        (
            "a.csv",
            text(
                "Export\nName;Rechtswert [m];Hochwert [m];H;Code\n-;m;m;m;-\nP1;1.234,5;-2,25;3,0;\"a;b\"\n;4;;6;x\n",
            ),
        ),
        ("b.csv", text("101,500000.12,4500000.50,12.10,TREE\n102,500001.12,4500000.50,12.20,POLE\n")),
        ("c.csv", text("x\ty\tz\tr\tg\tb\n1'234.5\t1,234.5\t3\t1\t2\t3\n4\t5\t#N/A\t9\t8\t7\n")),
        ("a.pts", text("2\n1 2 3 4 5 6 7\n8 9 10 11 12 13 14\n1\n1 2 3 4 5 6 7\n")),
        ("a.ptx", text(&[scan, scan].concat())),
        ("a.obj", text(&format!("{cube}vn 0 0 1\nvt 0 1\ng a b\nf 1/1/1 2//1 -1 \\\n 4\nf 1 2 3\n"))),
        (
            "b.obj",
            text(&format!(
                "{cube}cstype rat bspline\ndeg 1 1\nsurf 0 1 0 0.5 1 2 3 4\nparm u 0 0 1 1\nparm v 0 0 1 1\ntrim 0 1 1\n\
                end\ncstype bezier\ndeg 1\ncurv 0 3 1 2 3 4\nparm u 0 1 2 3\nend\n"
            )),
        ),
        ("a.stl", stl),
        (
            "b.stl",
            text(
                "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 -2.5e-16\nend loop\nendfacet\n\
                facet\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
            ),
        ),
        ("a.off", text("OFF 3 1 3 # all\n0 0 0 1 0 0\n0 1 0 3\n0 1 2\n")),
        (
            "b.off",
            text(
                "CNOFF\n3 1 3\n0 0 0 0 0 1 255 0 0\n1 0 0 0 0 1 0 255 0\n0 1 0 0 0 1 0 0 255\n3 0 1 2 9 9 9\n",
            ),
        ),
        (
            "a.ply",
            text(
                "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
            property list uchar uchar name\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n1 2 3 1 80\n4 5 6 0\n\
            7 8 9 2 80 81\n3 0 1 2\n",
            ),
        ),
        ("b.ply", binary_ply),
        (
            "a.pcd",
            text(
                "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n\
            VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2 3 4.2e-38\n5 6 7 8e-39\n",
            ),
        ),
        ("b.pcd", std::fs::read(fixture("formats/pcd/pcd-rs/demo_compressed.pcd")).unwrap()),
        ("c.pcd", std::fs::read(fixture("formats/pcd/pcd-rs/v06_binary.pcd")).unwrap()),
        ("a.json", std::fs::read(fixture("formats/json/model.json")).unwrap()),
        (
            "b.json",
            text(
                r#"{"shape": {"type": "surface", "count": 1, "data": [{"type": "spline", "rational": true, "degree_u": 1,
                "degree_v": 1, "knotvector_u": [0, 0, 1, 1], "knotvector_v": [0, 0, 1, 1], "size_u": 2, "size_v": 2,
                "control_points": {"points": [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 1]], "weights": [1, 2, 1, 1]},
                "trims": {"count": 0, "data": []}, "name": "a"}]}}"#,
            ),
        ),
    ]
}

/// Pieces of other numbers, separators and keywords that damage a text more than single bytes do.
const PIECES: [&[u8]; 26] = [
    b"nan",
    b"-",
    b"1e308",
    b"-1e-320",
    b"999999999999",
    b"0",
    b",",
    b";",
    b"\t",
    b"\"",
    b"\n",
    b"\r",
    b"\n\r",
    b"#",
    b" ",
    b"4294967295",
    b"\xff\xfe",
    b"\x00",
    b"P1",
    b"[",
    b"}",
    b"end",
    b"1,5",
    b"1.234,5",
    b"\xef\xbb\xbf",
    b"OFF",
];

/// `data` with up to four changes: bytes, pieces put in or over others, parts repeated, exchanged, cut out or off.
fn damaged(data: &[u8], random: &mut Random) -> Vec<u8> {
    let mut data = data.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(data.len());
        let other = (at + random.below(40)).min(data.len());
        let piece = PIECES[random.below(PIECES.len())];
        match random.below(8) {
            0 | 1 if at < data.len() => data[at] = u8::try_from(random.below(256)).unwrap(),
            2 => drop(data.splice(at..at, piece.iter().copied())),
            3 => drop(data.splice(at..other, piece.iter().copied())),
            4 => {
                let part = data[at..other].to_vec();
                let to = random.below(data.len());
                drop(data.splice(to..to, part));
            }
            5 => drop(data.drain(at..other)),
            6 => data.truncate(other),
            _ => {
                let mut words: Vec<&[u8]> = data.split(|&byte| byte == b' ').collect();
                let (one, other) = (random.below(words.len()), random.below(words.len()));
                words.swap(one, other);
                data = words.join(&b' ');
            }
        }
    }
    data
}

#[test]
fn two_thousand_damaged_files_of_every_variant_end_in_an_answer_or_an_error() {
    for (number, (name, whole)) in (1u64..).zip(seeds()) {
        let hint = Format::from_path(name.as_ref());
        let loaded = read_bytes(&whole, hint, &ReadOptions::default());
        assert!(loaded.is_ok(), "{name}: {}", loaded.unwrap_err());
        let mut random = Random(0x2545_f491_4f6c_dd1d ^ number);
        for round in 0..2000 {
            let data = damaged(&whole, &mut random);
            let options = if round % 2 == 0 {
                ReadOptions::default()
            } else {
                ReadOptions { format: hint, ..ReadOptions::default() }
            };
            let before = LIVE.get();
            PEAK.set(before);
            let start = Instant::now();
            let result = read_bytes(&data, hint, &options.with_decimal_comma(round % 3 == 0));
            let (took, peak) = (start.elapsed(), PEAK.get().saturating_sub(before));
            drop(result);
            assert!(took < Duration::from_secs(5), "{name}, round {round}: {took:?}");
            assert!(
                peak <= 20 * data.len() + (50 << 20),
                "{name}, round {round}: {peak} bytes for {}",
                data.len()
            );
            // Of files as small as these the bound above says little.
            assert!(
                peak <= FLOOR + FACTOR * data.len(),
                "{name}, round {round}: {peak} bytes for {}",
                data.len()
            );
        }
    }
}

#[test]
fn memory_is_in_proportion_to_large_files() {
    let rows = 60_000;
    let repeated = |head: &str, row: &str| [head, &row.repeat(rows)].concat().into_bytes();
    let mut stl = vec![b' '; 80];
    stl.extend(u32::try_from(rows).unwrap().to_le_bytes());
    for row in 0..rows {
        stl.extend([0; 12]);
        let x = row as f32;
        [x, 0.0, 0.0, x + 1.0, 0.0, 0.0, x, 1.0, 0.0]
            .iter()
            .for_each(|value| stl.extend(value.to_le_bytes()));
        stl.extend([0; 2]);
    }
    let scan = format!("{rows}\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    for (name, data) in [
        ("a.xyz", repeated("", "1 2 3\n")),
        ("b.xyz", repeated("", "P 1 2 3\n")),
        ("a.csv", repeated("name;x;y;z;code\n", "a;1,5;2;3;b\n")),
        ("a.ptx", repeated(&scan, "1 2 3 4\n")),
        ("a.obj", repeated("", "v 1 2 3\n")),
        ("a.stl", stl),
        ("a.off", repeated(&format!("OFF {rows} 0 0\n"), "1 2 3\n")),
    ] {
        let before = LIVE.get();
        PEAK.set(before);
        let result = read_bytes(&data, Format::from_path(name.as_ref()), &ReadOptions::default());
        let peak = PEAK.get().saturating_sub(before);
        assert!(result.is_ok(), "{name}: {}", result.unwrap_err());
        assert!(
            peak <= 20 * data.len(),
            "{name}: {peak} bytes for {}, {} times",
            data.len(),
            peak / data.len()
        );
    }
}
