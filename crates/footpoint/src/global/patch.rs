//! Bézier patches of one or several surfaces, prepared for the search.

use super::bernstein::binomial;
use super::cells::Cells;
use super::geometry::{Geometry, Homogeneous};
use super::lanes::{Lanes, Row, WIDTH, add_scaled, zero_row};
use super::scratch::Scratch;
use super::seeds::Sampling;
use super::tree::{Bounds, BoxTree};
use crate::projector::pool::Pool;
use nalgebra::Vector3;
use nurbs_core::{BezierPatch, BsplineSurface};
use std::ops::Deref;

pub(crate) use super::geometry::Patch;

/// All patches of a model, rows of squared distance forms with `8 K` coefficients, and a tree to find the nearest.
///
/// For the local query `y = x − centre` the squared distance, times the squared weight function, is the
/// polynomial `A − 2 ⟨y, B⟩ + |y|² W` with `A = |wS|²`, `B = w·wS`, `W = w²`: all three are stored in Bernstein
/// form of degree `2p < 8K` in `u` and `8K − 1 ≥ 2q` in `v`.
#[derive(Clone, Debug)]
pub(crate) struct PatchSet<const K: usize> {
    geometry: Geometry,
    pub(crate) tree: BoxTree<3>,
    /// `halves[0]`, `halves[1]`: row `j` is what coefficient `j` contributes to the lower and upper half.
    pub(crate) halves: [Vec<Row<K>>; 2],
    pub(super) sampling: Sampling<K>,
    forms: Vec<Row<K>>,
    pub(crate) scratch: Pool<Scratch<K>>,
}

/// A patch set is its geometry, and more.
impl<const K: usize> Deref for PatchSet<K> {
    type Target = Geometry;

    #[inline(always)]
    fn deref(&self) -> &Geometry {
        &self.geometry
    }
}

impl<const K: usize> PatchSet<K> {
    /// Degree of the forms in `v`.
    pub(crate) const DEGREE: usize = WIDTH * K - 1;

