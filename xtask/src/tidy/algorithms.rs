//! The table that leads from equations to functions names functions that exist.

use super::finding::Finding;
use crate::workspace::File;

const ALGORITHMS: &str = "docs/ALGORITHMS.md";

/// Finds paths such as `footpoint::step` in `docs/ALGORITHMS.md` whose last part is not defined in the crate named by the first.
pub(crate) fn check(files: &[File]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (number, line) in files.iter().filter(|file| file.path == ALGORITHMS).flat_map(File::numbered_lines) {
        for path in line.split('`').skip(1).step_by(2).filter(|span| is_path(span)) {
            let (crate_name, rest) = path.split_once("::").unwrap_or((path, ""));
            let name = rest.rsplit("::").next().unwrap_or(rest);
            let folder = format!("crates/{}/src/", crate_name.replace('_', "-"));
            let sources = files.iter().filter(|file| file.path.starts_with(&folder));
            if !sources.flat_map(File::numbered_lines).any(|(_, line)| defines(line, name)) {
                findings.push(Finding::error(
                    ALGORITHMS,
                    number,
                    format!("`{path}` does not exist (nothing called `{name}` in {folder})"),
                    "correct the name, or remove the row",
                ));
            }
        }
    }
    findings
}

/// Whether a code span is a path of identifiers, with at least one `::`.
fn is_path(span: &str) -> bool {
    let is_identifier = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    span.contains("::") && span.split("::").all(is_identifier)
}

/// Whether a source line defines an item or an enum variant called `name`.
fn defines(line: &str, name: &str) -> bool {
    const KINDS: &[&str] = &["fn ", "const fn ", "struct ", "enum ", "trait ", "const ", "type ", "mod "];
    let line = line.trim_start();
    let code = line.strip_prefix("pub(crate) ").or_else(|| line.strip_prefix("pub ")).unwrap_or(line);
    let is_item =
        KINDS.iter().filter_map(|kind| code.strip_prefix(kind)?.strip_prefix(name)).any(ends_a_word);
    let is_variant = name.starts_with(char::is_uppercase)
        && line.strip_prefix(name).is_some_and(|rest| rest.starts_with([',', '(']) || rest.starts_with(" {"));
    is_item || is_variant
}

/// Whether a word that stands before `rest` ends there.
fn ends_a_word(rest: &str) -> bool {
    !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_must_name_what_exists() {
        let table = File::in_memory(
            ALGORITHMS,
            "| eq | `a_b::step` and `a_b::Kind::Fast` |\n| x | `a_b::missing` | `κ = 1` |\n",
        );
        let source = File::in_memory(
            "crates/a-b/src/lib.rs",
            "pub(crate) fn step<T>() {}\npub enum Kind {\n    Fast,\n}\nlet missing = 1;\n",
        );
        let findings = check(&[table, source]);
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert_eq!(findings[0].line, 2);
        assert!(findings[0].what.contains("nothing called `missing` in crates/a-b/src/"));
    }
}
