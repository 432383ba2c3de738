//! How the lines of a table are built: separator, header, units, count, decimal sign, columns of text.

use crate::wording::counted;
use std::collections::HashSet;

use super::fields::{Field, Separator, is_comment};
use super::names;
use super::notation::{Evidence, Found, Notation, PLAIN};
use crate::columns::{is_position, names_a_position};
use crate::number::parse_count;
use crate::source::{Source, decode_name, quoted};
use crate::{Error, Format};

/// Most lines before a header.
const PREAMBLE: usize = 100;
/// Lines that are looked at first.
const SAMPLE: usize = 200;
/// Most columns of a list of points.
pub(super) const MOST_COLUMNS: usize = 1000;

/// What the beginning of a table tells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) separator: Separator,
    pub(super) notation: Notation,
    /// Names of the columns, where there is a header line.
    pub(super) names: Option<Vec<String>>,
    /// Number of columns, where it does not follow from the names or the first row: words behind the last number are one text.
    pub(super) width: Option<usize>,
    /// Places of the columns that hold text.
    pub(super) texts: Vec<usize>,
    /// Places of columns without a name in which nothing was seen: separators at the ends of lines, or two in a row.
    pub(super) blanks: Vec<usize>,
    /// The place of the column that names the points, one of `texts`.
    pub(super) label: Option<usize>,
    /// The number of points in the first line of a PTS file.
    pub(super) promised: Option<u64>,
    /// Where the rows begin.
    pub(super) data: usize,
    /// What had to be decided.
    pub(super) notes: Vec<String>,
}

/// Whether a line consists of numbers, of which it has two or more, perhaps after a name (or one count, as in PTS).
pub(crate) fn looks_like_row(line: &[u8]) -> bool {
    let fields: Vec<Field<'_>> = row_separator(&[line]).fields(line).collect();
    let count = numeric(&fields);
    match fields.as_slice() {
        [] => false,
        [count] => parse_count(count.text).is_some(),
        fields => {
            count == fields.len() || count >= 3 || count == 2 && fields.len() == 3 && !is_numeric(&fields[0])
        }
    }
}

/// Whether a line, perhaps a comment, names columns among which are x and y.
pub(crate) fn looks_like_header(line: &[u8]) -> bool {
    header_names(line).is_some()
}

/// The format of a file whose rows are like this one.
pub(crate) fn format_of_row(line: &[u8]) -> Format {
    match row_separator(&[line]) {
        Separator::Byte(_) => Format::Csv,
        Separator::Blank if parse_count(line.trim_ascii()).is_some() => Format::Pts,
        Separator::Blank => Format::Xyz,
    }
}

/// A line without the signs of a comment before it.
fn uncommented(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii();
    &line[line.iter().take_while(|&&byte| matches!(byte, b'#' | b'/' | b'%' | b'!')).count()..]
}

/// Whether a field is a number in some notation.
fn is_numeric(field: &Field<'_>) -> bool {
    [PLAIN, Notation::Point { grouped: true }, Notation::Comma { grouped: true }]
        .iter()
        .any(|notation| notation.parse(field.text).is_some())
}

