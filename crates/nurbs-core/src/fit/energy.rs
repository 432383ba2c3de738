//! The bending energy of spline curves and surfaces, exactly.

use super::gauss::gauss_legendre;
use super::normal::Block;
use super::observations::Space;
use crate::{KnotVector, MAX_DEGREE, basis};

/// `∫ N_i^{(d)} N_j^{(d)}` over one span for `d = 0, 1, 2`, derivatives and integral with respect to the
/// parameter scaled to a domain of length 1.
struct SpanGrams {
    span: usize,
    order: [Vec<f64>; 3],
}

fn span_grams(knots: &KnotVector) -> Vec<SpanGrams> {
    let p = knots.degree();
    let length = knots.domain().length();
    let nodes = gauss_legendre(p + 1);
    let grams = |span: usize| {
        let interval = knots.span_interval(span);
        let mut order = [(); 3].map(|()| vec![0.0; (p + 1) * (p + 1)]);
        let mut rows = [[0.0; MAX_DEGREE + 1]; 3];
        for &(s, weight) in &nodes {
            basis::jet(knots, span, interval.lerp(s), &mut rows);
            let mut factor = weight * interval.length() / length;
            for (gram, row) in order.iter_mut().zip(&rows) {
                for (i, line) in gram.chunks_exact_mut(p + 1).enumerate() {
                    for (slot, value) in line.iter_mut().zip(row) {
                        *slot += factor * row[i] * value;
                    }
                }
                factor *= length * length;
            }
        }
        SpanGrams { span, order }
    };
    knots.spans().map(grams).collect()
}

/// `factor · ∫ |c''|²` for a curve, `factor · ∫∫ |s_uu|² + 2 |s_uv|² + |s_vv|²` for a surface (the thin
/// plate energy), with the domain scaled to the unit interval or square.
pub(crate) fn bending(space: &Space, factor: f64) -> Vec<Block> {
    if factor == 0.0 {
        return Vec::new();
    }
    let in_u = span_grams(&space.u);
    let Some(v) = &space.v else {
        let block = |grams: &SpanGrams| Block {
            columns: space.columns(grams.span, 0),
            gram: grams.order[2].iter().map(|g| g * factor).collect(),
        };
        return in_u.iter().map(block).collect();
    };
    let in_v = span_grams(v);
    let (p, q) = (space.u.degree() + 1, v.degree() + 1);
    let mut blocks = Vec::with_capacity(in_u.len() * in_v.len());
    for a in &in_u {
        for b in &in_v {
            let mut gram = Vec::with_capacity(p * q * p * q);
            for (i, j) in (0..p * q).map(|row| (row / q, row % q)) {
                for (k, l) in (0..p * q).map(|column| (column / q, column % q)) {
                    let term = |d: usize| a.order[d][i * p + k] * b.order[2 - d][j * q + l];
                    gram.push(factor * (term(2) + 2.0 * term(1) + term(0)));
                }
            }
            blocks.push(Block { columns: space.columns(a.span, b.span), gram });
        }
    }
    blocks
}
