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
const EXPONENTS: [[usize; 3]; 15] = exponents(4);

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

/// Exponents of `u`, `v`, `w` of the `COUNT` Bernstein polynomials of a degree.
const fn exponents<const COUNT: usize>(degree: usize) -> [[usize; 3]; COUNT] {
    let mut out = [[0; 3]; COUNT];
    let (mut index, mut a) = (0, 0);
    while a <= degree {
        let mut b = 0;
        while a + b <= degree {
            out[index] = [a, b, degree - a - b];
            index += 1;
            b += 1;
        }
        a += 1;
    }
    out
}

/// The index of exponents in [`exponents`].
const fn index_of(degree: usize, [a, b, _]: [usize; 3]) -> usize {
    // Before row a there are rows of degree + 1, degree, … entries.
    a * (degree + 1) - a * a.saturating_sub(1) / 2 + b
}

/// Ordinates of the derivative by coordinate `d` (`v` or `w`, with `u` falling as it grows), function by function.
const fn derived<const FROM: usize, const TO: usize>(
    ordinates: &[[f64; REGULAR]; FROM],
    degree: usize,
    d: usize,
) -> [[f64; REGULAR]; TO] {
    let lower: [[usize; 3]; TO] = exponents(degree - 1);
    let mut out = [[0.0; REGULAR]; TO];
    let mut p = 0;
    while p < TO {
        let (mut up, mut down) = (lower[p], lower[p]);
        up[d] += 1;
        down[0] += 1;
        let (up, down) = (index_of(degree, up), index_of(degree, down));
        let mut f = 0;
        while f < REGULAR {
            out[p][f] = degree as f64 * (ordinates[up][f] - ordinates[down][f]);
            f += 1;
        }
        p += 1;
    }
    out
}

/// [`ORDINATES`] and those of the derivatives, polynomial by polynomial.
const VALUE: [[f64; REGULAR]; 15] = {
    let mut out = [[0.0; REGULAR]; 15];
    let mut p = 0;
    while p < 15 {
        let mut f = 0;
        while f < REGULAR {
            out[p][f] = ORDINATES[f][p];
            f += 1;
        }
        p += 1;
    }
    out
};
const BY_V: [[f64; REGULAR]; 10] = derived(&VALUE, 4, 1);
const BY_W: [[f64; REGULAR]; 10] = derived(&VALUE, 4, 2);
const BY_VV: [[f64; REGULAR]; 6] = derived(&BY_V, 3, 1);
const BY_VW: [[f64; REGULAR]; 6] = derived(&BY_V, 3, 2);
const BY_WW: [[f64; REGULAR]; 6] = derived(&BY_W, 3, 2);

/// The Bernstein polynomials of one degree more than those that are given.
fn raised<const FROM: usize, const TO: usize>(lower: &[f64; FROM], degree: usize, x: [f64; 3]) -> [f64; TO] {
    let mut out = [0.0; TO];
    for (e, value) in exponents::<FROM>(degree - 1).into_iter().zip(lower) {
        for (d, x) in x.into_iter().enumerate() {
            let mut up = e;
            up[d] += 1;
            out[index_of(degree, up)] += x * value;
        }
    }
    out
}

/// `Σ b_p ordinates_p` for all functions.
fn summed<const COUNT: usize>(
    polynomials: &[f64; COUNT],
    ordinates: &[[f64; REGULAR]; COUNT],
) -> [f64; REGULAR] {
    let mut out = [0.0; REGULAR];
    for (polynomial, row) in polynomials.iter().zip(ordinates) {
        for (sum, ordinate) in out.iter_mut().zip(row) {
            *sum += polynomial * ordinate;
        }
    }
    out
}

/// The functions of the twelve control vertices at `(v, w)`, `v, w ≥ 0`, `v + w ≤ 1`.
pub(super) fn basis([v, w]: [f64; 2]) -> [Orders; REGULAR] {
    let x = [1.0 - v - w, v, w];
    // In the order of the exponents of degree one: w, v, u.
    let linear = [x[2], x[1], x[0]];
    let quadratic: [f64; 6] = raised(&linear, 2, x);
    let cubic: [f64; 10] = raised(&quadratic, 3, x);
    let quartic: [f64; 15] = raised(&cubic, 4, x);
    let orders = [
        summed(&quartic, &VALUE),
        summed(&cubic, &BY_V),
        summed(&cubic, &BY_W),
        summed(&quadratic, &BY_VV),
        summed(&quadratic, &BY_VW),
        summed(&quadratic, &BY_WW),
    ];
    std::array::from_fn(|f| orders.map(|order| order[f]))
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