fn numeric(fields: &[Field<'_>]) -> usize {
    fields.iter().filter(|field| is_numeric(field)).count()
}

/// The names in a header line, if x and y are among them; as they are written.
fn header_names(line: &[u8]) -> Option<Vec<String>> {
    let line = uncommented(line);
    let separator = Separator::of(line);
    let fields: Vec<Field<'_>> = separator.fields(line).collect();
    if fields.len() < 2 || fields.len() > MOST_COLUMNS || fields.iter().any(is_numeric) {
        return None;
    }
    let name = |field: &Field<'_>| decode_name(field.text).into_owned();
    let found: Vec<String> = match separator {
        // A unit in brackets may stand apart from its name: "x [mm] y [mm]".
        Separator::Blank => {
            let is_unit = |field: &&Field<'_>| field.text.starts_with(b"[") || field.text.starts_with(b"(");
            fields.iter().filter(|field| !is_unit(field)).map(name).collect()
        }
        Separator::Byte(_) => fields.iter().map(name).collect(),
    };
    let mut resolved = found.clone();
    let _ = names::resolve(&mut resolved);
    names_a_position(resolved.iter().map(String::as_str)).then_some(found)
}

/// The separator of rows: one that stands in all of them.
fn row_separator(rows: &[&[u8]]) -> Separator {
    let counts =
        |byte: u8| rows.iter().map(move |row| Separator::Byte(byte).fields(row.trim_ascii_end()).count());
    let everywhere = |byte: u8| !rows.is_empty() && counts(byte).all(|count| count > 1);
    if everywhere(b';') {
        return Separator::Byte(b';');
    }
    // Tabs may also be blanks that align columns; then they come in different numbers, or blanks divide numbers too.
    let tabs: HashSet<usize> =
        rows.iter().map(|row| row.iter().filter(|&&byte| byte == b'\t').count()).collect();
    let divided = |row: &&[u8]| {
        let mut fields = Separator::Byte(b'\t').fields(row);
        fields
            .any(|field| !field.quoted && Separator::Blank.fields(field.text).filter(is_numeric).count() > 1)
    };
    if tabs.len() == 1 && everywhere(b'\t') && !rows.iter().any(divided) {
        return Separator::Byte(b'\t');
    }
    if everywhere(b'|') {
        return Separator::Byte(b'|');
    }
    if everywhere(b',') {
        // Commas within numbers that blanks divide: "1,5 2,25 3,0" or "1,234.5 2,345.6".
        let within = |row: &&[u8]| {
            let fields: Vec<Field<'_>> = Separator::Blank.fields(row).collect();
            let numbers = numeric(&fields);
            fields.len() > 1
                && (numbers == fields.len() || numbers >= 2 && !is_numeric(&fields[0]))
                && fields.iter().any(|field| field.text.contains(&b',') && is_numeric(field))
        };
        return if rows.iter().all(within) { Separator::Blank } else { Separator::Byte(b',') };
    }
    Separator::Blank
}

/// What a column was seen to hold.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    cells: usize,
    numbers: usize,
    /// Numbers written without, and with, a decimal point.
    whole: usize,
    pointed: usize,
}

impl Layout {
    /// Looks at the beginning, or, to be thorough, at all lines.
    pub(super) fn detect(source: Source<'_>, decimal_comma: bool, thorough: bool) -> Result<Self, Error> {
        let mut out = Self {
            separator: Separator::Blank,
            notation: PLAIN,
            names: None,
            width: None,
            texts: Vec::new(),
            blanks: Vec::new(),
            label: None,
            promised: None,
            data: source.data.len(),
            notes: Vec::new(),
        };
        let described = out.find_rows(source)?;
        let limit = if thorough { usize::MAX } else { SAMPLE };
        let lines = source.lines_from(out.data).filter(|(_, line)| !is_comment(line));
        let mut rows: Vec<(usize, &[u8])> = lines.take(limit).collect();
        if out.promised.is_some() {
            // Several scans in one file: each begins with its count.
            rows.retain(|(_, line)| parse_count(line.trim_ascii()).is_none());
        }
        let lines: Vec<&[u8]> = rows.iter().map(|&(_, line)| line).collect();
        out.separator = match (lines.as_slice(), &out.names) {
            ([], _) => Separator::Blank,
            (lines, _) => row_separator(lines),
        };
        if let (None, Some(names)) = (&out.names, described) {
            let width = lines.first().map(|line| out.separator.fields(line).count());
            out.names = width.is_none_or(|width| width == names.len()).then_some(names);
        }
        out.find_notation(source, &rows, decimal_comma)?;
        out.find_texts(&lines);
        if let Some(names) = &mut out.names {
            let taken = names::resolve(names);
            if !taken.is_empty() {
                out.notes.push(format!("the columns {} were taken as coordinates", taken.join(", ")));
            }
        }
        Ok(out)
    }

    /// Passes over comments, a preamble, a header and units; returns names in a comment.
    fn find_rows(&mut self, source: Source<'_>) -> Result<Option<Vec<String>>, Error> {
        let mut described = None;
        let mut lines = source.lines_from(0);
        let first = lines.by_ref().find(|(_, line)| {
            // Names may stand in the last comment before the rows: "# x y z" or "//X Y Z".
            let names = header_names(line).filter(|_| is_comment(line));
            described = names.or(described.take());
            !is_comment(line)
        });
        let Some((at, row)) = first else { return Ok(described) };
        self.promised = parse_count(row.trim_ascii());
        if self.promised.is_some() {
            self.data = lines.offset();
            return Ok(None);
        }
        if let Some(names) = header_names(row) {
            self.names = Some(names);
            self.data = lines.offset();
        } else if looks_like_row(row) {
            self.data = at;
            return Ok(described);
        } else {
            self.pass_preamble(source, at, row)?;
        }
        self.pass_units(source);
        Ok(None)
    }

