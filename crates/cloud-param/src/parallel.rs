//! Work spread over threads (the only file that knows `rayon`).

use rayon::prelude::*;

/// Items per task.
const CHUNK: usize = 64;

/// `[f(0), f(1), …, f(count − 1)]`, in parallel; the results do not depend on the number of threads.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().with_min_len(CHUNK).map(f).collect()
}

/// The same for few calls that take long.
pub(crate) fn tasks<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().map(f).collect()
}
