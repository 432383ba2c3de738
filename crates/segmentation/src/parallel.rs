//! Work in parallel, with results in order.

pub(crate) use lanes::tasks as map;

/// Items of a task of [`flat_chunks`].
const CHUNK: usize = 64;

/// What `f` makes of chunks of the items, in their order.
pub(crate) fn flat_chunks<T: Sync, R: Send>(items: &[T], f: impl Fn(&[T]) -> Vec<R> + Sync) -> Vec<R> {
    lanes::ranges(items.len(), CHUNK, |range| f(&items[range])).into_iter().flatten().collect()
}
