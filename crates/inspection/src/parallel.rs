//! Many points at once.

use footpoint::Progress;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Points per task: fixed, so that the work is cut in the same places whatever the number of threads.
const CHUNK: usize = 512;
/// Tasks whose results are held at once.
const ROUND: usize = 128;

/// Hands over `(i, f(i))` for all `i` below `count`, computed in parallel, a round of consecutive ones at a time. `progress`
/// hears how many are done and can break off; the rest is then `cancelled`.
pub(crate) fn each<T: Clone + Send + Sync>(
    count: usize,
    cancelled: &T,
    progress: Progress<'_>,
    f: &(dyn Fn(usize) -> T + Sync),
    receive: &mut dyn FnMut(&[(usize, T)]),
) {
    let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let task = |start: usize| -> Vec<(usize, T)> {
        let end = count.min(start + CHUNK);
        if stop.load(Ordering::Relaxed) {
            return (start..end).map(|index| (index, cancelled.clone())).collect();
        }
        let out = (start..end).map(|index| (index, f(index))).collect();
        let total = done.fetch_add(end - start, Ordering::Relaxed) + end - start;
        if progress(total, count).is_break() {
            stop.store(true, Ordering::Relaxed);
        }
        out
    };
    for first in (0..count).step_by(CHUNK * ROUND) {
        let starts: Vec<usize> = (first..count.min(first + CHUNK * ROUND)).step_by(CHUNK).collect();
        let chunks: Vec<Vec<(usize, T)>> = lanes::tasks(starts.len(), |k| task(starts[k]));
        receive(&chunks.into_iter().flatten().collect::<Vec<_>>());
    }
}
