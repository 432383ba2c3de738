//! The lines of an IGES file: 80 columns, the section letter in column 73, the number within the section after it.

use super::fault::Fault;

/// Column of the section letter, counted from 0.
const LETTER: usize = 72;
/// Columns of a record.
const WIDTH: usize = 80;

/// One line of a section.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    /// Number in the file, counted from 1.
    pub(crate) number: usize,
    /// Columns 1 to 72; shorter where the writer left out blanks.
    pub(crate) text: &'a [u8],
}

impl<'a> Line<'a> {
    /// Columns `start..end`, counted from 0, as far as the line has them.
    pub(crate) fn columns(&self, start: usize, end: usize) -> &'a [u8] {
        &self.text[start.min(self.text.len())..end.min(self.text.len())]
    }
}

/// The lines of the sections that hold data.
#[derive(Debug, Default)]
pub(crate) struct Records<'a> {
    /// Global section.
    pub(crate) global: Vec<Line<'a>>,
    /// Directory entry section.
    pub(crate) directory: Vec<Line<'a>>,
    /// Parameter data section.
    pub(crate) parameters: Vec<Line<'a>>,
}

/// Whether the bytes begin like an IGES file in ASCII form.
#[must_use]
pub fn is_iges(data: &[u8]) -> bool {
    let Some((_, first)) = lines(data).next() else { return false };
    first.get(LETTER) == Some(&b'S') && sequence(first) == Some(1)
}

impl<'a> Records<'a> {
    /// Sorts the lines of a file by section.
    ///
    /// Sequence numbers are checked: pointers of the file count lines, so one that is lost or doubled would silently
    /// lead to other entities.
    pub(crate) fn new(data: &'a [u8]) -> Result<Self, Fault> {
        let mut found = Self::default();
        let mut last = b'S';
        let mut count_in_section = 0;
        for (number, line) in lines(data) {
            if line.trim_ascii().is_empty() {
                continue;
            }
            let (text, letter) = split(line).ok_or_else(|| {
                Fault::at_line(number, "the line has no section letter (S, G, D, P or T) in column 73")
            })?;
            check_form(letter, number)?;
            if rank(letter) < rank(last) {
                let what = format!(
                    "a line of section {} after one of section {}",
                    char::from(letter),
                    char::from(last)
                );
                return Err(Fault::at_line(number, what));
            }
            count_in_section = if letter == last { count_in_section + 1 } else { 1 };
            last = letter;
            let rest = &line[text.len()..];
            if letter != b'T' && sequence_of(rest) != Some(count_in_section) {
                let what = format!(
                    "columns 74 to 80 hold `{}`, but this is line {count_in_section} of section {}",
                    String::from_utf8_lossy(rest.get(1..).unwrap_or_default()).trim(),
                    char::from(letter)
                );
                return Err(Fault::at_line(number, what));
            }
            let line = Line { number, text };
            match letter {
                b'S' => {}
                b'G' => found.global.push(line),
                b'D' => found.directory.push(line),
                b'P' => found.parameters.push(line),
                _ => return Ok(found),
            }
        }
        let line = lines(data).last().map_or(0, |(number, _)| number);
        let what = "the file ends without its last line (section T)";
        Err(Fault::at_line(line, what).with_advice("the file is truncated: export or copy it again"))
    }
}

/// Order of the sections.
fn rank(letter: u8) -> usize {
    b"SGDPT".iter().position(|&known| known == letter).unwrap_or(usize::MAX)
}

/// Refuses the binary and the compressed form.
fn check_form(letter: u8, number: usize) -> Result<(), Fault> {
    let form = match letter {
        b'B' => "binary",
        b'C' => "compressed ASCII",
        _ => return Ok(()),
    };
    let what = format!("this is an IGES file in {form} form, which is not read");
    Err(Fault::at_line(number, what).unsupported("export it in (fixed format) ASCII form"))
}

/// Columns 1 to 72 and the section letter of a line.
fn split(line: &[u8]) -> Option<(&[u8], u8)> {
    let known = |letter: u8| b"SGDPTBC".contains(&letter);
    if let Some(&letter) = line.get(LETTER).filter(|&&letter| known(letter)) {
        return Some((&line[..LETTER], letter));
    }
    // Writers that count characters of UTF-8, not bytes.
    let text = std::str::from_utf8(line).ok()?;
    let (at, _) = text.char_indices().nth(LETTER)?;
    let letter = line[at];
    known(letter).then(|| (&line[..at], letter))
}

/// The sequence number of a line with its letter in column 73.
fn sequence(line: &[u8]) -> Option<u64> {
    sequence_of(line.get(LETTER..)?)
}

/// The sequence number after the section letter.
fn sequence_of(rest: &[u8]) -> Option<u64> {
    integer(&rest[1.min(rest.len())..rest.len().min(WIDTH - LETTER)])
}

/// An unsigned number between blanks.
fn integer(field: &[u8]) -> Option<u64> {
    std::str::from_utf8(field.trim_ascii()).ok()?.parse().ok()
}

/// Lines with their numbers: ended by LF, CR LF or CR, or records of 80 bytes without any end.
fn lines(data: &[u8]) -> Box<dyn Iterator<Item = (usize, &[u8])> + '_> {
    let head = &data[..data.len().min(4 * WIDTH)];
    let ended = if head.contains(&b'\n') {
        Some(b'\n')
    } else if head.contains(&b'\r') {
        Some(b'\r')
    } else {
        None
    };
    match ended {
        Some(end) => {
            let parts = data.split(move |&byte| byte == end);
            Box::new((1..).zip(parts.map(|line| line.strip_suffix(b"\r").unwrap_or(line))))
        }
        None => Box::new((1..).zip(data.chunks(WIDTH))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(text: &str, letter: char, sequence: usize) -> String {
        format!("{text:<72}{letter}{sequence:>7}\n")
    }

    fn small() -> String {
        line("part", 'S', 1)
            + &line("1H,,1H;;", 'G', 1)
            + &line("", 'D', 1)
            + &line("", 'D', 2)
            + &line("", 'P', 1)
            + &line("S      1G      1D      2P      1", 'T', 1)
    }

    #[test]
    fn sections_with_all_ends_of_lines() {
        let text = small();
        for form in
            [text.clone(), text.replace('\n', "\r\n"), text.replace('\n', "\r"), text.replace('\n', "")]
        {
            assert!(is_iges(form.as_bytes()));
            let found = Records::new(form.as_bytes()).unwrap();
            let counts = [found.global.len(), found.directory.len(), found.parameters.len()];
            assert_eq!((counts, found.directory[1].number), ([1, 2, 1], 4));
        }
    }

    #[test]
    fn lines_that_are_lost_are_noticed() {
        let text = small();
        let without = |index: usize| {
            let kept = text.lines().enumerate().filter(|(i, _)| *i != index);
            kept.map(|(_, line)| format!("{line}\n")).collect::<String>()
        };
        let fault = Records::new(without(2).as_bytes()).unwrap_err();
        assert_eq!(fault.line, 3);
        assert!(fault.what.contains("columns 74 to 80 hold `2`"), "{fault:?}");
        let fault = Records::new(without(5).as_bytes()).unwrap_err();
        assert!(fault.advice.contains("truncated"), "{fault:?}");
        let binary = text.replacen("S      1", "B      1", 1);
        assert!(Records::new(binary.as_bytes()).unwrap_err().unsupported);
    }
}
