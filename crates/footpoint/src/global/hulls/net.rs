//! Control nets of parts of a patch, relative to the query: cut in two, measured, evaluated.

use crate::global::bernstein::basis_jet;
use crate::global::geometry::Homogeneous;
use crate::global::lanes::{Lanes, WIDTH};
use nurbs_core::MAX_DEGREE;

/// Components of a control point, `w (p − x)` and `w`.
pub(super) const COMPONENTS: usize = 4;

/// Ranges over a part, as middle and half of the length.
pub(super) struct Ranges {
    /// By component: value, `u`, `v`, `uu`, `uv`, `vv`.
    pub(super) parts: [[[f64; 2]; 6]; COMPONENTS],
}

impl Ranges {
    /// Bound of the squared weight.
    #[inline(always)]
    pub(super) fn most_weight_sq(&self) -> f64 {
        let [middle, half] = self.parts[3][0];
        (middle.abs() + half) * (middle.abs() + half)
    }
}

/// The degrees of a net and how its numbers are laid out: component by component, each row by row in `u`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) p: usize,
    pub(super) q: usize,
    /// Three where all weights are 1.
    pub(super) components: usize,
}

impl Layout {
    pub(super) fn new([p, q]: [usize; 2], rational: bool) -> Self {
        Self { p, q, components: if rational { COMPONENTS } else { COMPONENTS - 1 } }
    }

    /// Control points.
    pub(super) fn count(self) -> usize {
        (self.p + 1) * (self.q + 1)
    }

    /// Numbers of a net.
    pub(super) fn length(self) -> usize {
        self.components * self.count()
    }

    /// Degree in a direction.
    pub(super) fn degree(self, d: usize) -> usize {
        if d == 0 { self.p } else { self.q }
    }

    /// Appends a net given point by point.
    pub(super) fn push(self, net: &[Homogeneous], out: &mut Vec<f64>) {
        for c in 0..self.components {
            out.extend(net.iter().map(|point| point[c]));
        }
    }

    /// Control point `k`, not divided by its weight, and the weight.
    #[inline(always)]
    pub(super) fn point(self, net: &[f64], k: usize) -> Homogeneous {
        let n = self.count();
        let w = if self.components == COMPONENTS { net[3 * n + k] } else { 1.0 };
        [net[k], net[n + k], net[2 * n + k], w]
    }

    /// Cuts a net at `at` in direction `d`; the parts below and above take its place and the one of `high`. `work` is a buffer.
    #[inline(always)]
    pub(super) fn cut(self, low: &mut [f64], high: &mut [f64], d: usize, at: f64, work: &mut Vec<f64>) {
        let (rows, columns) = (self.p + 1, self.q + 1);
        let n = rows * columns;
        work.resize(2 * n, 0.0);
        let (below, above) = work.split_at_mut(n);
        for (low, high) in low.chunks_exact_mut(n).zip(high.chunks_exact_mut(n)) {
            if d == 0 {
                high.copy_from_slice(low);
                cut_rows(low, high, columns, at);
            } else if columns < WIDTH {
                high.copy_from_slice(low);
                for (low, high) in low.chunks_exact_mut(columns).zip(high.chunks_exact_mut(columns)) {
                    cut_rows(low, high, 1, at);
                }
            } else {
                // Long rows: turned, so that many are treated side by side.
                transpose(low, rows, columns, above);
                cut_rows(below, above, rows, at);
                transpose(below, columns, rows, low);
                transpose(above, columns, rows, high);
            }
        }
    }

    /// Value, `u`, `v`, `uu`, `uv`, `vv` of the components at a place of the part.
    #[inline(always)]
    pub(super) fn jet(self, net: &[f64], [s, t]: [f64; 2]) -> [Homogeneous; 6] {
        let (rows, columns) = (self.p + 1, self.q + 1);
        let mut bu = [[0.0; 3]; MAX_DEGREE + 1];
        let mut bv = [[0.0; 3]; MAX_DEGREE + 1];
        basis_jet(self.p, s, &mut bu[..rows]);
        basis_jet(self.q, t, &mut bv[..columns]);
        let mut jet = [[0.0; COMPONENTS]; 6];
        jet[0][3] = 1.0;
        for c in 0..self.components {
            let net = &net[c * rows * columns..][..rows * columns];
            let mut sums = [0.0; 6];
            for (row, b) in net.chunks_exact(columns).zip(&bu) {
                let mut along = [0.0; 3];
                for (value, b) in row.iter().zip(&bv) {
                    for k in 0..3 {
                        along[k] += value * b[k];
                    }
                }
                sums[0] += along[0] * b[0];
                sums[1] += along[0] * b[1];
                sums[2] += along[1] * b[0];
                sums[3] += along[0] * b[2];
                sums[4] += along[1] * b[1];
                sums[5] += along[2] * b[0];
            }
            for k in 0..6 {
                jet[k][c] = sums[k];
            }
        }
        jet
    }

