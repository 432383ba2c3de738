//! Tables that are read piece by piece: those whose lines are alike from the first to the last, without names of the points.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use mesh_core::PointCloud;
use nalgebra::{Point3, Vector3};

use super::fields::{Separator, is_comment};
use super::layout::Layout;
use super::meaning;
use super::rows::{RowReader, Rows};
use crate::columns::{Kind, point_columns};
use crate::piece::{Piece, Taker};
use crate::source::Source;
use crate::text_lines::TextLines;
use crate::wording::counted;
use crate::{Error, Format, ReadOptions};

/// Bytes at the beginning of a file by which its layout is found.
pub(crate) const HEAD: u64 = 1 << 18;
/// Rows that must be among them, more than the layout is found by, unless they are the whole file.
const ROWS: usize = 300;

/// A table that can be read piece by piece.
#[derive(Debug)]
pub(crate) struct Table {
    layout: Layout,
    /// Where the rows begin.
    start: u64,
    /// Number of rows.
    count: u64,
    /// Places in a row of x, y and z, and of normals.
    positions: [usize; 3],
    normals: Option<[usize; 3]>,
    /// Names of the columns.
    names: Vec<String>,
    format: Format,
    warnings: Vec<String>,
}

/// What one way through all rows tells.
#[derive(Default)]
struct Survey {
    count: u64,
    empty: usize,
    /// Whether all cells of the columns that seem to be blank are NaN.
    blanks: Vec<bool>,
    /// Whether all cells of a column are integers from 0 to 255.
    bytes: Vec<bool>,
    width: usize,
}

impl Table {
    /// Looks through a file that begins with `head`, a table without a mark of another encoding; `None` where it has to be read as
    /// a whole: because it holds names or texts, two columns, rows that differ, or anything that is wrong.
    pub(crate) fn survey(file: &mut File, head: &[u8], options: &ReadOptions) -> io::Result<Option<Self>> {
        let mark = if head.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let head = &head[mark..];
        let is_whole = (head.len() + mark) as u64 == file.metadata()?.len();
        let end = head.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
        let source = Source { data: if is_whole { head } else { &head[..end] } };
        let Ok(layout) = Layout::detect(source, options.decimal_comma, false) else { return Ok(None) };
        let rows = || source.lines_from(layout.data).filter(|(_, line)| !is_comment(line));
        let is_long = is_whole || rows().nth(ROWS).is_some();
        if !layout.texts.is_empty() || !is_long {
            return Ok(None);
        }
        let start = (mark + layout.data) as u64;
        let mut survey = Survey { blanks: vec![true; layout.blanks.len()], ..Survey::default() };
        let whole = visit(file, start, &layout, &mut |rows, width| {
            survey.width = width;
            survey.count += 1;
            survey.empty += std::mem::take(&mut rows.empty);
            for (is_blank, &place) in survey.blanks.iter_mut().zip(&layout.blanks) {
                *is_blank &= rows.values.get(place).is_none_or(|value| value.is_nan());
            }
            survey.bytes.resize(rows.values.len(), true);
            for (are_bytes, value) in survey.bytes.iter_mut().zip(&rows.values) {
                *are_bytes &= value.fract() == 0.0 && (0.0..=255.0).contains(value);
            }
            rows.values.clear();
            true
        })?;
        if !whole || survey.width < 3 || survey.count == 0 {
            return Ok(None);
        }
        let mut warnings = Self::warnings_of(&layout, &survey);
        let names = match &layout.names {
            Some(names) => names.clone(),
            None => meaning::guess(&sample(file, start, &layout, &survey)?, &layout, &mut warnings),
        };
        let given = names.clone();
        let names: Vec<String> = (names.into_iter().enumerate())
            .map(|(place, name)| if name.is_empty() { format!("column_{}", place + 1) } else { name })
            .collect();
        // A column of nothing is left out; whether it is one shows in all rows.
        let is_nothing = |place: usize| {
            layout.blanks.iter().position(|&blank| blank == place).is_some_and(|blank| survey.blanks[blank])
        };
        let is_open = |(place, name): (usize, &String)| name.is_empty() && !is_nothing(place);
        if given.iter().enumerate().any(is_open) {
            return Ok(None);
        }
        // Colours that are bytes are taken as they are; of others there may be something to tell.
        let kind =
            |place: usize| if survey.bytes.get(place) == Some(&true) { Kind::Byte } else { Kind::Text };
        let named = names.iter().enumerate().map(|(place, name)| (name.as_str(), kind(place)));
        let named: Vec<(&str, Kind)> = named.collect();
        let Some((positions, normals)) = point_columns(&named) else { return Ok(None) };
        let format = match (layout.promised, layout.separator) {
            (Some(_), _) => Format::Pts,
            (None, Separator::Blank) => Format::Xyz,
            (None, Separator::Byte(_)) => Format::Csv,
        };
        Ok(Some(Self {
            start,
            count: survey.count,
            positions,
            normals,
            names: given,
            format,
            warnings,
            layout,
        }))
    }

