//! How a patch is divided into tiles, and what is kept about each.

use super::reduce::Reducer;
use super::span::{Span, quotient, spans};
use super::{Leaf, Node, Tiles};
use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::simd::vectorized;
use crate::global::proof::hulls::net::{COMPONENTS, Layout, REDUCED};
use crate::global::surface::geometry::{Geometry, Patch};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Largest number of tiles of one patch: so many, and so many more for each degree above three.
const MOST: usize = 96;
const MORE: usize = 16;

/// Largest number of tiles of a model, about 1,100 bytes each.
const ALL: usize = 1 << 13;

/// How many times as many tiles a patch with weights may have if some are not like polynomials of low degree.
const AGAIN: usize = 2;

/// Fewer tiles than these are not worth it.
const FEWEST: usize = 8;

/// Degree above which every patch is divided: its squared distance has too many coefficients.
const HIGH: usize = 7;

/// How much a first derivative may differ from its middle, as a share of that, on a patch that is left as it is.
const TURN: f64 = 50.0;

/// Largest ratio of the weights of a patch that is left as it is.
const UNEVEN: f64 = 256.0;

/// A tile is divided no more when it is as plain as this, as a share of the size of the patch.
const PLAIN: f64 = 1e-4;

/// Sides shorter than this, in parameters of the patch, are not divided: numbers of half the length hold their halves.
const SHORT: f32 = 1.0 / 65536.0;

/// What counts of the sides of a tile on which the first derivatives change.
const CHANGE: f64 = 0.05;

/// A part of a patch that may be divided further.
struct Open {
    node: usize,
    net: Vec<f64>,
    unease: f64,
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Open {}
impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        self.unease.total_cmp(&other.unease).then(other.node.cmp(&self.node))
    }
}

/// The control net of a patch, component by component.
fn net_of(set: &Geometry, patch: &Patch, layout: Layout) -> Vec<f64> {
    let mut net = Vec::new();
    layout.push(set.net(patch), &mut net);
    net
}

/// Whether a patch is worth dividing.
fn is_hard(set: &Geometry, patch: &Patch) -> bool {
    let degree = patch.degrees().into_iter().max().unwrap_or(0);
    if degree > HIGH {
        return true;
    }
    if patch.pole.is_some() {
        return false;
    }
    if patch.max_weight_sq > UNEVEN * UNEVEN * patch.min_weight_sq {
        return true;
    }
    let layout = Layout::new(patch.degrees(), patch.rational);
    let points = euclidean(layout, &net_of(set, patch, layout));
    let flat = Layout::new(patch.degrees(), false);
    degree <= 3 && turn(flat, &points) > TURN
}

/// The control points divided by their weights, component by component.
fn euclidean(layout: Layout, net: &[f64]) -> Vec<f64> {
    let n = layout.count();
    let mut points = net[..3 * n].to_vec();
    if layout.components == COMPONENTS {
        for k in 0..3 * n {
            points[k] /= net[3 * n + k % n];
        }
    }
    points
}

/// How much the differences of neighbouring control points change, as a share of their middle.
fn turn(layout: Layout, points: &[f64]) -> f64 {
    let mut work = Vec::new();
    let ranges = vectorized(
        #[inline(always)]
        || layout.ranges(points, &mut work),
    );
    let length = |of: &dyn Fn(&[f64; 2]) -> f64, k: usize| {
        (0..3).map(|c| of(&ranges.parts[c][k]).powi(2)).sum::<f64>().sqrt()
    };
    let share = |k: usize| length(&|range| range[1], k) / length(&|range| range[0], k);
    let (u, v) = (share(1), share(2));
    // NaN, where a side has no length, counts as much.
    if u.is_nan() || v.is_nan() { f64::INFINITY } else { u.max(v) }
}

impl Tiles {
    /// Divides the patches that need it.
    pub(crate) fn new(set: &Geometry) -> Self {
        let mut tiles = Self::default();
        let hard: Vec<usize> = (0..set.patches.len()).filter(|&i| is_hard(set, &set.patches[i])).collect();
        if hard.is_empty() || ALL / (AGAIN * hard.len()) < FEWEST {
            return tiles;
        }
        tiles.roots = vec![u32::MAX; set.patches.len()];
        for &index in &hard {
            let patch = &set.patches[index];
            let degree = patch.degrees().into_iter().max().unwrap_or(0);
            let most = (MOST + MORE * degree.saturating_sub(3)).min(ALL / (AGAIN * hard.len()));
            tiles.roots[index] = u32::try_from(tiles.nodes.len()).unwrap_or(u32::MAX);
            tiles.divide(set, patch, most);
        }
        tiles
    }

