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

/// Memory beyond this is out of proportion to the file: packed colours, one byte per number, compressed zeros.
const FACTOR: usize = 150;
const FLOOR: usize = 1 << 16;

/// xorshift64*: the same bytes are flipped in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
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
    let ways = formats.iter().map(|&format| options.with_format(format)).chain([options]);
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
    let small =
        fixtures("formats").into_iter().chain(json).filter(|path| path.metadata().unwrap().len() <= 16 << 10);
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
