//! Heavy dependencies stay replaceable: in each crate one file knows them, and no public signature does.

use super::finding::Finding;
use crate::workspace::{File, Package};

/// Dependencies that only one file of a crate may name, and that no `pub` item may show.
const WRAPPED: &[&str] = &["faer", "kiddo", "pulp", "rayon"];

/// Finds crates that name a wrapped dependency in more than one file of `src`, and public items that show one.
pub(crate) fn check(packages: &[Package], files: &[File]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for package in packages {
        let folder = format!("{}/src/", package.folder());
        for dependency in WRAPPED {
            let sources =
                files.iter().filter(|file| file.path.starts_with(&folder) && file.has_extension("rs"));
            let users: Vec<(&File, usize)> = sources
                .filter_map(|file| {
                    Some((file, file.numbered_lines().find(|(_, line)| names(line, dependency))?.0))
                })
                .collect();
            for (file, line) in users.iter().skip(1) {
                findings.push(Finding::error(
                    &file.path,
                    *line,
                    format!("`{dependency}` is known to {} already", users[0].0.path),
                    "call that file instead, so that the dependency stays replaceable",
                ));
            }
            for (file, _) in &users {
                let shows_it = |line: &str| line.trim_start().starts_with("pub ") && names(line, dependency);
                if let Some((line, _)) = file.numbered_lines().find(|(_, line)| shows_it(line)) {
                    findings.push(Finding::error(
                        &file.path,
                        line,
                        format!("a public item shows `{dependency}`"),
                        "take and return types of our own or of nalgebra",
                    ));
                }
            }
        }
    }
    findings
}

/// Whether the code of a line (not its comment) has a path that begins with `dependency`.
fn names(line: &str, dependency: &str) -> bool {
    let code = line.split("//").next().unwrap_or(line);
    code.match_indices(dependency).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        let is_start = !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':' || c == '"');
        is_start && code[at + dependency.len()..].starts_with("::")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package() -> Package {
        Package {
            name: "a".into(),
            description: String::new(),
            manifest: "crates/a/Cargo.toml".into(),
            dependencies: Vec::new(),
        }
    }

    #[test]
    fn one_private_user_passes() {
        let user = File::in_memory(
            "crates/a/src/solve.rs",
            "use faer::Mat;\npub(crate) fn solve(m: faer::Mat<f64>) {}\n",
        );
        let talker = File::in_memory(
            "crates/a/src/lib.rs",
            "// faer::Mat is hidden in solve.rs\nuse crate::faer::x;\n",
        );
        let test = File::in_memory("crates/a/tests/t.rs", "use faer::Mat;\n");
        assert!(check(&[package()], &[user, talker, test]).is_empty());
    }

    #[test]
    fn second_users_and_public_signatures_fail() {
        let first = File::in_memory("crates/a/src/solve.rs", "\npub fn solve(m: faer::Mat<f64>) {}\n");
        let second = File::in_memory("crates/a/src/two.rs", "use faer::Mat;\n");
        let findings = check(&[package()], &[first, second]);
        assert!(
            findings[0].to_string().starts_with("error: crates/a/src/two.rs:1: `faer` is known to"),
            "{}",
            findings[0]
        );
        assert!(
            findings[1].to_string().starts_with("error: crates/a/src/solve.rs:2: a public item shows"),
            "{}",
            findings[1]
        );
    }
}
