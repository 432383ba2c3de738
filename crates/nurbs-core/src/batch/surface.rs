//! Points and jets of a surface at many parameters.

use super::groups::{Group, Groups};
use super::{SMALLEST, check_lengths, chunk_length};
use crate::simd::{Kernel, Lanes, MAX_LANES, dispatch};
use crate::span_table::MAX_FIXED_DEGREE;
use crate::surface_eval::add_orders;
use crate::{BsplineSurface, Error, ParametricSurface, SurfaceJet, basis_fixed, rational};
use nalgebra::Vector3;
use std::cell::RefCell;

/// Basis rows of one direction, function by function: value, first, second derivative.
type Columns<V> = [[V; 3]; MAX_FIXED_DEGREE + 1];

thread_local! {
    // Fresh memory for every call would cost as much as the evaluation.
    static GROUPS: RefCell<Groups<2>> = RefCell::default();
}

impl BsplineSurface {
    /// The jets at many parameters `(u, v)`, in their order.
    ///
    /// The same bits as [`jet`](ParametricSurface::jet) one by one, several times faster: parameters of one
    /// patch are evaluated together in vectors. Parameters outside the domain are wrapped or continued
    /// in the same way. Best for hundreds of parameters or more in one call, and for several on each patch.
    ///
    /// # Errors
    /// When `out` has another length than `params`.
    pub fn jets(&self, params: &[[f64; 2]], out: &mut [SurfaceJet]) -> Result<(), Error> {
        check_lengths(params.len(), out.len())?;
        if params.len() < SMALLEST || !self.has_fixed_degrees() {
            for (&[u, v], jet) in params.iter().zip(out) {
                *jet = self.jet(u, v);
            }
            return Ok(());
        }
        self.in_chunks(params, out, |groups, out| dispatch(Jets { surface: self, groups, out }));
        Ok(())
    }

    /// The points at many parameters `(u, v)`, in their order: as [`jets`](Self::jets), without derivatives.
    ///
    /// # Errors
    /// When `out` has another length than `params`.
    pub fn points(&self, params: &[[f64; 2]], out: &mut [Vector3<f64>]) -> Result<(), Error> {
        check_lengths(params.len(), out.len())?;
        if params.len() < SMALLEST || !self.has_fixed_degrees() {
            for (&[u, v], point) in params.iter().zip(out) {
                *point = self.point(u, v);
            }
            return Ok(());
        }
        self.in_chunks(params, out, |groups, out| dispatch(Points { surface: self, groups, out }));
        Ok(())
    }

    fn has_fixed_degrees(&self) -> bool {
        self.degree_u().max(self.degree_v()) <= MAX_FIXED_DEGREE
    }

    fn in_chunks<T>(&self, params: &[[f64; 2]], out: &mut [T], mut run: impl FnMut(&Groups<2>, &mut [T])) {
        let (n_u, n_v) = (self.n_u(), self.n_v());
        let length = chunk_length(n_u * n_v);
        let mut groups = GROUPS.take();
        for (params, out) in params.chunks(length).zip(out.chunks_mut(length)) {
            groups.fill(
                n_u * n_v,
                params,
                |[u, v]| self.wrap(u, v).into(),
                |[u, v]| self.knots_u().span(u) * n_v + self.knots_v().span(v),
            );
            run(&groups, out);
        }
        GROUPS.set(groups);
    }

    /// The spans that make up the key of a group.
    fn spans_of<const D: usize>(&self, group: &Group<'_, D>) -> (usize, usize) {
        (group.key / self.n_v(), group.key % self.n_v())
    }

    #[inline(always)]
    fn columns<L: Lanes, const N: usize>(&self, l: L, span: usize, u: L::V) -> Columns<L::V> {
        let rows = basis_fixed::jet::<L, N>(l, self.knots_u(), span, u);
        let mut columns = [[u; 3]; MAX_FIXED_DEGREE + 1];
        for i in 0..N {
            columns[i] = [rows[0][i], rows[1][i], rows[2][i]];
        }
        columns
    }

    #[inline(always)]
    fn columns_of_degree<L: Lanes>(&self, l: L, span: usize, u: L::V) -> Columns<L::V> {
        match self.degree_u() {
            1 => self.columns::<L, 2>(l, span, u),
            2 => self.columns::<L, 3>(l, span, u),
            3 => self.columns::<L, 4>(l, span, u),
            4 => self.columns::<L, 5>(l, span, u),
            _ => self.columns::<L, 6>(l, span, u),
        }
    }

