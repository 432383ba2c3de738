//! Records of a STEP file by their numbers: types with their values, as the text has them.
//!
//! Only what the caller asks for is kept, so that a large file costs one pass over its text.

use std::collections::{BTreeMap, HashMap};

/// Depth of lists within lists up to which values are read.
const MAX_DEPTH: usize = 32;

/// A value of a record.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// `#12`.
    Reference(u64),
    /// A number.
    Number(f64),
    /// A string, without its quotes.
    Text(String),
    /// `.NAME.`, `$` or `*`, without dots.
    Word(String),
    /// Values in parentheses; of a typed value (`LENGTH_MEASURE(1.)`) with its type.
    List(String, Vec<Self>),
}

/// The types of an entity with the values of each: one, or several for a complex entity.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Record {
    pub(super) parts: Vec<(String, Vec<Value>)>,
}

impl Record {
    /// The values of the first type that is asked for.
    pub(super) fn values(&self, wanted: impl Fn(&str) -> bool) -> Option<&[Value]> {
        self.parts.iter().find(|(kind, _)| wanted(kind)).map(|(_, values)| values.as_slice())
    }

    /// Whether it has one of the types that are asked for.
    pub(super) fn is(&self, wanted: impl Fn(&str) -> bool) -> bool {
        self.values(wanted).is_some()
    }

    /// All numbers of entities that it names, in their order.
    pub(super) fn references(&self) -> Vec<u64> {
        let mut out = Vec::new();
        self.parts.iter().flat_map(|(_, values)| values).for_each(|value| value.collect(&mut out));
        out
    }
}

impl Value {
    fn collect(&self, out: &mut Vec<u64>) {
        match self {
            Self::Reference(number) => out.push(*number),
            Self::List(_, values) => values.iter().for_each(|value| value.collect(out)),
            _ => {}
        }
    }

    /// All numbers of entities in it.
    pub(super) fn references(&self) -> Vec<u64> {
        let mut out = Vec::new();
        self.collect(&mut out);
        out
    }

    /// The number of the entity, if it names one.
    pub(super) fn reference(&self) -> Option<u64> {
        if let Self::Reference(number) = self { Some(*number) } else { None }
    }

    /// The string, if it is one.
    pub(super) fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// The number, or that of a typed value.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::List(_, values) => values.first().and_then(Self::number),
            _ => None,
        }
    }
}

/// Records by number, and which of them name an entity.
#[derive(Debug, Default)]
pub(super) struct Records {
    by_number: BTreeMap<u64, Record>,
    users: HashMap<u64, Vec<u64>>,
}

impl Records {
    /// Reads those records of a file of which a type is wanted.
    pub(super) fn read(text: &[u8], wanted: impl Fn(&str) -> bool) -> Self {
        let mut by_number = BTreeMap::new();
        let mut at = 0;
        while at < text.len() {
            let end = end_of_record(text, at);
            let parser = Parser { text: &text[at..end], at: 0 };
            if let Some((number, record)) = parser.instance(&wanted) {
                by_number.insert(number, record);
            }
            at = end;
        }
        let mut users: HashMap<u64, Vec<u64>> = HashMap::new();
        for (number, record) in &by_number {
            for named in record.references() {
                let list = users.entry(named).or_default();
                if list.last() != Some(number) {
                    list.push(*number);
                }
            }
        }
        Self { by_number, users }
    }

    pub(super) fn get(&self, number: u64) -> Option<&Record> {
        self.by_number.get(&number)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (u64, &Record)> {
        self.by_number.iter().map(|(number, record)| (*number, record))
    }

    /// Records that name an entity, in the order of their numbers.
    pub(super) fn users(&self, number: u64) -> impl Iterator<Item = (u64, &Record)> {
        let users = self.users.get(&number).into_iter().flatten();
        users.filter_map(|user| self.get(*user).map(|record| (*user, record)))
    }
}

/// The end of the record that begins at a place: behind the semicolon, outside of strings and comments.
fn end_of_record(text: &[u8], start: usize) -> usize {
    let (mut at, mut in_string) = (start, false);
    while at < text.len() {
        match text[at] {
            b'\'' => in_string = !in_string,
            b';' if !in_string => return at + 1,
            b'/' if !in_string && text.get(at + 1) == Some(&b'*') => {
                let close = text[at + 2..].windows(2).position(|pair| pair == b"*/");
                at = close.map_or(text.len(), |offset| at + 2 + offset + 1);
            }
            _ => {}
        }
        at += 1;
    }
    text.len()
}

struct Parser<'t> {
    text: &'t [u8],
    at: usize,
}

