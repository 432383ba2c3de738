//! PTX files that are read piece by piece.

use std::fs::File;
use std::io::{self, Seek, SeekFrom};

use crate::parsed::Parsed;
use crate::piece::{Piece, Taker};
use crate::ptx::{Head, Points, left_out, not_rigid, numbers};
use crate::scans::{Scan, chosen};
use crate::source::Source;
use crate::text_lines::TextLines;
use crate::{Error, Format, ReadOptions};

/// Lines of a head: two counts and a pose.
const HEAD_LINES: usize = 10;

/// A PTX file that can be read piece by piece.
#[derive(Debug)]
pub(crate) struct Grids {
    pub(crate) warnings: Vec<String>,
    pub(crate) scans: Vec<Scan>,
    /// Numbers per line.
    width: Option<usize>,
    has_several: bool,
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
    /// Numbers per line.
    width: Option<usize>,
}

impl Grids {
    /// Looks through a file; `None` where anything is wrong, which is said when it is read as a whole.
    pub(crate) fn survey(file: &File, options: &ReadOptions) -> io::Result<Option<Self>> {
        let Some(mut found) = visit(file, options, &mut |_, _, _| true)? else { return Ok(None) };
        let choice = options.scan.as_deref();
        if chosen(choice, &vec![None; found.count as usize]).is_err() {
            return Ok(None);
        }
        if found.missing > 0 {
            found.warnings.push(left_out(found.missing));
        }
        let Survey { warnings, scans, count, width, .. } = found;
        Ok(Some(Self { warnings, scans, width, has_several: count > 1 }))
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
        let found = visit(file, options, &mut |head, numbers, _| {
            piece.positions.push(head.place([numbers[0], numbers[1], numbers[2]]));
            if piece.positions.len() == limit {
                goes_on = taker.give(std::mem::take(&mut piece));
            }
            goes_on
        })?;
        if goes_on {
            self.check_same(found.as_ref())?;
        }
        if goes_on && !piece.positions.is_empty() {
            taker.give(piece);
        }
        Ok(())
    }

    /// Hands the points over with all that they carry, as long as `take` wants more.
    pub(crate) fn read_clouds(
        &self,
        file: &File,
        options: &ReadOptions,
        limit: usize,
        take: &mut dyn FnMut(Parsed) -> Result<bool, Error>,
    ) -> io::Result<Result<(), Error>> {
        let mut give = |points: &mut Points| -> Result<bool, Error> {
            let cloud = std::mem::take(points).into_cloud(self.width, self.has_several)?;
            let parsed = Parsed::cloud(Format::Ptx, cloud, self.warnings.clone());
            take(Parsed { scans: self.scans.clone(), ..parsed })
        };
        let mut points = Points::default();
        let mut goes_on = Ok(true);
        let found = visit(file, options, &mut |head, numbers, scan| {
            points.push(head, numbers, scan);
            if points.positions.len() == limit {
                goes_on = give(&mut points);
            }
            matches!(goes_on, Ok(true))
        })?;
        if matches!(goes_on, Ok(true)) {
            self.check_same(found.as_ref())?;
            if !points.positions.is_empty() {
                goes_on = give(&mut points);
            }
        }
        Ok(goes_on.map(|_| ()))
    }

    /// Makes sure that a second way through the file told what the first one did.
    fn check_same(&self, found: Option<&Survey>) -> io::Result<()> {
        if found.is_some_and(|found| found.scans == self.scans) {
            return Ok(());
        }
        Err(io::Error::new(io::ErrorKind::InvalidData, "the file has changed while it was read"))
    }
}

/// Visits the points of the chosen scans, by the numbers of their lines, until `take` says that it is enough; `None` where anything is
/// wrong.
fn visit(
    file: &File,
    options: &ReadOptions,
    take: &mut dyn FnMut(&Head, &[f64], u32) -> bool,
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
    let mut line_number = 0usize;
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
                matches!(numbers.len(), 3 | 4 | 7)
                    && *found.width.get_or_insert(numbers.len()) == numbers.len()
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
            if is_wanted && !take(&head, &numbers, found.count) {
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
