//! Control nets of parts of a patch, relative to the query: cut in two, measured, evaluated.

use crate::global::bernstein::basis_jet;
use crate::global::geometry::Homogeneous;
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

    /// Cuts a net at `at` in direction `d`; the parts below and above take its place and the one of `high`.
    #[inline(always)]
    pub(super) fn cut(self, low: &mut [f64], high: &mut [f64], d: usize, at: f64) {
        let (rows, columns) = (self.p + 1, self.q + 1);
        let n = rows * columns;
        let keep = 1.0 - at;
        high.copy_from_slice(low);
        for c in 0..self.components {
            let (low, high) = (&mut low[c * n..][..n], &mut high[c * n..][..n]);
            if d == 0 {
                for level in 0..rows {
                    low[level * columns..][..columns].copy_from_slice(&high[..columns]);
                    for i in 0..rows - 1 - level {
                        let (here, next) = high[i * columns..].split_at_mut(columns);
                        for (a, b) in here.iter_mut().zip(&next[..columns]) {
                            *a = *a * keep + b * at;
                        }
                    }
                }
            } else {
                for (low, high) in low.chunks_exact_mut(columns).zip(high.chunks_exact_mut(columns)) {
                    for level in 0..columns {
                        low[level] = high[0];
                        for j in 0..columns - 1 - level {
                            high[j] = high[j] * keep + high[j + 1] * at;
                        }
                    }
                }
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

    /// Ranges of value and derivatives over the part.
    #[inline(always)]
    pub(super) fn ranges(self, net: &[f64]) -> Ranges {
        let mut parts = [[[0.0; 2]; 6]; COMPONENTS];
        parts[3][0][0] = 1.0;
        for (c, part) in parts.iter_mut().enumerate().take(self.components) {
            *part = self.ranges_of(net, c);
        }
        Ranges { parts }
    }

    /// Ranges of one component.
    #[inline(always)]
    fn ranges_of(self, net: &[f64], c: usize) -> [[f64; 2]; 6] {
        let (rows, columns) = (self.p + 1, self.q + 1);
        let (p, q) = (self.p as f64, self.q as f64);
        let net = &net[c * rows * columns..][..rows * columns];
        let (last_u, last_v) = (rows - 1, columns - 1);
        let mut low = [f64::INFINITY; 6];
        let mut high = [f64::NEG_INFINITY; 6];
        let mut widen = |k: usize, value: f64| {
            low[k] = if value < low[k] { value } else { low[k] };
            high[k] = if value > high[k] { value } else { high[k] };
        };
        for i in 0..rows {
            let row = &net[i * columns..][..columns];
            for j in 0..columns {
                widen(0, row[j]);
            }
            for j in 0..last_v {
                widen(2, row[j + 1] - row[j]);
            }
            for j in 1..last_v {
                widen(5, (row[j + 1] - row[j]) - (row[j] - row[j - 1]));
            }
            if i < last_u {
                let next = &net[(i + 1) * columns..][..columns];
                for j in 0..columns {
                    widen(1, next[j] - row[j]);
                }
                for j in 0..last_v {
                    widen(4, (next[j + 1] - row[j + 1]) - (next[j] - row[j]));
                }
                if i > 0 {
                    let before = &net[(i - 1) * columns..][..columns];
                    for j in 0..columns {
                        widen(3, (next[j] - row[j]) - (row[j] - before[j]));
                    }
                }
            }
        }
        let factors = [1.0, p, q, p * (p - 1.0), p * q, q * (q - 1.0)];
        let mut out = [[0.0; 2]; 6];
        for k in 0..6 {
            // Directions of degree 1 have no second differences.
            if low[k] <= high[k] {
                out[k] = [0.5 * (high[k] + low[k]) * factors[k], 0.5 * (high[k] - low[k]) * factors[k]];
            }
        }
        out
    }
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
        for degrees in [[3, 3], [1, 4], [9, 2]] {
            let layout = Layout::new(degrees, true);
            let whole = net(layout);
            for d in 0..2 {
                let (mut low, mut high) = (whole.clone(), vec![0.0; whole.len()]);
                layout.cut(&mut low, &mut high, d, 0.3);
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
            let ranges = layout.ranges(&net);
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
                }
            }
        }
    }
}
