//! Work spread over threads.

pub(crate) use lanes::tasks;

/// Items per task.
const CHUNK: usize = 64;

/// `[f(0), f(1), …, f(count − 1)]`, in parallel; the results do not depend on the number of threads.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    lanes::map(count, CHUNK, f)
}
