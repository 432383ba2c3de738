//! The lines of a file that is written.

use super::entities::{Entities, text};
use crate::Error;
use crate::iges::global::flag_of;
use crate::write::flat::unwritable;
use crate::write::number;
use brep_core::description::{LengthUnit, ModelDescription};

/// The time that the file bears: none, so that the same model gives the same bytes.
const TIME: &str = "19700101.000000";
/// Resolution of a file whose model states none, as a share of its largest coordinate.
const RESOLUTION: f64 = 1e-9;

/// Lines of 72 columns, filled value by value.
struct Lines {
    lines: Vec<Vec<u8>>,
    width: usize,
}

impl Lines {
    fn new(width: usize) -> Self {
        Self { lines: vec![Vec::new()], width }
    }

    /// Adds a value and its delimiter: numbers stay in one line, strings are broken where it ends.
    fn add(&mut self, value: &[u8], delimiter: u8) {
        let breaks = value.len() >= self.width || is_text(value);
        let mut rest = [value, &[delimiter]].concat();
        let room = |lines: &Vec<Vec<u8>>, width: usize| width - lines.last().map_or(0, Vec::len);
        if !breaks && room(&self.lines, self.width) < rest.len() {
            self.lines.push(Vec::new());
        }
        while !rest.is_empty() {
            if room(&self.lines, self.width) == 0 {
                self.lines.push(Vec::new());
            }
            let cut = room(&self.lines, self.width).min(rest.len());
            let tail = rest.split_off(cut);
            if let Some(line) = self.lines.last_mut() {
                line.extend(rest);
            }
            rest = tail;
        }
    }
}

fn is_text(value: &[u8]) -> bool {
    let digits = value.iter().take_while(|byte| byte.is_ascii_digit()).count();
    digits > 0 && value.get(digits) == Some(&b'H')
}

/// The whole file.
pub(super) fn file(model: &ModelDescription, entities: &Entities, largest: f64) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    let mut counts = [0; 4];
    let mut put = |letter: u8, text: &[u8]| {
        let section = b"SGDP".iter().position(|&known| known == letter).unwrap_or_default();
        counts[section] += 1;
        line(&mut out, text, letter, counts[section]);
    };
    put(b'S', b"Written by Industrial Geometry");
    for text in global(model, largest)?.lines {
        put(b'G', &text);
    }
    let records: Vec<Vec<Vec<u8>>> = entities.list().iter().map(|entity| record(&entity.values)).collect();
    let mut first = 1;
    for (entity, record) in entities.list().iter().zip(&records) {
        let status = entity.status.number();
        let upper = format!("{:8}{first:8}{:8}{:8}{:8}{:8}{:8}{:8}{status}", entity.kind, 0, 0, 0, 0, 0, 0);
        let lower = format!("{:8}{:8}{:8}{:8}{:8}", entity.kind, 0, 0, record.len(), entity.form);
        put(b'D', upper.as_bytes());
        put(b'D', lower.as_bytes());
        first += record.len();
    }
    for (number, record) in (1..).step_by(2).zip(&records) {
        for text in record {
            let padding = b" ".repeat(64 - text.len());
            put(b'P', &[text.as_slice(), &padding, format!("{number:8}").as_bytes()].concat());
        }
    }
    let [s, g, d, p] = counts;
    line(&mut out, format!("S{s:7}G{g:7}D{d:7}P{p:7}").as_bytes(), b'T', 1);
    if counts.iter().any(|&count| count > 9_999_999) {
        return Err(unwritable("model", "it takes more than 9999999 lines, which the format cannot count"));
    }
    Ok(out)
}

fn line(out: &mut Vec<u8>, text: &[u8], letter: u8, number: usize) {
    out.extend_from_slice(text);
    out.extend(std::iter::repeat_n(b' ', 72_usize.saturating_sub(text.len())));
    out.push(letter);
    out.extend(format!("{number:7}\n").into_bytes());
}

fn record(values: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let mut lines = Lines::new(64);
    let last = values.len().saturating_sub(1);
    for (i, value) in values.iter().enumerate() {
        lines.add(value, if i == last { b';' } else { b',' });
    }
    lines.lines
}

fn global(model: &ModelDescription, largest: f64) -> Result<Lines, Error> {
    let unit = model.unit.clone().unwrap_or_else(LengthUnit::millimetre);
    let Some((flag, unit_name)) = flag_of(&unit) else {
        let why = format!(
            "the format has no unit of {} m; convert it to mm, m, inch or another usual unit first",
            unit.metres
        );
        return Err(unwritable(&format!("unit \"{}\"", unit.name), why));
    };
    let real = |value: f64| number::real(value, 'D').into_bytes();
    let plain = |value: &str| value.as_bytes().to_vec();
    let resolution = model.uncertainty.filter(|value| *value > 0.0).unwrap_or(RESOLUTION * largest.max(1.0));
    let name = text(if model.name.trim().is_empty() { "model" } else { model.name.trim() });
    let values = [
        text(","),
        text(";"),
        name.clone(),
        name.clone(),
        text("Industrial Geometry"),
        text(env!("CARGO_PKG_VERSION")),
        plain("32"),
        plain("308"),
        plain("15"),
        plain("308"),
        plain("15"),
        name,
        plain("1."),
        plain(&flag.to_string()),
        text(unit_name),
        plain("1"),
        plain("0.01"),
        text(TIME),
        real(resolution),
        real(largest),
        Vec::new(),
        Vec::new(),
        plain("11"),
        plain("0"),
        text(TIME),
    ];
    let mut lines = Lines::new(72);
    let last = values.len() - 1;
    for (i, value) in values.iter().enumerate() {
        lines.add(value, if i == last { b';' } else { b',' });
    }
    Ok(lines)
}
