//! Control nets of parts of a patch, relative to the query: cut in two, measured, evaluated.

use crate::global::arithmetic::bernstein::basis_jet;
use crate::global::arithmetic::homogeneous::Homogeneous;
use crate::global::arithmetic::lanes::{Lanes, WIDTH};
use nurbs_core::MAX_DEGREE;

/// Components of a control point, `w (p − x)` and `w`.
pub(super) const COMPONENTS: usize = 4;

/// Degree of approximations.
pub(super) const REDUCED: usize = 5;

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

/// How much value, `u`, `v`, `uu`, `uv`, `vv`, `uuu`, `uuv`, `uvv`, `vvv` of any component may differ from what a net tells: coordinates,
/// and the weight.
pub(super) type Reduction = [[f64; 10]; 2];

impl Ranges {
    /// Adds what the components may differ by.
    #[inline(always)]
    pub(super) fn widen(&mut self, reduction: &Reduction) {
        for c in 0..COMPONENTS {
            for k in 0..6 {
                self.parts[c][k][1] += reduction[usize::from(c == 3)][k];
            }
        }
    }
}

/// The same for third derivatives.
#[inline(always)]
pub(super) fn widen_thirds(thirds: &mut [[[f64; 2]; 4]; COMPONENTS], reduction: &Reduction) {
    for c in 0..COMPONENTS {
        for k in 0..4 {
            thirds[c][k][1] += reduction[usize::from(c == 3)][6 + k];
        }
    }
}

/// The degrees of a net and how its numbers are laid out: component by component, each row by row in `u`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) p: usize,
    pub(super) q: usize,
    /// Three where all weights are 1.
    pub(super) components: usize,
}

impl Layout {
    pub(super) const BICUBIC: Self = Self { p: 3, q: 3, components: COMPONENTS - 1 };