    fn divide(&mut self, set: &Geometry, patch: &Patch, most: usize) {
        let layout = Layout::new(patch.degrees(), patch.rational);
        let net = net_of(set, patch, layout);
        let (root, unease) = enclose(layout, &net, [0.0; 2], [1.0; 2]);
        self.nodes.push(root);
        let plain = PLAIN * patch.radius;
        let mut heap = BinaryHeap::from([Open { node: self.nodes.len() - 1, net, unease }]);
        let mut work = Vec::new();
        // Low degrees are left as they are.
        let reducer = if layout.p.max(layout.q) > REDUCED { Reducer::new(layout) } else { None };
        let first = if reducer.is_some() { most / 2 } else { most };
        let most = if reducer.is_some() && patch.rational { AGAIN * most } else { most };
        while heap.len() < first && heap.peek().is_some_and(|open| open.unease > plain) {
            let Some(open) = heap.pop() else { break };
            heap.extend(self.halves(layout, &open, None, &mut work).into_iter().flatten());
        }
        // In the order of the nodes: heaps have none.
        let mut open = heap.into_vec();
        open.sort_by_key(|open| open.node);
        let (mut count, mut next) = (open.len(), 0);
        while next < open.len() {
            let Open { node, net, .. } = &open[next];
            next += 1;
            let centre = self.nodes[*node].centre;
            let about = about(layout, net, &centre);
            let reduced = reducer.as_ref().and_then(|reducer| reducer.reduce(&about, patch.radius));
            if reducer.is_some() && reduced.is_none() && count < most && self.nodes[*node].divisible() {
                count += 1;
                let direction = Some(unlike(layout, &about));
                let halves = self.halves(layout, &open[next - 1], direction, &mut work);
                open.extend(halves.into_iter().flatten());
                continue;
            }
            let mut leaf = Leaf::new(set, patch, layout, &about, &self.nodes[*node]);
            if let Some(found) = reduced {
                leaf.net = u32::try_from(self.nets.len()).unwrap_or(u32::MAX);
                leaf.reduction =
                    found.reduction.map(|part| part.map(|value| narrow(value * (1.0 + 1e-6) + 1e-44)));
                leaf.least = narrow(found.least * (1.0 - 1e-6));
                self.nets.extend(found.net);
            }
            self.nodes[*node].leaf = u32::try_from(self.leaves.len()).unwrap_or(u32::MAX);
            self.leaves.push(leaf);
        }
    }

    /// Cuts a part in two, in the direction that is given or of more use.
    fn halves(
        &mut self,
        layout: Layout,
        open: &Open,
        direction: Option<usize>,
        work: &mut Vec<f64>,
    ) -> [Option<Open>; 2] {
        let Node { low, high, .. } = self.nodes[open.node];
        let mut better: Option<(f64, [(Vec<f64>, (Node, f64)); 2])> = None;
        let side = |d: usize| high[d] - low[d];
        // A direction in which there is nothing to divide is not taken.
        let direction = direction.map(|d| if side(d) < SHORT { 1 - d } else { d });
        for d in (0..2).filter(|&d| side(d) >= SHORT && direction.is_none_or(|given| given == d)) {
            let (mut below, mut above) = (open.net.clone(), open.net.clone());
            layout.cut(&mut below, &mut above, d, 0.5, work);
            let (mut end, mut start) = (high, low);
            (end[d], start[d]) = (0.5 * (low[d] + high[d]), 0.5 * (low[d] + high[d]));
            let parts = [enclose(layout, &below, low, end), enclose(layout, &above, start, high)];
            let unease = parts[0].1 + parts[1].1;
            if better.as_ref().is_none_or(|(least, _)| unease < *least) {
                let [first, second] = parts;
                better = Some((unease, [(below, first), (above, second)]));
            }
        }
        let Some((_, parts)) = better else { return [None, None] };
        self.nodes[open.node].next = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        parts.map(|(net, (node, unease))| {
            self.nodes.push(node);
            Some(Open { node: self.nodes.len() - 1, net, unease })
        })
    }
}

