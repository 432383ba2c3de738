//! The yardstick: a bicubic jet written by hand, without any abstraction.

/// Values, first and second derivatives of the four cubic functions of a span.
#[inline]
pub(crate) fn cubic(k: &[f64], s: usize, t: f64) -> [[f64; 4]; 3] {
    let (l1, l2, l3) = (t - k[s], t - k[s - 1], t - k[s - 2]);
    let (r1, r2, r3) = (k[s + 1] - t, k[s + 2] - t, k[s + 3] - t);
    let a = 1.0 / (k[s + 1] - k[s]);
    let (b0, b1) = (r1 * a / (k[s + 1] - k[s - 1]), l1 * a / (k[s + 2] - k[s]));
    let (n0, n1, n2) = (r1 * b0, l2 * b0 + r2 * b1, l1 * b1);
    let (h0, h1, h2) = (1.0 / (k[s + 1] - k[s - 2]), 1.0 / (k[s + 2] - k[s - 1]), 1.0 / (k[s + 3] - k[s]));
    let (c0, c1, c2) = (n0 * h0, n1 * h1, n2 * h2);
    let (q0, q1) = (a / (k[s + 1] - k[s - 1]), a / (k[s + 2] - k[s]));
    let (e0, e1, e2) = (6.0 * q0 * h0, -6.0 * (q0 + q1) * h1, 6.0 * q1 * h2);
    [
        [r1 * c0, l3 * c0 + r2 * c1, l2 * c1 + r3 * c2, l1 * c2],
        [-3.0 * c0, 3.0 * (c0 - c1), 3.0 * (c1 - c2), 3.0 * c2],
        [e0, e1 - e0, e2 - e1, -e2].map(|x| x),
    ]
}

/// Point, u, v, uu, uv, vv of a bicubic surface whose net has `n_v` columns.
#[inline]
pub(crate) fn bicubic_jet(
    knots: [&[f64]; 2],
    net: &[[f64; 3]],
    n_v: usize,
    spans: [usize; 2],
    u: f64,
    v: f64,
) -> [[f64; 3]; 6] {
    let bu = cubic(knots[0], spans[0], u);
    let bv = cubic(knots[1], spans[1], v);
    let mut out = [[0.0; 3]; 6];
    for i in 0..4 {
        let mut row = [[0.0; 3]; 3];
        for j in 0..4 {
            let p = &net[(spans[0] - 3 + i) * n_v + spans[1] - 3 + j];
            for c in 0..3 {
                row[0][c] += bv[0][j] * p[c];
                row[1][c] += bv[1][j] * p[c];
                row[2][c] += bv[2][j] * p[c];
            }
        }
        for c in 0..3 {
            out[0][c] += bu[0][i] * row[0][c];
            out[1][c] += bu[1][i] * row[0][c];
            out[2][c] += bu[0][i] * row[1][c];
            out[3][c] += bu[2][i] * row[0][c];
            out[4][c] += bu[1][i] * row[1][c];
            out[5][c] += bu[0][i] * row[2][c];
        }
    }
    out
}

/// Point and two derivatives of a cubic curve in the plane.
#[inline]
pub(crate) fn cubic_jet(knots: &[f64], points: &[[f64; 2]], span: usize, t: f64) -> [[f64; 2]; 3] {
    let b = cubic(knots, span, t);
    let mut out = [[0.0; 2]; 3];
    for j in 0..4 {
        for d in 0..3 {
            for c in 0..2 {
                out[d][c] += b[d][j] * points[span - 3 + j][c];
            }
        }
    }
    out
}

/// The span of `t` by bisection.
#[inline]
pub(crate) fn span(knots: &[f64], degree: usize, t: f64) -> usize {
    let n = knots.len() - degree - 1;
    (degree + knots[degree..n].partition_point(|&k| k <= t)).saturating_sub(1).max(degree)
}
