//! Work spread over threads, with results that do not depend on their number.

use nalgebra::Point;

use crate::spatial_order::spatial_order;

/// Items per task: enough to hide the cost of a task, few enough to keep all threads busy to the end.
const CHUNK: usize = 256;

/// `f(0), f(1), …` of queries at points, in the order of the points.
pub(crate) fn map<const D: usize, T: Send>(
    points: &[Point<f64, D>],
    f: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    map_with(points, || (), |(), index| f(index))
}

/// `f(scratch, 0), f(scratch, 1), …` of queries at points, in the order of the points.
///
/// They are answered in an order in which neighbours follow each other. The scratch memory must not carry anything
/// from query to query.
pub(crate) fn map_with<const D: usize, S: Send, T: Send>(
    points: &[Point<f64, D>],
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    let Some(order) = spatial_order(points) else { return in_chunks(points.len(), scratch, f) };
    let answers = in_chunks(order.len(), scratch, |scratch, place| f(scratch, order[place] as usize));
    let mut sorted: Vec<Option<T>> = answers.iter().map(|_| None).collect();
    for (answer, index) in answers.into_iter().zip(order) {
        sorted[index as usize] = Some(answer);
    }
    // The order has every index once.
    sorted.into_iter().flatten().collect()
}

/// Answers to queries at points, in the order of the points, found for packets of up to `length` that are near each other.
///
/// `f` gets the indices of a packet, and appends one answer for each.
pub(crate) fn packets<const D: usize, T: Send>(
    points: &[Point<f64, D>],
    length: usize,
    f: impl Fn(&[u32], &mut Vec<T>) + Sync,
) -> Vec<T> {
    let order = spatial_order(points);
    let task = length * CHUNK.div_ceil(length);
    let parts = lanes::ranges(points.len(), task, |range| {
        let mut out = Vec::with_capacity(range.len());
        let indices: Vec<u32> = match &order {
            Some(order) => order[range].to_vec(),
            None => range.filter_map(|index| u32::try_from(index).ok()).collect(),
        };
        for packet in indices.chunks(length) {
            f(packet, &mut out);
        }
        out
    });
    let Some(order) = order else { return parts.into_iter().flatten().collect() };
    let mut sorted: Vec<Option<T>> = std::iter::repeat_with(|| None).take(order.len()).collect();
    for (answer, index) in parts.into_iter().flatten().zip(order) {
        sorted[index as usize] = Some(answer);
    }
    // The order has every index once.
    sorted.into_iter().flatten().collect()
}

/// `f(scratch, 0), f(scratch, 1), …` in order.
fn in_chunks<S: Send, T: Send>(
    count: usize,
    scratch: impl Fn() -> S + Sync,
    f: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    lanes::map_with(count, CHUNK, scratch, f)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_order() {
        for count in [0, 1, CHUNK, CHUNK + 1, 10 * CHUNK - 1] {
            let points: Vec<_> = (0..count).map(|i| Point::from([(i as f64 * 0.618).fract(), 0.0])).collect();
            assert!(map(&points, |index| 3 * index).into_iter().eq((0..count).map(|index| 3 * index)));
        }
    }
}
