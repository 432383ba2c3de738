//! Every source cited in comments and documents is listed in `docs/REFERENCES.md`.

use super::finding::Finding;
use crate::workspace::File;

const REFERENCES: &str = "docs/REFERENCES.md";

/// Words that tell a place in a source, as they follow a tag and a comma.
const PLACES: &[&str] = &["eq", "sec", "tab", "fig", "alg", "ch", "p.", "pp.", "thm", "example", "app"];

/// Finds cited tags that have no entry, entries with the same tag, and entries nobody cites (a note).
///
/// An entry is a list item that begins `- **[TAG]**`. A citation is `[TAG]` or `[TAG, place]` in a document or in a comment of a
/// source file. A tag is a short name that ends with the year (`HW05`, `BA05`, `Fa12`), or capitals alone (`MPK`) if a place follows.
pub(crate) fn check(files: &[File]) -> Vec<Finding> {
    let entries: Vec<(usize, &str)> = files
        .iter()
        .filter(|file| file.path == REFERENCES)
        .flat_map(File::numbered_lines)
        .filter_map(|(number, line)| Some((number, line.strip_prefix("- **[")?.split_once("]**")?.0)))
        .collect();

    let mut findings = Vec::new();
    let mut cited = vec![false; entries.len()];
    for file in files.iter().filter(|file| file.path != REFERENCES) {
        for (number, line) in file.numbered_lines() {
            let Some(text) = prose(file, line) else {
                continue;
            };
            for tag in tags(text) {
                match entries.iter().position(|(_, entry)| *entry == tag) {
                    Some(index) => cited[index] = true,
                    None => findings.push(Finding::error(
                        &file.path,
                        number,
                        format!("[{tag}] is not in {REFERENCES}"),
                        "correct the tag, or add the source to the list",
                    )),
                }
            }
        }
    }
    for (index, (number, tag)) in entries.iter().enumerate() {
        if entries[..index].iter().any(|(_, earlier)| earlier == tag) {
            findings.push(Finding::error(
                REFERENCES,
                *number,
                format!("[{tag}] is listed twice"),
                "remove or rename one",
            ));
        } else if !cited[index] {
            findings.push(Finding::note(
                REFERENCES,
                *number,
                format!("[{tag}] is not cited"),
                "cite it where it is used, or remove it",
            ));
        }
    }
    findings
}

/// The part of a line that people read: all of a document, the comment of a source line.
fn prose<'a>(file: &File, line: &'a str) -> Option<&'a str> {
    if file.has_extension("md") {
        Some(line)
    } else if file.has_extension("rs") {
        let in_string = |at: usize| line[..at].matches('"').count() % 2 == 1;
        line.match_indices("//").find(|(at, _)| !in_string(*at)).map(|(at, _)| &line[at..])
    } else {
        None
    }
}

/// The tags cited in `text`.
fn tags(text: &str) -> impl Iterator<Item = &str> {
    text.match_indices('[').filter_map(move |(at, _)| {
        let rest = &text[at + 1..];
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric())?;
        let (tag, after) = rest.split_at(end);
        let place = after.strip_prefix(',').map(|place| place.trim_start().to_ascii_lowercase());
        let closes = after.strip_prefix('\\').unwrap_or(after).strip_prefix(']');
        let is_link = closes.is_some_and(|after| after.starts_with(['(', ':']));
        let names_a_place =
            place.as_ref().is_some_and(|place| PLACES.iter().any(|word| place.starts_with(word)));
        let is_citation = match year_digits(tag)? {
            0 => tag.len() >= 2 && names_a_place,
            _ => (closes.is_some() && !is_link) || place.is_some(),
        };
        is_citation.then_some(tag)
    })
}

/// How many digits (2 or none) end a tag; `None` when the word cannot be a tag.
fn year_digits(word: &str) -> Option<usize> {
    let letters = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = word.len() - letters.len();
    let shape_fits = letters.starts_with(|c: char| c.is_ascii_uppercase())
        && letters.len() <= 5
        && letters.chars().all(|c| c.is_ascii_alphabetic());
    let is_capitals = letters.chars().all(|c| c.is_ascii_uppercase());
    (shape_fits && (digits == 2 || digits == 0 && is_capitals)).then_some(digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<&str> {
        tags(text).collect()
    }

    #[test]
    fn tags_are_told_from_other_brackets() {
        assert_eq!(
            found("see [HW05, eq. (7)] and \\[Fa12\\], [MPK, eq. (16)], [PT97, A5.1]"),
            ["HW05", "Fa12", "MPK", "PT97"]
        );
        assert_eq!(
            found("[`Vec`] [OK] [T, N] x[i0] [P, Q] [0, 1] [M10](link) [Foo] [ABCDEF12]"),
            Vec::<&str>::new()
        );
        assert_eq!(found("a citation over two lines [HW05,"), ["HW05"]);
    }

    #[test]
    fn unknown_tags_fail_and_unused_entries_are_notes() {
        let references = File::in_memory(
            REFERENCES,
            "# References\n- **[HW05]** One.\n- **[PT97]** Two.\n- **[PT97]** Again.\n",
        );
        let source = File::in_memory("a.rs", "/// By [HW05, eq. (7)] and [Zz99].\nlet x = [A10, B20];\n");
        let texts: Vec<String> = check(&[references, source]).iter().map(ToString::to_string).collect();
        assert_eq!(texts.len(), 3, "{texts:?}");
        assert!(texts[0].starts_with("error: a.rs:1: [Zz99] is not in"));
        assert!(texts[1].starts_with("note: docs/REFERENCES.md:3: [PT97] is not cited"));
        assert!(texts[2].starts_with("error: docs/REFERENCES.md:4: [PT97] is listed twice"));
    }
}
