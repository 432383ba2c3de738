//! Folds by bounds on the normal: the coefficients of `s_u × s_v` in Bernstein's basis.

use crate::parallel;
use nalgebra::Vector3;
use nurbs_core::{BezierPatch, BsplineSurface};

/// How often a cell is halved in both directions where its normals are not proven to be on one side: normals that differ by more than a
/// right angle in such a part are a fold.
const HALVINGS: usize = 5;
/// How much further where they do not differ, but are not proven either, near a place without a normal.
const FURTHER: usize = 3;
/// Share of the largest coefficient that counts as nothing, at poles.
const NEGLIGIBLE: f64 = 1e-9;

/// Parts of a knot span in each direction down to which folds are found.
pub(super) const PARTS: usize = 1 << HALVINGS;

/// The cells of a surface without weights in which the normal turns to the other side within a part of a span, by the index of their
/// spans in u and v, in ascending order.
///
/// The vector `s_u × s_v` of a Bézier patch of degrees p and q is a polynomial of degrees 2p − 1 and 2q − 1. It lies in the cone that its
/// Bernstein coefficients span: where these have a positive component along their sum, the patch has no fold. Where they do not, the
/// patch is halved. So every cell that is not told is proven to be free of folds down to that size.
pub(super) fn folded(surface: &BsplineSurface) -> Vec<[usize; 2]> {
    if surface.weights().is_some() {
        return Vec::new();
    }
    let patches = surface.bezier_patches();
    let columns = surface.knots_v().spans().count().max(1);
    let normals = parallel::tasks(patches.len(), |k| Normals::of(&patches[k]));
    let largest = normals.iter().map(Normals::largest).fold(0.0, f64::max);
    let found = parallel::tasks(normals.len(), |k| normals[k].turn_over(0, NEGLIGIBLE * largest));
    found.iter().enumerate().filter(|(_, f)| **f).map(|(k, _)| [k / columns, k % columns]).collect()
}

/// Bernstein coefficients of `s_u × s_v`, `rows × columns` of them.
struct Normals {
    rows: usize,
    columns: usize,
    coefficients: Vec<Vector3<f64>>,
}

/// Binomial coefficients `n over k`.
fn binomials(n: usize) -> Vec<f64> {
    let mut row = vec![1.0; n + 1];
    for k in 1..=n {
        row[k] = row[k - 1] * (n + 1 - k) as f64 / k as f64;
    }
    row
}

impl Normals {
    fn of(patch: &BezierPatch) -> Self {
        let [p, q] = patch.degrees;
        let net = |i: usize, j: usize| patch.control_points[i * (q + 1) + j];
        let (rows, columns) = (2 * p, 2 * q);
        let mut coefficients = vec![Vector3::zeros(); rows * columns];
        if p == 0 || q == 0 {
            return Self { rows, columns, coefficients };
        }
        let [bp, bp1, bq, bq1] = [p, p - 1, q, q - 1].map(binomials);
        // Products of polynomials are sums of products of their coefficients times binomials.
        for i in 0..p {
            for j in 0..=q {
                let by_u = (net(i + 1, j) - net(i, j)) * (bp1[i] * bq[j]);
                for k in 0..=p {
                    for l in 0..q {
                        let by_v = (net(k, l + 1) - net(k, l)) * (bp[k] * bq1[l]);
                        coefficients[(i + k) * columns + j + l] += by_u.cross(&by_v);
                    }
                }
            }
        }
        let [bu, bv] = [rows - 1, columns - 1].map(binomials);
        for (k, c) in coefficients.iter_mut().enumerate() {
            *c /= bu[k / columns] * bv[k % columns];
        }
        Self { rows, columns, coefficients }
    }

    fn largest(&self) -> f64 {
        self.coefficients.iter().map(|c| c.norm()).fold(0.0, f64::max)
    }

