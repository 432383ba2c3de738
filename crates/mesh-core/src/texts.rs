//! Texts of points.

use std::fmt;

/// A named text per point, such as the name of the point or a code for what was measured.
///
/// ```
/// let mut names = mesh_core::TextField::new("name");
/// names.push("bore 1");
/// names.push("");
/// assert_eq!((names.len(), names.get(0), names.get(2)), (2, Some("bore 1"), None));
/// ```
#[derive(Clone, PartialEq, Eq, Default)]
pub struct TextField {
    name: String,
    /// All texts one after another, and where each of them ends: much less memory than a `String` for each.
    text: String,
    ends: Vec<usize>,
}

impl TextField {
    /// No texts under a name.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), text: String::new(), ends: Vec::new() }
    }

    /// What the texts are called in files.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Calls the texts something else.
    #[must_use]
    pub fn with_name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Adds the text of the next point.
    pub fn push(&mut self, text: &str) {
        self.text.push_str(text);
        self.ends.push(self.text.len());
    }

    /// Number of points.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no point.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The text of the point at `index`, if it exists; empty where the point has none.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<&str> {
        let end = *self.ends.get(index)?;
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        self.text.get(start..end)
    }

    /// The texts in the order of the points.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        (0..self.len()).filter_map(|index| self.get(index))
    }

    /// The texts at the given indices, which must exist.
    pub(crate) fn select(&self, indices: &[u32]) -> Self {
        let mut out = Self::new(self.name.as_str());
        indices.iter().for_each(|&index| out.push(self.get(index as usize).unwrap_or_default()));
        out
    }

    /// Drops the texts of the points whose flag is false.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        let mut out = Self::new(std::mem::take(&mut self.name));
        self.iter().zip(keep).filter(|(_, keep)| **keep).for_each(|(text, _)| out.push(text));
        *self = out;
    }
}

impl fmt::Debug for TextField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: ", self.name)?;
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selects_and_drops() {
        let mut field = TextField::new("code");
        ["a", "", "ccc"].into_iter().for_each(|text| field.push(text));
        assert_eq!(field.select(&[2, 2, 0, 1]).iter().collect::<Vec<_>>(), ["ccc", "ccc", "a", ""]);
        field.retain(&[true, false, true]);
        assert_eq!(format!("{field:?}"), "\"code\": [\"a\", \"ccc\"]");
        assert_eq!(field.name(), "code");
    }
}
