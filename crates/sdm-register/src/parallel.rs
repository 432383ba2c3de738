//! Sums over many points.

pub(crate) use lanes::tasks;
use std::ops::Range;

/// Points per task: fixed, so that sums are taken in the same order whatever the number of threads.
const CHUNK: usize = 1024;

/// The results of `f` on consecutive ranges of `0..count`, in their order.
pub(crate) fn ranges<T: Send>(count: usize, f: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    lanes::ranges(count, CHUNK, f)
}

/// `[f(0), f(1), …, f(count − 1)]`, in parallel.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    lanes::map(count, CHUNK, f)
}
