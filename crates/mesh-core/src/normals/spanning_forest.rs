//! A spanning forest of the neighbours in a cloud that prefers neighbours with like normals.

use crate::Neighbour;

/// Costs up to this one count as equal: such links are followed as they come.
const LOW: f64 = 0.1;
/// Classes of higher costs, up to 1.
const CLASSES: usize = 1024;

/// The first `degree` neighbours of point `i`, without itself.
pub(crate) fn links(i: usize, near: &[Neighbour], degree: usize) -> Vec<u32> {
    let others = near.iter().map(|neighbour| neighbour.index).filter(|&index| index != i);
    // There are many such lists: each is allocated once.
    let mut list = Vec::with_capacity(degree.min(near.len()));
    list.extend(others.take(degree).filter_map(|index| u32::try_from(index).ok()));
    list
}

/// A link between two neighbours.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Link {
    /// From 0 to 1.
    pub(crate) cost: f64,
    /// Whether the two are on different sides.
    pub(crate) opposite: bool,
}

/// Trees of points, and on which side each point is as seen from the root (\[Kru56\], with union and find).
#[derive(Debug)]
pub(crate) struct Forest(Vec<Node>);

#[derive(Debug, Clone, Copy)]
struct Node {
    parent: u32,
    opposite: bool,
}

impl Forest {
    /// Joins `count` points (up to 32 bits) along the links to their neighbours, the cheap ones first, until none joins two trees.
    ///
    /// `neighbours(i)` are those of a point, `link(i, j)` tells about a pair of them, `None` where there is no way.
    pub(crate) fn new<'a>(
        count: usize,
        neighbours: impl Fn(usize) -> &'a [u32],
        link: impl Fn(usize, usize) -> Option<Link>,
    ) -> Self {
        let mut forest =
            Self((0u32..).zip(0..count).map(|(parent, _)| Node { parent, opposite: false }).collect());
        let mut classes: Vec<Vec<(u32, u32)>> = vec![Vec::new(); CLASSES];
        for (i, one) in (0..count).zip(0u32..) {
            for &other in neighbours(i) {
                if forest.root_of(one).0 == forest.root_of(other).0 {
                    continue;
                }
                match link(i, other as usize) {
                    Some(Link { cost, opposite }) if cost <= LOW => forest.join(one, other, opposite),
                    Some(Link { cost, .. }) => classes[class_of(cost)].push((one, other)),
                    None => {}
                }
            }
        }
        for (one, other) in classes.into_iter().flatten() {
            if forest.root_of(one).0 != forest.root_of(other).0
                && let Some(Link { opposite, .. }) = link(one as usize, other as usize)
            {
                forest.join(one, other, opposite);
            }
        }
        forest
    }

    /// The root of the tree of a point, and whether the two are on different sides.
    pub(crate) fn root_of(&mut self, point: u32) -> (u32, bool) {
        let (mut root, mut opposite) = (point, false);
        loop {
            let node = self.0[root as usize];
            if node.parent == root {
                break;
            }
            opposite ^= node.opposite;
            root = node.parent;
        }
        // Next time the way is shorter.
        let (mut at, mut side) = (point, opposite);
        while at != root {
            let node = std::mem::replace(&mut self.0[at as usize], Node { parent: root, opposite: side });
            side ^= node.opposite;
            at = node.parent;
        }
        (root, opposite)
    }

    fn join(&mut self, one: u32, other: u32, opposite: bool) {
        let ((first, first_side), (second, second_side)) = (self.root_of(one), self.root_of(other));
        let (root, child) = (first.min(second), first.max(second));
        self.0[child as usize] = Node { parent: root, opposite: opposite ^ first_side ^ second_side };
    }
}

/// The class of a cost.
fn class_of(cost: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the class is the integer part"
    )]
    ((cost * CLASSES as f64) as usize).min(CLASSES - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cheap_links_decide_about_sides() {
        // A ring of four in which one link, the dearest, contradicts the others; and two points on their own.
        let neighbours: [&[u32]; 6] = [&[1, 3], &[2], &[3], &[], &[5], &[]];
        let link = |i: usize, j: usize| match (i, j) {
            (0, 1) => Some(Link { cost: 0.05, opposite: true }),
            (1, 2) => Some(Link { cost: 0.5, opposite: false }),
            (2, 3) => Some(Link { cost: 0.3, opposite: true }),
            (0, 3) => Some(Link { cost: 0.9, opposite: true }),
            _ => None,
        };
        let mut forest = Forest::new(6, |i| neighbours[i], link);
        let found: Vec<_> = (0..6).map(|i| forest.root_of(i)).collect();
        assert_eq!(found, [(0, false), (0, true), (0, true), (0, false), (4, false), (5, false)]);
    }
}
