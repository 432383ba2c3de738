//! Work spread over threads, with results that do not depend on their number (the only file that knows `rayon`).

use rayon::prelude::*;

/// Items per task: enough to hide the cost of a task, few enough to keep all threads busy to the end.
const CHUNK: usize = 256;

/// `f(0), f(1), …` in order.
pub(crate) fn map<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    map_with(count, || (), |(), index| f(index))
}

/// `f(scratch, 0), f(scratch, 1), …` in order; the scratch memory must not carry anything from item to item.
pub(crate) fn map_with<S, T: Send>(
    count: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    let chunks = count.div_ceil(CHUNK);
    let task = |chunk: usize| {
        let mut scratch = scratch();
        let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(count);
        range.map(|index| f(&mut scratch, index)).collect::<Vec<T>>()
    };
    // One chunk, and what is called from many threads already, stays on its thread.
    if chunks <= 1 {
        return (0..chunks).flat_map(task).collect();
    }
    let parts: Vec<Vec<T>> = (0..chunks).into_par_iter().map(task).collect();
    let mut all = Vec::with_capacity(count);
    all.extend(parts.into_iter().flatten());
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_order() {
        for count in [0, 1, CHUNK, CHUNK + 1, 10 * CHUNK - 1] {
            assert_eq!(map(count, |index| 3 * index), (0..count).map(|index| 3 * index).collect::<Vec<_>>());
        }
    }
}
