//! Damaged files end in an answer or an error, soon.

use crate::iges_builder::everything;
use crate::iges_files::fixture;
use brep_core::Model;
use nalgebra::Vector3;
use std::time::{Duration, Instant};

/// Longest time for one file.
const LONGEST: Duration = Duration::from_secs(5);

/// A small generator of numbers that are the same everywhere.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).unwrap() % end.max(1)
    }
}

fn mutated(data: &[u8], seed: u64) -> Vec<u8> {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1);
    let mut data = data.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(data.len());
        let length = random.below(200).min(data.len() - at);
        match random.below(24) {
            0 => data[at] = u8::try_from(random.below(256)).unwrap(),
            1 => data[at] = b"0123456789,;.-+EDH \n"[random.below(20)],
            2 => drop(data.drain(at..at + length)),
            3 => {
                let piece = data[at..at + length].to_vec();
                let to = random.below(data.len());
                data.splice(to..to, piece);
            }
            4 => data.truncate(at.max(1)),
            5..=12 => {
                // Digits of a whole line: sequence numbers and sections stay.
                let start = at / 81 * 81;
                for byte in data.iter_mut().skip(start).take(64).filter(|byte| byte.is_ascii_digit()) {
                    *byte = b'0' + u8::try_from(random.below(10)).unwrap();
                }
            }
            13 => {
                let other = random.below(data.len());
                data.swap(at, other);
            }
            14..=19 => {
                // One character of a record: sections and sequence numbers stay.
                let at = at / 81 * 81 + random.below(64);
                if let Some(byte) = data.get_mut(at) {
                    *byte = b"0123456789,;.-+EDH "[random.below(19)];
                }
            }
            _ => {
                // Two lines change places.
                let (a, b) = (at / 81 * 81, random.below(data.len()) / 81 * 81);
                if a + 64 <= data.len() && b + 64 <= data.len() {
                    (0..64).for_each(|k| data.swap(a + k, b + k));
                }
            }
        }
    }
    data
}

fn run(data: &[u8], seeds: std::ops::Range<u64>) -> [usize; 2] {
    let mut counts = [0; 2];
    for seed in seeds {
        let data = mutated(data, seed);
        let read = || {
            let clock = Instant::now();
            let found = cad_io::read_iges(&data);
            // What was read becomes a model that answers, or is refused.
            if let Ok(built) = found.as_ref().map_err(drop).and_then(|found| Model::new(found).map_err(drop))
            {
                let _ = built.nearest(&Vector3::new(1.0, 2.0, 3.0));
                let _ = built.nearest_on_line(
                    &Vector3::new(1.0, 2.0, 3.0),
                    &Vector3::new(0.3, 0.5, 1.0),
                    1e3,
                    None,
                );
            }
            (found, clock.elapsed())
        };
        let (found, mut time) = read();
        if time > LONGEST {
            // A machine that is busy with other things is no fault of the reader.
            time = read().1.min(read().1);
        }
        assert!(time < LONGEST, "seed {seed} took {time:?}");
        if let Ok(model) = &found {
            // What was read can be written, or refused.
            let written = cad_io::to_iges(model);
            let _ = cad_io::to_step(model);
            if let Ok(written) = written {
                cad_io::read_iges(&written).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            }
        }
        counts[usize::from(found.is_ok())] += 1;
    }
    counts
}

#[test]
fn two_thousand_damaged_files() {
    let [refused, read] = run(everything().as_bytes(), 0..2000);
    assert!(refused > 100 && read > 100, "{refused} refused, {read} read");
}

#[test]
fn damaged_files_of_another_program() {
    let [refused, read] = run(&fixture("example-arcs.iges"), 0..500);
    assert!(refused > 50 && read > 50, "{refused} refused, {read} read");
    run(&fixture("impeller.igs"), 0..4);
}