    #[inline(always)]
    fn values_of_degree<L: Lanes>(&self, l: L, span: usize, u: L::V) -> [L::V; MAX_FIXED_DEGREE + 1] {
        #[inline(always)]
        fn padded<L: Lanes, const N: usize>(s: &BsplineSurface, l: L, span: usize, u: L::V) -> [L::V; 6] {
            let mut out = [u; MAX_FIXED_DEGREE + 1];
            out[..N].copy_from_slice(&basis_fixed::values::<L, N>(l, s.knots_u(), span, u));
            out
        }
        match self.degree_u() {
            1 => padded::<L, 2>(self, l, span, u),
            2 => padded::<L, 3>(self, l, span, u),
            3 => padded::<L, 4>(self, l, span, u),
            4 => padded::<L, 5>(self, l, span, u),
            _ => padded::<L, 6>(self, l, span, u),
        }
    }

    /// Coordinate `C` of control point `index`, times its weight; the weight itself for `C = 3`.
    #[inline(always)]
    fn homogeneous<const RATIONAL: bool, const C: usize>(&self, index: usize) -> f64 {
        let weight = if RATIONAL { self.weights().map_or(1.0, |w| w[index]) } else { 1.0 };
        match (RATIONAL, C) {
            (false, _) => self.control_points()[index][C],
            (true, 3) => weight,
            (true, _) => self.control_points()[index][C] * weight,
        }
    }
}

struct Jets<'a> {
    surface: &'a BsplineSurface,
    groups: &'a Groups<2>,
    out: &'a mut [SurfaceJet],
}

impl Kernel for Jets<'_> {
    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        match (self.surface.degree_v(), self.surface.weights().is_some()) {
            (1, false) => self.all::<L, 2, false>(l),
            (2, false) => self.all::<L, 3, false>(l),
            (3, false) => self.all::<L, 4, false>(l),
            (4, false) => self.all::<L, 5, false>(l),
            (_, false) => self.all::<L, 6, false>(l),
            (1, true) => self.all::<L, 2, true>(l),
            (2, true) => self.all::<L, 3, true>(l),
            (3, true) => self.all::<L, 4, true>(l),
            (4, true) => self.all::<L, 5, true>(l),
            (_, true) => self.all::<L, 6, true>(l),
        }
    }
}

impl Jets<'_> {
    #[inline(always)]
    fn all<L: Lanes, const M: usize, const RATIONAL: bool>(&mut self, l: L) {
        let mut lanes = [0.0; 18 * MAX_LANES];
        for group in self.groups.iter() {
            let (span_u, span_v) = self.surface.spans_of(&group);
            let [us, vs] = group.parameters;
            for (block, order) in group.order.chunks(L::COUNT).enumerate() {
                let at = block * L::COUNT;
                if let &[index] = order {
                    // One left over: vectors are not worth it.
                    self.out[index as usize] = self.surface.jet_in_span(span_u, span_v, us[at], vs[at]);
                    continue;
                }
                let (u, v) = (l.load(&us[at..]), l.load(&vs[at..]));
                let [x, y, z] = jet_lanes::<L, M, RATIONAL>(l, self.surface, span_u, span_v, u, v);
                for slot in 0..6 {
                    for (c, coordinate) in [x, y, z].iter().enumerate() {
                        l.store(coordinate[slot], &mut lanes[(3 * slot + c) * L::COUNT..]);
                    }
                }
                for (lane, &index) in order.iter().enumerate() {
                    let vector = |slot: usize| {
                        let at = |c: usize| lanes[(3 * slot + c) * L::COUNT + lane];
                        Vector3::new(at(0), at(1), at(2))
                    };
                    self.out[index as usize] = SurfaceJet {
                        point: vector(0),
                        du: vector(1),
                        dv: vector(2),
                        duu: vector(3),
                        duv: vector(4),
                        dvv: vector(5),
                    };
                }
            }
        }
    }
}