/// The direction in which a net is less like one of the degree of approximations: where the derivatives of the next order are larger.
fn unlike(layout: Layout, net: &[f64]) -> usize {
    let n = layout.count();
    let size = |d: usize| {
        let degree = layout.degree(d);
        let (stride, count) = if d == 0 { (layout.q + 1, layout.q + 1) } else { (1, layout.p + 1) };
        let line = |k: usize| if d == 0 { k } else { k * (layout.q + 1) };
        let factor: f64 = (0..=REDUCED).map(|k| degree.saturating_sub(k) as f64).product();
        let mut most = 0.0f64;
        let mut values: Vec<f64> = Vec::new();
        for component in net.chunks_exact(n) {
            for first in (0..count).map(line) {
                values.clear();
                values.extend((0..=degree).map(|k| component[first + k * stride]));
                for _ in 0..=REDUCED.min(degree) {
                    for k in 1..values.len() {
                        values[k - 1] = values[k] - values[k - 1];
                    }
                    values.pop();
                }
                most = values.iter().fold(most, |all, value| all.max(value.abs()));
            }
        }
        most * factor
    };
    usize::from(size(1) > size(0))
}

/// A net relative to a place.
fn about(layout: Layout, net: &[f64], place: &[f64; 3]) -> Vec<f64> {
    let n = layout.count();
    let mut about = net.to_vec();
    for c in 0..3 {
        for k in 0..n {
            let w = if layout.components == COMPONENTS { net[3 * n + k] } else { 1.0 };
            about[c * n + k] -= w * place[c];
        }
    }
    about
}

/// The box of a part, and how much there is to be gained by dividing it.
fn enclose(layout: Layout, net: &[f64], low: [f32; 2], high: [f32; 2]) -> (Node, f64) {
    let points = euclidean(layout, net);
    let n = layout.count();
    let at = |k: usize| [points[k], points[n + k], points[2 * n + k]];
    let [a, b, c, d] = [0, layout.q, n - 1 - layout.q, n - 1].map(at);
    let u: [f64; 3] = std::array::from_fn(|k| (c[k] + d[k]) - (a[k] + b[k]));
    let v: [f64; 3] = std::array::from_fn(|k| (b[k] + d[k]) - (a[k] + c[k]));
    let axes = frame(u, v);
    let mut centre = [0.0; 3];
    let mut half = [0.0; 3];
    for (axis, half) in axes.iter().zip(&mut half) {
        let along = |k: usize| axis[0] * points[k] + axis[1] * points[n + k] + axis[2] * points[2 * n + k];
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..n {
            least = least.min(along(k));
            most = most.max(along(k));
        }
        let middle = 0.5 * (least + most);
        *half = 0.5 * (most - least);
        for c in 0..3 {
            centre[c] += middle * axis[c];
        }
    }
    // Rounding errors of the axes and of what was projected on them.
    let size = (0..3 * n).fold(0.0f64, |all, k| all.max(points[k].abs()));
    let node = Node {
        centre,
        axes,
        half: half.map(|h| h + 32.0 * f64::EPSILON * size),
        low,
        high,
        next: 0,
        leaf: 0,
    };
    let flat = Layout { components: COMPONENTS - 1, ..layout };
    let thickness = half.into_iter().fold(f64::INFINITY, f64::min);
    let change = turn(flat, &points).min(1.0);
    let mut sides = half;
    sides.sort_by(f64::total_cmp);
    let unease = thickness + CHANGE * change * (sides[1] + sides[2]);
    let unease = if node.divisible() { unease } else { 0.0 };
    (node, unease)
}

/// Three directions at right angles: along one of two vectors, in the plane of both, and across it; others where these have none.
fn frame(u: [f64; 3], v: [f64; 3]) -> [[f64; 3]; 3] {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let unit = |a: [f64; 3]| {
        let length = dot(a, a).sqrt();
        (length > 1e-150 && length.is_finite()).then(|| a.map(|c| c / length))
    };
    let (long, other) = if dot(u, u) >= dot(v, v) { (u, v) } else { (v, u) };
    let Some(first) = unit(long) else { return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };
    // Twice: what is left of almost parallel vectors is not quite at right angles.
    let upright = |a: [f64; 3]| {
        let share = dot(a, first);
        unit([a[0] - share * first[0], a[1] - share * first[1], a[2] - share * first[2]])
    };
    let smallest = (0..3).fold(0, |best, c| if first[c].abs() < first[best].abs() { c } else { best });
    let mut spare = [0.0; 3];
    spare[smallest] = 1.0;
    let along = upright(other).filter(|_| dot(other, other) > 1e-24 * dot(long, long));
    let second = along.or_else(|| upright(spare)).and_then(upright).unwrap_or(spare);
    [first, second, cross(first, second)]
}

impl Node {
    fn divisible(&self) -> bool {
        (0..2).any(|d| self.high[d] - self.low[d] >= SHORT)
    }
}

