//! Independent work on all cores (the only file that knows `rayon`).

use rayon::prelude::*;

/// `[f(0), f(1), …, f(count − 1)]`, in parallel, in order; at least `grain` calls per task.
pub(crate) fn map<T: Send>(count: usize, grain: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().with_min_len(grain.max(1)).map(f).collect()
}