/// x, y and z of value, u, v, uu, uv, vv: the sums of the single jet, in the same order.
#[inline(always)]
fn jet_lanes<L: Lanes, const M: usize, const RATIONAL: bool>(
    l: L,
    surface: &BsplineSurface,
    span_u: usize,
    span_v: usize,
    u: L::V,
    v: L::V,
) -> [[L::V; 6]; 3] {
    let bu = surface.columns_of_degree(l, span_u, u);
    let bv = basis_fixed::jet::<L, M>(l, surface.knots_v(), span_v, v);
    let x = sums::<L, M, RATIONAL, 0>(l, surface, span_u, span_v, &bu, &bv);
    let y = sums::<L, M, RATIONAL, 1>(l, surface, span_u, span_v, &bu, &bv);
    let z = sums::<L, M, RATIONAL, 2>(l, surface, span_u, span_v, &bu, &bv);
    if !RATIONAL {
        return [x, y, z];
    }
    let w = sums::<L, M, RATIONAL, 3>(l, surface, span_u, span_v, &bu, &bv);
    let inverse = l.div(l.splat(1.0), w[0]);
    [
        rational::surface_quotient(l, &x, &w, inverse),
        rational::surface_quotient(l, &y, &w, inverse),
        rational::surface_quotient(l, &z, &w, inverse),
    ]
}

/// Value, u, v, uu, uv, vv of homogeneous coordinate `C`. One coordinate after the other: its sums stay in
/// registers.
#[inline(always)]
fn sums<L: Lanes, const M: usize, const RATIONAL: bool, const C: usize>(
    l: L,
    surface: &BsplineSurface,
    span_u: usize,
    span_v: usize,
    bu: &Columns<L::V>,
    bv: &[[L::V; M]; 3],
) -> [L::V; 6] {
    let zero = l.splat(0.0);
    let mut sum = [zero; 6];
    for (i, b) in bu.iter().take(surface.degree_u() + 1).enumerate() {
        let start = surface.row_start(span_u, span_v, i);
        let x = l.splat(surface.homogeneous::<RATIONAL, C>(start));
        let mut r = [l.mul(x, bv[0][0]), l.mul(x, bv[1][0]), l.mul(x, bv[2][0])];
        for j in 1..M {
            let x = l.splat(surface.homogeneous::<RATIONAL, C>(start + j));
            r[0] = l.add(r[0], l.mul(x, bv[0][j]));
            r[1] = l.add(r[1], l.mul(x, bv[1][j]));
            r[2] = l.add(r[2], l.mul(x, bv[2][j]));
        }
        add_orders(l, &mut sum, &r, b);
    }
    sum
}

struct Points<'a> {
    surface: &'a BsplineSurface,
    groups: &'a Groups<2>,
    out: &'a mut [Vector3<f64>],
}

impl Kernel for Points<'_> {
    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        match (self.surface.degree_v(), self.surface.weights().is_some()) {
            (1, false) => self.all::<L, 2, false>(l),
            (2, false) => self.all::<L, 3, false>(l),
            (3, false) => self.all::<L, 4, false>(l),
            (4, false) => self.all::<L, 5, false>(l),
            (_, false) => self.all::<L, 6, false>(l),
            (1, true) => self.all::<L, 2, true>(l),
            (2, true) => self.all::<L, 3, true>(l),
            (3, true) => self.all::<L, 4, true>(l),
            (4, true) => self.all::<L, 5, true>(l),
            (_, true) => self.all::<L, 6, true>(l),
        }
    }
}

impl Points<'_> {
    #[inline(always)]
    fn all<L: Lanes, const M: usize, const RATIONAL: bool>(&mut self, l: L) {
        let mut lanes = [[0.0; MAX_LANES]; 3];
        for group in self.groups.iter() {
            let (span_u, span_v) = self.surface.spans_of(&group);
            let [us, vs] = group.parameters;
            for (block, order) in group.order.chunks(L::COUNT).enumerate() {
                let at = block * L::COUNT;
                let (u, v) = (l.load(&us[at..]), l.load(&vs[at..]));
                let point = point_lanes::<L, M, RATIONAL>(l, self.surface, span_u, span_v, u, v);
                for c in 0..3 {
                    l.store(point[c], &mut lanes[c]);
                }
                for (lane, &index) in order.iter().enumerate() {
                    self.out[index as usize] = Vector3::new(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
                }
            }
        }
    }
}

