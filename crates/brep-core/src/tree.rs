//! A tree of boxes.

use nalgebra::Vector3;
use nurbs_core::Aabb;

/// Items of a leaf at most.
const LEAF: usize = 2;

/// Boxes of items, in a binary tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

#[derive(Clone, Debug)]
struct Node {
    bounds: Aabb<3>,
    content: Content,
}

#[derive(Clone, Debug)]
enum Content {
    Children([usize; 2]),
    Items(Vec<usize>),
}

impl Tree {
    pub(crate) fn new(boxes: &[Aabb<3>]) -> Self {
        let mut tree = Self::default();
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        if !boxes.is_empty() {
            tree.build(boxes, &mut order);
        }
        tree
    }

    fn build(&mut self, boxes: &[Aabb<3>], items: &mut [usize]) -> usize {
        let first = boxes[items[0]];
        let bounds = items.iter().fold(first, |found, &i| found.merged(&boxes[i]));
        let index = self.nodes.len();
        self.nodes.push(Node { bounds, content: Content::Items(items.to_vec()) });
        if items.len() > LEAF {
            let axis = bounds.sides().imax();
            // Ties by index: the tree is the same in every run.
            items.sort_by(|&a, &b| {
                boxes[a].centre()[axis].total_cmp(&boxes[b].centre()[axis]).then(a.cmp(&b))
            });
            let (low, high) = items.split_at_mut(items.len() / 2);
            let children = [self.build(boxes, low), self.build(boxes, high)];
            self.nodes[index].content = Content::Children(children);
        }
        index
    }

    /// The box of everything.
    pub(crate) fn bounds(&self) -> Option<Aabb<3>> {
        self.nodes.first().map(|n| n.bounds)
    }

    /// Visits items near `x` first. `visit` is given an item and returns the distance beyond which nothing matters.
    pub(crate) fn search(&self, x: &Vector3<f64>, mut reach: f64, visit: &mut dyn FnMut(usize) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = vec![(self.nodes[0].bounds.distance(x), 0)];
        while let Some((distance, index)) = stack.pop() {
            if distance > reach {
                continue;
            }
            match &self.nodes[index].content {
                Content::Items(items) => {
                    for &item in items {
                        reach = visit(item);
                    }
                }
                Content::Children(children) => {
                    let mut next = children.map(|c| (self.nodes[c].bounds.distance(x), c));
                    if next[0].0 < next[1].0 {
                        next.swap(0, 1);
                    }
                    stack.extend(next);
                }
            }
        }
    }
}
