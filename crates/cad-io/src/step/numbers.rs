//! Numbers of the entities in the text of a STEP file.
//!
//! The library that reads the file numbers the entities of each type by itself, in the order of their numbers in the
//! file and without those that it dropped. This scan finds the numbers again.

use std::collections::{HashMap, HashSet};

/// Entity numbers by type, in increasing order, without the dropped ones.
#[derive(Debug, Default)]
pub(super) struct EntityNumbers {
    kept: HashMap<String, Vec<u64>>,
    dropped: HashMap<u64, String>,
}

impl EntityNumbers {
    /// Scans the text. `dropped` are the numbers of entities that were left out.
    pub(super) fn scan(text: &[u8], dropped: &HashSet<u64>) -> Self {
        let mut found = Self::default();
        let mut at = 0;
        while at < text.len() {
            // One record: everything up to a semicolon outside of strings and comments.
            let (end, head) = record(text, at);
            if let Some((number, kind)) = instance(&head) {
                if dropped.contains(&number) {
                    found.dropped.insert(number, kind);
                } else {
                    found.kept.entry(kind).or_default().push(number);
                }
            }
            at = end;
        }
        found.kept.values_mut().for_each(|numbers| numbers.sort_unstable());
        found
    }

    /// The number of the entity with the given place among those of its type; 0 when it is not known.
    pub(super) fn number(&self, kind: &str, index: u32) -> u64 {
        self.kept.get(kind).and_then(|numbers| numbers.get(index as usize)).copied().unwrap_or(0)
    }

    /// All numbers that the file defines.
    pub(super) fn defined(&self) -> HashSet<u64> {
        self.kept.values().flatten().chain(self.dropped.keys()).copied().collect()
    }

    /// Type of a dropped entity. Complex entities are called `complex entity`.
    pub(super) fn dropped_kind(&self, number: u64) -> &str {
        match self.dropped.get(&number).map(String::as_str) {
            Some("") => "complex entity",
            Some(kind) => kind,
            None => "entity",
        }
    }
}

/// Longest beginning of a record that is looked at: `#number = TYPE(`.
const HEAD: usize = 200;

/// The end of the record that starts at `start`, and its beginning without blanks and comments.
fn record(text: &[u8], start: usize) -> (usize, Vec<u8>) {
    let mut head = Vec::with_capacity(64);
    let mut in_string = false;
    let mut at = start;
    while at < text.len() {
        let byte = text[at];
        at += 1;
        if in_string {
            in_string = byte != b'\'';
            continue;
        }
        match byte {
            b'\'' => {
                in_string = true;
                // What comes before the first string is enough.
                if head.len() < HEAD {
                    head.push(byte);
                }
            }
            b'/' if text.get(at) == Some(&b'*') => {
                let rest = &text[at + 1..];
                let close = rest.windows(2).position(|pair| pair == b"*/");
                at = close.map_or(text.len(), |offset| at + 1 + offset + 2);
            }
            b';' => return (at, head),
            _ if byte.is_ascii_whitespace() => {}
            _ if head.len() < HEAD => head.push(byte),
            _ => {}
        }
    }
    (at, head)
}

/// Number and type of the entity instance whose record begins so; the type of a complex instance is empty.
fn instance(head: &[u8]) -> Option<(u64, String)> {
    let rest = head.strip_prefix(b"#")?;
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let number = std::str::from_utf8(&rest[..digits]).ok()?.parse().ok()?;
    let kind = rest[digits..].strip_prefix(b"=")?;
    let length = kind.iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
    Some((number, String::from_utf8_lossy(&kind[..length]).to_ascii_uppercase()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_beside_strings_and_comments() {
        let text =
            b"ISO-10303-21;HEADER;ENDSEC;DATA;\n/* #1=PLANE(); */ #7 = plane('a;#3=PLANE(''x'')',#2);\n\
                     #4=PLANE('',#2);#5=( A() B('it''s') );#6=PLANE('',#9);\nENDSEC;";
        let numbers = EntityNumbers::scan(text, &HashSet::from([6]));
        assert_eq!([0, 1, 2].map(|i| numbers.number("PLANE", i)), [4, 7, 0]);
        assert_eq!(numbers.number("", 0), 5);
        assert_eq!(numbers.dropped_kind(6), "PLANE");
    }
}
