//! Work on many nodes or contours (the only file that knows `rayon`).

use rayon::prelude::*;

/// Nodes per task.
const CHUNK: usize = 1024;

/// `[f(0), f(1), …, f(count − 1)]`, in parallel.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().with_min_len(CHUNK).map(f).collect()
}

/// `[f(0), f(1), …, f(count − 1)]` of calls that take long, in parallel.
pub(crate) fn tasks<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().map(f).collect()
}
