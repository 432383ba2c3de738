//! Newton's method for eight queries side by side on one patch.

use super::descend::{
    DEFINITE, Foot, GROWTH, LAST_SHARE, LAST_STEP, Model, Move, SLOPE_NOISE_SQ, STANDSTILL,
};
use super::geometry::{Geometry, Patch};
use super::lanes::{Lanes, WIDTH};
use super::power::{self, Wide};
use nalgebra::Vector3;
use nurbs_core::SurfaceJet;

/// A point on its way downhill.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walker {
    pub(crate) x: Vector3<f64>,
    pub(crate) local: [f64; 2],
    /// Squared distance of the place before, which must not be exceeded.
    pub(crate) before_sq: f64,
    pub(crate) patch: u32,
    /// Whose point it is.
    pub(crate) index: u32,
    /// Jets evaluated so far.
    pub(crate) steps: u32,
}

/// How a walk on one patch ends.
pub(crate) enum Outcome {
    /// At a foot.
    Landed(Foot, SurfaceJet),
    /// On another patch.
    Crossed(Walker),
    /// Where the distance grows: to be walked again, with step control.
    Lost,
}

/// One evaluation of eight places: jets, model, and where Newton's step leads to.
struct Round {
    jets: [Wide<3>; 6],
    distance_sq: Lanes,
    gradient: [Lanes; 2],
    metric: [Lanes; 3],
    hessian: [Lanes; 3],
    step: [Lanes; 2],
    target: [Lanes; 2],
    /// Bit by bit: lanes that go to the target, inside the patch.
    plain: u32,
    /// Those for which the step is negligible.
    last: u32,
}

/// The places of eight walkers.
struct Places {
    y: [Lanes; 3],
    local: [Lanes; 2],
    before_sq: Lanes,
}

impl Geometry {
    /// Lets walkers on one patch go downhill until they land or leave; each does the same, bit for bit, as in
    /// [`descend`](Self::descend).
    #[inline(always)]
    pub(crate) fn newton_lanes(
        &self,
        group: &[Walker],
        max_steps: u32,
        mut report: impl FnMut(&Walker, Outcome),
    ) {
        let patch = &self.patches[group[0].patch as usize];
        match (patch.order, patch.rational) {
            (4, false) => self.iterate::<4, 3>(patch, group, max_steps, report),
            (4, true) => self.iterate::<4, 4>(patch, group, max_steps, report),
            (3, false) => self.iterate::<3, 3>(patch, group, max_steps, report),
            (3, true) => self.iterate::<3, 4>(patch, group, max_steps, report),
            _ => group.iter().for_each(|walker| report(walker, Outcome::Lost)),
        }
    }

    #[inline(always)]
    fn iterate<const N: usize, const C: usize>(
        &self,
        patch: &Patch,
        group: &[Walker],
        max_steps: u32,
        mut report: impl FnMut(&Walker, Outcome),
    ) {
        let net = self.powers::<N, C>(patch);
        let zero = Lanes::splat(0.0);
        let mut places = Places { y: [zero; 3], local: [Lanes::splat(0.5); 2], before_sq: zero };
        let mut steps = [0u32; WIDTH];
        let mut members = [0usize; WIDTH];
        let (mut occupied, mut waiting) = (0u32, 0usize);
        let mut free = (1u32 << WIDTH) - 1;
        loop {
            // A lane that has become free takes the next walker.
            while free != 0 && waiting < group.len() {
                let l = free.trailing_zeros() as usize;
                free &= free - 1;
                occupied |= 1 << l;
                let walker = &group[waiting];
                let y = walker.x - patch.centre;
                for c in 0..3 {
                    places.y[c].0[l] = y[c];
                }
                for d in 0..2 {
                    places.local[d].0[l] = walker.local[d];
                }
                places.before_sq.0[l] = walker.before_sq;
                (steps[l], members[l]) = (walker.steps, waiting);
                waiting += 1;
            }
            if occupied == 0 {
                return;
            }
            let round = round::<N, C>(net, patch.origin, &places, self.size);
            let mut limited = 0;
            for l in 0..WIDTH {
                steps[l] += 1;
                limited |= u32::from(steps[l] >= max_steps) << l;
            }
            let mut attention = occupied & (!round.plain | round.last | limited);
            while attention != 0 {
                let l = attention.trailing_zeros() as usize;
                attention &= attention - 1;
                let walker = &group[members[l]];
                let outcome = self.conclude_lane(&round, &places, l, walker, steps[l], max_steps);
                match outcome {
                    Ok(local) => {
                        for d in 0..2 {
                            places.local[d].0[l] = local[d];
                        }
                    }
                    Err(outcome) => {
                        report(walker, outcome);
                        occupied &= !(1 << l);
                        free |= 1 << l;
                    }
                }
            }
            for d in 0..2 {
                places.local[d] = places.local[d].replaced(round.plain, &round.target[d]);
            }
            places.before_sq = round.distance_sq;
        }
    }

