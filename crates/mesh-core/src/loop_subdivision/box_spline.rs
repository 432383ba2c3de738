//! The quartic box spline: the limit surface over a triangle whose corners are regular.
//!
//! Twelve control vertices act on such a triangle. In the barycentric coordinates `u = 1 − v − w`, `v`, `w` their functions
//! are quartic polynomials, written here in Bernstein form. There are three kinds of them up to the symmetries of the
//! triangle: for its corners, for the vertices across its edges, and for the outer vertices at its corners.

/// Number of control vertices of a regular triangle.
pub(super) const REGULAR: usize = 12;

/// Values, and derivatives by `v`, `w`, `vv`, `vw`, `ww`.
pub(super) type Orders = [f64; 6];

/// Exponents of `u`, `v`, `w` of the fifteen Bernstein polynomials of degree four.
const EXPONENTS: [[usize; 3]; 15] = {
    let mut out = [[0; 3]; 15];
    let (mut index, mut a) = (0, 0);
    while a <= 4 {
        let mut b = 0;
        while a + b <= 4 {
            out[index] = [a, b, 4 - a - b];
            index += 1;
            b += 1;
        }
        a += 1;
    }
    out
};

/// Bernstein ordinates times 24 of the function of a corner, by the exponent of its own coordinate and the larger and
/// smaller of the others.
const fn corner(own: usize, larger: usize) -> f64 {
    match (own, larger) {
        (4 | 3, _) => 12.0,
        (2, 2) => 8.0,
        (2, _) => 10.0,
        (1, 3) | (0, 2) => 4.0,
        (1, _) => 6.0,
        (0, 4) => 2.0,
        _ => 3.0,
    }
}

/// The same for the vertex across the edge of two corners: by the exponent of the third coordinate and the larger of the
/// others.
const fn across(third: usize, larger: usize) -> f64 {
    match (third, larger) {
        (0, 4) => 2.0,
        (0, 3) => 3.0,
        (0, 2) => 4.0,
        (1, _) => 1.0,
        _ => 0.0,
    }
}

/// The same for an outer vertex: by the exponents of the corner at which it lies and of the end of the edge beside it.
const fn outer(corner: usize, beside: usize) -> f64 {
    match (corner, beside) {
        (4, 0) => 2.0,
        (3, 1) => 1.0,
        _ => 0.0,
    }
}

/// The corner, and the end of the edge beside it, of the outer vertices.
const OUTER: [[usize; 2]; 6] = [[0, 1], [0, 2], [1, 2], [1, 0], [2, 0], [2, 1]];

/// Bernstein ordinates of the twelve functions: the corners; the vertices across the edges `uv`, `vw`, `wu`; the outer ones
/// in the order of [`OUTER`].
const ORDINATES: [[f64; 15]; REGULAR] = {
    let mut out = [[0.0; 15]; REGULAR];
    let mut p = 0;
    while p < 15 {
        let e = EXPONENTS[p];
        let mut k = 0;
        while k < 3 {
            let (next, last) = (e[(k + 1) % 3], e[(k + 2) % 3]);
            out[k][p] = corner(e[k], if next > last { next } else { last }) / 24.0;
            // Across the edge from corner k to the next one, opposite to the last.
            out[3 + k][p] = across(last, if e[k] > next { e[k] } else { next }) / 24.0;
            k += 1;
        }
        let mut k = 0;
        while k < 6 {
            out[6 + k][p] = outer(e[OUTER[k][0]], e[OUTER[k][1]]) / 24.0;
            k += 1;
        }
        p += 1;
    }
    out
};

