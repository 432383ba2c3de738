//! Trees of shortest edges.

use nalgebra::SVector;

/// For each node its neighbours in the minimum spanning tree (Prim's algorithm), with their distances.
fn tree<const D: usize>(nodes: &[SVector<f64, D>]) -> Vec<Vec<(usize, f64)>> {
    let n = nodes.len();
    let mut tree: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
    let mut nearest = vec![(f64::INFINITY, 0); n];
    let mut inside = vec![false; n];
    let mut current = 0;
    for _ in 1..n {
        inside[current] = true;
        let mut next = (f64::INFINITY, usize::MAX);
        for i in 0..n {
            if inside[i] {
                continue;
            }
            let length = (nodes[i] - nodes[current]).norm();
            if length < nearest[i].0 {
                nearest[i] = (length, current);
            }
            if nearest[i].0 < next.0 {
                next = (nearest[i].0, i);
            }
        }
        if next.1 == usize::MAX {
            break;
        }
        let (length, from) = nearest[next.1];
        tree[from].push((next.1, length));
        tree[next.1].push((from, length));
        current = next.1;
    }
    tree
}

/// The length of the minimum spanning tree.
pub(super) fn tree_length<const D: usize>(nodes: &[SVector<f64, D>]) -> f64 {
    // Each edge is listed at both ends.
    tree(nodes).iter().flatten().map(|(_, length)| length).sum::<f64>() / 2.0
}

/// The longest path in the minimum spanning tree (twice the furthest node).
pub(super) fn longest_path<const D: usize>(nodes: &[SVector<f64, D>]) -> Vec<usize> {
    let tree = tree(nodes);
    let (end, _) = furthest(&tree, 0);
    let (other, before) = furthest(&tree, end);
    let mut path = vec![other];
    let mut at = other;
    while at != end {
        at = before[at];
        path.push(at);
    }
    path
}

/// The node furthest from another along the tree, and for each node the one before on the way.
fn furthest(tree: &[Vec<(usize, f64)>], from: usize) -> (usize, Vec<usize>) {
    let mut before = vec![from; tree.len()];
    let mut best = (0.0, from);
    let mut stack = vec![(from, from, 0.0)];
    while let Some((node, parent, length)) = stack.pop() {
        before[node] = parent;
        if length > best.0 {
            best = (length, node);
        }
        for &(next, edge) in tree[node].iter().filter(|(next, _)| *next != parent) {
            stack.push((next, node, length + edge));
        }
    }
    (best.1, before)
}
