//! A file with its entities, and the parameter data of each.

use super::directory::{self, Entry};
use super::fault::{EXPORT_AGAIN, Fault};
use super::global::Global;
use super::records::{Line, Records};
use super::tokens::{Delimiters, Tokens, Value, decoded, integer, real};
use std::cell::Cell;

/// Columns of parameter data in a line; a pointer back to the directory follows.
const DATA_WIDTH: usize = 64;
/// Deepest chain of entities that name others. Faces of solids take 7.
const DEEPEST: usize = 16;

/// The lines of a file, read as far as no entity is concerned.
#[derive(Debug)]
pub(crate) struct File<'a> {
    /// Global section.
    pub(crate) global: Global,
    /// Directory entries, in order.
    pub(crate) entries: Vec<Entry>,
    parameters: Vec<Line<'a>>,
    /// Whether each entity was read as part of another one.
    used: Vec<Cell<bool>>,
    /// Lines of parameter data that may still be read: damaged pointers may lead to the same entities again and again.
    budget: Cell<usize>,
}

impl<'a> File<'a> {
    /// Reads sections and directory.
    pub(crate) fn new(data: &'a [u8]) -> Result<Self, Fault> {
        let records = Records::new(data)?;
        let entries = directory::entries(&records.directory)?;
        Ok(Self {
            global: Global::new(&records.global)?,
            used: entries.iter().map(|_| Cell::new(false)).collect(),
            budget: Cell::new(100 * (records.parameters.len() + 100)),
            entries,
            parameters: records.parameters,
        })
    }

    /// Whether an entity was read as part of another one.
    pub(crate) fn is_used(&self, entry: &Entry) -> bool {
        self.cell(entry).is_some_and(Cell::get)
    }

    /// Marks an entity as read.
    pub(crate) fn mark_used(&self, entry: &Entry) {
        if let Some(cell) = self.cell(entry) {
            cell.set(true);
        }
    }

    fn cell(&self, entry: &Entry) -> Option<&Cell<bool>> {
        self.used.get(usize::try_from(entry.sequence / 2).ok()?)
    }

    /// The entity that a pointer names.
    pub(crate) fn entry(&self, sequence: u32) -> Option<&Entry> {
        let index = usize::try_from(sequence.checked_sub(1)? / 2).ok()?;
        self.entries.get(index).filter(|_| !sequence.is_multiple_of(2))
    }

    /// The parameter data of an entity, past its type number. `depth` counts the entities that led here.
    pub(crate) fn record(&self, entry: &Entry, depth: usize) -> Result<Cursor<'_>, Fault> {
        if depth > DEEPEST {
            let what =
                "the entity is named through more than 16 others; the pointers of the file form a circle";
            return Err(Fault::of(entry, what));
        }
        let lines = self.lines(entry)?;
        let Some(budget) = self.budget.get().checked_sub(lines.len() + 1) else {
            let what = "entities name each other over and over; pointers of the file are damaged";
            return Err(Fault::of(entry, what));
        };
        self.budget.set(budget);
        let tokens = Tokens::new(lines.iter(), DATA_WIDTH, Some(entry.into()));
        let delimiters = self.global.delimiters;
        let mut cursor = Cursor { tokens, delimiters, place: 0, file: self, depth };
        let kind = cursor.integer("entity type number")?;
        if kind != i64::from(entry.kind) {
            let what = format!(
                "the parameter data are of type {kind}, the directory entry is of type {}",
                entry.kind
            );
            return Err(cursor.fault(what));
        }
        Ok(cursor)
    }

    /// The lines of parameter data of an entity.
    fn lines(&self, entry: &Entry) -> Result<&[Line<'a>], Fault> {
        let first = entry.parameters.wrapping_sub(1);
        let Some(rest) = self.parameters.get(first..).filter(|rest| !rest.is_empty()) else {
            let (found, asked) = (self.parameters.len(), entry.parameters);
            let what = format!("its parameter data begin in line {asked} of section P, which has {found}");
            return Err(Fault::of(entry, what));
        };
        let back = |line: &Line<'_>| integer(line.columns(DATA_WIDTH, 72).trim_ascii());
        let own = Some(i64::from(entry.sequence));
        // Lines of its own, by their pointers back; where a writer leaves those out, the count of the directory holds.
        let count = rest.iter().take_while(|line| back(line) == own).count();
        if count > 0 {
            return Ok(&rest[..count]);
        }
        if let Some(other) = back(&rest[0]) {
            let what = format!("its parameter data begin in a line that belongs to entity {other}");
            return Err(Fault { line: rest[0].number, ..Fault::of(entry, what) });
        }
        Ok(&rest[..entry.parameter_lines.clamp(1, rest.len())])
    }
}

/// The values of one record, in order.
#[derive(Debug)]
pub(crate) struct Cursor<'f> {
    tokens: Tokens,
    delimiters: Delimiters,
    place: usize,
    file: &'f File<'f>,
    depth: usize,
}

impl<'f> Cursor<'f> {
    /// A fault at the value that was read last.
    pub(crate) fn fault(&self, what: impl Into<String>) -> Fault {
        self.tokens.fault(what)
    }

    /// A fault of values that contradict each other.
    pub(crate) fn invalid(&self, what: impl std::fmt::Display) -> Fault {
        self.tokens.fault(what.to_string()).with_advice(EXPORT_AGAIN)
    }

