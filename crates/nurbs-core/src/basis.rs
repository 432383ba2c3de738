//! B-spline basis functions and their derivatives at one parameter, without allocation.

use crate::basis_fixed;
use crate::knots::{KnotVector, MAX_DEGREE};
use crate::simd::One;

/// Array for the values of the `p + 1` basis functions that do not vanish on a span.
pub type BasisRow = [f64; MAX_DEGREE + 1];

/// Values `N_{i−p}(t) … N_i(t)` of the basis functions of span `i`, in `row[..=p]` ([PT97, A2.2]).
pub fn values(knots: &KnotVector, span: usize, t: f64, row: &mut BasisRow) {
    fn fixed<const N: usize>(knots: &KnotVector, span: usize, t: f64, row: &mut BasisRow) {
        row[..N].copy_from_slice(&basis_fixed::values::<One, N>(One, knots, span, t));
    }
    match knots.degree() {
        1 => fixed::<2>(knots, span, t, row),
        2 => fixed::<3>(knots, span, t, row),
        3 => fixed::<4>(knots, span, t, row),
        4 => fixed::<5>(knots, span, t, row),
        5 => fixed::<6>(knots, span, t, row),
        p => {
            row[0] = 1.0;
            for j in 1..=p {
                raise(knots.as_slice(), span, t, j, row);
            }
        }
    }
}

/// Values and derivatives up to `order` of the `p + 1` functions of a span.
///
/// Row `k` of `out` receives the `k`-th derivatives in `out[k][..=p]`; rows above the degree are zero.
/// `out` must have at least `order + 1` rows ([PT97, A2.3], rearranged: a derivative is a difference
/// of the functions of one degree less, so that only the triangle of lower degrees is kept).
pub fn derivatives(knots: &KnotVector, span: usize, t: f64, order: usize, out: &mut [BasisRow]) {
    let p = knots.degree();
    let k = knots.as_slice();
    for (d, row) in out.iter_mut().enumerate().take(order + 1) {
        row[..=p].fill(0.0);
        if d > p {
            continue;
        }
        // The functions of degree p − d …
        let q = p - d;
        row[0] = 1.0;
        for j in 1..=q {
            raise(k, span, t, j, row);
        }
        // … and d differences, each of which raises the degree by one.
        for j in q + 1..=p {
            difference(k, span, j, row);
        }
    }
}

/// One step of the recurrence from degree `j − 1` to `j` on `row[..j]`.
fn raise(k: &[f64], span: usize, t: f64, j: usize, row: &mut BasisRow) {
    let mut saved = 0.0;
    for r in 0..j {
        let right = k[span + r + 1];
        let left = k[span + r + 1 - j];
        let value = row[r] / (right - left);
        row[r] = saved + (right - t) * value;
        saved = (t - left) * value;
    }
    row[j] = saved;
}

/// Values, first and second derivatives in one pass through the recurrence, in `out[0..3][..=p]`; the
/// second derivatives of degree 1 are zero.
///
/// Degrees up to 5 have loops of constant length and no divisions, with reciprocals of the knot
/// differences that the knot vector keeps; the others run the general recurrence.
#[inline]
pub fn jet(knots: &KnotVector, span: usize, t: f64, out: &mut [BasisRow; 3]) {
    fn fixed<const N: usize>(knots: &KnotVector, span: usize, t: f64, out: &mut [BasisRow; 3]) {
        let rows = basis_fixed::jet::<One, N>(One, knots, span, t);
        for (to, from) in out.iter_mut().zip(&rows) {
            to[..N].copy_from_slice(from);
        }
    }
    match knots.degree() {
        1 => fixed::<2>(knots, span, t, out),
        2 => fixed::<3>(knots, span, t, out),
        3 => fixed::<4>(knots, span, t, out),
        4 => fixed::<5>(knots, span, t, out),
        5 => fixed::<6>(knots, span, t, out),
        _ => jet_general(knots, span, t, out),
    }
}

