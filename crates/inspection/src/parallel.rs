//! Many points at once (the only file that knows `rayon`).

use footpoint::Progress;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Points per task: fixed, so that the work is cut in the same places whatever the number of threads.
const CHUNK: usize = 512;

/// `[f(0), f(1), …, f(count − 1)]`, in parallel. `progress` hears how many are done and can break off; the rest is then
/// `cancelled`.
pub(crate) fn map<T: Clone + Send + Sync>(
    count: usize,
    cancelled: &T,
    progress: Progress<'_>,
    f: impl Fn(usize) -> T + Sync + Send,
) -> Vec<T> {
    let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let starts: Vec<usize> = (0..count).step_by(CHUNK).collect();
    let task = |&start: &usize| -> Vec<T> {
        let end = count.min(start + CHUNK);
        if stop.load(Ordering::Relaxed) {
            return vec![cancelled.clone(); end - start];
        }
        let out = (start..end).map(&f).collect();
        let total = done.fetch_add(end - start, Ordering::Relaxed) + end - start;
        if progress(total, count).is_break() {
            stop.store(true, Ordering::Relaxed);
        }
        out
    };
    let chunks: Vec<Vec<T>> = starts.par_iter().map(task).collect();
    chunks.into_iter().flatten().collect()
}