    /// Entities that led here, this one included.
    pub(crate) const fn depth(&self) -> usize {
        self.depth + 1
    }

    /// Whether all values were read.
    pub(crate) const fn is_ended(&self) -> bool {
        self.tokens.is_ended()
    }

    /// A value that must be there; one that is left empty has the default of the standard.
    fn parse<T>(
        &mut self,
        name: &str,
        default: T,
        kind: &str,
        parse: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<T, Fault> {
        if self.tokens.is_ended() {
            return Err(self.fault(format!("the record ends before parameter {} ({name})", self.place)));
        }
        let place = self.place;
        self.place += 1;
        let (text, found) = match self.tokens.next(self.delimiters)? {
            Value::Empty => return Ok(default),
            Value::Text(text) => (decoded(text), None),
            Value::Plain(text) => (decoded(text), parse(text)),
        };
        found.ok_or_else(|| self.fault(format!("parameter {place} ({name}) is `{text}`, which is no {kind}")))
    }

    /// A real number.
    pub(crate) fn real(&mut self, name: &str) -> Result<f64, Fault> {
        self.parse(name, 0.0, "finite number", real)
    }

    /// Real numbers.
    pub(crate) fn reals<const N: usize>(&mut self, name: &str) -> Result<[f64; N], Fault> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.real(name)?;
        }
        Ok(values)
    }

    /// `count` real numbers; the count is checked against the length of the record first.
    pub(crate) fn list(&mut self, count: usize, name: &str) -> Result<Vec<f64>, Fault> {
        self.expect(count, name)?;
        (0..count).map(|_| self.real(name)).collect()
    }

    /// An integer.
    pub(crate) fn integer(&mut self, name: &str) -> Result<i64, Fault> {
        self.parse(name, 0, "integer", integer)
    }

    /// A number that is not negative.
    pub(crate) fn index(&mut self, name: &str) -> Result<usize, Fault> {
        let value = self.integer(name)?;
        let negative = || self.fault(format!("the {name} is {value}; it must not be negative"));
        usize::try_from(value).map_err(|_| negative())
    }

    /// A number of things, each of which takes at least one value of the record.
    pub(crate) fn count(&mut self, name: &str) -> Result<usize, Fault> {
        let count = self.index(name)?;
        if count > 0 {
            self.expect(count, name)?;
        }
        Ok(count)
    }

    /// An error unless the record is long enough for so many more values.
    pub(crate) fn expect(&self, count: usize, name: &str) -> Result<(), Fault> {
        let left = self.tokens.left();
        if count <= left {
            return Ok(());
        }
        Err(self.fault(format!("the record is too short for {count} values ({name}): {left} bytes are left")))
    }

    /// A pointer; `None` for 0.
    pub(crate) fn optional(&mut self, name: &str) -> Result<Option<&'f Entry>, Fault> {
        let value = self.integer(name)?;
        if value == 0 {
            return Ok(None);
        }
        // Some pointers are written with a minus sign as a mark.
        let found = u32::try_from(value.unsigned_abs()).ok().and_then(|sequence| self.file.entry(sequence));
        match found {
            Some(entry) => {
                self.file.mark_used(entry);
                Ok(Some(entry))
            }
            None => {
                let last = (2 * self.file.entries.len()).saturating_sub(1);
                Err(self.fault(format!(
                    "the {name} is {value}; directory entries are the odd numbers up to {last}"
                )))
            }
        }
    }

    /// A pointer that must name an entity.
    pub(crate) fn pointer(&mut self, name: &str) -> Result<&'f Entry, Fault> {
        let found = self.optional(name)?;
        found.ok_or_else(|| self.fault(format!("the {name} is 0; it must name an entity")))
    }

    /// `count` pointers that must name entities.
    pub(crate) fn pointers(&mut self, count: usize, name: &str) -> Result<Vec<&'f Entry>, Fault> {
        self.expect(count, name)?;
        (0..count).map(|_| self.pointer(name)).collect()
    }

    /// A string.
    pub(crate) fn text(&mut self) -> Result<String, Fault> {
        self.place += 1;
        Ok(match self.tokens.next(self.delimiters)? {
            Value::Empty => String::new(),
            Value::Text(text) | Value::Plain(text) => decoded(text),
        })
    }

    /// The name of an entity whose own parameters have all been read: that of a name property (type 406, form 15) among
    /// the pointers at the end of the record, else its label.
    pub(crate) fn name(mut self, entry: &Entry) -> String {
        self.name_property().ok().flatten().unwrap_or_else(|| entry.label.clone())
    }

    fn name_property(&mut self) -> Result<Option<String>, Fault> {
        if self.is_ended() {
            return Ok(None);
        }
        // Associativities and notes first, properties second.
        let notes = self.count("number of associativities")?;
        for _ in 0..notes {
            self.integer("pointer to an associativity")?;
        }
        if self.is_ended() {
            return Ok(None);
        }
        let properties = self.count("number of properties")?;
        for _ in 0..properties {
            let property = self.pointer("pointer to a property")?;
            if (property.kind, property.form) == (406, 15) {
                let mut values = self.file.record(property, self.depth())?;
                values.integer("number of property values")?;
                return values.text().map(Some);
            }
        }
        Ok(None)
    }
}