/// [`jet`] for any degree from 2: the functions of degree `p − 2` and `p − 1`, which the derivatives are
/// differences of, come up on the way to degree `p` and are tapped there.
fn jet_general(knots: &KnotVector, span: usize, t: f64, out: &mut [BasisRow; 3]) {
    let p = knots.degree();
    let k = knots.as_slice();
    let [n0, n1, n2] = out;
    n0[0] = 1.0;
    for j in 1..=p {
        if j + 1 == p {
            // n0 holds degree p − 2: start of the second derivative, one difference taken here.
            n2[..j].copy_from_slice(&n0[..j]);
            difference(k, span, j, n2);
        }
        if j == p {
            n1[..j].copy_from_slice(&n0[..j]);
            difference(k, span, j, n1);
            difference(k, span, j, n2);
        }
        raise(k, span, t, j, n0);
    }
}

/// The derivatives of the functions of degree `j` from those (in `row[..j]`) of degree `j − 1`.
#[inline]
fn difference(k: &[f64], span: usize, j: usize, row: &mut BasisRow) {
    let mut saved = 0.0;
    for r in 0..j {
        let value = row[r] * j as f64 / (k[span + r + 1] - k[span + r + 1 - j]);
        row[r] = saved - value;
        saved = value;
    }
    row[j] = saved;
}

/// The weights with which the `p + 1` control points of a span enter the polar form (blossom) with
/// the given `p` arguments.
///
/// The polar form of a span at `(a, …, a, b, …, b)` is a Bézier point of that span: this is how exact
/// Bézier extraction, knot insertion and degree elevation are done here ([PT97, sec. 5.3], by blossoming).
pub fn polar_weights(knots: &KnotVector, span: usize, arguments: &[f64], row: &mut BasisRow) {
    let p = knots.degree();
    debug_assert_eq!(arguments.len(), p);
    let k = knots.as_slice();
    // Transposed de Boor algorithm: start from the one result and distribute it to its ancestors.
    row[..=p].fill(0.0);
    row[p] = 1.0;
    for r in (1..=p).rev() {
        for j in r..=p {
            // At level r point j was made of points j − 1 and j.
            let i = span + j - p;
            let (left, right) = (k[i], k[i + p + 1 - r]);
            let alpha = (arguments[r - 1] - left) / (right - left);
            let value = row[j];
            row[j - 1] += (1.0 - alpha) * value;
            row[j] = alpha * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knots() -> KnotVector {
        KnotVector::new(3, vec![0., 0., 0., 0., 0.3, 0.3, 0.7, 1., 1., 1., 1.]).unwrap()
    }

    #[test]
    fn jet_agrees_with_general_derivatives() {
        for p in 1..=7 {
            // Uneven spans and a double knot.
            let inner = [0.3, 0.3, 0.31, 0.9];
            let inner = if p == 1 { &inner[1..] } else { &inner };
            let mut t = vec![0.0; p + 1];
            t.extend(inner);
            t.extend(vec![1.0; p + 1]);
            let k = KnotVector::new(p, t).unwrap();
            for i in 0..=20 {
                let t = i as f64 / 20.0;
                let span = k.span(t);
                let mut general = [[f64::NAN; MAX_DEGREE + 1]; 3];
                let (mut fast, mut value) = (general, general[0]);
                derivatives(&k, span, t, 2, &mut general);
                jet(&k, span, t, &mut fast);
                values(&k, span, t, &mut value);
                assert_eq!(value[..=p], fast[0][..=p]);
                for d in 0..3 {
                    let scale = general[d][..=p].iter().fold(1.0, |m: f64, x| m.max(x.abs()));
                    for j in 0..=p {
                        let (a, b) = (general[d][j], fast[d][j]);
                        assert!((a - b).abs() <= 4e-15 * scale, "p {p} t {t} d {d}: {a} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn polar_form_on_the_diagonal_is_the_value() {
        let k = knots();
        for t in [0.0, 0.1, 0.3, 0.55, 0.99] {
            let span = k.span(t);
            let (mut a, mut b) = ([0.0; MAX_DEGREE + 1], [0.0; MAX_DEGREE + 1]);
            values(&k, span, t, &mut a);
            polar_weights(&k, span, &[t; 3], &mut b);
            for j in 0..4 {
                assert!((a[j] - b[j]).abs() < 1e-15, "{t}: {a:?} {b:?}");
            }
        }
    }
}
