//! A bounding volume hierarchy over boxes, as a flat array ([Er05, ch. 6]).

use nalgebra::Point;
use std::ops::Range;

/// Most items of a leaf.
const LEAF_SIZE: usize = 4;
/// Bins along the longest axis in which splits are tried.
const BINS: usize = 16;
/// From this depth on nodes are split in half, so that the tree cannot degenerate into a list.
const BINNED_DEPTH: usize = 30;
/// Bound on the depth: a binned part and halvings of at most 2³² items.
const MAX_DEPTH: usize = BINNED_DEPTH + 33;

/// An axis-aligned box; empty when `min > max`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Aabb<const D: usize = 3> {
    pub(crate) min: [f64; D],
    pub(crate) max: [f64; D],
}

impl<const D: usize> Aabb<D> {
    pub(crate) const EMPTY: Self = Self { min: [f64::INFINITY; D], max: [f64::NEG_INFINITY; D] };

    pub(crate) fn of_points(points: &[Point<f64, D>]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, point| {
            bounds.union(&Self { min: point.coords.into(), max: point.coords.into() })
        })
    }

    fn union(&self, other: &Self) -> Self {
        let mut union = *self;
        for axis in 0..D {
            union.min[axis] = union.min[axis].min(other.min[axis]);
            union.max[axis] = union.max[axis].max(other.max[axis]);
        }
        union
    }

    fn centre(&self, axis: usize) -> f64 {
        0.5 * self.min[axis] + 0.5 * self.max[axis]
    }

    /// Half the surface area in space, half the circumference in the plane: what the chance of a hit is proportional to.
    fn half_area(&self) -> f64 {
        let extent: [f64; D] = std::array::from_fn(|axis| (self.max[axis] - self.min[axis]).max(0.0));
        let face =
            |across: usize| (0..D).filter(|&axis| axis != across).map(|axis| extent[axis]).product::<f64>();
        (0..D).map(face).sum()
    }

    /// The smallest `|t|` for which `origin + t · direction` lies in the box, `None` where the line misses it.
    ///
    /// Errs on the side of a hit, by a few units in the last place.
    fn nearest_on_line(&self, origin: &Point<f64, D>, direction: &[f64; D]) -> Option<f64> {
        const SLACK: f64 = 4.0 * f64::EPSILON;
        let (mut start, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..D {
            let (low, high) = (self.min[axis] - origin[axis], self.max[axis] - origin[axis]);
            if direction[axis] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / direction[axis], high / direction[axis]);
            let (first, last) = (a.min(b), a.max(b));
            start = start.max(first - first.abs() * SLACK);
            end = end.min(last + last.abs() * SLACK);
        }
        (start <= end).then(|| start.max(-end).max(0.0))
    }

    /// Squared distance from a point, 0 inside.
    #[inline]
    pub(crate) fn distance_sq(&self, x: &Point<f64, D>) -> f64 {
        let mut sum = 0.0;
        for axis in 0..D {
            let outside = larger(larger(self.min[axis] - x[axis], x[axis] - self.max[axis]), 0.0);
            sum += outside * outside;
        }
        sum
    }
}

/// The larger of two numbers, neither of which is NaN: one instruction, where `f64::max` is several.
#[inline]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers, neither of which is NaN.
#[inline]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// `count > 0`: a leaf with the items `order[first..first + count]`; else a node with children `first`, `first + 1`.
#[derive(Debug, Clone, Copy)]
struct Node<const D: usize> {
    bounds: Aabb<D>,
    first: usize,
    count: usize,
}

/// The hierarchy. Items are addressed by their place in `order`.
#[derive(Debug, Clone)]
pub(crate) struct Bvh<const D: usize = 3> {
    nodes: Vec<Node<D>>,
    /// Item at each place.
    pub(crate) order: Vec<u32>,
}

