//! A tree of axis-aligned boxes with eight children per node, tested eight at a time (best first as in \[JC98\]).

use crate::global::arithmetic::lanes::{Lanes, WIDTH};
use nalgebra::Vector3;

/// Marks a child that is a leaf; the other bits are the index of the item.
const LEAF: u32 = 1 << 31;

/// Lower and upper corner of a box.
pub(crate) type Bounds<const D: usize> = [[f64; D]; 2];

#[derive(Clone, Debug)]
struct Node<const D: usize> {
    low: [Lanes; D],
    high: [Lanes; D],
    children: [u32; WIDTH],
    count: usize,
}

/// Boxes of pieces of a shape.
#[derive(Clone, Debug)]
pub(crate) struct BoxTree<const D: usize> {
    nodes: Vec<Node<D>>,
}

/// An entry of the traversal: squared distance of a box, and what is in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Visit {
    pub(crate) distance_sq: f64,
    child: u32,
}

/// What a visited entry holds.
pub(crate) enum Content {
    Node(usize),
    Item(usize),
}

impl Visit {
    /// The entry of the root.
    pub(crate) fn root() -> Self {
        Self { distance_sq: 0.0, child: 0 }
    }

    #[inline(always)]
    pub(crate) fn content(self) -> Content {
        if self.child & LEAF == 0 {
            Content::Node(self.child as usize)
        } else {
            Content::Item((self.child & !LEAF) as usize)
        }
    }
}

impl<const D: usize> BoxTree<D> {
    /// A tree over `boxes`; there must be at least one.
    pub(crate) fn new(boxes: &[Bounds<D>]) -> Self {
        let mut items: Vec<u32> = (0..u32::try_from(boxes.len()).unwrap_or(LEAF - 1)).collect();
        let mut tree = Self { nodes: Vec::new() };
        tree.build(boxes, &mut items);
        tree
    }

    fn build(&mut self, boxes: &[Bounds<D>], items: &mut [u32]) -> u32 {
        let index = self.nodes.len();
        let empty = Node {
            low: [Lanes::splat(f64::INFINITY); D],
            high: [Lanes::splat(f64::NEG_INFINITY); D],
            children: [0; WIDTH],
            count: 0,
        };
        self.nodes.push(empty);
        let mut node = self.nodes[index].clone();
        for group in split(boxes, items) {
            if group.is_empty() {
                continue;
            }
            let slot = node.count;
            for d in 0..D {
                let of = |item: &u32| &boxes[*item as usize];
                node.low[d].0[slot] = group.iter().map(|i| of(i)[0][d]).fold(f64::INFINITY, f64::min);
                node.high[d].0[slot] = group.iter().map(|i| of(i)[1][d]).fold(f64::NEG_INFINITY, f64::max);
            }
            node.children[slot] = if group.len() == 1 { group[0] | LEAF } else { self.build(boxes, group) };
            node.count += 1;
        }
        self.nodes[index] = node;
        u32::try_from(index).unwrap_or(0)
    }

    /// Bytes of the tree.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.nodes[..])
    }

    /// Pushes the children of a node that are no further than `limit_sq`, the nearest last.
    #[inline(always)]
    pub(crate) fn expand(&self, node: usize, x: &[f64; D], limit_sq: f64, stack: &mut Vec<Visit>) {
        let node = &self.nodes[node];
        let zero = Lanes::splat(0.0);
        let mut distance = zero;
        for d in 0..D {
            let x = Lanes::splat(x[d]);
            let outside = (node.low[d] - x).max(x - node.high[d]).max(zero);
            distance = distance + outside * outside;
        }
        let first = stack.len();
        for slot in 0..node.count {
            let distance_sq = distance.0[slot];
            if distance_sq <= limit_sq {
                let mut place = stack.len();
                stack.push(Visit { distance_sq, child: node.children[slot] });
                while place > first && stack[place - 1].distance_sq < distance_sq {
                    stack.swap(place - 1, place);
                    place -= 1;
                }
            }
        }
    }
}

/// Splits the items into at most eight groups by three rounds of median cuts.
fn split<'a, const D: usize>(boxes: &[Bounds<D>], items: &'a mut [u32]) -> Vec<&'a mut [u32]> {
    let mut groups: Vec<&mut [u32]> = vec![items];
    for _ in 0..3 {
        let mut next = Vec::with_capacity(2 * groups.len());
        for group in groups {
            if group.len() < 2 {
                next.push(group);
                continue;
            }
            let centre = |i: u32, d: usize| boxes[i as usize][0][d] + boxes[i as usize][1][d];
            let mut axis = 0;
            let mut widest = f64::NEG_INFINITY;
            for d in 0..D {
                let low = group.iter().map(|&i| centre(i, d)).fold(f64::INFINITY, f64::min);
                let high = group.iter().map(|&i| centre(i, d)).fold(f64::NEG_INFINITY, f64::max);
                if high - low > widest {
                    (axis, widest) = (d, high - low);
                }
            }
            let middle = group.len() / 2;
            group.select_nth_unstable_by(middle, |&a, &b| {
                centre(a, axis).total_cmp(&centre(b, axis)).then(a.cmp(&b))
            });
            let (a, b) = group.split_at_mut(middle);
            next.push(a);
            next.push(b);
        }
        groups = next;
    }
    groups
}

pub(crate) fn bounds(points: &[Vector3<f64>]) -> Bounds<3> {
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = -low;
    for p in points {
        low = low.inf(p);
        high = high.sup(p);
    }
    [low.into(), high.into()]
}

/// Largest side of the box around all boxes.
pub(crate) fn extent(boxes: &[Bounds<3>]) -> f64 {
    (0..3)
        .map(|d| {
            let low = boxes.iter().map(|b| b[0][d]).fold(f64::INFINITY, f64::min);
            let high = boxes.iter().map(|b| b[1][d]).fold(f64::NEG_INFINITY, f64::max);
            high - low
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_nearest_box() {
        let boxes: Vec<Bounds<2>> = (0..100)
            .map(|i| {
                let (x, y) = (f64::from(i % 10), f64::from(i / 10));
                [[x, y], [x + 0.5, y + 0.5]]
            })
            .collect();
        let tree = BoxTree::new(&boxes);
        let mut stack = vec![Visit::root()];
        let mut seen = Vec::new();
        while let Some(visit) = stack.pop() {
            match visit.content() {
                Content::Node(n) => tree.expand(n, &[3.2, 7.9], 0.3, &mut stack),
                Content::Item(i) => seen.push((i, visit.distance_sq)),
            }
        }
        // The query lies above box 73 and below box 83, 0.4 and 0.1 away.
        assert!(seen.iter().any(|s| s.0 == 73 && (s.1 - 0.16).abs() < 1e-12), "{seen:?}");
        assert_eq!(seen.first().map(|s| s.0), Some(83), "{seen:?}");
        assert!(!seen.iter().any(|s| s.0 == 0));
    }
}
