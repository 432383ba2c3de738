//! Points and jets of a curve at many parameters.

use super::groups::Groups;
use super::{SMALLEST, check_lengths, chunk_length};
use crate::simd::{Kernel, Lanes, MAX_LANES, dispatch};
use crate::span_table::MAX_FIXED_DEGREE;
use crate::{BsplineCurve, CurveJet, Error, ParametricCurve, basis_fixed, rational};
use nalgebra::SVector;
use std::cell::RefCell;

thread_local! {
    // Fresh memory for every call would cost as much as the evaluation.
    static GROUPS: RefCell<Groups<1>> = RefCell::default();
}

impl<const D: usize> BsplineCurve<D> {
    /// The jets at many parameters, in their order.
    ///
    /// The same bits as [`jet`](ParametricCurve::jet) one by one, faster: parameters of one span are
    /// evaluated together in vectors. Parameters outside the domain are wrapped or continued in the
    /// same way.
    ///
    /// # Errors
    /// When `out` has another length than `params`.
    pub fn jets(&self, params: &[f64], out: &mut [CurveJet<D>]) -> Result<(), Error> {
        check_lengths(params.len(), out.len())?;
        if params.len() < SMALLEST || self.degree() > MAX_FIXED_DEGREE {
            for (&t, jet) in params.iter().zip(out) {
                *jet = self.jet(t);
            }
            return Ok(());
        }
        let length = chunk_length(self.knots().basis_count());
        let mut groups = GROUPS.take();
        let mut wrapped = Vec::new();
        for (params, out) in params.chunks(length).zip(out.chunks_mut(length)) {
            wrapped.clear();
            wrapped.extend(params.iter().map(|&t| [self.wrap(t)]));
            groups.fill([self.knots()], &wrapped);
            dispatch(Jets { curve: self, groups: &groups, out });
        }
        GROUPS.set(groups);
        Ok(())
    }

    /// The points at many parameters, in their order, with the same bits as [`point`](ParametricCurve::point).
    ///
    /// # Errors
    /// When `out` has another length than `params`.
    pub fn points(&self, params: &[f64], out: &mut [SVector<f64, D>]) -> Result<(), Error> {
        check_lengths(params.len(), out.len())?;
        // A point costs less than the sorting that vectors need.
        for (&t, point) in params.iter().zip(out) {
            *point = self.point(t);
        }
        Ok(())
    }
}

struct Jets<'a, const D: usize> {
    curve: &'a BsplineCurve<D>,
    groups: &'a Groups<1>,
    out: &'a mut [CurveJet<D>],
}

impl<const D: usize> Kernel for Jets<'_, D> {
    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        match self.curve.degree() {
            1 => self.all::<L, 2>(l),
            2 => self.all::<L, 3>(l),
            3 => self.all::<L, 4>(l),
            4 => self.all::<L, 5>(l),
            _ => self.all::<L, 6>(l),
        }
    }
}

impl<const D: usize> Jets<'_, D> {
    #[inline(always)]
    fn all<L: Lanes, const N: usize>(&mut self, l: L) {
        for group in self.groups.iter() {
            let (span, [ts]) = (group.key, group.parameters);
            for (block, order) in group.order.chunks(L::COUNT).enumerate() {
                let rows =
                    basis_fixed::jet::<L, N>(l, self.curve.knots(), span, l.load(&ts[block * L::COUNT..]));
                let start = span + 1 - N;
                let points = &self.curve.control_points()[start..][..N];
                let weights = self.curve.factors().map(|w| &w[start..][..N]);
                let mut divisor = None;
                if let Some(weights) = weights {
                    let w = combine(l, &rows, |j| weights[j]);
                    divisor = Some((w, l.div(l.splat(1.0), w[0])));
                }
                for c in 0..D {
                    let mut a = combine(l, &rows, |j| weights.map_or(points[j][c], |w| points[j][c] * w[j]));
                    if let Some((w, inverse)) = divisor {
                        a = rational::curve_quotient(l, &a, &w, inverse);
                    }
                    let mut lanes = [[0.0; MAX_LANES]; 3];
                    for k in 0..3 {
                        l.store(a[k], &mut lanes[k]);
                    }
                    for (lane, &index) in order.iter().enumerate() {
                        let jet = &mut self.out[index as usize];
                        (jet.point[c], jet.d1[c], jet.d2[c]) =
                            (lanes[0][lane], lanes[1][lane], lanes[2][lane]);
                    }
                }
            }
        }
    }
}

/// `Σ_j rows[k][j] · x(j)` for value, first and second derivative.
#[inline(always)]
fn combine<L: Lanes, const N: usize>(l: L, rows: &[[L::V; N]; 3], x: impl Fn(usize) -> f64) -> [L::V; 3] {
    let mut a = [l.splat(0.0); 3];
    for j in 0..N {
        let x = l.splat(x(j));
        for k in 0..3 {
            let term = l.mul(x, rows[k][j]);
            a[k] = if j == 0 { term } else { l.add(a[k], term) };
        }
    }
    a
}