    /// Looks for a header further down.
    fn pass_preamble(&mut self, source: Source<'_>, at: usize, first: &[u8]) -> Result<(), Error> {
        let mut lines = source.lines_from(at);
        let mut passed = 0usize;
        while let Some((_, line)) = lines.next().filter(|_| passed < PREAMBLE) {
            if let Some(names) = header_names(line).filter(|_| !is_comment(line)) {
                self.names = Some(names);
                self.data = lines.offset();
                self.notes.push(format!(
                    "passed over: {} before the names of the columns",
                    counted(passed, "line")
                ));
                return Ok(());
            }
            passed += 1;
        }
        Err(not_a_header(source, at, first))
    }

    /// Passes over a line under the header that names units or types, or is a rule.
    fn pass_units(&mut self, source: Source<'_>) {
        let mut lines = source.lines_from(self.data);
        let next = lines.by_ref().find(|(_, line)| !line.trim_ascii().is_empty());
        let (Some((_, line)), Some(names)) = (next, &self.names) else { return };
        if is_comment(line) {
            return;
        }
        if line.iter().all(|byte| b"-=_+|,; \t".contains(byte))
            && line.iter().any(|byte| b"-=_".contains(byte))
        {
            self.data = lines.offset();
            return self.pass_units(source);
        }
        let separator = row_separator(&[line]);
        let cells: Vec<String> =
            separator.fields(line).map(|field| decode_name(field.text).into_owned()).collect();
        let units: Option<Vec<String>> = cells.iter().map(|cell| names::unit(cell)).collect();
        let mut resolved = names.clone();
        let _ = names::resolve(&mut resolved);
        let of_axes = |units: &[String]| {
            let axes = resolved.iter().zip(units).filter(|(name, _)| is_position(name));
            axes.map(|(_, unit)| unit.clone()).collect::<HashSet<String>>()
        };
        // A row of empty cells is a point without coordinates.
        if let Some(units) = units.filter(|_| cells.iter().any(|cell| !cell.is_empty()))
            && of_axes(&units).len() == 1
            && cells.len() == names.len()
        {
            let unit = of_axes(&units).into_iter().next().filter(|unit| !unit.is_empty());
            self.notes.push(format!(
                "the line under the names was taken as that of units{}; numbers are left as they are",
                unit.map(|unit| format!(" ({unit})")).unwrap_or_default()
            ));
            self.data = lines.offset();
        }
    }

    fn find_notation(
        &mut self,
        source: Source<'_>,
        rows: &[(usize, &[u8])],
        decimal_comma: bool,
    ) -> Result<(), Error> {
        // Points matter only beside commas.
        if !rows.iter().any(|(_, line)| line.contains(&b',')) {
            return Ok(());
        }
        let mut evidence = Evidence::default();
        let mut first = None;
        for &(at, line) in rows {
            for field in self.separator.fields(line).filter(is_numeric) {
                evidence.add(field.text);
                if field.text.contains(&b',') {
                    first.get_or_insert((at, line));
                }
            }
        }
        let Some((at, line)) = first else { return Ok(()) };
        self.notation = match evidence.found() {
            Found::Contradiction => return Err(mixed_signs(source, at, line)),
            Found::OpenComma if !decimal_comma && self.separator == Separator::Byte(b',') => {
                return Err(open_comma(source, at, line));
            }
            Found::OpenComma => {
                self.notes.push("commas in numbers were taken as decimal commas".to_owned());
                Notation::Comma { grouped: false }
            }
            Found::Certain(notation) => notation,
        };
        if self.separator == Separator::Blank
            && matches!(self.notation, Notation::Comma { .. })
            && !decimal_comma
        {
            return Err(decimal_comma_between_blanks(source, at, line));
        }
        Ok(())
    }

