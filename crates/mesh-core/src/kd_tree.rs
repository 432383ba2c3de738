//! A k-d tree over different positions, with the boxes of its nodes ([Er05, ch. 7]).
//!
//! Every node knows the box around its own points, not only the planes that part it from others: a query far from all points,
//! for which those planes say nothing, still leaves out most of the nodes.

use std::cmp::Ordering;
use std::num::NonZeroUsize;
use std::sync::Arc;

use crate::Error;

/// Most points of a leaf.
const LEAF_SIZE: usize = 8;
/// Bound on the depth: halvings of at most 2³² points.
const MAX_DEPTH: usize = 34;

/// A tree over finite points. Answers name points by their place in the slice that the tree was built from.
#[derive(Clone)]
pub(crate) struct KdTree<const D: usize>(Arc<Nodes<D>>);

struct Nodes<const D: usize> {
    nodes: Vec<Node<D>>,
    /// The points in the order of the leaves, and their numbers.
    points: Vec<[f64; D]>,
    items: Vec<u32>,
    /// Place of each number in that order.
    places: Vec<u32>,
}

/// `count > 0`: a leaf with the points `first..first + count`; else a node with children `first`, `first + 1`.
#[derive(Clone, Copy)]
struct Node<const D: usize> {
    min: [f64; D],
    max: [f64; D],
    first: u32,
    count: u32,
}

impl<const D: usize> Node<D> {
    fn around(points: &[[f64; D]], items: &[u32]) -> Self {
        let mut node = Self { min: [f64::INFINITY; D], max: [f64::NEG_INFINITY; D], first: 0, count: 0 };
        for &item in items {
            for axis in 0..D {
                let value = points[item as usize][axis];
                node.min[axis] = node.min[axis].min(value);
                node.max[axis] = node.max[axis].max(value);
            }
        }
        node
    }

    /// Squared distance of the box from a point, 0 inside. Never more than [`distance_sq`] of a point in the box: both are the
    /// same sums, rounded the same way, and rounding keeps the order of numbers.
    #[inline]
    fn distance_sq(&self, x: &[f64; D]) -> f64 {
        let mut sum = 0.0;
        for axis in 0..D {
            let outside = (self.min[axis] - x[axis]).max(x[axis] - self.max[axis]).max(0.0);
            sum += outside * outside;
        }
        sum
    }
}

#[inline]
fn distance_sq<const D: usize>(x: &[f64; D], point: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for axis in 0..D {
        let along = x[axis] - point[axis];
        sum += along * along;
    }
    sum
}

impl<const D: usize> std::fmt::Debug for KdTree<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "KdTree({} points in R{D})", self.0.points.len())
    }
}