/// The functions of the twelve control vertices at `(v, w)`, `v, w ≥ 0`, `v + w ≤ 1`.
pub(super) fn basis([v, w]: [f64; 2]) -> [Orders; REGULAR] {
    let x = [1.0 - v - w, v, w];
    let mut powers = [[1.0; 5]; 3];
    for (power, x) in powers.iter_mut().zip(x) {
        for k in 1..5 {
            power[k] = power[k - 1] * x;
        }
    }
    // Derivatives of u^a v^b w^c by one or two of the coordinates.
    let monomial = |e: [usize; 3], by: [usize; 3]| {
        let mut product = 1.0;
        for d in 0..3 {
            let Some(rest) = e[d].checked_sub(by[d]) else { return 0.0 };
            product *= powers[d][rest] * falling(e[d], by[d]);
        }
        product
    };
    let mut out = [[0.0; 6]; REGULAR];
    for (p, &e) in EXPONENTS.iter().enumerate() {
        let binomial = 24.0 / (FACTORIALS[e[0]] * FACTORIALS[e[1]] * FACTORIALS[e[2]]);
        let d = |by: [usize; 3]| monomial(e, by);
        let (uu, uv, uw) = (d([2, 0, 0]), d([1, 1, 0]), d([1, 0, 1]));
        let orders = [
            d([0; 3]),
            d([0, 1, 0]) - d([1, 0, 0]),
            d([0, 0, 1]) - d([1, 0, 0]),
            d([0, 2, 0]) - 2.0 * uv + uu,
            d([0, 1, 1]) - uv - uw + uu,
            d([0, 0, 2]) - 2.0 * uw + uu,
        ];
        for (function, ordinates) in out.iter_mut().zip(&ORDINATES) {
            let factor = binomial * ordinates[p];
            if factor != 0.0 {
                for k in 0..6 {
                    function[k] += factor * orders[k];
                }
            }
        }
    }
    out
}

const FACTORIALS: [f64; 5] = [1.0, 1.0, 2.0, 6.0, 24.0];

/// `n (n − 1) …`, `k ≤ 2` factors.
fn falling(n: usize, k: usize) -> f64 {
    match k {
        0 => 1.0,
        1 => n as f64,
        _ => (n * n.saturating_sub(1)) as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loop_subdivision::neighbourhood::PLACES;

    fn places() -> impl Iterator<Item = [f64; 2]> {
        (0..40).map(|k| {
            let (v, w) = ((0.618 * f64::from(k)).fract(), (0.414 * f64::from(k)).fract());
            if v + w <= 1.0 { [v, w] } else { [1.0 - v, 1.0 - w] }
        })
    }

    #[test]
    fn the_functions_reproduce_quadratics_of_the_lattice() {
        for [v, w] in places() {
            let basis = basis([v, w]);
            let sum = |f: &dyn Fn(f64, f64) -> f64, order: usize| {
                basis
                    .iter()
                    .zip(PLACES)
                    .map(|(b, [x, y])| b[order] * f(f64::from(x), f64::from(y)))
                    .sum::<f64>()
            };
            assert!((sum(&|_, _| 1.0, 0) - 1.0).abs() < 1e-14);
            assert!((1..6).all(|order| sum(&|_, _| 1.0, order).abs() < 1e-13));
            assert!((sum(&|x, _| x, 0) - v).abs() < 1e-14 && (sum(&|_, y| y, 0) - w).abs() < 1e-14);
            assert!((sum(&|x, _| x, 1) - 1.0).abs() < 1e-13 && sum(&|x, _| x, 2).abs() < 1e-13);
            // Quadratics keep their second derivatives.
            assert!(
                (sum(&|x, _| x * x, 3) - 2.0).abs() < 1e-12 && (sum(&|x, y| x * y, 4) - 1.0).abs() < 1e-12
            );
            assert!((sum(&|_, y| y * y, 5) - 2.0).abs() < 1e-12 && sum(&|_, y| y * y, 3).abs() < 1e-12);
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let h = 1e-5;
        let (v, w) = (0.3, 0.25);
        let at = |a: f64, b: f64| basis([v + a * h, w + b * h]);
        let here = basis([v, w]);
        for i in 0..REGULAR {
            let slope =
                |a: f64, b: f64, order: usize| (at(a, b)[i][order] - at(-a, -b)[i][order]) / (2.0 * h);
            assert!(
                (slope(1.0, 0.0, 0) - here[i][1]).abs() < 1e-9
                    && (slope(0.0, 1.0, 0) - here[i][2]).abs() < 1e-9
            );
            assert!(
                (slope(1.0, 0.0, 1) - here[i][3]).abs() < 1e-8
                    && (slope(0.0, 1.0, 1) - here[i][4]).abs() < 1e-8
            );
            assert!((slope(0.0, 1.0, 2) - here[i][5]).abs() < 1e-8);
        }
    }
}