    pub(crate) fn new<'a>(surfaces: impl Iterator<Item = &'a BsplineSurface>) -> Self {
        let mut set = Self {
            geometry: Geometry::default(),
            tree: BoxTree::new(&[]),
            halves: halving_rows(),
            sampling: Sampling::default(),
            forms: Vec::new(),
            scratch: Pool::default(),
        };
        let mut boxes: Vec<Bounds<3>> = Vec::new();
        for (shape, surface) in surfaces.enumerate() {
            let first = set.patches.len();
            let columns = surface.knots_v().spans().count();
            for (index, patch) in surface.bezier_patches().iter().enumerate() {
                boxes.push(bounds(&patch.control_points));
                set.push(shape, [index / columns, index % columns], patch);
            }
            let cells = Cells::new(surface, first, columns, &set.geometry);
            set.geometry.cells.push(cells);
        }
        set.geometry.size = extent(&boxes);
        set.tree = BoxTree::new(&boxes);
        set
    }

    fn push(&mut self, shape: usize, cell: [usize; 2], patch: &BezierPatch) {
        let [low, high] = bounds(&patch.control_points);
        let centre = 0.5 * (Vector3::from(low) + Vector3::from(high));
        let weight = |i: usize| patch.weights.as_ref().map_or(1.0, |w| w[i]);
        let net: Vec<Homogeneous> = (patch.control_points.iter().enumerate())
            .map(|(i, p)| {
                let (q, w) = ((p - centre) * weight(i), weight(i));
                [q.x, q.y, q.z, w]
            })
            .collect();
        let form = self.forms.len();
        self.sampling.prepare(2 * patch.degrees[0]);
        self.push_form(&net, patch.degrees, patch.weights.is_some());
        self.geometry.push(shape, cell, patch, centre, net, form);
    }

    /// Appends the rows of `A`, `B` (three coordinates) and, if rational, `W`.
    fn push_form(&mut self, net: &[Homogeneous], degrees: [usize; 2], rational: bool) {
        let product = product(net, degrees, |a, b| {
            [a[0] * b[0] + a[1] * b[1] + a[2] * b[2], a[3] * b[0], a[3] * b[1], a[3] * b[2], a[3] * b[3]]
        });
        for part in 0..if rational { 5 } else { 4 } {
            for row in product.chunks(2 * degrees[1] + 1) {
                self.forms.push(elevate_row(row.iter().map(|c| c[part])));
            }
        }
    }

    /// As [`form`](Self::form), on a box of the patch and with differences taken before products, so that the
    /// rounding errors are small against the coefficients however small these are.
    pub(crate) fn fine_form(
        &self,
        patch: &Patch,
        y: &Vector3<f64>,
        region: &super::scratch::Region,
        limit_sq: f64,
        out: &mut [Row<K>],
    ) {
        let [p, q] = patch.degrees;
        let mut net: Vec<Homogeneous> = self
            .net(patch)
            .iter()
            .map(|c| [c[0] - c[3] * y.x, c[1] - c[3] * y.y, c[2] - c[3] * y.z, c[3]])
            .collect();
        for j in 0..=q {
            restrict(&mut net, j, q + 1, p, region.low[0], region.high[0]);
        }
        for i in 0..=p {
            restrict(&mut net, i * (q + 1), 1, q, region.low[1], region.high[1]);
        }
        let product = product(&net, patch.degrees, |a, b| {
            [a[0] * b[0] + a[1] * b[1] + a[2] * b[2] - limit_sq * (a[3] * b[3])]
        });
        for (row, out) in product.chunks(2 * q + 1).zip(out) {
            *out = elevate_row(row.iter().map(|c| c[0]));
        }
    }

    /// Bernstein coefficients of `w² (|S − x|² − limit_sq)` on the patch; `y` is `x − centre`.
    ///
    /// Returns the size of the terms that were summed, of which rounding errors are a share.
    #[inline(always)]
    pub(crate) fn form(&self, patch: &Patch, y: &Vector3<f64>, limit_sq: f64, out: &mut [Row<K>]) {
        let rows = patch.rows();
        let forms = &self.forms[patch.form..patch.form + rows * if patch.rational { 5 } else { 4 }];
        let constant = y.norm_squared() - limit_sq;
        let (a, rest) = forms.split_at(rows);
        let (bx, rest) = rest.split_at(rows);
        let (by, rest) = rest.split_at(rows);
        let (bz, w) = rest.split_at(rows);
        let factors = [-2.0 * y.x, -2.0 * y.y, -2.0 * y.z];
        for i in 0..rows {
            for k in 0..K {
                let mut value =
                    a[i][k] + (bx[i][k] * factors[0] + by[i][k] * factors[1] + bz[i][k] * factors[2]);
                if patch.rational {
                    value = value + w[i][k] * constant;
                } else {
                    value = value + Lanes::splat(constant);
                }
                out[i][k] = value;
            }
        }
    }

    /// Bernstein coefficients of the squared weight function, unless it is constant 1.
    pub(crate) fn weight_form(&self, patch: &Patch) -> Option<&[Row<K>]> {
        let rows = patch.rows();
        patch.rational.then(|| &self.forms[patch.form + 4 * rows..patch.form + 5 * rows])
    }

    /// Bytes of the prepared data.
    pub(crate) fn memory(&self) -> usize {
        self.geometry.memory() + size_of_val(&self.forms[..]) + self.tree.memory()
    }
}

