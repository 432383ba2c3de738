//! Words for numbers of things.

/// A number of things: `1 point`, `2 points`.
pub(crate) fn counted(count: usize, thing: &str) -> String {
    if count == 1 { format!("1 {thing}") } else { format!("{count} {thing}s") }
}
