//! New feet of points that have moved a little: many warm starts at once.

use super::batch;
use super::surface::{Sets, SurfaceProjector, with_set};
use crate::global::dispatch::vectorized;
use crate::global::lanes::WIDTH;
use crate::global::patch::PatchSet;
use crate::{Error, SurfaceFootpoint};
use nalgebra::Vector3;

/// Limit of the scalar iterations.
const MAX_STEPS: u32 = 50;

impl SurfaceProjector {
    /// Local feet of many points, each from the parameter of a previous answer, as between the iterations of a
    /// registration or a fit.
    ///
    /// Points on the same patch are iterated eight at a time; nothing is certified. The same bits come out whatever
    /// the number of threads.
    ///
    /// # Errors
    /// [`Error::StartCount`] unless there is one previous answer per point.
    pub fn update_many(
        &self,
        points: &[Vector3<f64>],
        previous: &[SurfaceFootpoint],
    ) -> Result<Vec<SurfaceFootpoint>, Error> {
        if points.len() != previous.len() {
            return Err(Error::StartCount { found: previous.len(), needed: points.len() });
        }
        Ok(with_set!(&self.set, set => update(set, points, previous)))
    }
}

/// A point, where it starts, and the patch of that place.
#[derive(Clone, Copy)]
struct Start {
    patch: usize,
    local: [f64; 2],
    index: u32,
}

fn update<const K: usize>(
    set: &PatchSet<K>,
    points: &[Vector3<f64>],
    previous: &[SurfaceFootpoint],
) -> Vec<SurfaceFootpoint> {
    let mut results = vec![SurfaceFootpoint::invalid(); points.len()];
    let locate = |(index, before): (usize, &SurfaceFootpoint)| {
        let usable = points[index].iter().all(|c| c.is_finite())
            && before.shape < set.cells.len()
            && before.parameter.iter().all(|c| c.is_finite());
        usable.then(|| {
            let cells = &set.cells[before.shape];
            let (cell, local) = cells.locate(before.parameter);
            Start { patch: cells.patch(cell), local, index: u32::try_from(index).unwrap_or(u32::MAX) }
        })
    };
    let starts: Vec<Start> = previous.iter().enumerate().filter_map(locate).collect();
    let starts = by_patch(&starts, set.patches.len());
    let answers = batch::in_chunks(&starts, |chunk, out: &mut Vec<(u32, SurfaceFootpoint)>| {
        vectorized(
            #[inline(always)]
            || {
                for group in chunk.chunk_by(|a, b| a.patch == b.patch) {
                    for eight in group.chunks(WIDTH) {
                        step(set, points, eight, out);
                    }
                }
            },
        );
    });
    for (index, answer) in answers.into_iter().flatten() {
        results[index as usize] = answer;
    }
    results
}

/// Up to eight points on one patch.
#[inline(always)]
fn step<const K: usize>(
    set: &PatchSet<K>,
    points: &[Vector3<f64>],
    eight: &[Start],
    out: &mut Vec<(u32, SurfaceFootpoint)>,
) {
    // A short group is filled up with its first member.
    let lane = |l: usize| eight.get(l).unwrap_or(&eight[0]);
    let x: [Vector3<f64>; WIDTH] = std::array::from_fn(|l| points[lane(l).index as usize]);
    let local: [[f64; 2]; WIDTH] = std::array::from_fn(|l| lane(l).local);
    let feet = set.newton_lanes(eight[0].patch, &x, &local);
    for (start, foot) in eight.iter().zip(feet) {
        let x = &points[start.index as usize];
        let foot =
            foot.unwrap_or_else(|| set.finish(x, &set.descend(x, start.patch, start.local, MAX_STEPS)));
        out.push((start.index, foot));
    }
}

/// The starts in the order of their patches, within a patch in the order of the input (counting sort).
fn by_patch(starts: &[Start], patches: usize) -> Vec<Start> {
    let mut next = vec![0usize; patches + 1];
    for start in starts {
        next[start.patch + 1] += 1;
    }
    for i in 0..patches {
        next[i + 1] += next[i];
    }
    let mut sorted = starts.to_vec();
    for start in starts {
        sorted[next[start.patch]] = *start;
        next[start.patch] += 1;
    }
    sorted
}