/// Bernstein coefficients of products of a net with itself, row-major in degrees `(2p, 2q)`.
fn product<const N: usize>(
    net: &[Homogeneous],
    [p, q]: [usize; 2],
    multiply: impl Fn(&Homogeneous, &Homogeneous) -> [f64; N],
) -> Vec<[f64; N]> {
    let columns = 2 * q + 1;
    let mut out = vec![[0.0; N]; (2 * p + 1) * columns];
    // Products of Bernstein polynomials are convolutions of the coefficients, up to binomials.
    let share = |n: usize, i: usize, j: usize| binomial(n, i) * binomial(n, j) / binomial(2 * n, i + j);
    let shares_v: Vec<f64> = (0..(q + 1) * (q + 1)).map(|k| share(q, k / (q + 1), k % (q + 1))).collect();
    for i in 0..=p {
        for k in 0..=p {
            let share_u = share(p, i, k);
            for j in 0..=q {
                for l in 0..=q {
                    let factor = share_u * shares_v[j * (q + 1) + l];
                    let value = multiply(&net[i * (q + 1) + j], &net[k * (q + 1) + l]);
                    let slot = &mut out[(i + k) * columns + j + l];
                    for c in 0..N {
                        slot[c] += factor * value[c];
                    }
                }
            }
        }
    }
    out
}

/// Coefficients raised to the degree of a row, one degree at a time.
fn elevate_row<const K: usize>(coefficients: impl ExactSizeIterator<Item = f64>) -> Row<K> {
    let mut degree = coefficients.len() - 1;
    let mut flat = [[0.0; WIDTH]; K];
    let b = flat.as_flattened_mut();
    for (slot, value) in b.iter_mut().zip(coefficients) {
        *slot = value;
    }
    while degree < WIDTH * K - 1 {
        degree += 1;
        b[degree] = b[degree - 1];
        for j in (1..degree).rev() {
            let share = j as f64 / degree as f64;
            b[j] = share * b[j - 1] + (1.0 - share) * b[j];
        }
    }
    flat.map(Lanes)
}

/// Bézier points `net[first + k · stride]`, `k = 0..=n`, restricted to the parameters from `low` to `high`.
fn restrict(net: &mut [Homogeneous], first: usize, stride: usize, n: usize, low: f64, high: f64) {
    let mut blend = |a: usize, b: usize, to: usize, s: f64| {
        for c in 0..4 {
            net[to][c] = (1.0 - s) * net[a][c] + s * net[b][c];
        }
    };
    let at = |k: usize| first + k * stride;
    if high < 1.0 {
        for level in 1..=n {
            for k in (level..=n).rev() {
                blend(at(k - 1), at(k), at(k), high);
            }
        }
    }
    if low > 0.0 {
        let s = low / high;
        for level in 1..=n {
            for k in 0..=n - level {
                blend(at(k), at(k + 1), at(k), s);
            }
        }
    }
}

/// Rows that take a polynomial of degree `8 K − 1` to its lower and upper half.
fn halving_rows<const K: usize>() -> [Vec<Row<K>>; 2] {
    let n = WIDTH * K - 1;
    let rows = |share: &dyn Fn(usize, usize) -> f64| {
        (0..=n)
            .map(|j| {
                let mut row = zero_row::<K>();
                for l in 0..=n {
                    row[l / WIDTH].0[l % WIDTH] = share(j, l);
                }
                row
            })
            .collect::<Vec<_>>()
    };
    let power = |k: usize| 0.5f64.powi(i32::try_from(k).unwrap_or(i32::MAX));
    [
        rows(&|j, l| if j <= l { binomial(l, j) * power(l) } else { 0.0 }),
        rows(&|j, l| if j >= l { binomial(n - l, j - l) * power(n - l) } else { 0.0 }),
    ]
}

/// `row` restricted to one of the halves given by [`PatchSet::halves`].
#[inline(always)]
pub(crate) fn halve_row<const K: usize>(row: &Row<K>, half: &[Row<K>]) -> Row<K> {
    let mut out = zero_row::<K>();
    for k in 0..K {
        for l in 0..WIDTH {
            add_scaled(&mut out, &half[k * WIDTH + l], row[k].0[l]);
        }
    }
    out
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
