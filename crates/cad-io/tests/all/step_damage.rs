//! Damaged STEP files end in errors or in models, never in a panic, and quickly.

use crate::step::fixture;
use brep_core::Model;
use cad_io::{Error, read_step};
use nalgebra::Vector3;
use std::time::{Duration, Instant};

/// Pieces that mutations put into the text.
const PIECES: [&str; 14] = [
    "NaN",
    "1E308",
    "-1E-308",
    "$",
    "*",
    "()",
    "#1",
    "#999999",
    "0.",
    ".F.",
    ";",
    "'",
    "ADVANCED_FACE",
    "1.0E+400",
];

pub(crate) fn mutate(text: &[u8], seed: u64) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 16) as usize % below.max(1)
    };
    let mut out = text.to_vec();
    for _ in 0..1 + next(4) {
        let at = next(out.len());
        let to = (at + next(60)).min(out.len());
        match next(6) {
            0 => drop(out.drain(at..to)),
            1 => {
                out.splice(at..to.min(at + 6), PIECES[next(PIECES.len())].bytes());
            }
            2 => out[at] = b"0123456789.-#,()'ETF"[next(20)],
            3 => {
                let piece = out[at..to].to_vec();
                let place = next(out.len());
                out.splice(place..place, piece);
            }
            4 => out.truncate(at.max(out.len() / 2)),
            _ => out[at] = u8::try_from(next(256)).unwrap(),
        }
    }
    out
}

fn run(name: &str, seeds: std::ops::Range<u64>) {
    let text = std::fs::read(fixture(name)).unwrap();
    for seed in seeds {
        let damaged = mutate(&text, seed);
        let start = Instant::now();
        if let Ok(description) = read_step(&damaged)
            && let Ok(model) = Model::new(&description)
        {
            let _ = model.nearest(&Vector3::new(1.0, 2.0, 3.0));
        }
        assert!(start.elapsed() < Duration::from_secs(5), "{name}, seed {seed}");
    }
}

#[test]
fn two_thousand_damaged_files() {
    run("00000050_80d90bfdd2e74e709956122a_step_000.step", 0..1000);
    run("nema-17-bracket.step", 1000..2000);
}

#[test]
fn errors_name_line_or_entity() {
    let text = std::fs::read(fixture("nema-17-bracket.step")).unwrap();
    let cut = &text[..text.len() / 2];
    let error = read_step(cut).unwrap_err();
    assert!(matches!(error, Error::Malformed { .. }), "{error}");
    for (bytes, wanted) in [
        (&b""[..], "does not begin with ISO-10303-21"),
        (b"solid cube", "does not begin with ISO-10303-21"),
        (b"ISO-10303-21;\nHEADER;\n(((", "line"),
    ] {
        let message = read_step(bytes).unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
    }
    // What is named and not there is told with who names it, and where.
    let broken = String::from_utf8_lossy(&text).replace("#1086,#1163", "#999999,#1163");
    let message = read_step(broken.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("#1085 (ADVANCED_FACE): it names #999999"), "{message}");
    assert!(message.contains("(line 1290)"), "{message}");
    let missing = cad_io::read_step_file("no/such/file.step".as_ref()).unwrap_err().to_string();
    assert!(missing.contains("no/such/file.step"), "{missing}");
}
