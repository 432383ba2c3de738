//! The k-d tree over different positions (the only file that knows `kiddo`).

use std::num::NonZeroUsize;
use std::sync::Arc;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::Error;

/// Relative widening of squared radii: covers the rounding of the bounds by which branches are left out.
const SLACK: f64 = 1.0 + 1e-12;

/// A tree over finite points. Answers name points by their place in the slice that the tree was built from.
#[derive(Clone)]
pub(crate) struct KdTree<const D: usize>(Arc<ImmutableKdTree<f64, D>>);

impl<const D: usize> std::fmt::Debug for KdTree<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "KdTree({} points in R{D})", self.0.size())
    }
}

impl<const D: usize> KdTree<D> {
    /// `None` for no points, where no query has an answer.
    pub(crate) fn new(points: &[[f64; D]]) -> Result<Option<Self>, Error> {
        if points.is_empty() {
            return Ok(None);
        }
        match ImmutableKdTree::new_from_slice(points) {
            Ok(tree) => Ok(Some(Self(Arc::new(tree)))),
            // The tree numbers its points with 32 bits; nothing else can go wrong when it is built at once.
            Err(_) => Err(Error::TooMany { what: "points", count: points.len() }),
        }
    }

    /// Squared distance and number of the nearest point; the smallest number where several are equally near.
    pub(crate) fn nearest(&self, x: &[f64; D]) -> (f64, u32) {
        let first = self.0.query(x).nearest_one::<SquaredEuclidean<f64>>().execute();
        let mut best = (first.distance, first.item);
        self.visit_within(x, first.distance, |distance_sq, item| {
            if distance_sq < best.0 || distance_sq == best.0 && item < best.1 {
                best = (distance_sq, item);
            }
        });
        best
    }

    /// Appends the `count` nearest points, and all that are as far as the last of them, in no order.
    pub(crate) fn nearest_n(&self, x: &[f64; D], count: NonZeroUsize, found: &mut Vec<(f64, u32)>) {
        // One more than asked for shows whether the farthest is tied.
        let more = count.saturating_add(1).min(NonZeroUsize::MIN.saturating_add(self.0.size()));
        let near = self.0.query(x).nearest_n::<SquaredEuclidean<f64>>(more).execute();
        match (near.get(count.get() - 1), near.get(count.get())) {
            (Some(last), Some(next)) if next.distance <= last.distance * SLACK => {
                let limit = last.distance;
                self.visit_within(x, limit, |distance_sq, item| found.push((distance_sq, item)));
            }
            _ => found.extend(near.iter().take(count.get()).map(|item| (item.distance, item.item))),
        }
    }

    /// Visits all points up to a squared distance, and perhaps some that are farther by rounding.
    pub(crate) fn visit_within(&self, x: &[f64; D], limit_sq: f64, mut visit: impl FnMut(f64, u32)) {
        let query = self.0.query(x).within::<SquaredEuclidean<f64>>(limit_sq * SLACK);
        query.unsorted().visit(|item| visit(item.distance, item.item));
    }
}