    /// Tells columns of text from columns of numbers.
    fn find_texts(&mut self, rows: &[&[u8]]) {
        let mut seen: Vec<Seen> = Vec::new();
        for row in rows {
            for (place, field) in self.separator.fields(row).take(MOST_COLUMNS).enumerate() {
                if seen.len() <= place {
                    seen.push(Seen::default());
                }
                let is_number = self.notation.parse(field.text).is_some();
                let column = &mut seen[place];
                column.cells += usize::from(!field.is_empty());
                column.numbers += usize::from(is_number);
                column.whole +=
                    usize::from(!field.text.is_empty() && field.text.iter().all(u8::is_ascii_digit));
                column.pointed +=
                    usize::from(is_number && field.text.iter().any(|byte| b".,".contains(byte)));
            }
        }
        let is_named = |place: usize| {
            self.names.as_ref().is_some_and(|names| names.get(place).is_some_and(|name| !name.is_empty()))
        };
        self.blanks = (0..seen.len()).filter(|&place| seen[place].cells == 0 && !is_named(place)).collect();
        let is_text = |place: usize| seen.get(place).is_some_and(|seen| 2 * seen.numbers < seen.cells);
        if let Some(names) = &self.names {
            let mut resolved = names.clone();
            let _ = names::resolve(&mut resolved);
            let is_axis = |place: usize| is_position(&resolved[place]);
            let labels: Vec<usize> =
                (0..names.len()).filter(|&place| !is_axis(place) && names::is_label(&names[place])).collect();
            // Of several, the one that holds text: "No., Name".
            let label = labels.iter().find(|&&place| is_text(place)).or(labels.first()).copied();
            self.texts = (0..names.len())
                .filter(|&place| !is_axis(place) && (is_text(place) || label == Some(place)))
                .collect();
            let before = self.texts.first().copied().filter(|&first| !(0..first).any(is_axis));
            self.label = label.or(before);
            return;
        }
        let mut width = seen.len();
        let mut texts: Vec<usize> = (0..width).filter(|&place| is_text(place)).collect();
        let last_number = (0..width).rfind(|place| !texts.contains(place));
        if let Some(last) = last_number.filter(|last| self.separator == Separator::Blank && last + 2 < width)
        {
            width = last + 2;
            self.width = Some(width);
            texts.retain(|&place| place < width);
        }
        let is_number = |place: &usize| !texts.contains(place) && !self.blanks.contains(place);
        let numbers: Vec<usize> = (0..width).filter(is_number).collect();
        // Without a header, a point with text has three coordinates, or two after its name.
        if numbers.len() >= if texts.first() == Some(&0) { 2 } else { 3 } {
            self.label = texts.first().copied().filter(|&place| place == 0 || texts.len() == 1);
            self.texts = texts;
        }
        if self.label != Some(0)
            && self.promised.is_none()
            && numbers_points(rows, self.separator, &seen, &numbers, &self.texts)
        {
            self.texts.insert(0, 0);
            self.label = Some(0);
            self.notes
                .push("the integers in the first column were taken as numbers of the points".to_owned());
        }
    }
}

/// Whether the first column holds numbers of points and not coordinates: different integers, before numbers that are
/// all written with decimals, or before three coordinates and a text.
fn numbers_points(
    rows: &[&[u8]],
    separator: Separator,
    seen: &[Seen],
    numbers: &[usize],
    texts: &[usize],
) -> bool {
    let [0, coordinates @ ..] = numbers else { return false };
    let all = |place: usize, count: fn(&Seen) -> usize| {
        count(&seen[place]) == seen[place].cells && seen[place].cells > 0
    };
    let whole = all(0, |seen| seen.whole);
    let pointed =
        coordinates.len() >= 3 && coordinates[..3].iter().all(|&place| all(place, |seen| seen.pointed));
    let coded = coordinates.len() == 3 && !texts.is_empty();
    if !whole || !(pointed || coded) {
        return false;
    }
    let mut different = HashSet::new();
    rows.iter().filter_map(|row| separator.fields(row).next()).all(|field| different.insert(field.text))
}

fn not_a_header(source: Source<'_>, at: usize, line: &[u8]) -> Error {
    source.line_error(
        at,
        format!(
            "{} holds neither numbers nor names of columns among which are x and y",
            quoted(line.trim_ascii())
        ),
        "write the names of the columns into the first line (name,x,y,z,nx,ny,nz,r,g,b,intensity,…), or remove it",
    )
}

fn decimal_comma_between_blanks(source: Source<'_>, at: usize, line: &[u8]) -> Error {
    source.line_error(
        at,
        format!("{} seems to have decimal commas, which between blanks may also be separators", quoted(line.trim_ascii())),
        "say so (`indgeo convert --decimal-comma`), separate the columns by semicolons, or replace the commas by points",
    )
}

fn open_comma(source: Source<'_>, at: usize, line: &[u8]) -> Error {
    source.line_error(
        at,
        format!("the commas in {} may stand for decimals or for thousands", quoted(line.trim_ascii())),
        "say which (`indgeo convert --decimal-comma`), or write the numbers with decimal points",
    )
}

fn mixed_signs(source: Source<'_>, at: usize, line: &[u8]) -> Error {
    source.line_error(
        at,
        format!(
            "{} has a comma where other numbers have points, so that its meaning is open",
            quoted(line.trim_ascii())
        ),
        "write all numbers with the same decimal sign, and without signs between thousands",
    )
}
