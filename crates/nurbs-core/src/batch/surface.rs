//! Points and jets of a surface at many parameters.

use super::groups::Groups;
use super::surface_lanes::Evaluation;
use super::{SMALLEST, check_lengths, chunk_length};
use crate::simd::{Kernel, Lanes, dispatch};
use crate::span_table::MAX_FIXED_DEGREE;
use crate::{BsplineSurface, Error, ParametricSurface, SurfaceJet};
use nalgebra::Vector3;
use std::cell::RefCell;

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
        if params.len() < SMALLEST || !self.fits_in_lanes() {
            for (&[u, v], jet) in params.iter().zip(out) {
                *jet = self.jet(u, v);
            }
            return Ok(());
        }
        self.in_chunks(params, out, |groups, out| {
            if out.len() < params.len() {
                bring_near(out);
            }
            dispatch(Chunk { surface: self, groups, out });
        });
        Ok(())
    }

    /// The points at many parameters `(u, v)`, in their order: as [`jets`](Self::jets), without derivatives.
    ///
    /// # Errors
    /// When `out` has another length than `params`.
    pub fn points(&self, params: &[[f64; 2]], out: &mut [Vector3<f64>]) -> Result<(), Error> {
        check_lengths(params.len(), out.len())?;
        if params.len() < SMALLEST || !self.fits_in_lanes() {
            for (&[u, v], point) in params.iter().zip(out) {
                *point = self.point(u, v);
            }
            return Ok(());
        }
        self.in_chunks(params, out, |groups, out| dispatch(Chunk { surface: self, groups, out }));
        Ok(())
    }

    fn fits_in_lanes(&self) -> bool {
        self.degree_u().max(self.degree_v()) <= MAX_FIXED_DEGREE
            && self.n_u() * self.n_v() < u32::MAX as usize
    }

    fn in_chunks<T>(&self, params: &[[f64; 2]], out: &mut [T], mut run: impl FnMut(&Groups<2>, &mut [T])) {
        let length = chunk_length(self.n_u() * self.n_v());
        let knots = [self.knots_u(), self.knots_v()];
        let periodic = knots.iter().any(|k| k.is_periodic());
        let mut groups = GROUPS.take();
        let mut wrapped = Vec::new();
        for (mut params, out) in params.chunks(length).zip(out.chunks_mut(length)) {
            if periodic {
                wrapped.clear();
                wrapped.extend(params.iter().map(|&[u, v]| <[f64; 2]>::from(self.wrap(u, v))));
                params = &wrapped;
            }
            groups.fill(knots, params);
            run(&groups, out);
        }
        GROUPS.set(groups);
    }
}

/// Reads a number of every line of memory that results will be written to, in order. The processor fetches
/// them ahead, which it cannot where they are written in the order of the groups: with 100,000 results,
/// twice as fast.
fn bring_near(results: &[SurfaceJet]) {
    let read = |sum, jet: &SurfaceJet| sum ^ jet.point.x.to_bits() ^ jet.dv.z.to_bits() ^ jet.dvv.y.to_bits();
    std::hint::black_box(results.iter().fold(0, read));
}

/// A chunk of parameters.
struct Chunk<'a, T> {
    surface: &'a BsplineSurface,
    groups: &'a Groups<2>,
    out: &'a mut [T],
}

impl<T: Evaluation> Kernel for Chunk<'_, T> {
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

impl<T: Evaluation> Chunk<'_, T> {
    #[inline(always)]
    fn all<L: Lanes, const M: usize, const RATIONAL: bool>(&mut self, l: L) {
        for group in self.groups.iter() {
            let [us, vs] = group.parameters;
            for (block, order) in group.order.chunks(L::COUNT).enumerate() {
                let (us, vs) = (&us[block * L::COUNT..], &vs[block * L::COUNT..]);
                if order.len() > L::Half::COUNT {
                    self.block::<L, M, RATIONAL>(l, group.key, us, vs, order);
                } else {
                    self.block::<L::Half, M, RATIONAL>(l.half(), group.key, us, vs, order);
                }
            }
        }
    }

    #[inline(always)]
    fn block<L: Lanes, const M: usize, const RATIONAL: bool>(
        &mut self,
        l: L,
        key: usize,
        us: &[f64],
        vs: &[f64],
        order: &[u32],
    ) {
        let spans = (key / self.surface.n_v(), key % self.surface.n_v());
        T::in_lanes::<L, M, RATIONAL>(l, self.surface, spans, [l.load(us), l.load(vs)], order, self.out);
    }
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
                            width.run(Chunk { surface: &s, groups, out: &mut *out });
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

    #[test]
    fn periodic_surfaces_and_many_chunks_give_the_bits_of_the_single_evaluation() {
        let knots = [KnotVector::uniform_periodic(3, 9).unwrap(), KnotVector::uniform_clamped(2, 7).unwrap()];
        let [n_u, n_v] = [knots[0].basis_count(), knots[1].basis_count()];
        let noise = |i: usize| (i as f64 * 0.754_877_666).fract();
        let point = |i: usize| Vector3::new(noise(i), noise(3 * i + 1), noise(7 * i + 2));
        let net = (0..n_u * n_v).map(|i| point(i % (9 * n_v))).collect();
        let [u, v] = knots;
        let s = BsplineSurface::new(u, v, net, None).unwrap();
        let params: Vec<[f64; 2]> = (0..10_000)
            .map(|i| [(f64::from(i) * 0.618_034).fract() * 30.0 - 10.0, (f64::from(i) * 0.7549).fract()])
            .collect();
        let mut jets = vec![s.jet(0.0, 0.0); params.len()];
        s.jets(&params, &mut jets).unwrap();
        for (&[u, v], jet) in params.iter().zip(&jets) {
            assert_eq!(bits(jet), bits(&s.jet(u, v)), "{u} {v}");
        }
    }
}
