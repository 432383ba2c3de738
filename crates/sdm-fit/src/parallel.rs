//! Work on many points (the only file that knows `rayon`).

use rayon::prelude::*;
use std::ops::Range;

/// Points per task: fixed, so that sums are taken in the same order whatever the number of threads.
const CHUNK: usize = 1024;

/// The results of `f` on consecutive ranges of `0..count`, in their order.
pub(crate) fn ranges<T: Send>(count: usize, f: impl Fn(Range<usize>) -> T + Sync + Send) -> Vec<T> {
    (0..count.div_ceil(CHUNK)).into_par_iter().map(|k| f(k * CHUNK..((k + 1) * CHUNK).min(count))).collect()
}

/// `[f(0), f(1), …, f(count − 1)]`, in parallel.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().with_min_len(CHUNK).map(f).collect()
}

/// `[f(0), f(1), …, f(count − 1)]` of calls that take long, in parallel.
pub(crate) fn tasks<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().map(f).collect()
}
