//! Many queries at once (the only file that knows `rayon`).

use rayon::prelude::*;

/// Queries per task: fixed, so that the work is cut in the same places whatever the number of threads.
const CHUNK: usize = 256;

/// `[f(0), f(1), …, f(count − 1)]`, in parallel.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().with_min_len(CHUNK).map(f).collect()
}

/// The same where `f` may leave something in a scratch memory that saves the next one time, but does not change its result.
pub(crate) fn map_with<S, T: Send>(
    count: usize,
    scratch: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, usize) -> T + Sync + Send,
) -> Vec<T> {
    (0..count).into_par_iter().with_min_len(CHUNK).map_init(scratch, f).collect()
}

/// Lets `f` fill stretches of `length` entries in parallel; it is told the index of the first of them.
pub(crate) fn fill<T: Send>(out: &mut [T], length: usize, f: impl Fn(usize, &mut [T]) + Sync + Send) {
    out.par_chunks_mut(length.max(1)).enumerate().for_each(|(chunk, out)| f(chunk * length.max(1), out));
}