    fn warnings_of(layout: &Layout, survey: &Survey) -> Vec<String> {
        let mut warnings = layout.notes.clone();
        let count = usize::try_from(survey.count).unwrap_or(usize::MAX);
        let within = layout.blanks.iter().zip(&survey.blanks).filter(|(place, _)| **place < survey.width);
        let blanks = within.filter(|(_, is_blank)| **is_blank).count();
        let empty = survey.empty.saturating_sub(blanks.saturating_mul(count));
        if empty > 0 {
            warnings.push(format!("read as NaN: {}", counted(empty, "empty field")));
        }
        if let Some(promised) = layout.promised.filter(|promised| *promised != survey.count) {
            warnings.push(format!("the first line says {promised} points, but the file holds {count}"));
        }
        warnings
    }

    pub(crate) fn format(&self) -> Format {
        self.format
    }

    /// What is to be said about the file.
    pub(crate) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Hands the points over with all that they carry; nothing is to be told of the pieces.
    pub(crate) fn read_clouds(
        &self,
        file: &mut File,
        limit: usize,
        take: &mut dyn FnMut(PointCloud) -> Result<bool, Error>,
    ) -> io::Result<Result<(), Error>> {
        let mut piece: Vec<f64> = Vec::new();
        let (mut width, mut rows_in_piece, mut seen) = (0, 0, 0);
        let mut failed = None;
        let mut give = |values: Vec<f64>, width: usize| {
            let rows = Rows { values, width, texts: Vec::new(), empty: 0 };
            let cloud = super::assemble_rows(self.names.clone(), rows, &self.layout, &mut Vec::new());
            match cloud.and_then(&mut *take) {
                Ok(goes_on) => goes_on,
                Err(error) => {
                    failed = Some(error);
                    false
                }
            }
        };
        let mut goes_on = true;
        let whole = visit(file, self.start, &self.layout, &mut |rows, of_rows| {
            width = of_rows;
            piece.append(&mut rows.values);
            rows_in_piece += 1;
            seen += 1;
            if rows_in_piece == limit {
                rows_in_piece = 0;
                goes_on = give(std::mem::take(&mut piece), width);
            }
            goes_on
        })?;
        if goes_on && (!whole || seen != self.count) {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "the file has changed while it was read"));
        }
        if goes_on && !piece.is_empty() {
            give(piece, width);
        }
        Ok(failed.map_or(Ok(()), Err))
    }

    /// Hands the points over.
    pub(crate) fn read<E>(&self, file: &mut File, limit: usize, taker: &mut Taker<'_, E>) -> io::Result<()> {
        let mut piece = Piece { positions: Vec::new(), normals: self.normals.map(|_| Vec::new()) };
        let mut goes_on = true;
        let mut seen = 0;
        let whole = visit(file, self.start, &self.layout, &mut |rows, _| {
            let row = &rows.values;
            let triple = |places: [usize; 3]| places.map(|place| row.get(place).copied().unwrap_or(f64::NAN));
            piece.positions.push(Point3::from(triple(self.positions)));
            if let (Some(normals), Some(places)) = (&mut piece.normals, self.normals) {
                normals.push(Vector3::from(triple(places)));
            }
            rows.values.clear();
            seen += 1;
            if piece.positions.len() == limit {
                let next = Piece { positions: Vec::new(), normals: self.normals.map(|_| Vec::new()) };
                goes_on = taker.give(std::mem::replace(&mut piece, next));
            }
            goes_on
        })?;
        if goes_on && (!whole || seen != self.count) {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "the file has changed while it was read"));
        }
        if goes_on && !piece.positions.is_empty() {
            taker.give(piece);
        }
        Ok(())
    }
}

/// Visits all rows, each of them alone in the rows that are handed over with their number of columns, until `take` says that it is
/// enough; whether there is no row that differs.
fn visit(
    file: &mut File,
    start: u64,
    layout: &Layout,
    take: &mut dyn FnMut(&mut Rows, usize) -> bool,
) -> io::Result<bool> {
    let mut file = file.try_clone()?;
    file.seek(SeekFrom::Start(start))?;
    let mut lines = TextLines::new(file);
    let mut reader = RowReader::new(layout);
    loop {
        let line = match lines.next() {
            Ok(Some(line)) => line,
            Ok(None) => return Ok(true),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => return Ok(false),
            Err(error) => return Err(error),
        };
        // Where something is wrong it is said when the file is read as a whole.
        let Ok(true) = reader.read_line(Source { data: line }, layout, (0, line)) else { return Ok(false) };
        let width = reader.width();
        if !reader.rows.values.is_empty() && !take(&mut reader.rows, width) {
            return Ok(true);
        }
    }
}

/// The rows from which the meaning of columns without names is guessed: those that are looked at when all are in memory.
fn sample(file: &mut File, start: u64, layout: &Layout, survey: &Survey) -> io::Result<Rows> {
    let step = (survey.count / meaning::SAMPLE as u64).max(1);
    let mut values = Vec::new();
    let mut place = 0;
    visit(file, start, layout, &mut |rows, _| {
        if place % step == 0 {
            values.extend_from_slice(&rows.values);
        }
        place += 1;
        rows.values.clear();
        true
    })?;
    Ok(Rows { values, width: survey.width, texts: Vec::new(), empty: 0 })
}

/// The beginning of a file.
pub(crate) fn head(file: &mut File) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    file.take(HEAD).read_to_end(&mut head)?;
    Ok(head)
}
