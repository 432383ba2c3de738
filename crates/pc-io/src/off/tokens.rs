//! The words of an OFF file, without comments.

use crate::Error;
use crate::source::{Lines, Source, is_blank};

/// Words one after another, over the ends of lines.
#[derive(Debug, Clone)]
pub(super) struct Tokens<'a> {
    pub(super) source: Source<'a>,
    lines: Lines<'a>,
    /// Where the current line begins, the line without its comment, and what has been read of it.
    start: usize,
    line: &'a [u8],
    at: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(source: Source<'a>, offset: usize) -> Self {
        Self { source, lines: source.lines_from(offset), start: offset, line: b"", at: 0 }
    }

    /// The next word of the current line.
    pub(super) fn next_in_line(&mut self) -> Option<&'a [u8]> {
        let rest = &self.line[self.at..];
        let start = rest.iter().position(|&byte| !is_blank(byte))?;
        let length = rest[start..].iter().position(|&byte| is_blank(byte)).unwrap_or(rest.len() - start);
        self.at += start + length;
        Some(&rest[start..start + length])
    }

    /// The next word and the place of its line.
    pub(super) fn next(&mut self) -> Option<(usize, &'a [u8])> {
        loop {
            if let Some(word) = self.next_in_line() {
                return Some((self.start, word));
            }
            let (start, line) = self.lines.next()?;
            let line = line.split(|&byte| byte == b'#').next().unwrap_or(line);
            (self.start, self.line, self.at) = (start, line, 0);
        }
    }

    /// The next word, which must be there.
    pub(super) fn next_or(&mut self, what: &str) -> Result<(usize, &'a [u8]), Error> {
        self.next().ok_or_else(|| {
            self.source.line_error(
                self.source.data.len(),
                format!("the file ends where {what} is expected"),
                "the file is truncated or its counts are wrong, export it again",
            )
        })
    }

    /// Goes to the end of the current line; tells whether words were left in it.
    pub(super) fn skip_line(&mut self) -> bool {
        let left = self.next_in_line().is_some();
        self.at = self.line.len();
        left
    }

    /// The current line.
    pub(super) const fn line(&self) -> &'a [u8] {
        self.line
    }

    /// Offset of what comes next.
    pub(super) fn offset(&self) -> usize {
        let left = self.line[self.at..].iter().any(|&byte| !is_blank(byte));
        if left { self.start + self.at } else { self.lines.offset() }
    }
}