#[inline(always)]
fn point_lanes<L: Lanes, const M: usize, const RATIONAL: bool>(
    l: L,
    surface: &BsplineSurface,
    span_u: usize,
    span_v: usize,
    u: L::V,
    v: L::V,
) -> [L::V; 3] {
    let bu = surface.values_of_degree(l, span_u, u);
    let bv = basis_fixed::values::<L, M>(l, surface.knots_v(), span_v, v);
    let x = sum::<L, M, RATIONAL, 0>(l, surface, span_u, span_v, &bu, &bv);
    let y = sum::<L, M, RATIONAL, 1>(l, surface, span_u, span_v, &bu, &bv);
    let z = sum::<L, M, RATIONAL, 2>(l, surface, span_u, span_v, &bu, &bv);
    if !RATIONAL {
        return [x, y, z];
    }
    let w = sum::<L, M, RATIONAL, 3>(l, surface, span_u, span_v, &bu, &bv);
    let inverse = l.div(l.splat(1.0), w);
    [l.mul(x, inverse), l.mul(y, inverse), l.mul(z, inverse)]
}

/// The value of homogeneous coordinate `C`.
#[inline(always)]
fn sum<L: Lanes, const M: usize, const RATIONAL: bool, const C: usize>(
    l: L,
    surface: &BsplineSurface,
    span_u: usize,
    span_v: usize,
    bu: &[L::V; MAX_FIXED_DEGREE + 1],
    bv: &[L::V; M],
) -> L::V {
    let mut sum = l.splat(0.0);
    for (i, b) in bu.iter().take(surface.degree_u() + 1).enumerate() {
        let start = surface.row_start(span_u, span_v, i);
        let mut r = l.mul(l.splat(surface.homogeneous::<RATIONAL, C>(start)), bv[0]);
        for j in 1..M {
            let x = l.splat(surface.homogeneous::<RATIONAL, C>(start + j));
            r = l.add(r, l.mul(x, bv[j]));
        }
        sum = l.add(sum, l.mul(r, *b));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::KnotVector;
    use crate::simd::Width;

    fn surface(p: usize, q: usize, rational: bool) -> BsplineSurface {
        let (n_u, n_v) = (p + 4, q + 3);
        let noise = |i: usize| (i as f64 * 0.754_877_666).fract();
        let points = (0..n_u * n_v).map(|i| Vector3::new(noise(i), noise(3 * i + 1), noise(7 * i + 2)));
        let weights = rational.then(|| (0..n_u * n_v).map(|i| 0.5 + noise(5 * i)).collect());
        let knots = |p, n| KnotVector::uniform_clamped(p, n).unwrap();
        BsplineSurface::new(knots(p, n_u), knots(q, n_v), points.collect(), weights).unwrap()
    }

    fn bits(jet: &SurfaceJet) -> Vec<u64> {
        [jet.point, jet.du, jet.dv, jet.duu, jet.duv, jet.dvv]
            .iter()
            .flat_map(|v| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>())
            .collect()
    }

    #[test]
    fn every_width_gives_the_bits_of_the_single_evaluation() {
        let params: Vec<[f64; 2]> = (0..200)
            .map(|i| [(f64::from(i) * 0.618_034).fract() * 1.2 - 0.1, (f64::from(i) * 0.7549).fract()])
            .collect();
        let nothing = surface(1, 1, false).jet(0.0, 0.0);
        for p in 1..=MAX_FIXED_DEGREE {
            for q in 1..=MAX_FIXED_DEGREE {
                for rational in [false, true] {
                    let s = surface(p, q, rational);
                    let mut jets = vec![nothing; params.len()];
                    let mut points = vec![Vector3::zeros(); params.len()];
                    s.in_chunks(&params, &mut jets, |groups, out| {
                        for width in Width::all() {
                            out.fill(nothing);
                            width.run(Jets { surface: &s, groups, out });
                            for (&[u, v], jet) in params.iter().zip(&*out) {
                                assert_eq!(bits(jet), bits(&s.jet(u, v)), "{p} {q} {rational} {width:?}");
                            }
                        }
                    });
                    s.points(&params, &mut points).unwrap();
                    for (&[u, v], point) in params.iter().zip(&points) {
                        assert_eq!(*point, s.point(u, v), "{p} {q} {rational}");
                    }
                }
            }
        }
    }
}
