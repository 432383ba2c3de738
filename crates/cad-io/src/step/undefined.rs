//! References to entities that a file does not define: why entities that name them are dropped.

use super::numbers::EntityNumbers;
use super::records::Records;
use brep_core::description::Unread;
use std::collections::HashSet;

/// Entities among those that were dropped which name an entity that is not there. What was dropped with them follows from these.
pub(super) fn find(text: &[u8], numbers: &EntityNumbers, dropped: &[u64]) -> Vec<Unread> {
    let kinds: HashSet<&str> = dropped.iter().map(|number| numbers.dropped_kind(*number)).collect();
    let records = Records::read(text, |kind| kinds.contains(kind));
    let defined = numbers.defined();
    let named = |number: &u64| {
        let missing =
            records.get(*number)?.references().into_iter().find(|named| !defined.contains(named))?;
        let line = line_of(text, *number).map_or_else(String::new, |line| format!(" (line {line})"));
        Some(Unread {
            source: *number,
            kind: numbers.dropped_kind(*number).to_owned(),
            why: format!("it names #{missing}, which the file does not define{line}"),
        })
    };
    dropped.iter().filter_map(named).collect()
}

/// The line, counted from 1, on which the record of an entity begins.
fn line_of(text: &[u8], number: u64) -> Option<usize> {
    let wanted = number.to_string();
    let begins = |line: &[u8]| {
        let rest = line.trim_ascii_start().strip_prefix(b"#")?.strip_prefix(wanted.as_bytes())?;
        rest.trim_ascii_start().starts_with(b"=").then_some(())
    };
    text.split(|byte| *byte == b'\n').position(|line| begins(line).is_some()).map(|line| line + 1)
}
