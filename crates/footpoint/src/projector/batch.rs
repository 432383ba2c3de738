//! Many points at once: coherent order, threads (the only file that knows `rayon`).

use super::Progress;
use crate::global::arithmetic::simd::vectorized;
use nalgebra::SVector;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

/// Points per task: fixed, so that the results do not depend on the number of threads.
const CHUNK: usize = 512;
/// Tasks whose answers are held at once.
const ROUND: usize = 128;

/// Points after which the progress is told, and a cancellation noticed, inside a task.
const REPORT: usize = 32;

/// What a batch of queries needs to know about the shape.
pub(crate) trait Batch<const D: usize>: Sync {
    /// Working memory.
    type Scratch: Default + Send + 'static;
    /// Result of one query.
    type Output: Copy + Send + Sync;

    fn invalid(&self) -> Self::Output;
    fn cancelled(&self) -> Self::Output;
    /// The answer for a finite point, which depends on nothing else.
    fn answer(&self, x: &SVector<f64, D>, scratch: &mut Self::Scratch) -> Self::Output;
}

/// Gets results with the indices of their points, a round at a time.
pub(crate) type Receive<'a, T> = &'a mut dyn FnMut(&[(usize, T)]);

/// Points to be projected.
pub(crate) struct Queries<'a, const D: usize> {
    pub(crate) count: usize,
    pub(crate) at: &'a (dyn Fn(usize) -> SVector<f64, D> + Sync),
}

/// One query.
pub(crate) fn single<const D: usize, B: Batch<D>>(
    batch: &B,
    x: &SVector<f64, D>,
    scratch: &mut B::Scratch,
) -> B::Output {
    let queries = Queries { count: 1, at: &|_| *x };
    let mut answer = batch.invalid();
    slice(batch, &queries, &[0], scratch, &mut |_, out| {
        answer = out;
        true
    });
    answer
}

/// Answers the points of one chunk in order, as long as `store` says so.
fn slice<const D: usize, B: Batch<D>>(
    batch: &B,
    queries: &Queries<'_, D>,
    order: &[u32],
    scratch: &mut B::Scratch,
    store: &mut dyn FnMut(u32, B::Output) -> bool,
) {
    vectorized(
        #[inline(always)]
        || {
            for &index in order {
                let x = &(queries.at)(index as usize);
                let out =
                    if x.iter().all(|c| c.is_finite()) { batch.answer(x, scratch) } else { batch.invalid() };
                if !store(index, out) {
                    break;
                }
            }
        },
    );
}

/// All points, in parallel.
pub(crate) fn run<const D: usize, B: Batch<D>>(
    batch: &B,
    points: &[SVector<f64, D>],
    progress: Progress<'_>,
) -> Vec<B::Output> {
    let mut results = vec![batch.cancelled(); points.len()];
    let queries = Queries { count: points.len(), at: &|index| points[index] };
    each(batch, &queries, progress, &|_, answer| *answer, &mut |answers| {
        for &(index, answer) in answers {
            results[index] = answer;
        }
    });
    results
}

/// All points, in parallel, each answer turned into what `treat` makes of it; `receive` gets these with the indices of their
/// points, a round at a time.
pub(crate) fn each<const D: usize, B: Batch<D>, T: Send>(
    batch: &B,
    queries: &Queries<'_, D>,
    progress: Progress<'_>,
    treat: &(dyn Fn(usize, &B::Output) -> T + Sync),
    receive: Receive<'_, T>,
) {
    let order = coherent_order(queries);
    let done = AtomicUsize::new(0);
    let cancelled = AtomicBool::new(false);
    for round in order.chunks(CHUNK * ROUND) {
        let chunks: Vec<Vec<(usize, T)>> =
            lanes::tasks_with(round.len().div_ceil(CHUNK), B::Scratch::default, |scratch, task| {
                let chunk = &round[task * CHUNK..((task + 1) * CHUNK).min(round.len())];
                let mut out = Vec::with_capacity(chunk.len());
                if !cancelled.load(Relaxed) {
                    slice(batch, queries, chunk, scratch, &mut |index, answer| {
                        out.push((index as usize, treat(index as usize, &answer)));
                        if out.len() % REPORT == 0 || out.len() == chunk.len() {
                            let news = if out.len() % REPORT == 0 { REPORT } else { out.len() % REPORT };
                            let total = done.fetch_add(news, Relaxed) + news;
                            if progress(total, queries.count).is_break() {
                                cancelled.store(true, Relaxed);
                            }
                        }
                        !cancelled.load(Relaxed)
                    });
                }
                let left = chunk[out.len()..].iter().map(|&index| index as usize);
                out.extend(left.map(|index| (index, treat(index, &batch.cancelled()))).collect::<Vec<_>>());
                out
            });
        receive(&chunks.into_iter().flatten().collect::<Vec<_>>());
    }
}

/// Treats slices of fixed length of points and their answers in parallel.
pub(crate) fn zip_chunks<P: Sync, R: Send, W: Default + Send>(
    points: &[P],
    answers: &mut [R],
    length: usize,
    treat: impl Fn(&[P], &mut [R], &mut W) + Sync,
) {
    if points.len() <= length {
        treat(points, answers, &mut W::default());
        return;
    }
    lanes::fill_with(answers, length, W::default, |work, first, answers| {
        treat(&points[first..first + answers.len()], answers, work);
    });
}

/// Indices of the points along a space-filling (Morton) curve, so that neighbours in the order are neighbours in
/// space; points in one cell are ordered by their coordinates, so that the order is that of the set of points.
fn coherent_order<const D: usize>(queries: &Queries<'_, D>) -> Vec<u32> {
    let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
    let mut high = -low;
    for p in (0..queries.count).map(queries.at).filter(|p| p.iter().all(|c| c.is_finite())) {
        low = low.inf(&p);
        high = high.sup(&p);
    }
    let bits = (63 / D.max(1)).min(21);
    let cells = (1u64 << bits) as f64;
    let scale = cells / (high - low).max().max(f64::MIN_POSITIVE);
    let key = |p: &SVector<f64, D>| -> u64 {
        let mut key = 0;
        for d in 0..D {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "clamped to the range of cells; NaN becomes 0"
            )]
            let cell = ((p[d] - low[d]) * scale).clamp(0.0, cells - 1.0) as u64;
            key |= spread(cell, D) << d;
        }
        key
    };
    let mut keyed: Vec<(u64, u32)> = (0..queries.count)
        .into_par_iter()
        .map(|i| (key(&(queries.at)(i)), u32::try_from(i).unwrap_or(u32::MAX)))
        .collect();
    keyed.par_sort_unstable_by(|a, b| {
        let same_cell = || {
            let [p, q] = [a, b].map(|pair| (queries.at)(pair.1 as usize));
            let pairs = p.iter().zip(q.iter());
            pairs.map(|(p, q)| p.total_cmp(q)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
        };
        a.0.cmp(&b.0).then_with(same_cell).then(a.1.cmp(&b.1))
    });
    // Into memory of its own: collected in place the order would keep that of the keys.
    let mut order = Vec::with_capacity(keyed.len());
    order.extend(keyed.iter().map(|(_, index)| *index));
    order
}

/// Bits of `cell` moved `stride` places apart.
fn spread(cell: u64, stride: usize) -> u64 {
    (0..64 / stride.max(1)).fold(0, |out, bit| out | ((cell >> bit) & 1) << (bit * stride))
}
