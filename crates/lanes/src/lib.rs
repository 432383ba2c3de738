//! Work spread over threads whose results do not depend on the number of threads.
//!
//! For the crates of this workspace; its functions may change at any time. Results come in the order of their indices, and tasks are
//! cut in the same places whatever the number of threads.
//!
//! ```
//! assert_eq!(lanes::map(5, 2, |i| i * i), [0, 1, 4, 9, 16]);
//! assert_eq!(lanes::ranges(5, 2, |range| range.sum::<usize>()), [1, 5, 4]);
//! ```

use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Calls `work` with every index below `count`.
///
/// The only place that knows the scheduler. It is not generic: what rayon makes of a call takes longer to compile than most of what is
/// called.
fn spread(count: usize, work: &(dyn Fn(usize) + Sync)) {
    if count <= 1 {
        (0..count).for_each(work);
    } else {
        (0..count).into_par_iter().for_each(work);
    }
}

/// A panic of a task ends all of them, so that no lock is found poisoned.
fn value<T>(lock: Mutex<T>) -> T {
    lock.into_inner().unwrap_or_else(PoisonError::into_inner)
}

fn with<T, R>(lock: &Mutex<T>, change: impl FnOnce(&mut T) -> R) -> R {
    change(&mut lock.lock().unwrap_or_else(PoisonError::into_inner))
}

/// `[f(0), f(1), …, f(count − 1)]` of calls that take long: each is a task.
pub fn tasks<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let slots: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    spread(count, &|index| {
        let result = f(index);
        with(&slots[index], |slot| *slot = Some(result));
    });
    slots.into_iter().filter_map(value).collect()
}

/// The same with scratch memory that one call leaves to another; results must not depend on what is in it.
pub fn tasks_with<S: Send, T: Send>(
    count: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    let left: Mutex<Vec<S>> = Mutex::new(Vec::new());
    tasks(count, |index| {
        let mut memory = with(&left, Vec::pop).unwrap_or_else(&scratch);
        let result = f(&mut memory, index);
        with(&left, |left| left.push(memory));
        result
    })
}

/// The results of `f` on ranges of `length` indices below `count`, in their order; the last range may be shorter.
pub fn ranges<T: Send>(count: usize, length: usize, f: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let length = length.max(1);
    tasks(count.div_ceil(length), |task| f(range(task, length, count)))
}

/// `[f(0), f(1), …, f(count − 1)]`; `length` of them are a task.
pub fn map<T: Send>(count: usize, length: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    joined(ranges(count, length, |range| range.map(&f).collect()))
}

/// The same with scratch memory, as in [`tasks_with`].
pub fn map_with<S: Send, T: Send>(
    count: usize,
    length: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    let length = length.max(1);
    joined(tasks_with(count.div_ceil(length), scratch, |memory, task| {
        range(task, length, count).map(|index| f(memory, index)).collect()
    }))
}

/// Lets `f` change stretches of `length` entries; it is told the index of the first of them. With scratch memory, as in
/// [`tasks_with`].
pub fn fill_with<S: Send, T: Send>(
    out: &mut [T],
    length: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, usize, &mut [T]) + Sync,
) {
    let length = length.max(1);
    let stretches: Vec<Mutex<&mut [T]>> = out.chunks_mut(length).map(Mutex::new).collect();
    tasks_with(stretches.len(), scratch, |memory, task| {
        with(&stretches[task], |stretch| f(memory, task * length, stretch));
    });
}

/// Lets `f` change stretches of `length` entries; it is told the index of the first of them.
pub fn fill<T: Send>(out: &mut [T], length: usize, f: impl Fn(usize, &mut [T]) + Sync) {
    fill_with(out, length, || (), |(), first, stretch| f(first, stretch));
}

fn range(task: usize, length: usize, count: usize) -> Range<usize> {
    task * length..((task + 1) * length).min(count)
}

fn joined<T>(mut parts: Vec<Vec<T>>) -> Vec<T> {
    if parts.len() == 1 {
        return parts.pop().unwrap_or_default();
    }
    let mut all = Vec::with_capacity(parts.iter().map(Vec::len).sum());
    parts.into_iter().for_each(|part| all.extend(part));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_for_all_lengths() {
        for count in [0, 1, 2, 255, 256, 257, 3000] {
            let wanted: Vec<usize> = (0..count).map(|i| 3 * i).collect();
            assert_eq!(tasks(count, |i| 3 * i), wanted);
            for length in [0, 1, 7, 256, 10_000] {
                assert_eq!(map(count, length, |i| 3 * i), wanted);
                let sums = ranges(count, length, |range| range.map(|i| 3 * i).collect::<Vec<_>>());
                assert_eq!(sums.concat(), wanted);
                let reused = map_with(count, length, Vec::new, |memory: &mut Vec<usize>, i| {
                    memory.clear();
                    memory.push(3 * i);
                    memory[0]
                });
                assert_eq!(reused, wanted);
                let mut filled = vec![0; count];
                fill(&mut filled, length, |first, stretch| {
                    stretch.iter_mut().enumerate().for_each(|(k, entry)| *entry = 3 * (first + k));
                });
                assert_eq!(filled, wanted);
            }
        }
    }

    #[test]
    fn scratch_memory_is_made_once_per_thread_at_most() {
        let made = Mutex::new(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        pool.install(|| tasks_with(1000, || with(&made, |made| *made += 1), |(), i| i));
        assert!((1..=2).contains(&value(made)));
    }

    #[test]
    #[should_panic(expected = "task 7")]
    fn the_panic_of_a_task_is_that_of_the_call() {
        tasks(20, |i| assert!(i != 7, "task {i}"));
    }
}

/// The example of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