    /// Whether normals are on different sides within a part.
    fn turn_over(&self, depth: usize, negligible: f64) -> bool {
        let sum: Vector3<f64> = self.coefficients.iter().sum();
        if let Some(middle) = sum.try_normalize(0.0)
            && self.coefficients.iter().all(|c| c.dot(&middle) >= -negligible)
        {
            return false;
        }
        if self.largest() <= negligible || !self.largest().is_finite() {
            return false;
        }
        if depth >= HALVINGS {
            let last = self.coefficients.len();
            let corners = [0, self.columns - 1, last - self.columns, last - 1].map(|k| self.coefficients[k]);
            let opposite = |k: usize, l: usize| {
                let bound = negligible * corners[k].norm().max(corners[l].norm());
                corners[k].dot(&corners[l]) < -bound
            };
            if (0..4).any(|k| (0..k).any(|l| opposite(k, l))) {
                return true;
            }
            if depth >= HALVINGS + FURTHER {
                return false;
            }
        }
        self.quarters().iter().any(|part| part.turn_over(depth + 1, negligible))
    }

    /// The four parts of a patch that is halved in both directions (de Casteljau).
    fn quarters(&self) -> [Self; 4] {
        let [low, high] = self.halved(self.columns, 1, self.rows, self.columns);
        let [a, b] = low.halved(1, self.columns, self.columns, self.rows);
        let [c, d] = high.halved(1, self.columns, self.columns, self.rows);
        [a, b, c, d]
    }

    /// Halves along lines of `count` coefficients, `step` apart, of which there are `lines`, `between` apart.
    fn halved(&self, step: usize, between: usize, count: usize, lines: usize) -> [Self; 2] {
        let (mut low, mut high) = (self.coefficients.clone(), self.coefficients.clone());
        let mut line = vec![Vector3::zeros(); count];
        for k in 0..lines {
            for (i, slot) in line.iter_mut().enumerate() {
                *slot = self.coefficients[k * between + i * step];
            }
            for level in 0..count {
                low[k * between + level * step] = line[0];
                high[k * between + (count - 1 - level) * step] = line[count - 1 - level];
                for i in 0..count - 1 - level {
                    line[i] = (line[i] + line[i + 1]) * 0.5;
                }
            }
        }
        [low, high].map(|coefficients| Self { coefficients, ..*self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nurbs_core::{KnotVector, ParametricSurface};

    fn surface(place: &dyn Fn(f64, f64) -> Vector3<f64>) -> BsplineSurface {
        let knots = KnotVector::uniform_clamped(3, 8).unwrap();
        let at = knots.greville();
        let net = (0..64).map(|k| place(at[k / 8], at[k % 8])).collect();
        BsplineSurface::new(knots.clone(), knots, net, None).unwrap()
    }

    #[test]
    fn coefficients_are_those_of_the_normal() {
        let surface = surface(&|u, v| Vector3::new(u + 0.2 * v * v, v - 0.1 * u * u, (3.0 * u).sin() * v));
        for patch in surface.bezier_patches() {
            let normals = Normals::of(&patch);
            let parts = normals.quarters();
            // The last corner of the first quarter is the middle, in the parameters of the patch.
            let [u, v] = patch.intervals;
            let jet = surface.jet(u.lerp(0.5), v.lerp(0.5));
            let expected = jet.du.cross(&jet.dv) * (u.length() * v.length());
            let [p, q] = patch.degrees;
            let found = parts[0].coefficients[parts[0].coefficients.len() - 1] * (p * q) as f64;
            assert!((found - expected).norm() < 1e-12 * expected.norm(), "{found} {expected}");
            assert!((parts[3].coefficients[0] - parts[0].coefficients[35]).norm() < 1e-14);
        }
    }

    #[test]
    fn a_fold_inside_one_cell_is_found() {
        assert!(folded(&surface(&|u, v| Vector3::new(u, v, u * v))).is_empty());
        // One control point is drawn far across its neighbours: the sheet turns over between two knots.
        let folds = folded(&surface(&|u, v| {
            let moved = if (u - 0.4).abs() < 0.1 && (v - 0.4).abs() < 0.1 { 0.9 } else { 0.0 };
            Vector3::new(u + moved, v, 0.0)
        }));
        assert!(!folds.is_empty() && folds.len() < 17, "{folds:?}");
    }
}
