//! No source file is so long that it must hold more than one idea.

use super::finding::Finding;
use crate::workspace::File;

/// Longest source file in lines.
const LIMIT: usize = 500;

/// Finds `.rs` files with more than 500 lines.
pub(crate) fn check(files: &[File]) -> Vec<Finding> {
    files
        .iter()
        .filter(|file| file.has_extension("rs"))
        .map(|file| (file, file.numbered_lines().count()))
        .filter(|(_, lines)| *lines > LIMIT)
        .map(|(file, lines)| {
            Finding::error(
                &file.path,
                LIMIT + 1,
                format!("{lines} lines, at most {LIMIT} are allowed"),
                "split it into modules, each named after the one thing it holds",
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_sharp_and_for_sources_only() {
        let at_limit = File::in_memory("a.rs", &"x\n".repeat(500));
        let beyond = File::in_memory("b.rs", &"x\n".repeat(501));
        let prose = File::in_memory("c.md", &"x\n".repeat(501));
        let findings = check(&[at_limit, beyond, prose]);
        assert_eq!(findings.len(), 1);
        assert!(findings[0].to_string().starts_with("error: b.rs:501: 501 lines"), "{}", findings[0]);
    }
}