impl<const D: usize> Bvh<D> {
    /// Builds the hierarchy over `boxes`, item `i` having the box `boxes[i]`. There must be one, and all must be finite.
    pub(crate) fn new(boxes: &[Aabb<D>]) -> Self {
        let mut order: Vec<u32> = (0u32..).take(boxes.len()).collect();
        let mut nodes = Vec::with_capacity(boxes.len() / 2 + 1);
        nodes.push(Node { bounds: Aabb::EMPTY, first: 0, count: 0 });
        let mut open = vec![(0usize, 0usize, boxes.len(), 0usize)];
        while let Some((node, start, end, depth)) = open.pop() {
            let items = &mut order[start..end];
            let bounds = items.iter().fold(Aabb::EMPTY, |sum, &item| sum.union(&boxes[item as usize]));
            nodes[node] = if items.len() > LEAF_SIZE {
                let middle = start + split(items, boxes, &bounds, depth);
                let child = nodes.len();
                nodes.extend([Node { bounds: Aabb::EMPTY, first: 0, count: 0 }; 2]);
                open.push((child + 1, middle, end, depth + 1));
                open.push((child, start, middle, depth + 1));
                Node { bounds, first: child, count: 0 }
            } else {
                Node { bounds, first: start, count: items.len() }
            };
        }
        Self { nodes, order }
    }

    /// Visits the places of items, nearest boxes first, as long as their boxes are not farther than the squared
    /// distance that `visit` returned last (it starts at infinity).
    #[inline]
    pub(crate) fn nearest(&self, x: &Point<f64, D>, visit: impl FnMut(usize) -> f64) {
        self.nearest_where(x, f64::INFINITY, |_| true, visit);
    }

    /// As [`Bvh::nearest`], without the nodes that `keeps` refuses, and from a squared distance that is known to be enough.
    #[inline]
    pub(crate) fn nearest_where(
        &self,
        x: &Point<f64, D>,
        enough_sq: f64,
        keeps: impl Fn(usize) -> bool,
        mut visit: impl FnMut(usize) -> f64,
    ) {
        let mut limit = enough_sq;
        let mut stack = [(0usize, 0.0f64); MAX_DEPTH + 1];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (index, distance_sq) = stack[depth];
            if distance_sq > limit {
                continue;
            }
            let mut node = &self.nodes[index];
            while node.count == 0 {
                let children = &self.nodes[node.first..node.first + 2];
                let distance = |child: usize| {
                    if keeps(node.first + child) {
                        children[child].bounds.distance_sq(x)
                    } else {
                        f64::INFINITY
                    }
                };
                let distances = [distance(0), distance(1)];
                let near = usize::from(distances[1] < distances[0]);
                if distances[1 - near] <= limit && distances[1 - near] < f64::INFINITY {
                    stack[depth] = (node.first + 1 - near, distances[1 - near]);
                    depth += 1;
                }
                if distances[near] > limit || distances[near] == f64::INFINITY {
                    break;
                }
                node = &children[near];
            }
            for place in node.first..node.first + node.count {
                limit = visit(place);
            }
        }
    }

    /// Visits the leaves whose boxes are not farther from a point than a squared distance: the places of their items, their box, and its
    /// squared distance, as long as `visit` wants more. Whether it always did.
    pub(crate) fn leaves_within(
        &self,
        x: &Point<f64, D>,
        limit_sq: f64,
        mut visit: impl FnMut(Range<usize>, &Aabb<D>, f64) -> bool,
    ) -> bool {
        let mut stack = [0usize; MAX_DEPTH + 1];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth]];
            let distance_sq = node.bounds.distance_sq(x);
            if distance_sq > limit_sq {
                continue;
            }
            if node.count > 0 {
                if !visit(node.first..node.first + node.count, &node.bounds, distance_sq) {
                    return false;
                }
            } else {
                (stack[depth], stack[depth + 1]) = (node.first, node.first + 1);
                depth += 2;
            }
        }
        true
    }

    /// A value per node, from those of its items or of its children.
    pub(crate) fn gathered<T: Clone>(
        &self,
        empty: &T,
        of_items: impl Fn(Range<usize>) -> T,
        merged: impl Fn(&T, &T) -> T,
    ) -> Vec<T> {
        let mut values = vec![empty.clone(); self.nodes.len()];
        // Children come after their parents.
        for (index, node) in self.nodes.iter().enumerate().rev() {
            values[index] = match node.count {
                0 => merged(&values[node.first], &values[node.first + 1]),
                count => of_items(node.first..node.first + count),
            };
        }
        values
    }
}