impl<const D: usize> KdTree<D> {
    /// `None` for no points, where no query has an answer.
    pub(crate) fn new(points: &[[f64; D]]) -> Result<Option<Self>, Error> {
        if points.is_empty() {
            return Ok(None);
        }
        let Ok(count) = u32::try_from(points.len()) else {
            return Err(Error::TooMany { what: "points", count: points.len() });
        };
        let mut items: Vec<u32> = (0..count).collect();
        let mut nodes = Vec::with_capacity(points.len() / 2 + 1);
        nodes.push(Node::around(points, &items));
        let mut open = vec![(0usize, 0usize, points.len())];
        while let Some((node, start, end)) = open.pop() {
            let part = &mut items[start..end];
            if part.len() <= LEAF_SIZE {
                (nodes[node].first, nodes[node].count) = (index_of(start), index_of(part.len()));
                continue;
            }
            let extent = |axis: usize| nodes[node].max[axis] - nodes[node].min[axis];
            let axis = (1..D).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best });
            // Whole leaves on the left.
            let half = (part.len() / 2).next_multiple_of(LEAF_SIZE).min(part.len() - 1);
            part.select_nth_unstable_by(half, |&one, &other| {
                let [one_value, other_value] = [one, other].map(|item| points[item as usize][axis]);
                one_value.total_cmp(&other_value).then(one.cmp(&other))
            });
            let child = nodes.len();
            let (left, right) = part.split_at(half);
            let children = [Node::around(points, left), Node::around(points, right)];
            nodes.extend(children);
            (nodes[node].first, nodes[node].count) = (index_of(child), 0);
            open.push((child + 1, start + half, end));
            open.push((child, start, start + half));
        }
        let mut places = vec![0; points.len()];
        for (place, &item) in (0u32..).zip(&items) {
            places[item as usize] = place;
        }
        let points = items.iter().map(|&item| points[item as usize]).collect();
        Ok(Some(Self(Arc::new(Nodes { nodes, points, items, places }))))
    }

    /// Visits leaves, nearer ones first as far as that is cheap, whose boxes are not farther than the squared distance that `visit`
    /// returned last; it is told squared distance and number of each point.
    #[inline]
    fn descend(&self, x: &[f64; D], limit_sq: f64, mut visit: impl FnMut(f64, u32) -> f64) {
        let Nodes { nodes, points, items, .. } = &*self.0;
        let mut limit = limit_sq;
        let mut stack = [(0usize, 0.0f64); MAX_DEPTH];
        let mut depth = 1;
        stack[0] = (0, nodes[0].distance_sq(x));
        while depth > 0 {
            depth -= 1;
            let (index, distance) = stack[depth];
            if distance > limit {
                continue;
            }
            let mut node = &nodes[index];
            while node.count == 0 {
                let first = node.first as usize;
                let distances = [nodes[first].distance_sq(x), nodes[first + 1].distance_sq(x)];
                let near = usize::from(distances[1] < distances[0]);
                if distances[1 - near] <= limit {
                    stack[depth] = (first + 1 - near, distances[1 - near]);
                    depth += 1;
                }
                if distances[near] > limit {
                    break;
                }
                node = &nodes[first + near];
            }
            let range = node.first as usize..(node.first + node.count) as usize;
            for (point, &item) in points[range.clone()].iter().zip(&items[range]) {
                limit = visit(distance_sq(x, point), item);
            }
        }
    }

    /// Squared distance and number of the nearest point; the smallest number where several are equally near. The search begins
    /// at the distance of a guess, if there is one, which does not change the answer.
    pub(crate) fn nearest(&self, x: &[f64; D], guess: Option<u32>) -> (f64, u32) {
        let first = guess.and_then(|item| self.0.places.get(item as usize).map(|&place| (place, item)));
        let mut best = first.map_or((f64::INFINITY, u32::MAX), |(place, item)| {
            (distance_sq(x, &self.0.points[place as usize]), item)
        });
        self.descend(x, best.0, |distance_sq, item| {
            if distance_sq < best.0 || distance_sq == best.0 && item < best.1 {
                best = (distance_sq, item);
            }
            best.0
        });
        best
    }

    /// Appends the `count` nearest points, in no order; of those that are as far as the last of them, the ones with the
    /// smallest numbers.
    pub(crate) fn nearest_n(&self, x: &[f64; D], count: NonZeroUsize, found: &mut Vec<(f64, u32)>) {
        let count = count.get().min(self.0.points.len());
        let before = found.len();
        let farther = |one: &(f64, u32), other: &(f64, u32)| -> Ordering {
            one.0.total_cmp(&other.0).then(one.1.cmp(&other.1))
        };
        // Twice as many as asked for are gathered before those that are too far are thrown out, all at once.
        let mut limit = f64::INFINITY;
        self.descend(x, limit, |distance_sq, item| {
            if distance_sq <= limit {
                found.push((distance_sq, item));
                if found.len() - before >= 2 * count + LEAF_SIZE {
                    let near = &mut found[before..];
                    let (_, last, _) = near.select_nth_unstable_by(count - 1, farther);
                    limit = last.0;
                    found.truncate(before + count);
                }
            }
            limit
        });
        if found.len() - before > count {
            found[before..].select_nth_unstable_by(count - 1, farther);
            found.truncate(before + count);
        }
    }

    /// Visits all points up to a squared distance.
    pub(crate) fn visit_within(&self, x: &[f64; D], limit_sq: f64, mut visit: impl FnMut(f64, u32)) {
        self.descend(x, limit_sq, |distance_sq, item| {
            if distance_sq <= limit_sq {
                visit(distance_sq, item);
            }
            limit_sq
        });
    }
}

/// An index that was checked to be below 2³².
fn index_of(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}
