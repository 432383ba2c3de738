//! Lines of text files that are larger than memory.

use std::fs::File;
use std::io::{self, Read};

use memchr::memchr2;

/// Bytes that are read at a time.
const CHUNK: usize = 1 << 20;
/// Longest line that is read so; files with longer ones are no tables.
const LONGEST: usize = 1 << 16;

/// Lines one after another, which end as those of a text in memory: with `\n`, `\r\n` or `\r`.
#[derive(Debug)]
pub(crate) struct TextLines {
    file: File,
    buffer: Vec<u8>,
    /// Place in the buffer of what comes next.
    at: usize,
    is_at_end: bool,
}

impl TextLines {
    /// The lines of a file from where it is read next.
    pub(crate) fn new(file: File) -> Self {
        Self { file, buffer: Vec::new(), at: 0, is_at_end: false }
    }

    /// The next line without its end; `None` at the end of the file.
    ///
    /// # Errors
    /// Those of the file; [`io::ErrorKind::InvalidData`] for a line that is too long.
    pub(crate) fn next(&mut self) -> io::Result<Option<&[u8]>> {
        let mut searched = 0;
        loop {
            let rest = &self.buffer[self.at..];
            let found = memchr2(b'\n', b'\r', &rest[searched..]).map(|place| place + searched);
            // Whether `\n` follows `\r` is known only when more has been read.
            let is_open = found.is_none_or(|end| rest[end] == b'\r' && end + 1 == rest.len());
            if !is_open || self.is_at_end {
                if rest.is_empty() {
                    return Ok(None);
                }
                let length = found.unwrap_or(rest.len());
                let ending = match rest.get(length..) {
                    Some([b'\r', b'\n', ..]) => 2,
                    Some([]) | None => 0,
                    Some(_) => 1,
                };
                let start = self.at;
                self.at += length + ending;
                return Ok(Some(&self.buffer[start..start + length]));
            }
            searched = found.unwrap_or(rest.len());
            if searched > LONGEST {
                return Err(io::ErrorKind::InvalidData.into());
            }
            self.read_more()?;
        }
    }

    fn read_more(&mut self) -> io::Result<()> {
        self.buffer.drain(..self.at);
        self.at = 0;
        let more = (&mut self.file).take(CHUNK as u64).read_to_end(&mut self.buffer)?;
        self.is_at_end = more == 0;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Lines;
    use std::io::Write;

    #[test]
    fn the_lines_are_those_of_the_text_in_memory() {
        let mut text = Vec::new();
        for i in 0..200_000u32 {
            text.extend(i.to_string().into_bytes());
            text.extend([b"\n".as_slice(), b"\r\n", b"\r", b"\n\n"][i as usize % 4]);
        }
        for text in [text.clone(), text[..text.len() - 1].to_vec(), b"\r".to_vec(), Vec::new()] {
            let mut file = tempfile::tempfile().unwrap();
            file.write_all(&text).unwrap();
            io::Seek::rewind(&mut file).unwrap();
            let mut lines = TextLines::new(file);
            for (_, expected) in Lines::new(&text) {
                assert_eq!(lines.next().unwrap(), Some(expected));
            }
            assert_eq!(lines.next().unwrap(), None);
        }
    }

    #[test]
    fn long_lines_are_given_up() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&vec![b'1'; 3 << 20]).unwrap();
        io::Seek::rewind(&mut file).unwrap();
        assert!(TextLines::new(file).next().is_err());
    }
}
