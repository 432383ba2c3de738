//! Work on many things at once.

/// The results for all items, in their order.
pub(crate) fn map<I: Sync, T: Send>(items: &[I], f: impl Fn(&I) -> T + Sync) -> Vec<T> {
    lanes::tasks(items.len(), |index| f(&items[index]))
}
