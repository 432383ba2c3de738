//! Damaged files of scanners: an answer or an error, quickly, without a panic, without memory out of proportion, and without
//! half a file.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic")]

use std::time::{Duration, Instant};

use crate::common::fixture;
use crate::mutation::{Random, peak_of};
use pc_io::{Format, ReadOptions, WriteOptions, read_bytes};

/// What the models of the decoders take whatever the file; the rest is in proportion to it.
const FLOOR: usize = 24 << 20;
const FACTOR: usize = 1500;
/// Damaged files per kind.
const ROUNDS: usize = 600;

/// The checksum of the pages of E57 (CRC-32C), bit by bit.
fn checksum(data: &[u8]) -> u32 {
    !data.iter().fold(!0u32, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| (sum >> 1) ^ if sum & 1 == 1 { 0x82f6_3b78 } else { 0 })
    })
}

/// Puts the right checksums under the pages.
fn sealed(mut data: Vec<u8>) -> Vec<u8> {
    for page in data.chunks_exact_mut(1024) {
        let (content, sum) = page.split_at_mut(1020);
        sum.copy_from_slice(&checksum(content).to_be_bytes());
    }
    data
}

fn damaged(whole: &[u8], round: usize, is_e57: bool, random: &mut Random) -> Vec<u8> {
    let mut data = whole.to_vec();
    match round % 12 {
        0 => data.truncate(random.below(data.len())),
        1 => {
            let at = random.below(data.len());
            data.drain(at..(at + 1 + random.below(200)).min(whole.len()));
        }
        2 => data.extend((0..random.below(3000)).map(|at| whole[at % whole.len()])),
        _ => {
            for _ in 0..=random.below(6) {
                // What stands before the points does most; in E57 the description is at the end.
                let at = match round % 3 {
                    0 => random.below(data.len()),
                    1 if is_e57 => data.len() - 1 - random.below(5000.min(data.len())),
                    _ => random.below(data.len().min(700)),
                };
                data[at] = match random.below(4) {
                    0 => 0xff,
                    1 => 0,
                    2 if is_e57 => b'0' + random.below(10) as u8,
                    _ => random.below(256) as u8,
                };
            }
        }
    }
    if is_e57 && !round.is_multiple_of(5) { sealed(data) } else { data }
}

#[test]
fn checksums_are_those_of_the_files() {
    let whole = std::fs::read(fixture("formats/e57/two_scans.e57")).unwrap();
    assert_eq!(sealed(whole.clone()), whole);
}

#[test]
fn damage_ends_in_an_answer_or_an_error() {
    let start = Instant::now();
    let dir = tempfile::tempdir().unwrap();
    let mut answers = [0usize; 2];
    for (number, name) in (1u64..).zip([
        "las/las-rs/autzen.laz",
        "las/las-rs/autzen.copc.laz",
        "las/laspy/1_4_w_evlr.laz",
        "las/laspy/autzen_geo_proj.las",
        "las/laspy/unregistered_extra_bytes.las",
        "e57/two_scans.e57",
    ]) {
        let whole = std::fs::read(fixture(&format!("formats/{name}"))).unwrap();
        let hint = Format::from_path(name.as_ref());
        let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ number);
        for round in 0..ROUNDS {
            let data = damaged(&whole, round, hint == Some(Format::E57), &mut random);
            let began = Instant::now();
            let (result, peak) = peak_of(|| read_bytes(&data, hint, &ReadOptions::default()));
            let took = began.elapsed();
            assert!(took < Duration::from_secs(2), "{name}, round {round}: {took:?}");
            assert!(
                peak <= FLOOR + FACTOR * data.len(),
                "{name}, round {round}: {peak} bytes for {}",
                data.len()
            );
            answers[usize::from(result.is_ok())] += 1;
            match result {
                Err(error) => assert!(error.to_string().contains("; "), "{name}, round {round}: {error}"),
                // What was read can be written, or is refused without leaving anything.
                Ok(loaded) if round % 40 == 0 => {
                    let path = dir.path().join("out.laz");
                    let written = pc_io::write(&path, &loaded.content, &WriteOptions::default());
                    let files = std::fs::read_dir(dir.path()).unwrap().count();
                    assert_eq!(files, usize::from(written.is_ok()), "{name}, round {round}");
                    let _ = std::fs::remove_file(&path);
                }
                Ok(_) => {}
            }
        }
    }
    // Both happen, or the damage is of the wrong kind.
    assert!(answers[0] > 1000 && answers[1] > 300, "{answers:?}");
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}
