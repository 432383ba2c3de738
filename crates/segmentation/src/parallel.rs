//! Work in parallel, with results in order (the only file that knows `rayon`).

use rayon::prelude::*;

/// Items of a task of [`flat_chunks`].
const CHUNK: usize = 64;

/// `f` of every index below `count`, in their order.
pub(crate) fn map<R: Send>(count: usize, f: impl Fn(usize) -> R + Send + Sync) -> Vec<R> {
    (0..count).into_par_iter().map(f).collect()
}

/// What `f` makes of chunks of the items, in their order.
pub(crate) fn flat_chunks<T: Sync, R: Send>(items: &[T], f: impl Fn(&[T]) -> Vec<R> + Send + Sync) -> Vec<R> {
    items.par_chunks(CHUNK).flat_map_iter(f).collect()
}
