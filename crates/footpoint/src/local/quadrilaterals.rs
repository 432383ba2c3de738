//! Initial parameters by subdivision into quadrilaterals.

use nalgebra::{SVector, Vector3};
use nurbs_core::{Interval, ParametricSurface};

/// Parameters of the point nearest to `x` on the surface made of `counts` quadrilaterals.
///
/// The surface is sampled at `(counts[0] + 1) × (counts[1] + 1)` equally spaced parameters; each
/// quadrilateral is taken as two triangles, `x` is projected onto the nearest one, and the parameters are
/// recovered from its position there (\[PT01\]). Costs one evaluation for each sample; counts of 0 are
/// taken as 1.
pub fn nearest_quadrilateral<S: ParametricSurface + ?Sized>(
    surface: &S,
    x: &Vector3<f64>,
    counts: [usize; 2],
) -> [f64; 2] {
    let domains = surface.domain();
    let counts = counts.map(|n| n.max(1));
    let at = |domain: Interval, i: f64, n: usize| domain.lerp(i / n as f64);
    let row = |i: usize| -> Vec<Vector3<f64>> {
        let u = at(domains[0], i as f64, counts[0]);
        (0..=counts[1]).map(|j| surface.point(u, at(domains[1], j as f64, counts[1]))).collect()
    };
    let mut best = (f64::INFINITY, [0.0, 0.0]);
    let mut before = row(0);
    for i in 0..counts[0] {
        let after = row(i + 1);
        for j in 0..counts[1] {
            let (a, b, c, d) = (before[j], after[j], after[j + 1], before[j + 1]);
            // (Δi, Δj) of the corners: a (0,0), b (1,0), c (1,1), d (0,1).
            let [s, t] = nearest_in_triangle(x, &a, &b, &c);
            let candidates = [(a + (b - a) * s + (c - a) * t, [s + t, t]), {
                let [s, t] = nearest_in_triangle(x, &a, &d, &c);
                (a + (d - a) * s + (c - a) * t, [t, s + t])
            }];
            for (point, [di, dj]) in candidates {
                let distance_sq = (point - x).norm_squared();
                if distance_sq < best.0 {
                    best = (distance_sq, [i as f64 + di, j as f64 + dj]);
                }
            }
        }
        before = after;
    }
    [at(domains[0], best.1[0], counts[0]), at(domains[1], best.1[1], counts[1])]
}

/// `(s, t)` with `a + s(b − a) + t(c − a)` the point of the triangle nearest to `x`.
fn nearest_in_triangle(x: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> [f64; 2] {
    let (e, f, w) = (b - a, c - a, x - a);
    let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
    let (ew, fw) = (e.dot(&w), f.dot(&w));
    let determinant = ee * ff - ef * ef;
    if determinant > 1e-14 * ee * ff {
        let (s, t) = ((ff * ew - ef * fw) / determinant, (ee * fw - ef * ew) / determinant);
        if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
            return [s, t];
        }
    }
    // Outside or degenerate: the nearest point lies on one of the sides.
    let on_side = |from: &Vector3<f64>, to: &Vector3<f64>| {
        let side = to - from;
        share_of(&(x - from), &side)
    };
    let (p, q, r) = (on_side(a, b), on_side(a, c), on_side(b, c));
    let sides = [[p, 0.0], [0.0, q], [1.0 - r, r]];
    let distance_sq = |[s, t]: &[f64; 2]| (w - e * *s - f * *t).norm_squared();
    let mut best = sides[0];
    for side in &sides[1..] {
        if distance_sq(side) < distance_sq(&best) {
            best = *side;
        }
    }
    best
}

/// Where along `side` the foot of `w` lies, as a share within 0 and 1; 0 if the side has no length.
pub(crate) fn share_of<const D: usize>(w: &SVector<f64, D>, side: &SVector<f64, D>) -> f64 {
    let length_sq = side.norm_squared();
    if length_sq > 0.0 { (w.dot(side) / length_sq).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nurbs_core::{SurfaceFn, SurfaceJet};

    #[test]
    fn planes_are_recovered_exactly() {
        let zero = Vector3::zeros();
        let plane = SurfaceFn::new([Interval::UNIT, Interval::UNIT], |u: f64, v: f64| SurfaceJet {
            point: Vector3::new(3.0 * u + v, 2.0 * v, 1.0),
            du: Vector3::new(3.0, 0.0, 0.0),
            dv: Vector3::new(1.0, 2.0, 0.0),
            duu: zero,
            duv: zero,
            dvv: zero,
        });
        for (u, v) in [(0.3, 0.8), (0.71, 0.05), (0.5, 0.5), (0.0, 1.0)] {
            let x = Vector3::new(3.0 * u + v, 2.0 * v, -4.0);
            let [p, q] = nearest_quadrilateral(&plane, &x, [3, 4]);
            assert!((p - u).abs() < 1e-14 && (q - v).abs() < 1e-14, "{p} {q} for {u} {v}");
        }
        let [p, q] = nearest_quadrilateral(&plane, &Vector3::new(99.0, 1.0, 1.0), [2, 2]);
        assert!(p == 1.0 && q > 0.0, "{p} {q}");
    }
}
