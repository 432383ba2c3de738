//! Snapshot files that no test reads any more, and pending ones that nobody accepted.

use super::finding::Finding;
use crate::workspace::File;

/// Finds `.snap` files whose test source is gone or does not name them, and `.snap.new` files.
///
/// insta names a file `MODULE__PATH__NAME.snap` and writes the source into its header; NAME is the first argument of
/// `assert_snapshot!` or the name of the test function, without a leading `test_`, with `-2`, `-3`, … for further ones.
pub(crate) fn check(files: &[File]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for file in files {
        if file.path.ends_with(".snap.new") {
            findings.push(Finding::error(
                &file.path,
                0,
                "a snapshot nobody accepted",
                "rename it to .snap if it is right, delete it if not",
            ));
        } else if file.has_extension("snap") {
            findings.extend(check_one(file, files));
        }
    }
    findings
}

fn check_one(snapshot: &File, files: &[File]) -> Option<Finding> {
    let source = snapshot
        .numbered_lines()
        .take_while(|(number, line)| *number == 1 || *line != "---")
        .find_map(|(_, line)| line.strip_prefix("source:"));
    let Some(source) = source.map(|value| value.trim().trim_matches('"')) else {
        return Some(Finding::error(
            &snapshot.path,
            1,
            "the header names no source",
            "write it anew with INSTA_UPDATE=always cargo test",
        ));
    };
    let Some(test) = files.iter().find(|file| file.path == source) else {
        return Some(Finding::error(
            &snapshot.path,
            1,
            format!("its test {source} is gone"),
            "delete the snapshot",
        ));
    };
    let name = name_of(&snapshot.path);
    let ways_to_name_it = [format!("\"{name}\""), format!("fn {name}("), format!("fn test_{name}(")];
    let is_named =
        test.numbered_lines().any(|(_, line)| ways_to_name_it.iter().any(|way| line.contains(way.as_str())));
    if is_named {
        return None;
    }
    Some(Finding::error(
        &snapshot.path,
        1,
        format!("no test in {source} reads it"),
        format!("delete it, or name it in the test as a literal \"{name}\""),
    ))
}

/// NAME out of `…/MODULE__PATH__NAME-2.snap`.
fn name_of(path: &str) -> &str {
    let stem = path.rsplit('/').next().unwrap_or(path).trim_end_matches(".snap");
    let name = stem.rsplit("__").next().unwrap_or(stem);
    match name.rsplit_once('-') {
        Some((base, number)) if !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()) => {
            base
        }
        _ => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot(path: &str) -> File {
        File::in_memory(path, "---\nsource: crates/a/tests/t.rs\nexpression: table\n---\nsource: not this\n")
    }

    #[test]
    fn named_snapshots_pass() {
        let test =
            File::in_memory("crates/a/tests/t.rs", "fn table_2() { assert_snapshot!(\"table_1\", x); }\n");
        let folder = "crates/a/tests/snapshots";
        let files = [
            test,
            snapshot(&format!("{folder}/t__table_1.snap")),
            snapshot(&format!("{folder}/t__table_2-3.snap")),
        ];
        assert!(check(&files).is_empty(), "{:?}", check(&files));
    }

    #[test]
    fn orphans_and_pending_ones_fail() {
        let test = File::in_memory("crates/a/tests/t.rs", "fn table_2() {}\n");
        let orphan = snapshot("crates/a/tests/snapshots/t__table_1.snap");
        let findings = check(&[test, orphan.clone(), File::in_memory("x/t__table_2.snap.new", "")]);
        assert!(findings[0].what.contains("no test in crates/a/tests/t.rs reads it"), "{}", findings[0]);
        assert!(findings[1].what.contains("nobody accepted"), "{}", findings[1]);
        assert!(check(&[orphan])[0].what.contains("is gone"));
        assert!(check(&[File::in_memory("x/t__a.snap", "---\n---\n")])[0].what.contains("no source"));
    }
}
