//! A queue of work by distance.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Something that waits at a distance.
#[derive(Clone, Copy, Debug)]
struct Waiting<T> {
    distance: f64,
    order: u64,
    item: T,
}

impl<T> PartialEq for Waiting<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T> Eq for Waiting<T> {}

impl<T> PartialOrd for Waiting<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> Ord for Waiting<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap gives the greatest first; of equals that which came first.
        other.distance.total_cmp(&self.distance).then_with(|| other.order.cmp(&self.order))
    }
}

/// Gives items by distance, of equals the one that came first.
#[derive(Debug)]
pub(super) struct Queue<T> {
    heap: BinaryHeap<Waiting<T>>,
    count: u64,
}

impl<T> Queue<T> {
    pub(super) fn new() -> Self {
        Self { heap: BinaryHeap::new(), count: 0 }
    }

    pub(super) fn push(&mut self, distance: f64, item: T) {
        self.count += 1;
        self.heap.push(Waiting { distance, order: self.count, item });
    }

    /// The distance of the next item.
    pub(super) fn least(&self) -> Option<f64> {
        self.heap.peek().map(|waiting| waiting.distance)
    }

    pub(super) fn pop(&mut self) -> Option<(f64, T)> {
        self.heap.pop().map(|waiting| (waiting.distance, waiting.item))
    }
}
