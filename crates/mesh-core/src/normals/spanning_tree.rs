//! A spanning tree of the neighbours in a cloud that prefers neighbours with like normals.

use nalgebra::Vector3;

use crate::Neighbour;

/// Classes of costs.
const CLASSES: usize = 1024;

/// Which points of a cloud are neighbours, in both directions.
#[derive(Debug)]
pub(crate) struct Graph {
    starts: Vec<usize>,
    links: Vec<u32>,
}

impl Graph {
    /// The first `degree` neighbours of point `i`, without itself.
    pub(crate) fn links(i: usize, near: &[Neighbour], degree: usize) -> Vec<u32> {
        let others = near.iter().map(|neighbour| neighbour.index).filter(|&index| index != i);
        others.take(degree).filter_map(|index| u32::try_from(index).ok()).collect()
    }

    /// `list` gives the neighbours of a point.
    pub(crate) fn new<'a>(count: usize, list: impl Fn(usize) -> &'a [u32]) -> Self {
        // Of two points that are neighbours of each other the first one has the link.
        let links = || {
            let list = &list;
            (0u32..).zip(0..count).flat_map(move |(from, i)| {
                let own = move |&to: &u32| from < to || !list(to as usize).contains(&from);
                list(i).iter().copied().filter(own).map(move |to| (from, to))
            })
        };
        let mut starts = vec![0usize; count + 2];
        for (from, to) in links() {
            starts[from as usize + 2] += 1;
            starts[to as usize + 2] += 1;
        }
        for i in 2..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut ends = vec![0u32; starts[count + 1]];
        for (from, to) in links() {
            for (one, other) in [(from, to), (to, from)] {
                let place = &mut starts[one as usize + 1];
                ends[*place] = other;
                *place += 1;
            }
        }
        starts.pop();
        Self { starts, links: ends }
    }

    fn neighbours(&self, i: usize) -> &[u32] {
        &self.links[self.starts[i]..self.starts[i + 1]]
    }

    /// Connected parts among the points with a normal, each as its points in ascending order.
    pub(crate) fn components(&self, normals: &[Vector3<f64>]) -> Vec<Vec<u32>> {
        let mut seen: Vec<bool> = normals.iter().map(|&normal| normal == Vector3::zeros()).collect();
        let mut components = Vec::new();
        for (seed, index) in (0..normals.len()).zip(0u32..) {
            if std::mem::replace(&mut seen[seed], true) {
                continue;
            }
            let mut component = vec![index];
            let mut next = 0;
            while let Some(&point) = component.get(next) {
                next += 1;
                for &other in self.neighbours(point as usize) {
                    if !std::mem::replace(&mut seen[other as usize], true) {
                        component.push(other);
                    }
                }
            }
            component.sort_unstable();
            components.push(component);
        }
        components
    }

    /// Grows the spanning tree of least costs (0 to 1) from `root` over points that are not yet reached, and calls
    /// `visit(parent, child)` along it, parents first. A link without cost is none.
    ///
    /// Prim's algorithm with costs sorted into classes; within a class the link found last comes first.
    pub(crate) fn grow(
        &self,
        root: u32,
        reached: &mut [bool],
        cost: impl Fn(usize, usize) -> Option<f64>,
        mut visit: impl FnMut(usize, usize),
    ) {
        let mut classes: Vec<Vec<(u32, u32)>> = vec![Vec::new(); CLASSES];
        let mut lowest = 0;
        let mut open = Some(root);
        reached[root as usize] = true;
        loop {
            if let Some(point) = open.take() {
                for &other in self.neighbours(point as usize) {
                    if reached[other as usize] {
                        continue;
                    }
                    if let Some(cost) = cost(point as usize, other as usize) {
                        let class = class_of(cost);
                        classes[class].push((point, other));
                        lowest = lowest.min(class);
                    }
                }
            }
            let Some((parent, child)) = classes[lowest].pop() else {
                lowest += 1;
                if lowest == CLASSES {
                    return;
                }
                continue;
            };
            if !std::mem::replace(&mut reached[child as usize], true) {
                visit(parent as usize, child as usize);
                open = Some(child);
            }
        }
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
