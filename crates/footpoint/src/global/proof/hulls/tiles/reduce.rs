//! Approximations of tiles by polynomials of degree 5, and how far they are off.

use super::build::narrow;
use super::span::{Span, spans};
use crate::global::arithmetic::bernstein::{basis_jet, elevation_matrix};
use crate::global::proof::hulls::net::{COMPONENTS, Layout, REDUCED};
use nalgebra::SMatrix;

/// Coefficients of an approximation in each direction.
const COUNT: usize = REDUCED + 1;

/// An approximation whose second derivatives differ by more than this, as a share of the first ones, does not help.
const COARSE: f64 = 0.005;

/// Interpolates tiles of patches of the same degrees at places between 0 and 1, coordinates times weights and weights alike.
pub(super) struct Reducer {
    layout: Layout,
    /// Values of the Bernstein polynomials of the patch at the places.
    basis: [Vec<[f64; COUNT]>; 2],
    /// From values to control points.
    inverse: SMatrix<f64, COUNT, COUNT>,
    /// Degrees of the difference of patch and approximation.
    degrees: [usize; 2],
    /// What coefficients contribute to those of these degrees, row by row: of the patch, and of the approximation.
    elevations: [[Vec<f64>; 2]; 2],
}

/// An approximation, component by component, and how far it is off.
pub(super) struct Reduced {
    pub(super) net: Vec<f32>,
    /// Bounds for derivatives of orders 0 to 3: of a coordinate times the weight, but for the order 0 of the length of all three, and
    /// of the weight.
    pub(super) reduction: [[f64; 4]; 2],
    /// Bound of the weights, and of those of the approximation, from below.
    pub(super) least: f64,
}

impl Reducer {
    pub(super) fn new(layout: Layout) -> Option<Self> {
        // Where the polynomial of least size is zero: Chebyshev's.
        let angle = |i: usize| std::f64::consts::PI * (2 * i + 1) as f64 / (2 * COUNT) as f64;
        let places: [f64; COUNT] = std::array::from_fn(|i| 0.5 - 0.5 * angle(i).cos());
        let values = |degree: usize| {
            let mut out = vec![[0.0; COUNT]; degree + 1];
            for (i, &place) in places.iter().enumerate() {
                let mut basis = vec![[0.0; 3]; degree + 1];
                basis_jet(degree, place, &mut basis);
                out.iter_mut().zip(&basis).for_each(|(out, basis)| out[i] = basis[0]);
            }
            out
        };
        let own = values(REDUCED);
        let inverse = SMatrix::<f64, COUNT, COUNT>::from_fn(|i, j| own[j][i]).try_inverse()?;
        let patch = [layout.p, layout.q];
        let degrees = patch.map(|p| p.max(REDUCED));
        let flat = |from: usize, to: usize| elevation_matrix(from, to).concat();
        Some(Self {
            layout,
            basis: patch.map(values),
            inverse,
            degrees,
            elevations: [
                [flat(patch[0], degrees[0]), flat(patch[1], degrees[1])],
                degrees.map(|to| flat(REDUCED, to)),
            ],
        })
    }

