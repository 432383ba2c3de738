//! Test data: small, and each file with a known origin and licence.

use super::finding::Finding;
use crate::workspace::File;

/// Most bytes in `fixtures/` altogether.
const LIMIT: u64 = 40_000_000;

const PROVENANCE: &str = "fixtures/PROVENANCE.md";

/// One row of the provenance table: a file name, with `*` for any text, in the folder that the last heading names.
struct Row {
    pattern: String,
    line: usize,
}

/// Finds fixtures that no row of `fixtures/PROVENANCE.md` covers, rows that cover nothing (a note), and too large a folder.
///
/// Headings name folders (`## cad` stands for `fixtures/cad`), the first cell of a row names a file in that folder or a path below
/// it. Licence texts (`fixtures/LICENSES/`) need no row.
pub(crate) fn check(files: &[File]) -> Vec<Finding> {
    let fixtures: Vec<&File> = files.iter().filter(|file| file.path.starts_with("fixtures/")).collect();
    if fixtures.is_empty() {
        return Vec::new();
    }
    let mut findings = Vec::new();
    let total: u64 = fixtures.iter().map(|file| file.size).sum();
    if total > LIMIT {
        findings.push(Finding::error(
            "fixtures",
            0,
            format!("{total} bytes, at most {LIMIT} are allowed"),
            "take out the largest files, or replace them by smaller ones that show the same",
        ));
    }
    let rows = fixtures.iter().find(|file| file.path == PROVENANCE).map_or_else(Vec::new, |file| rows(file));
    let mut used = vec![false; rows.len()];
    for file in fixtures {
        let name = &file.path["fixtures/".len()..];
        if name == "PROVENANCE.md" || name.starts_with("LICENSES/") {
            continue;
        }
        let mut is_covered = false;
        for (row, used) in rows.iter().zip(&mut used) {
            if matches(&row.pattern, name) {
                is_covered = true;
                *used = true;
            }
        }
        if !is_covered {
            findings.push(Finding::error(
                &file.path,
                0,
                "its origin is not known",
                format!("add a row with source and licence to {PROVENANCE}, under the heading of its folder"),
            ));
        }
    }
    for (row, _) in rows.iter().zip(used).filter(|(_, used)| !used) {
        findings.push(Finding::note(
            PROVENANCE,
            row.line,
            format!("no file is named `{}`", row.pattern),
            "remove the row",
        ));
    }
    findings
}

fn rows(provenance: &File) -> Vec<Row> {
    let mut folder = String::new();
    let mut rows = Vec::new();
    let mut is_body = false;
    for (line, text) in provenance.numbered_lines() {
        if text.starts_with('#') {
            let heading = text.trim_start_matches('#').trim().trim_matches('`').trim_end_matches('/');
            folder = heading.strip_prefix("fixtures").unwrap_or(heading).trim_start_matches('/').to_owned();
        }
        let Some(cells) = text.trim().strip_prefix('|') else {
            is_body = false;
            continue;
        };
        let first = cells.split('|').next().unwrap_or_default().trim().trim_matches('`');
        if first.starts_with("--") || first.starts_with(":-") {
            is_body = true;
        } else if is_body && !first.is_empty() {
            let first = first.strip_prefix("fixtures/").unwrap_or(first);
            let pattern = if folder.is_empty() || first.starts_with(&format!("{folder}/")) {
                first.to_owned()
            } else {
                format!("{folder}/{first}")
            };
            rows.push(Row { pattern, line });
        }
    }
    rows
}

/// Whether `name` is of the form `pattern`, where each `*` stands for any text.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((head, tail)) => name.strip_prefix(head).is_some_and(|rest| {
            (0..=rest.len()).any(|at| rest.is_char_boundary(at) && matches(tail, &rest[at..]))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "# Provenance\n\n## cad\n\n| file | source |\n|---|---|\n| a.step | ours |\n| gone.step | ours |\n\n\
                         ## `fixtures/feet/`\n| file | source |\n|---|---|\n| `c_*.q` | ours |\n";

    fn fixture(path: &str, size: u64) -> File {
        File { path: path.into(), size, text: None }
    }

    #[test]
    fn rows_and_wildcards_cover_files() {
        let files = [
            File::in_memory(PROVENANCE, TABLE),
            fixture("fixtures/LICENSES/x.txt", 1),
            fixture("fixtures/cad/a.step", 1),
            fixture("fixtures/feet/c_hw2.on.q", 1),
        ];
        let findings = check(&files);
        assert_eq!(findings.len(), 1);
        assert_eq!(
            findings[0].to_string(),
            "note: fixtures/PROVENANCE.md:8: no file is named `cad/gone.step`; remove the row"
        );
    }

    #[test]
    fn unknown_origin_and_size_fail() {
        let files = [File::in_memory(PROVENANCE, TABLE), fixture("fixtures/scans/a.step", 1)];
        assert!(check(&files)[0].what.contains("origin is not known"));
        let findings = check(&[fixture("fixtures/cad/a.step", LIMIT + 1)]);
        assert!(findings[0].what.contains("at most 40000000"), "{}", findings[0]);
        assert!(check(&[fixture("crates/a.bin", LIMIT + 1)]).is_empty());
    }
}
