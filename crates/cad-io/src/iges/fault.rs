//! What is wrong with an IGES file, and where.

use super::directory::Entry;

/// The entity that a fault is in: directory sequence number and entity type number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EntityId {
    /// Sequence number of its directory entry (odd).
    pub(crate) sequence: u32,
    /// Entity type number.
    pub(crate) kind: u32,
}

impl From<&Entry> for EntityId {
    fn from(entry: &Entry) -> Self {
        Self { sequence: entry.sequence, kind: entry.kind }
    }
}

/// A fault of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    /// Line of the file, counted from 1; 0 for the file as a whole.
    pub(crate) line: usize,
    /// The entity, where it is in one.
    pub(crate) entity: Option<EntityId>,
    /// What was found and what was expected.
    pub(crate) what: String,
    /// What to do.
    pub(crate) advice: &'static str,
    /// Whether the content is valid IGES that is not read here.
    pub(crate) unsupported: bool,
}

/// The usual cure.
pub(crate) const EXPORT_AGAIN: &str = "the file is damaged: export it again";

impl Fault {
    /// A fault in a line that belongs to no entity.
    pub(crate) fn at_line(line: usize, what: impl Into<String>) -> Self {
        Self { line, entity: None, what: what.into(), advice: EXPORT_AGAIN, unsupported: false }
    }

    /// A fault of an entity as a whole, at the line of its directory entry.
    pub(crate) fn of(entry: &Entry, what: impl Into<String>) -> Self {
        Self { entity: Some(entry.into()), ..Self::at_line(entry.line, what) }
    }

    /// The same with another advice.
    pub(crate) fn with_advice(self, advice: &'static str) -> Self {
        Self { advice, ..self }
    }

    /// The same as content that is valid but not read here.
    pub(crate) fn unsupported(self, advice: &'static str) -> Self {
        Self { advice, unsupported: true, ..self }
    }
}