    /// The approximation of a net, given relative to a place on it, of a patch of a size; none if it is too far off.
    pub(super) fn reduce(&self, net: &[f64], size: f64) -> Option<Reduced> {
        let layout = self.layout;
        let n = layout.count();
        let rational = layout.components == COMPONENTS;
        let [p, q] = self.degrees;
        let mut off = Vec::with_capacity(layout.components * (p + 1) * (q + 1));
        let mut reduced = Vec::with_capacity(layout.components * COUNT * COUNT);
        for net in net.chunks_exact(n) {
            let points = self.inverse * self.values(net) * self.inverse.transpose();
            // As they will be kept.
            let flat: Vec<f64> =
                (0..COUNT * COUNT).map(|k| f64::from(narrow(points[(k / COUNT, k % COUNT)]))).collect();
            let same = self.degrees == [layout.p, layout.q];
            let own =
                if same { net.to_vec() } else { elevated(net, layout.q + 1, &self.elevations[0], q + 1) };
            let other = elevated(&flat, COUNT, &self.elevations[1], q + 1);
            off.extend(own.iter().zip(other).map(|(own, other)| own - other));
            reduced.extend(flat);
        }
        if !off.iter().chain(&reduced).all(|value| value.is_finite()) {
            return None;
        }
        let found = spans(Layout { p, q, components: layout.components }, &off);
        let (mut least, mut heaviest) = (1.0, 1.0);
        if rational {
            let all = || net[3 * n..].iter().chain(&reduced[3 * COUNT * COUNT..]).copied();
            least = all().fold(f64::INFINITY, f64::min);
            heaviest = all().fold(0.0, f64::max);
        }
        // Rounding errors add up in differences.
        let error = 64.0 * f64::EPSILON * (p + q) as f64 * heaviest;
        let most = |spans: &[[Span; 10]], size: f64| -> [f64; 4] {
            [(0, 1), (1, 3), (3, 6), (6, 10)].map(|(from, to)| {
                let order = i32::from(from > 0) + i32::from(from > 1) + i32::from(from > 3);
                let all = spans.iter().flat_map(|spans| &spans[from..to]).map(|span: &Span| span.most());
                all.fold(0.0, f64::max) + size * error * (2.0 * p.max(q) as f64).powi(order)
            })
        };
        let mut reduction =
            [most(&found[..3], size), if rational { most(&found[3..], 1.0) } else { [0.0; 4] }];
        let length = found[..3].iter().map(|spans| spans[0].most().powi(2)).sum::<f64>().sqrt();
        reduction[0][0] = length + 2.0 * error * size;
        // The sides of the approximation, and how far it reaches from the place.
        let at = |(i, j): (usize, usize)| -> [f64; 3] {
            let component = |c: usize| reduced[(c * COUNT + i) * COUNT + j];
            let w = if rational { component(3) } else { 1.0 };
            [0, 1, 2].map(|c| component(c) / w)
        };
        let length = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
        let last = REDUCED;
        let [a, b, c, d] = [(0, 0), (0, last), (last, 0), (last, last)].map(at);
        let (u, v) = (length(a, c).max(length(b, d)), length(a, b).max(length(c, d)));
        let reach = [a, b, c, d].into_iter().fold(0.0f64, |all, corner| all.max(length(corner, [0.0; 3])));
        let bent = (reduction[0][2] + reach * reduction[1][2]) / least;
        let finite = reduction.as_flattened().iter().all(|value| value.is_finite());
        let helps = least > 0.0 && finite && bent <= COARSE * u.min(v);
        helps.then(|| Reduced { net: reduced.into_iter().map(narrow).collect(), reduction, least })
    }

    /// The values of a component at the places.
    fn values(&self, net: &[f64]) -> SMatrix<f64, COUNT, COUNT> {
        let columns = self.layout.q + 1;
        let mut out = SMatrix::<f64, COUNT, COUNT>::zeros();
        for (row, by_u) in net.chunks_exact(columns).zip(&self.basis[0]) {
            let mut along = [0.0; COUNT];
            for (value, by_v) in row.iter().zip(&self.basis[1]) {
                for l in 0..COUNT {
                    along[l] += value * by_v[l];
                }
            }
            for (l, along) in along.into_iter().enumerate() {
                for k in 0..COUNT {
                    out[(k, l)] += by_u[k] * along;
                }
            }
        }
        out
    }
}

/// The coefficients of a polynomial in higher degrees.
fn elevated(net: &[f64], columns: usize, [by_u, by_v]: &[Vec<f64>; 2], to: usize) -> Vec<f64> {
    let rows = net.len() / columns;
    let mut half = vec![0.0; rows * to];
    for (row, half) in net.chunks_exact(columns).zip(half.chunks_exact_mut(to)) {
        for (shares, out) in by_v.chunks_exact(columns).zip(half) {
            *out = row.iter().zip(shares).map(|(value, share)| value * share).sum();
        }
    }
    let mut out = vec![0.0; by_u.len() / rows * to];
    for (shares, out) in by_u.chunks_exact(rows).zip(out.chunks_exact_mut(to)) {
        for (row, share) in half.chunks_exact(to).zip(shares) {
            for l in 0..to {
                out[l] += row[l] * share;
            }
        }
    }
    out
}
