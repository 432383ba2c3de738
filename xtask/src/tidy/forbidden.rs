//! Leftovers: unfinished code, debug output, paths of one machine.

use super::finding::Finding;
use crate::workspace::File;

/// Macros that must not stay in any source file, without the exclamation mark (so that this file does not find itself).
const MACROS: &[(&str, &str)] = &[
    ("todo", "write the code, or leave the function out"),
    ("unimplemented", "write the code, or return an error that says what is not supported"),
    ("dbg", "remove the debug output"),
];

/// Folders that exist on one machine only, in two halves for the same reason.
const PLACES: &[(&str, &str)] =
    &[("/wor", "k/"), ("/tm", "p/"), ("../sha", "red"), ("/ho", "me/"), ("/ro", "ot/")];

/// Finds forbidden macros in sources and machine paths in all text of the project.
pub(crate) fn check(files: &[File]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in files {
        for (number, line) in file.numbered_lines() {
            if file.has_extension("rs") {
                for (name, todo) in MACROS {
                    if calls(line, name) {
                        findings.push(Finding::error(
                            &file.path,
                            number,
                            format!("`{name}!` left in the source"),
                            *todo,
                        ));
                    }
                }
            }
            for (first, second) in PLACES {
                let place = format!("{first}{second}");
                if names_place(line, &place) {
                    findings.push(Finding::error(
                        &file.path,
                        number,
                        format!("the path `{place}` exists on one machine only"),
                        "use a path from the workspace root, or a temporary folder of the test",
                    ));
                }
            }
        }
    }
    findings
}

/// Whether `line` calls the macro `name`: the name as a word of its own, `!`, an opening bracket.
fn calls(line: &str, name: &str) -> bool {
    let invocation = format!("{name}!");
    line.match_indices(&invocation).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        let after = line[at + invocation.len()..].trim_start().chars().next();
        !before.is_some_and(|c| c.is_alphanumeric() || c == '_') && after.is_some_and(|c| "([{".contains(c))
    })
}

/// Whether `line` holds `place` as the start of a path (a path such as `a/tmp/b` is none of one machine).
fn names_place(line: &str, place: &str) -> bool {
    line.match_indices(place).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        !before.is_some_and(|c| c.is_alphanumeric() || "_-./}".contains(c))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leftovers_are_found_with_their_line() {
        let text = format!("fn f() {{\n    to{}!()\n}}\n// see {}{}file\n", "do", PLACES[0].0, PLACES[0].1);
        let findings = check(&[File::in_memory("a.rs", &text)]);
        assert_eq!(findings.iter().map(|finding| finding.line).collect::<Vec<_>>(), [2, 4]);
    }

    #[test]
    fn words_that_only_look_alike_pass() {
        let text = "// no todo! is left\nmy_todo![1];\nlet path = \"a/work/b\";\nlet url = \"https://x.org/tmp/\";\n";
        assert!(check(&[File::in_memory("a.rs", text)]).is_empty());
        let prose = File::in_memory("a.md", "never `dbg!` in a source");
        assert!(check(&[prose]).is_empty());
    }
}