    /// What becomes of a lane that does not simply go on: a place on the same patch, or the end of its walk.
    #[inline(always)]
    #[expect(clippy::result_large_err, reason = "used at once; a box would cost an allocation per point")]
    fn conclude_lane(
        &self,
        round: &Round,
        places: &Places,
        l: usize,
        walker: &Walker,
        steps: u32,
        max_steps: u32,
    ) -> Result<[f64; 2], Outcome> {
        let distance_sq = round.distance_sq.0[l];
        if distance_sq > places.before_sq.0[l] * GROWTH || !distance_sq.is_finite() {
            return Err(Outcome::Lost);
        }
        let vector = |k: usize| {
            let [x, y, z] = &round.jets[k];
            Vector3::new(x.0[l], y.0[l], z.0[l])
        };
        let jet = SurfaceJet {
            point: vector(0),
            du: vector(1),
            dv: vector(2),
            duu: vector(3),
            duv: vector(4),
            dvv: vector(5),
        };
        let index = walker.patch as usize;
        let at = [places.local[0].0[l], places.local[1].0[l]];
        let mut foot = Foot { patch: index, local: at, distance_sq, steps, settled: false };
        let going = if round.plain >> l & 1 != 0 {
            let local = [round.target[0].0[l], round.target[1].0[l]];
            let last = round.last >> l & 1 != 0;
            Move::To { patch: index, local, step: round.step.map(|s| s.0[l]), last }
        } else {
            let model = Model {
                gradient: round.gradient.map(|g| g.0[l]),
                hessian: round.hessian.map(|h| h.0[l]),
                metric: round.metric.map(|m| m.0[l]),
            };
            self.advance(index, at, &model, distance_sq)
        };
        match going {
            Move::Rest => {
                foot.settled = true;
                Err(Outcome::Landed(foot, jet))
            }
            Move::Stop => Err(Outcome::Landed(foot, jet)),
            Move::To { patch, local, step, last } => {
                if last || steps >= max_steps {
                    foot.settled = last;
                    let (foot, jet) = self.land(&walker.x, foot, &jet, (patch, local), step, last);
                    return Err(Outcome::Landed(foot, jet));
                }
                if patch == index {
                    return Ok(local);
                }
                let patch = u32::try_from(patch).unwrap_or(u32::MAX);
                Err(Outcome::Crossed(Walker { local, patch, before_sq: distance_sq, steps, ..*walker }))
            }
        }
    }
}

#[inline(always)]
fn dot(a: &Wide<3>, b: &Wide<3>) -> Lanes {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// Positive inside the unit interval.
#[inline(always)]
fn open(x: Lanes) -> Lanes {
    x.min(Lanes::splat(1.0) - x)
}

/// The operations of [`descend`](Geometry::descend), in the same order, for the usual case: the Hessian is positive
/// definite and its step stays inside the patch.
#[inline(always)]
fn round<const N: usize, const C: usize>(net: &[f64], origin: [f64; 2], places: &Places, size: f64) -> Round {
    let [s, t] = places.local;
    let [o, p] = origin.map(Lanes::splat);
    let jets = power::lane_jets(&power::jet::<N, Wide<C>>(net, s - o, t - p));
    let [point, du, dv, duu, duv, dvv] = &jets;
    let r = [point[0] - places.y[0], point[1] - places.y[1], point[2] - places.y[2]];
    let distance_sq = dot(&r, &r);
    let gradient @ [gs, gt] = [dot(du, &r), dot(dv, &r)];
    let metric @ [ess, est, ett] = [dot(du, du), dot(du, dv), dot(dv, dv)];
    let hessian @ [hss, hst, htt] = [ess + dot(duu, &r), est + dot(duv, &r), ett + dot(dvv, &r)];
    let det = hss * htt - hst * hst;
    let inverse = Lanes::splat(1.0) / det;
    let step = [(hst * gt - htt * gs) * inverse, (hst * gs - hss * gt) * inverse];
    let target = [s + step[0], t + step[1]];
    let size_sq = size * size;
    let floor = LAST_SHARE[1] * size;
    let length_sq = step[0] * step[0] * ess + step[1] * step[1] * ett;
    // Every condition is that some number is positive; all of them hold if the smallest one is.
    let noise = (distance_sq + Lanes::splat(size_sq)) * SLOPE_NOISE_SQ;
    let slope = (gs * gs - noise * ess).max(gt * gt - noise * ett);
    let definite = (det - ess * DEFINITE * ett).min(hss).min(slope);
    let still = Lanes::splat(STANDSTILL * STANDSTILL * size_sq);
    let moving = (ess - still).min(ett - still);
    let inside = open(s).min(open(t)).min(open(target[0])).min(open(target[1]));
    // Adds nothing, or NaN where something is not finite.
    let finite = (target[0] + target[1] + distance_sq) * 0.0;
    let good = definite.min(moving).min(inside) + finite;
    let plain = good.positive() & (places.before_sq * GROWTH - distance_sq).not_negative();
    let limit = Lanes::splat(LAST_STEP);
    let short = (distance_sq * (LAST_SHARE[0] * LAST_SHARE[0])).max(Lanes::splat(floor * floor));
    let small = (limit - step[0].abs()).min(limit - step[1].abs());
    let last = small.positive() & (short - length_sq).not_negative();
    Round { jets, distance_sq, gradient, metric, hessian, step, target, plain, last }
}