impl Leaf {
    /// `about` is the net from the centre of the box, so that quotients by weights lose little.
    fn new(set: &Geometry, patch: &Patch, layout: Layout, about: &[f64], node: &Node) -> Self {
        let n = layout.count();
        let [p, q] = patch.degrees();
        let all = spans(layout, about);
        let mut spans = [all[0], all[1], all[2]];
        let mut spread = 1.0;
        if layout.components == COMPONENTS {
            let weights = all[3];
            let points = euclidean(layout, about);
            for (c, spans) in spans.iter_mut().enumerate() {
                let points = &points[c * n..(c + 1) * n];
                let low = points.iter().copied().fold(f64::INFINITY, f64::min);
                let high = points.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                *spans = quotient(spans, &weights, Span::new([0.5 * (low + high), 0.5 * (high - low)]));
            }
            let w = weights[0];
            spread = ((w.middle + w.half) / (w.middle - w.half).max(f64::MIN_POSITIVE)).max(1.0);
        }
        // Errors of the control points add up in differences.
        let error = 16.0 * f64::EPSILON * (p + q + 4) as f64 * patch.radius * spread;
        let order = |k: usize| [0, 1, 1, 2, 2, 2, 3, 3, 3, 3][k];
        let spans = spans.map(|spans| {
            let mut out = [[0.0f32; 2]; 10];
            for (k, span) in spans.into_iter().enumerate() {
                let differences = (2.0 * p.max(q) as f64).powi(order(k));
                // Numbers of half the length round by less than this.
                let half = span.half * (1.0 + 1e-6) + span.middle.abs() * 1e-6 + error * differences + 1e-44;
                out[k] = [narrow(span.middle), narrow(half)];
            }
            out
        });
        let sums = narrow(sums(set, patch, layout, node) * (1.0 + 1e-6));
        Self { spans, sums, reduction: [[0.0; 4]; 2], least: 1.0, net: u32::MAX }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "what is lost has been allowed for")]
pub(super) fn narrow(value: f64) -> f32 {
    value as f32
}

/// Rounding errors of value, slopes and second derivatives at a place of a tile, in such of the value: the sum that [`noise`] takes.
///
/// The derivatives of a patch are sums of weights times derivatives of Bernstein polynomials, whose absolute values are bounded by
/// the polynomials of lower degree.
///
/// [`noise`]: crate::global::proof::hulls::convex::noise
fn sums(set: &Geometry, patch: &Patch, layout: Layout, node: &Node) -> f64 {
    let (p, q) = (layout.p, layout.q);
    let side = [0, 1].map(|d| f64::from(node.high[d]) - f64::from(node.low[d]));
    let weights: Vec<f64> = set.net(patch).iter().map(|c: &Homogeneous| c[3]).collect();
    let mut buffers = (Vec::new(), Vec::new());
    // Bounds of the sums of absolute values, for a derivative of the orders `a` and `b`, and the least of that of none.
    let mut range = |a: usize, b: usize| -> [f64; 2] {
        if a > p || b > q {
            return [0.0; 2];
        }
        let mut net = weights.clone();
        let (mut rows, mut columns) = (p + 1, q + 1);
        let mut factor = 1.0;
        for _ in 0..a {
            factor *= (rows - 1) as f64 * side[0];
            net = (0..(rows - 1) * columns).map(|k| net[k] + net[k + columns]).collect();
            rows -= 1;
        }
        for _ in 0..b {
            factor *= (columns - 1) as f64 * side[1];
            net = (0..rows * (columns - 1))
                .map(|k| {
                    let first = k / (columns - 1) * columns + k % (columns - 1);
                    net[first] + net[first + 1]
                })
                .collect();
            columns -= 1;
        }
        if patch.rational {
            let part = Layout { p: rows - 1, q: columns - 1, components: 1 };
            part.restrict(
                &mut net,
                node.low.map(f64::from),
                node.high.map(f64::from),
                &mut buffers.0,
                &mut buffers.1,
            );
        }
        let (low, high) = net.iter().fold((f64::INFINITY, 0.0f64), |(l, h), w| (l.min(*w), h.max(*w)));
        [low * factor, high * factor]
    };
    let least = range(0, 0)[0];
    let mut share = |a: usize, b: usize| range(a, b)[1] / least;
    let first = share(1, 0) + share(0, 1);
    let second = share(2, 0) + 2.0 * share(1, 1) + share(0, 2);
    let sums = 1.0 + 3.0 * first + second + 2.0 * first * first;
    if sums.is_finite() { sums } else { f64::from(f32::MAX) }
}