impl<const D: usize> Bvh<D> {
    /// Visits the places of items whose boxes meet the line through `origin` along `direction`, as long as they can do
    /// so at `|t|` up to what `visit` returned last (it starts at infinity); nearer boxes tend to come first. Nodes that
    /// `keeps` refuses are left out.
    pub(crate) fn along_line(
        &self,
        origin: &Point<f64, D>,
        direction: &[f64; D],
        keeps: impl Fn(usize) -> bool,
        mut visit: impl FnMut(usize) -> f64,
    ) {
        let mut limit = f64::INFINITY;
        let mut stack = Vec::with_capacity(MAX_DEPTH + 1);
        stack.extend(self.nodes[0].bounds.nearest_on_line(origin, direction).map(|near| (0usize, near)));
        while let Some((index, near)) = stack.pop() {
            if near > limit {
                continue;
            }
            let node = &self.nodes[index];
            if node.count > 0 {
                for place in node.first..node.first + node.count {
                    limit = visit(place);
                }
                continue;
            }
            let mut children = [node.first, node.first + 1]
                .map(|child| (child, self.nodes[child].bounds.nearest_on_line(origin, direction)))
                .map(|(child, near)| (child, near.filter(|_| keeps(child))));
            if children[0].1 < children[1].1 {
                children.swap(0, 1);
            }
            // The nearer one, last on the stack, is taken first.
            stack.extend(children.iter().filter_map(|&(child, near)| Some((child, near?))));
        }
    }
}

/// Reorders the items and returns where the right part begins; neither part is empty.
fn split<const D: usize>(items: &mut [u32], boxes: &[Aabb<D>], bounds: &Aabb<D>, depth: usize) -> usize {
    let mut centres = Aabb::EMPTY;
    for &item in items.iter() {
        let middle = std::array::from_fn(|axis| boxes[item as usize].centre(axis));
        centres = centres.union(&Aabb { min: middle, max: middle });
    }
    let extent = |axis: usize| centres.max[axis] - centres.min[axis];
    let axis = (1..D).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best });
    let half = items.len() / 2;
    let binned = if depth < BINNED_DEPTH && extent(axis) > 0.0 && extent(axis).is_finite() {
        binned_split(items, boxes, &centres, bounds, axis)
    } else {
        None
    };
    binned.unwrap_or_else(|| {
        items.select_nth_unstable_by(half, |&one, &other| {
            let [one_centre, other_centre] = [one, other].map(|item| boxes[item as usize].centre(axis));
            one_centre.total_cmp(&other_centre).then(one.cmp(&other))
        });
        half
    })
}

/// The split between bins of least expected cost (surface area × items); `None` if everything falls on one side.
fn binned_split<const D: usize>(
    items: &mut [u32],
    boxes: &[Aabb<D>],
    centres: &Aabb<D>,
    bounds: &Aabb<D>,
    axis: usize,
) -> Option<usize> {
    let scale = BINS as f64 / (centres.max[axis] - centres.min[axis]);
    let bin_of = |item: u32| {
        let position = (boxes[item as usize].centre(axis) - centres.min[axis]) * scale;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the bin is the integer part"
        )]
        (position as usize).min(BINS - 1)
    };
    let mut bins = [(Aabb::EMPTY, 0usize); BINS];
    for &item in items.iter() {
        let bin = &mut bins[bin_of(item)];
        *bin = (bin.0.union(&boxes[item as usize]), bin.1 + 1);
    }
    let mut right_costs = [0.0; BINS];
    let mut right = (Aabb::EMPTY, 0usize);
    for bin in (1..BINS).rev() {
        right = (right.0.union(&bins[bin].0), right.1 + bins[bin].1);
        right_costs[bin] = right.0.half_area() * right.1 as f64;
    }
    let mut left = (Aabb::EMPTY, 0usize);
    let mut best = (f64::INFINITY, 0);
    for bin in 1..BINS {
        left = (left.0.union(&bins[bin - 1].0), left.1 + bins[bin - 1].1);
        let cost = left.0.half_area() * left.1 as f64 + right_costs[bin];
        if left.1 > 0 && left.1 < items.len() && cost < best.0 {
            best = (cost, bin);
        }
    }
    // Where boxes are so large that no split pays, halving still serves the query better than a long leaf.
    if best.1 == 0 || best.0 >= bounds.half_area() * items.len() as f64 {
        return None;
    }
    Some(partition(items, |item| bin_of(item) < best.1))
}

/// Moves the items that satisfy the predicate to the front and returns their number.
fn partition(items: &mut [u32], is_left: impl Fn(u32) -> bool) -> usize {
    let mut left = 0;
    for index in 0..items.len() {
        if is_left(items[index]) {
            items.swap(left, index);
            left += 1;
        }
    }
    left
}
