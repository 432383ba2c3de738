//! Many points at once: coherent order, threads (the only file that knows `rayon`).

use super::Progress;
use crate::global::simd::vectorized;
use nalgebra::SVector;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

/// Points per task: fixed, so that the results do not depend on the number of threads.
const CHUNK: usize = 512;

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

/// One query.
pub(crate) fn single<const D: usize, B: Batch<D>>(
    batch: &B,
    x: &SVector<f64, D>,
    scratch: &mut B::Scratch,
) -> B::Output {
    let mut answer = batch.invalid();
    slice(batch, std::slice::from_ref(x), &[0], scratch, &mut |_, out| {
        answer = out;
        true
    });
    answer
}

/// Answers the points of one chunk in order, as long as `store` says so.
fn slice<const D: usize, B: Batch<D>>(
    batch: &B,
    points: &[SVector<f64, D>],
    order: &[u32],
    scratch: &mut B::Scratch,
    store: &mut dyn FnMut(u32, B::Output) -> bool,
) {
    vectorized(
        #[inline(always)]
        || {
            for &index in order {
                let x = &points[index as usize];
                let out = if x.iter().all(|c| c.is_finite()) {
                    batch.answer(x, scratch)
                } else {
                    batch.invalid()
                };
                if !store(index, out) {
                    break;
                }
            }
        },
    )
}

/// All points, in parallel.
pub(crate) fn run<const D: usize, B: Batch<D>>(
    batch: &B,
    points: &[SVector<f64, D>],
    progress: Progress<'_>,
) -> Vec<B::Output> {
    let order = coherent_order(points);
    let done = AtomicUsize::new(0);
    let cancelled = AtomicBool::new(false);
    let chunks: Vec<Vec<(u32, B::Output)>> = order
        .par_chunks(CHUNK)
        .map_init(B::Scratch::default, |scratch, chunk| {
            let mut out = Vec::with_capacity(chunk.len());
            if cancelled.load(Relaxed) {
                return out;
            }
            slice(batch, points, chunk, scratch, &mut |index, answer| {
                out.push((index, answer));
                if out.len() % REPORT == 0 || out.len() == chunk.len() {
                    let news = if out.len() % REPORT == 0 { REPORT } else { out.len() % REPORT };
                    let total = done.fetch_add(news, Relaxed) + news;
                    if progress(total, points.len()).is_break() {
                        cancelled.store(true, Relaxed);
                    }
                }
                !cancelled.load(Relaxed)
            });
            out
        })
        .collect();
    let mut results = vec![batch.cancelled(); points.len()];
    for (index, answer) in chunks.into_iter().flatten() {
        results[index as usize] = answer;
    }
    results
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
    points
        .par_chunks(length)
        .zip(answers.par_chunks_mut(length))
        .for_each_init(W::default, |work, (points, answers)| treat(points, answers, work));
}

/// Indices of the points along a space-filling (Morton) curve, so that neighbours in the order are neighbours in
/// space; points in one cell are ordered by their coordinates, so that the order is that of the set of points.
fn coherent_order<const D: usize>(points: &[SVector<f64, D>]) -> Vec<u32> {
    let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
    let mut high = -low;
    for p in points.iter().filter(|p| p.iter().all(|c| c.is_finite())) {
        low = low.inf(p);
        high = high.sup(p);
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
    let mut keyed: Vec<(u64, u32)> =
        points.par_iter().enumerate().map(|(i, p)| (key(p), u32::try_from(i).unwrap_or(u32::MAX))).collect();
    let coordinates = |i: u32| points[i as usize].iter();
    keyed.par_sort_unstable_by(|a, b| {
        let same_cell = || {
            let pairs = coordinates(a.1).zip(coordinates(b.1));
            pairs.map(|(p, q)| p.total_cmp(q)).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
        };
        a.0.cmp(&b.0).then_with(same_cell).then(a.1.cmp(&b.1))
    });
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// Bits of `cell` moved `stride` places apart.
fn spread(cell: u64, stride: usize) -> u64 {
    (0..64 / stride.max(1)).fold(0, |out, bit| out | ((cell >> bit) & 1) << (bit * stride))
}
