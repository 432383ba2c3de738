//! PTX files that are read piece by piece.

use std::fs::File;
use std::io::{self, Seek, SeekFrom};

use nalgebra::Point3;

use crate::ReadOptions;
use crate::pieces::{Piece, Taker};
use crate::ptx::{Head, left_out, not_rigid, numbers};
use crate::scans::{Scan, chosen};
use crate::source::Source;
use crate::text_lines::TextLines;

/// Lines of a head: two counts and a pose.
const HEAD_LINES: usize = 10;

/// A PTX file that can be read piece by piece.
#[derive(Debug)]
pub(crate) struct Grids {
    pub(crate) warnings: Vec<String>,
    pub(crate) scans: Vec<Scan>,
}

/// What a way through a file tells.
#[derive(Debug, Default)]
struct Survey {
    warnings: Vec<String>,
    scans: Vec<Scan>,
    /// Places without a point in the chosen scans.
    missing: usize,
    /// Scans in the file.
    count: u32,
}

impl Grids {
    /// Looks through a file; `None` where anything is wrong, which is said when it is read as a whole.
    pub(crate) fn survey(file: &File, options: &ReadOptions) -> io::Result<Option<Self>> {
        let Some(mut found) = visit(file, options, &mut |_| true)? else { return Ok(None) };
        let choice = options.scan.as_deref();
        if chosen(choice, &vec![None; found.count as usize]).is_err() {
            return Ok(None);
        }
        if found.missing > 0 {
            found.warnings.push(left_out(found.missing));
        }
        Ok(Some(Self { warnings: found.warnings, scans: found.scans }))
    }

    /// Hands the points over.
    pub(crate) fn read<E>(
        &self,
        file: &File,
        options: &ReadOptions,
        limit: usize,
        taker: &mut Taker<'_, E>,
    ) -> io::Result<()> {
        let mut piece = Piece::default();
        let mut goes_on = true;
        let found = visit(file, options, &mut |point| {
            piece.positions.push(point);
            if piece.positions.len() == limit {
                goes_on = taker.give(std::mem::take(&mut piece));
            }
            goes_on
        })?;
        if goes_on && found.is_none_or(|found| found.scans != self.scans) {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "the file has changed while it was read"));
        }
        if goes_on && !piece.positions.is_empty() {
            taker.give(piece);
        }
        Ok(())
    }
}

/// Visits the points of the chosen scans until `take` says that it is enough; `None` where anything is wrong.
fn visit(
    file: &File,
    options: &ReadOptions,
    take: &mut dyn FnMut(Point3<f64>) -> bool,
) -> io::Result<Option<Survey>> {
    let choice = options.scan.as_deref();
    let wanted = choice.and_then(|choice| choice.parse::<u32>().ok());
    let mut file = file.try_clone()?;
    file.seek(SeekFrom::Start(0))?;
    let mut lines = TextLines::new(file);
    let mut next = || match lines.next() {
        Ok(line) => Ok(line.map(<[u8]>::to_vec)),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => Ok(None),
        Err(error) => Err(error),
    };
    let mut found = Survey::default();
    let (mut line_number, mut width) = (0usize, None);
    loop {
        let Some(line) = next()? else { return Ok(Some(found)) };
        line_number += 1;
        if line.trim_ascii().is_empty() {
            continue;
        }
        let at = line_number;
        let mut text = line;
        for _ in 1..HEAD_LINES {
            let Some(line) = next()? else { return Ok(None) };
            line_number += 1;
            text.push(b'\n');
            text.extend(line);
        }
        let source = Source { data: &text };
        let mut rest = source.lines_from(0);
        let Some(first) = rest.next() else { return Ok(None) };
        let Ok(head) = Head::read(source, first, &mut rest) else { return Ok(None) };
        if !head.is_rigid() {
            found.warnings.push(not_rigid(found.count, at));
        }
        let is_wanted = wanted.is_none_or(|wanted| wanted == found.count);
        let (mut points, mut missing) = (0, 0);
        for _ in 0..head.count {
            let Some(line) = next()? else { return Ok(None) };
            line_number += 1;
            let Some(numbers) = numbers(&line).filter(|numbers| {
                matches!(numbers.len(), 3 | 4 | 7) && *width.get_or_insert(numbers.len()) == numbers.len()
            }) else {
                return Ok(None);
            };
            if numbers[..3].iter().all(|&value| value == 0.0) {
                missing += 1;
                continue;
            }
            if numbers.iter().skip(4).any(|value| !(0.0..=255.0).contains(value)) {
                return Ok(None);
            }
            points += 1;
            if is_wanted && !take(head.place([numbers[0], numbers[1], numbers[2]])) {
                return Ok(Some(found));
            }
        }
        if is_wanted {
            found.missing += missing;
            let number = found.count as usize;
            found.scans.push(Scan { number, name: None, points, pose: Some(head.pose()) });
        }
        found.count += 1;
    }
}