    /// Ranges of value and derivatives over the part; `work` is a buffer.
    #[inline(always)]
    pub(super) fn ranges(self, net: &[f64], work: &mut Vec<f64>) -> Ranges {
        let (rows, columns) = (self.p + 1, self.q + 1);
        let n = self.count();
        let (p, q) = (self.p as f64, self.q as f64);
        let factors = [1.0, p, q, p * (p - 1.0), p * q, q * (q - 1.0)];
        let mut parts = [[[0.0; 2]; 6]; COMPONENTS];
        parts[3][0][0] = 1.0;
        work.resize(3 * n, 0.0);
        let (across, rest) = work.split_at_mut(n);
        let (turned, turned_across) = rest.split_at_mut(n);
        for (net, part) in net.chunks_exact(n).zip(&mut parts) {
            // Rows side by side, and columns side by side: all differences are those of neighbouring stretches.
            for ((to, a), b) in across.iter_mut().zip(net).zip(&net[columns..]) {
                *to = b - a;
            }
            transpose(net, rows, columns, turned);
            transpose(across, rows - 1, columns, turned_across);
            let (u, v) = (&across[..n - columns], &turned_across[..n - columns]);
            let values = [
                range::<0>(net, 0),
                range::<0>(u, 0),
                range::<1>(turned, rows),
                range::<1>(u, columns),
                range::<1>(v, rows - 1),
                range::<2>(turned, rows),
            ];
            for k in 0..6 {
                part[k] = [values[k][0] * factors[k], values[k][1] * factors[k]];
            }
        }
        Ranges { parts }
    }

    /// Ranges of the third derivatives `uuu`, `uuv`, `uvv`, `vvv` of the components over the part; `work` is a buffer.
    pub(super) fn thirds(self, net: &[f64], work: &mut Vec<f64>) -> [[[f64; 2]; 4]; COMPONENTS] {
        let (rows, columns) = (self.p + 1, self.q + 1);
        let n = self.count();
        let (p, q) = (self.p as f64, self.q as f64);
        let factors =
            [p * (p - 1.0) * (p - 2.0), p * (p - 1.0) * q, p * q * (q - 1.0), q * (q - 1.0) * (q - 2.0)];
        let mut thirds = [[[0.0; 2]; 4]; COMPONENTS];
        work.resize(3 * n, 0.0);
        let (turned, rest) = work.split_at_mut(n);
        let (along, back) = rest.split_at_mut(n);
        for (net, third) in net.chunks_exact(n).zip(&mut thirds) {
            transpose(net, rows, columns, turned);
            // Differences in `v`, which are rows of the turned net, and turned back.
            for ((to, a), b) in along.iter_mut().zip(&*turned).zip(&turned[rows..]) {
                *to = b - a;
            }
            transpose(along, columns - 1, rows, back);
            let v = &back[..rows * (columns - 1)];
            third[0] = range::<3>(net, columns);
            third[1] = range::<2>(v, columns - 1);
            third[3] = range::<3>(turned, rows);
            // And the other way about.
            for ((to, a), b) in along.iter_mut().zip(net).zip(&net[columns..]) {
                *to = b - a;
            }
            transpose(along, rows - 1, columns, back);
            third[2] = range::<2>(&back[..(rows - 1) * columns], rows - 1);
            for k in 0..4 {
                third[k] = [third[k][0] * factors[k], third[k][1] * factors[k]];
            }
        }
        thirds
    }
}

/// De Casteljau's scheme on rows of a length: `high` becomes its part above `at`, `low` the one below.
#[inline(always)]
fn cut_rows(low: &mut [f64], high: &mut [f64], row: usize, at: f64) {
    let keep = 1.0 - at;
    let length = high.len();
    for first in (0..length).step_by(row) {
        low[first..first + row].copy_from_slice(&high[..row]);
        for next in (row..length - first).step_by(row) {
            let (before, after) = high.split_at_mut(next);
            for (a, b) in before[next - row..].iter_mut().zip(&after[..row]) {
                *a = *a * keep + b * at;
            }
        }
    }
}

/// `to` becomes `from`, row by row of `columns`, with rows and columns exchanged.
#[inline(always)]
fn transpose(from: &[f64], rows: usize, columns: usize, to: &mut [f64]) {
    for (i, row) in from.chunks_exact(columns).take(rows).enumerate() {
        for (j, value) in row.iter().enumerate() {
            to[j * rows + i] = *value;
        }
    }
}

