//! Many queries at once.

pub(crate) use lanes::fill;

/// Queries per task: fixed, so that the work is cut in the same places whatever the number of threads.
const CHUNK: usize = 256;

/// `[f(0), f(1), …, f(count − 1)]`, in parallel.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    lanes::map(count, CHUNK, f)
}

/// Fills a list by stretches, in parallel; `f` is told the index of the first of each. Answers are written where they stay: joined from
/// parts, long lists would take twice the memory.
pub(crate) fn fill_frames<T: Send>(out: &mut [T], f: impl Fn(usize, &mut [T]) + Sync) {
    fill(out, CHUNK, f);
}

/// The same where `f` may leave something in a scratch memory that saves the next one time, but does not change its result.
pub(crate) fn map_with<S: Send, T: Send>(
    count: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    lanes::map_with(count, CHUNK, scratch, f)
}