impl Parser<'_> {
    /// The number of an instance and its types, if one of them is wanted.
    fn instance(mut self, wanted: &impl Fn(&str) -> bool) -> Option<(u64, Record)> {
        let number = self.taken(b'#').then(|| self.digits())??;
        if !self.taken(b'=') {
            return None;
        }
        let mut parts = Vec::new();
        if self.taken(b'(') {
            while let Some(kind) = self.keyword() {
                let values = self.list(0)?;
                parts.push((kind, values));
            }
        } else {
            let kind = self.keyword()?;
            // What is not wanted is not looked into.
            if !wanted(&kind) {
                return None;
            }
            let values = self.list(0)?;
            parts.push((kind, values));
        }
        let record = Record { parts };
        record.is(wanted).then_some((number, record))
    }

    fn skip(&mut self) {
        loop {
            match self.text.get(self.at) {
                Some(byte) if byte.is_ascii_whitespace() => self.at += 1,
                Some(b'/') if self.text.get(self.at + 1) == Some(&b'*') => {
                    let rest = &self.text[self.at + 2..];
                    let close = rest.windows(2).position(|pair| pair == b"*/");
                    self.at = close.map_or(self.text.len(), |offset| self.at + 2 + offset + 2);
                }
                _ => return,
            }
        }
    }

    fn peek(&mut self) -> Option<u8> {
        self.skip();
        self.text.get(self.at).copied()
    }

    fn taken(&mut self, byte: u8) -> bool {
        let is_there = self.peek() == Some(byte);
        self.at += usize::from(is_there);
        is_there
    }

    fn while_true(&mut self, keep: impl Fn(u8) -> bool) -> String {
        let rest = &self.text[self.at.min(self.text.len())..];
        let length = rest.iter().take_while(|byte| keep(**byte)).count();
        self.at += length;
        String::from_utf8_lossy(&rest[..length]).into_owned()
    }

    fn digits(&mut self) -> Option<u64> {
        self.while_true(|byte| byte.is_ascii_digit()).parse().ok()
    }

    fn keyword(&mut self) -> Option<String> {
        self.skip();
        let word = self.while_true(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'!'));
        (!word.is_empty()).then(|| word.to_ascii_uppercase())
    }

    fn list(&mut self, depth: usize) -> Option<Vec<Value>> {
        if depth > MAX_DEPTH || !self.taken(b'(') {
            return None;
        }
        let mut values = Vec::new();
        loop {
            if self.taken(b')') {
                return Some(values);
            }
            values.push(self.value(depth)?);
            let _ = self.taken(b',');
        }
    }

    fn value(&mut self, depth: usize) -> Option<Value> {
        match self.peek()? {
            b'#' => {
                self.at += 1;
                self.digits().map(Value::Reference)
            }
            b'\'' => self.string().map(Value::Text),
            b'.' => {
                self.at += 1;
                let word = self.while_true(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
                self.taken(b'.').then_some(Value::Word(word))
            }
            byte @ (b'$' | b'*') => {
                self.at += 1;
                Some(Value::Word(char::from(byte).to_string()))
            }
            b'"' => {
                self.at += 1;
                let word = self.while_true(|byte| byte != b'"');
                self.taken(b'"').then_some(Value::Word(word))
            }
            b'(' => self.list(depth + 1).map(|values| Value::List(String::new(), values)),
            byte if byte.is_ascii_digit() || matches!(byte, b'+' | b'-') => {
                let number = self.while_true(|byte| {
                    byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'E' | b'e')
                });
                number.parse().ok().map(Value::Number)
            }
            _ => {
                let kind = self.keyword()?;
                self.list(depth + 1).map(|values| Value::List(kind, values))
            }
        }
    }

    fn string(&mut self) -> Option<String> {
        let mut out = Vec::new();
        self.at += 1;
        loop {
            let byte = *self.text.get(self.at)?;
            self.at += 1;
            if byte != b'\'' {
                out.push(byte);
            } else if self.text.get(self.at) == Some(&b'\'') {
                self.at += 1;
                out.push(byte);
            } else {
                return Some(String::from_utf8_lossy(&out).into_owned());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_read_as_they_are_written() {
        let text = b"DATA;#1=PLANE('',#9);\n#2 = datum('it''s; A', $,/* ; */#7,.F.,'A');#3=(B(1.5E0,(#1,#2))A(LENGTH_MEASURE(-2)));#4=DATUM(";
        let records = Records::read(text, |kind| matches!(kind, "DATUM" | "A"));
        let numbers: Vec<u64> = records.iter().map(|(number, _)| number).collect();
        assert_eq!(numbers, [2, 3]);
        let datum = records.get(2).and_then(|record| record.values(|kind| kind == "DATUM")).unwrap_or(&[]);
        assert_eq!(datum[0].text(), Some("it's; A"));
        assert_eq!((datum[2].reference(), &datum[3]), (Some(7), &Value::Word("F".to_owned())));
        let complex = records.get(3).map(Record::references);
        assert_eq!(complex, Some(vec![1, 2]));
        let typed = records.get(3).and_then(|record| record.values(|kind| kind == "A")).unwrap_or(&[]);
        assert_eq!(typed[0].number(), Some(-2.0));
        assert_eq!(records.users(2).map(|(number, _)| number).collect::<Vec<_>>(), [3]);
    }
}