/// Middle and half of the length of the range of the differences of an order between neighbouring rows of a length; zeros if there are
/// none. Eight at a time.
#[inline(always)]
fn range<const ORDER: usize>(values: &[f64], row: usize) -> [f64; 2] {
    let Some(last) = values.get(ORDER * row..).filter(|last| !last.is_empty()) else { return [0.0; 2] };
    let stretch = |k: usize| &values[k.min(ORDER) * row..][..last.len()];
    let (first, second, third) = (stretch(0), stretch(1), stretch(2));
    let mut low = [f64::INFINITY; WIDTH];
    let mut high = [f64::NEG_INFINITY; WIDTH];
    let difference = |a: f64, b: f64, c: f64, d: f64| match ORDER {
        0 => a,
        1 => b - a,
        2 => (c - b) - (b - a),
        _ => ((d - c) - (c - b)) - ((c - b) - (b - a)),
    };
    let firsts = first.chunks_exact(WIDTH);
    let (seconds, thirds) = (second.chunks_exact(WIDTH), third.chunks_exact(WIDTH));
    let lasts = last.chunks_exact(WIDTH);
    let rest = firsts.remainder().iter().zip(seconds.remainder());
    let rest = rest.zip(thirds.remainder()).zip(lasts.remainder());
    for (((a, b), c), d) in rest {
        let value = difference(*a, *b, *c, *d);
        low[0] = if value < low[0] { value } else { low[0] };
        high[0] = if value > high[0] { value } else { high[0] };
    }
    for (((a, b), c), d) in firsts.zip(seconds).zip(thirds).zip(lasts) {
        for l in 0..WIDTH {
            let value = difference(a[l], b[l], c[l], d[l]);
            low[l] = if value < low[l] { value } else { low[l] };
            high[l] = if value > high[l] { value } else { high[l] };
        }
    }
    let (low, high) = (Lanes(low).horizontal_min(), Lanes(high).horizontal_max());
    [0.5 * (high + low), 0.5 * (high - low)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn net(layout: Layout) -> Vec<f64> {
        (0..layout.length())
            .map(|k| ((k * 7919) % 101) as f64 / 50.0 + if k >= 3 * layout.count() { 1.0 } else { -1.0 })
            .collect()
    }

    #[test]
    fn both_parts_are_the_same_surface() {
        for degrees in [[3, 3], [1, 4], [9, 2], [2, 9]] {
            let layout = Layout::new(degrees, true);
            let whole = net(layout);
            for d in 0..2 {
                let (mut low, mut high) = (whole.clone(), vec![0.0; whole.len()]);
                layout.cut(&mut low, &mut high, d, 0.3, &mut Vec::new());
                for place in [[0.1, 0.7], [0.9, 0.2], [1.0, 1.0]] {
                    let mut at = [place; 2];
                    at[0][d] *= 0.3;
                    at[1][d] = 0.3 + 0.7 * place[d];
                    for (part, at) in [(&low, at[0]), (&high, at[1])] {
                        let (a, b) = (layout.jet(part, place)[0], layout.jet(&whole, at)[0]);
                        assert!(
                            (0..COMPONENTS).all(|c| (a[c] - b[c]).abs() < 1e-13),
                            "{degrees:?} {d} {a:?} {b:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn ranges_hold_the_derivatives() {
        for degrees in [[3, 3], [1, 4], [5, 1]] {
            let layout = Layout::new(degrees, true);
            let net = net(layout);
            let ranges = layout.ranges(&net, &mut Vec::new());
            let thirds = layout.thirds(&net, &mut Vec::new());
            for k in 0..=20 {
                let place = [0.05 * f64::from(k), (0.37 * f64::from(k)).fract()];
                let jet = layout.jet(&net, place);
                for c in 0..COMPONENTS {
                    for (value, [middle, half]) in jet.iter().zip(ranges.parts[c]) {
                        assert!(
                            (value[c] - middle).abs() <= half + 1e-12,
                            "{degrees:?} {c} {value:?} {middle} {half}"
                        );
                    }
                    // Third derivatives by differences of second ones.
                    let step = |d: usize| {
                        let h = 1e-6;
                        let mut to = place;
                        to[d] += h;
                        let there = layout.jet(&net, to);
                        [3, 4, 5].map(|k| (there[k][c] - jet[k][c]) / h)
                    };
                    let (u, v) = (step(0), step(1));
                    for (value, [middle, half]) in [u[0], u[1], u[2], v[2]].into_iter().zip(thirds[c]) {
                        assert!(
                            (value - middle).abs() <= half + 1e-2,
                            "{degrees:?} {c} {value} {middle} {half}"
                        );
                    }
                    assert!((u[1] - v[0]).abs() < 1e-2 && (u[2] - v[1]).abs() < 1e-2);
                }
            }
        }
    }
}
