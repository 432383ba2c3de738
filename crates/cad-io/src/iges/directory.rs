//! The directory entry section: two lines of ten fields of eight columns for each entity.

use super::fault::{EntityId, Fault};
use super::records::Line;
use super::tokens::decoded;

/// One entity as the directory has it.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    /// Number of its first directory line, by which pointers name it: odd.
    pub(crate) sequence: u32,
    /// Number of that line in the file.
    pub(crate) line: usize,
    /// Entity type number.
    pub(crate) kind: u32,
    /// First line of its parameter data, counted from 1 within the section.
    pub(crate) parameters: usize,
    /// Number of lines of parameter data.
    pub(crate) parameter_lines: usize,
    /// Directory entry of its transformation matrix; 0 for none.
    pub(crate) transform: u32,
    /// The entity is not shown.
    pub(crate) is_hidden: bool,
    /// The entity exists only as part of another one.
    pub(crate) is_dependent: bool,
    /// Entity use flag: 0 geometry, 1 annotation, 2 definition, 3 other, 4 logical, 5 in parameters, 6 construction.
    pub(crate) usage: u32,
    /// Form number.
    pub(crate) form: i64,
    /// Label and subscript, as a name.
    pub(crate) label: String,
}

/// Reads all entries.
pub(crate) fn entries(lines: &[Line<'_>]) -> Result<Vec<Entry>, Fault> {
    if let [.., last] = lines
        && !lines.len().is_multiple_of(2)
    {
        return Err(Fault::at_line(last.number, "the second line of the last directory entry is missing"));
    }
    (1..).step_by(2).zip(lines.chunks_exact(2)).map(|(sequence, pair)| entry(sequence, pair)).collect()
}

fn entry(sequence: u32, pair: &[Line<'_>]) -> Result<Entry, Fault> {
    let [first, second] = [pair[0], pair[1]];
    let kind = unsigned(first, 0, "entity type number", None)?;
    let id = Some(EntityId { sequence, kind });
    let field = |line, place, name| unsigned(line, place, name, id);
    let again: u32 = field(second, 0, "entity type number")?;
    if again != kind {
        let what = format!("the two lines of the directory entry name the types {kind} and {again}");
        return Err(Fault { entity: id, ..Fault::at_line(second.number, what) });
    }
    let status = field(first, 8, "status number")?;
    let subscript = decoded(second.columns(64, 72));
    let label = decoded(second.columns(56, 64));
    let label = match subscript.as_str() {
        "" | "0" => label,
        _ if label.is_empty() => label,
        subscript => format!("{label} {subscript}"),
    };
    Ok(Entry {
        sequence,
        line: first.number,
        kind,
        parameters: index(field(first, 1, "pointer to parameter data")?),
        parameter_lines: index(field(second, 3, "number of parameter lines")?),
        transform: field(first, 6, "pointer to a transformation matrix")?,
        is_hidden: status / 1_000_000 % 100 == 1,
        is_dependent: matches!(status / 10_000 % 100, 1 | 3),
        usage: status / 100 % 100,
        form: signed(second, 4, "form number", id)?,
        label,
    })
}

fn index(value: u32) -> usize {
    usize::try_from(value).unwrap_or(usize::MAX)
}

/// A field that may be empty, which stands for 0; blanks within stand for zeros in the status number.
fn unsigned(line: Line<'_>, place: usize, name: &str, entity: Option<EntityId>) -> Result<u32, Fault> {
    let value = signed(line, place, name, entity)?;
    u32::try_from(value).map_err(|_| {
        let what = format!("the {name} is {value}; it must not be negative or beyond 99999999");
        Fault { entity, ..Fault::at_line(line.number, what) }
    })
}

fn signed(line: Line<'_>, place: usize, name: &str, entity: Option<EntityId>) -> Result<i64, Fault> {
    let field = line.columns(8 * place, 8 * place + 8);
    let text: String = field.trim_ascii().iter().map(|&byte| char::from(byte)).collect();
    let text = if place == 8 { text.replace(' ', "0") } else { text };
    if text.is_empty() {
        return Ok(0);
    }
    text.parse().map_err(|_| {
        let what = format!("the {name} (columns {} to {}) is `{text}`", 8 * place + 1, 8 * place + 8);
        Fault { entity, ..Fault::at_line(line.number, what) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(number: usize, text: &str) -> Line<'_> {
        Line { number, text: text.as_bytes() }
    }

    #[test]
    fn fields_of_an_entry() {
        let first = "     144       7       0       0       0       0       9       00000 0 0";
        let second = "     144       0       0       2       1                 BLADE       3";
        let found = entries(&[line(5, first), line(6, second)]).unwrap();
        let e = &found[0];
        assert_eq!((e.sequence, e.line, e.kind, e.parameters, e.parameter_lines), (1, 5, 144, 7, 2));
        assert_eq!((e.transform, e.is_hidden, e.is_dependent, e.usage, e.form), (9, false, false, 0, 1));
        assert_eq!(e.label, "BLADE 3");
    }

    #[test]
    fn faults_name_line_and_entity() {
        let first = "     144       7       0       0       0       0       0        01010500";
        let other = "     128       0       0       2       0";
        let fault = entries(&[line(5, first), line(6, other)]).unwrap_err();
        assert_eq!((fault.line, fault.entity), (6, Some(EntityId { sequence: 1, kind: 144 })));
        assert_eq!(entries(&[line(5, first)]).unwrap_err().line, 5);
        let fault = entries(&[line(5, "     14x")]).unwrap_err();
        assert!(fault.what.contains("second line"), "{fault:?}");
        let fault = entries(&[line(5, "     14x"), line(6, "     144")]).unwrap_err();
        assert!(fault.what.contains("`14x`"), "{fault:?}");
    }
}
