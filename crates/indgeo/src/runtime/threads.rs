//! Work in parallel, with results that do not depend on the number of threads.

use crate::error::Error;
use std::io::{self, Write};
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Rows per task.
const CHUNK: usize = 4096;
/// Tasks whose text is held in memory at once.
const TASKS: usize = 32;

/// Runs `work` with the given number of threads, or one per core.
pub(crate) fn with_threads<T: Send>(
    threads: Option<u16>,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> Result<T, Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from)).build();
    let advice = "use fewer threads (--threads)";
    let pool = pool.map_err(|source| Error::usage(format!("cannot start the threads: {source}"), advice))?;
    pool.install(work)
}

/// `f` of every item, in their order. `progress` hears how many are done and can break off; the rest is then `default`.
pub(crate) fn map<T: Sync, R: Clone + Send + Sync>(
    items: &[T],
    default: &R,
    progress: &(dyn Fn(usize, usize) -> ControlFlow<()> + Sync),
    f: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let (done, cancelled) = (AtomicUsize::new(0), AtomicBool::new(false));
    let task = |chunk: &[T]| -> Vec<R> {
        if cancelled.load(Ordering::Relaxed) {
            return vec![default.clone(); chunk.len()];
        }
        let out = chunk.iter().map(&f).collect();
        let total = done.fetch_add(chunk.len(), Ordering::Relaxed) + chunk.len();
        if progress(total, items.len()).is_break() {
            cancelled.store(true, Ordering::Relaxed);
        }
        out
    };
    lanes::ranges(items.len(), CHUNK, |range| task(&items[range])).into_iter().flatten().collect()
}

/// Writes `count` rows: `format` appends the bytes of a range of rows, ranges are formatted in parallel and written in order.
pub(crate) fn write_rows(
    out: &mut dyn Write,
    count: usize,
    format: impl Fn(Range<usize>, &mut Vec<u8>) + Sync,
) -> io::Result<()> {
    let mut start = 0;
    while start < count {
        let stop = count.min(start + CHUNK * TASKS);
        let starts: Vec<usize> = (start..stop).step_by(CHUNK).collect();
        let task = |first: usize| {
            let mut bytes = Vec::new();
            format(first..stop.min(first + CHUNK), &mut bytes);
            bytes
        };
        let texts: Vec<Vec<u8>> = lanes::tasks(starts.len(), |k| task(starts[k]));
        texts.iter().try_for_each(|text| out.write_all(text))?;
        start = stop;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_kept_and_cancelling_fills_up() {
        let items: Vec<usize> = (0..3 * CHUNK + 5).collect();
        let go = |_: usize, _: usize| ControlFlow::Continue(());
        assert_eq!(map(&items, &0, &go, |&i| i), items);
        let stop = |_: usize, _: usize| ControlFlow::Break(());
        let stopped = with_threads(Some(1), || Ok(map(&items, &usize::MAX, &stop, |&i| i))).unwrap();
        assert_eq!(stopped.len(), items.len());
        assert!(stopped.contains(&usize::MAX));
    }

    #[test]
    fn rows_are_written_in_order() {
        let count = CHUNK * TASKS + CHUNK + 1;
        let mut out = Vec::new();
        write_rows(&mut out, count, |rows, bytes| {
            bytes.extend(rows.flat_map(|i| u32::try_from(i).unwrap_or(0).to_le_bytes()));
        })
        .unwrap();
        let read: Vec<u32> = out.chunks(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert!(read.iter().zip(0u32..).all(|(&a, b)| a == b));
        assert_eq!(read.len(), count);
    }
}
