//! Work on many nodes or contours.

pub(crate) use lanes::tasks;

/// Nodes per task.
const CHUNK: usize = 1024;

/// `[f(0), f(1), …, f(count − 1)]`, in parallel.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    lanes::map(count, CHUNK, f)
}