    /// That of approximations.
    #[inline(always)]
    pub(super) const fn reduced(rational: bool) -> Self {
        Self { p: REDUCED, q: REDUCED, components: if rational { COMPONENTS } else { COMPONENTS - 1 } }
    }

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
        for c in 0..self.components {
            let (low, high) = (&mut low[c * n..(c + 1) * n], &mut high[c * n..(c + 1) * n]);
            if d == 0 {
                high.copy_from_slice(low);
                cut_rows(low, high, columns, at);
            } else {
                // Turned, so that many are treated side by side.
                transpose(low, rows, columns, above);
                cut_rows(below, above, rows, at);
                transpose(below, columns, rows, low);
                transpose(above, columns, rows, high);
            }
        }
    }

    /// Restricts a net to the parameters from `low` to `high`; `spare` and `work` are buffers.
    #[inline(always)]
    pub(super) fn restrict(
        self,
        net: &mut [f64],
        low: [f64; 2],
        high: [f64; 2],
        spare: &mut Vec<f64>,
        work: &mut Vec<f64>,
    ) {
        spare.resize(net.len(), 0.0);
        for d in 0..2 {
            if high[d] < 1.0 {
                self.cut(net, spare, d, high[d], work);
            }
            if low[d] > 0.0 {
                self.cut(net, spare, d, low[d] / high[d], work);
                net.copy_from_slice(spare);
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
        let n = rows * columns;
        for c in 0..self.components {
            let net = &net[c * n..(c + 1) * n];
            // By derivative in `u`, those in `v` side by side.
            let mut sums = [[0.0; 4]; 3];
            for i in 0..rows {
                let mut along = [0.0; 4];
                for j in 0..columns {
                    let value = net[i * columns + j];
                    let [b, first, second] = bv[j];
                    let b = [b, first, second, 0.0];
                    for k in 0..4 {
                        along[k] += value * b[k];
                    }
                }
                for l in 0..3 {
                    for k in 0..4 {
                        sums[l][k] += along[k] * bu[i][l];
                    }
                }
            }
            for (k, [l, m]) in [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]].into_iter().enumerate() {
                jet[k][c] = sums[l][m];
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
        for c in 0..self.components {
            let net = &net[c * n..(c + 1) * n];
            // Rows side by side, and columns side by side: all differences are those of neighbouring stretches.
            differences(net, columns, across);
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
                parts[c][k] = [values[k][0] * factors[k], values[k][1] * factors[k]];
            }
        }
        Ranges { parts }
    }

    /// Ranges of the third derivatives `uuu`, `uuv`, `uvv`, `vvv` of the components over the part; `work` is a buffer.
    #[inline(always)]
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
        for c in 0..self.components {
            let (net, third) = (&net[c * n..(c + 1) * n], &mut thirds[c]);
            transpose(net, rows, columns, turned);
            // Differences in `v`, which are rows of the turned net, and turned back.
            differences(turned, rows, along);
            transpose(along, columns - 1, rows, back);
            let v = &back[..rows * (columns - 1)];
            third[0] = range::<3>(net, columns);
            third[1] = range::<2>(v, columns - 1);
            third[3] = range::<3>(turned, rows);
            // And the other way about.
            differences(net, columns, along);
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
    let mut first = 0;
    while first < length {
        low[first..first + row].copy_from_slice(&high[..row]);
        // What is written is not read again at this level.
        let stretch = length - first - row;
        let mut k = 0;
        while k + WIDTH <= stretch {
            let (a, b) = (load(high, k), load(high, k + row));
            store(a * keep + b * at, high, k);
            k += WIDTH;
        }
        while k < stretch {
            high[k] = high[k] * keep + high[k + row] * at;
            k += 1;
        }
        first += row;
    }
}

/// Differences of neighbouring rows of a length.
#[inline(always)]
fn differences(values: &[f64], row: usize, to: &mut [f64]) {
    let stretch = values.len() - row;
    let mut k = 0;
    while k + WIDTH <= stretch {
        store(load(values, k + row) - load(values, k), to, k);
        k += WIDTH;
    }
    while k < stretch {
        to[k] = values[k + row] - values[k];
        k += 1;
    }
}

/// Eight neighbouring numbers.
#[inline(always)]
#[expect(clippy::manual_memcpy, reason = "loops of known length become moves of vectors")]
pub(super) fn load(values: &[f64], from: usize) -> Lanes {
    let values = &values[from..from + WIDTH];
    let mut out = Lanes::splat(0.0);
    for l in 0..WIDTH {
        out.0[l] = values[l];
    }
    out
}

#[inline(always)]
#[expect(clippy::manual_memcpy, reason = "loops of known length become moves of vectors")]
fn store(lanes: Lanes, to: &mut [f64], from: usize) {
    let to = &mut to[from..from + WIDTH];
    for l in 0..WIDTH {
        to[l] = lanes.0[l];
    }
}

/// `to` becomes `from`, row by row of `columns`, with rows and columns exchanged.
#[inline(always)]
fn transpose(from: &[f64], rows: usize, columns: usize, to: &mut [f64]) {
    let (from, to) = (&from[..rows * columns], &mut to[..rows * columns]);
    for i in 0..rows {
        for j in 0..columns {
            to[j * rows + i] = from[i * columns + j];
        }
    }
}

/// Middle and half of the length of the range of the differences of an order between neighbouring rows of a length; zeros if there are
/// none. Eight at a time.
#[inline(always)]
fn range<const ORDER: usize>(values: &[f64], row: usize) -> [f64; 2] {
    if values.len() <= ORDER * row {
        return [0.0; 2];
    }
    let stretch = values.len() - ORDER * row;
    let mut low = Lanes::splat(f64::INFINITY);
    let mut high = Lanes::splat(f64::NEG_INFINITY);
    let mut k = 0;
    while k + WIDTH <= stretch {
        let value = match ORDER {
            0 => load(values, k),
            1 => load(values, k + row) - load(values, k),
            2 => {
                let middle = load(values, k + row);
                (load(values, k + 2 * row) - middle) - (middle - load(values, k))
            }
            _ => {
                let (b, c) = (load(values, k + row), load(values, k + 2 * row));
                let middle = c - b;
                ((load(values, k + 3 * row) - c) - middle) - (middle - (b - load(values, k)))
            }
        };
        // NaN is left out, as by the comparison.
        low = value.min(low);
        high = value.max(high);
        k += WIDTH;
        if k < stretch && k + WIDTH > stretch && stretch > WIDTH {
            // The last ones, some of them once more.
            k = stretch - WIDTH;
        }
    }
    while k < stretch {
        let at = |i: usize| values[k + i * row];
        let value = match ORDER {
            0 => at(0),
            1 => at(1) - at(0),
            2 => (at(2) - at(1)) - (at(1) - at(0)),
            _ => ((at(3) - at(2)) - (at(2) - at(1))) - ((at(2) - at(1)) - (at(1) - at(0))),
        };
        let lane = k % WIDTH;
        low.0[lane] = if value < low.0[lane] { value } else { low.0[lane] };
        high.0[lane] = if value > high.0[lane] { value } else { high.0[lane] };
        k += 1;
    }
    let (low, high) = (low.horizontal_min(), high.horizontal_max());
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
