//! What a check says.

use std::fmt;

/// How much a finding weighs. Notes come first in the output, so that errors stand next to the prompt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Severity {
    /// Worth knowing, fails nothing.
    Note,
    /// Makes the command fail.
    Error,
}

/// One thing to mend: where, what, and what to do about it.
#[derive(Clone, Debug)]
pub(crate) struct Finding {
    pub(crate) severity: Severity,
    /// File from the workspace root.
    pub(crate) path: String,
    /// Line from 1; 0 when the finding is about the whole file.
    pub(crate) line: usize,
    pub(crate) what: String,
    pub(crate) todo: String,
}

impl Finding {
    pub(crate) fn error(path: &str, line: usize, what: impl Into<String>, todo: impl Into<String>) -> Self {
        Self { severity: Severity::Error, path: path.into(), line, what: what.into(), todo: todo.into() }
    }

    pub(crate) fn note(path: &str, line: usize, what: impl Into<String>, todo: impl Into<String>) -> Self {
        Self { severity: Severity::Note, ..Self::error(path, line, what, todo) }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let label = match self.severity {
            Severity::Note => "note",
            Severity::Error => "error",
        };
        write!(f, "{label}: {}", self.path)?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        write!(f, ": {}; {}", self.what, self.todo)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_tells_where_what_and_what_to_do() {
        assert_eq!(
            Finding::error("a.rs", 3, "broken", "mend it").to_string(),
            "error: a.rs:3: broken; mend it"
        );
        assert_eq!(Finding::note("a.rs", 0, "odd", "look").to_string(), "note: a.rs: odd; look");
    }
}
