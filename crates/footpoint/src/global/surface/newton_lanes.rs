//! Newton's method for several queries side by side on one patch.

use crate::global::arithmetic::power;
use crate::global::arithmetic::power::Wide;
use crate::global::arithmetic::simd::{MOST, Pack, Simd};
use crate::global::surface::descend::{
    DEFINITE, GROWTH, LAST_SHARE, LAST_STEP, Model, Move, SLOPE_NOISE_SQ, STANDSTILL,
};
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::{Geometry, Patch};
use crate::global::surface::landing_lanes::{Landing, landing};
use crate::{Location, Multiplicity, Status, SurfaceFootpoint};
use nalgebra::Vector3;
use nurbs_core::SurfaceJet;

/// A point on its way downhill.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Walker {
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
    /// At a foot inside the patch.
    Found(SurfaceFootpoint),
    /// At a place that is to be looked at.
    Landed(Foot, SurfaceJet),
    /// On another patch.
    Crossed(Walker),
    /// Where the distance grows: to be walked again, with step control.
    Lost,
}

/// One evaluation of several places: jets, model, and where Newton's step leads to.
pub(in crate::global) struct Round<S: Simd> {
    pub(in crate::global) jets: [Wide<S, 3>; 6],
    pub(in crate::global) distance_sq: Pack<S>,
    gradient: [Pack<S>; 2],
    metric: [Pack<S>; 3],
    hessian: [Pack<S>; 3],
    step: [Pack<S>; 2],
    pub(in crate::global) target: [Pack<S>; 2],
    /// Bit by bit: lanes that go to the target, inside the patch.
    plain: u32,
    /// Those for which the step is negligible.
    last: u32,
}

/// Where several walkers are, one in each place of the arrays.
struct Places {
    /// The points relative to the centre of the patch.
    y: [[f64; MOST]; 3],
    local: [[f64; MOST]; 2],
    before_sq: [f64; MOST],
}

/// The same in vectors.
pub(in crate::global) struct At<S: Simd> {
    pub(in crate::global) y: [Pack<S>; 3],
    pub(in crate::global) local: [Pack<S>; 2],
    before_sq: Pack<S>,
}

impl Places {
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> At<S> {
        // Closures in methods of arrays would not be compiled for vectors.
        let ([x, y, z], [s, t]) = (&self.y, &self.local);
        At {
            y: [Pack::load(simd, x), Pack::load(simd, y), Pack::load(simd, z)],
            local: [Pack::load(simd, s), Pack::load(simd, t)],
            before_sq: Pack::load(simd, &self.before_sq),
        }
    }
}

impl Geometry {
    /// Lets walkers on one patch, each of one of the points, go downhill until they land or leave; each does the same, bit for bit, as in
    /// [`descend`](Self::descend).
    #[inline(always)]
    pub(crate) fn newton_lanes<S: Simd>(
        &self,
        simd: S,
        points: &[Vector3<f64>],
        group: &[Walker],
        max_steps: u32,
        mut report: impl FnMut(&Walker, Outcome),
    ) {
        let patch = &self.patches[group[0].patch as usize];
        match (patch.order(), patch.rational) {
            (4, false) => self.iterate::<S, 4, 3>(simd, patch, points, group, max_steps, report),
            (4, true) => self.iterate::<S, 4, 4>(simd, patch, points, group, max_steps, report),
            (3, false) => self.iterate::<S, 3, 3>(simd, patch, points, group, max_steps, report),
            (3, true) => self.iterate::<S, 3, 4>(simd, patch, points, group, max_steps, report),
            _ => group.iter().for_each(|walker| report(walker, Outcome::Lost)),
        }
    }

    #[inline(always)]
    fn iterate<S: Simd, const N: usize, const C: usize>(
        &self,
        simd: S,
        patch: &Patch,
        points: &[Vector3<f64>],
        group: &[Walker],
        max_steps: u32,
        mut report: impl FnMut(&Walker, Outcome),
    ) {
        let net = self.powers::<N, C>(patch);
        let [o, p] = patch.origin();
        let origin = [Pack::splat(simd, o), Pack::splat(simd, p)];
        let mut places = Places { y: [[0.0; MOST]; 3], local: [[0.5; MOST]; 2], before_sq: [0.0; MOST] };
        let mut steps = [0u32; MOST];
        let mut members = [0usize; MOST];
        let (mut occupied, mut waiting) = (0u32, 0usize);
        let mut free = (1u32 << Pack::<S>::COUNT) - 1;
        loop {
            // A lane that has become free takes the next walker.
            for l in lanes_of(free).take(group.len() - waiting) {
                free &= !(1 << l);
                occupied |= 1 << l;
                let walker = &group[waiting];
                let y = points[walker.index as usize] - patch.centre;
                for c in 0..3 {
                    places.y[c][l] = y[c];
                }
                for d in 0..2 {
                    places.local[d][l] = walker.local[d];
                }
                places.before_sq[l] = walker.before_sq;
                (steps[l], members[l]) = (walker.steps, waiting);
                waiting += 1;
            }
            if occupied == 0 {
                return;
            }
            let at = places.load(simd);
            let round = round::<S, N, C>(net, &origin, &at, self.size);
            let mut limited = 0;
            for l in 0..Pack::<S>::COUNT {
                steps[l] += 1;
                limited |= u32::from(steps[l] >= max_steps) << l;
            }
            let short = occupied & round.plain & round.last;
            if short != 0 {
                let landing = landing(&round, &at, self.size);
                let found = short & landing.converged;
                let feet = Feet::new(&round, &landing);
                for l in lanes_of(found) {
                    report(&group[members[l]], Outcome::Found(feet.answer(patch, l, steps[l])));
                }
                occupied &= !found;
                free |= found;
            }
            for d in 0..2 {
                round.target[d].store(&mut places.local[d]);
            }
            round.distance_sq.store(&mut places.before_sq);
            let attention = occupied & (!round.plain | round.last | limited);
            for l in lanes_of(attention) {
                let walker = &group[members[l]];
                let x = &points[walker.index as usize];
                let outcome = self.conclude_lane(&round, &at, l, (walker, x), steps[l], max_steps);
                match outcome {
                    Ok(local) => {
                        for d in 0..2 {
                            places.local[d][l] = local[d];
                        }
                    }
                    Err(outcome) => {
                        report(walker, outcome);
                        occupied &= !(1 << l);
                        free |= 1 << l;
                    }
                }
            }
        }
    }

    /// What becomes of a lane that does not simply go on: a place on the same patch, or the end of its walk.
    #[inline(always)]
    #[expect(clippy::result_large_err, reason = "used at once; a box would cost an allocation per point")]
    fn conclude_lane<S: Simd>(
        &self,
        round: &Round<S>,
        from: &At<S>,
        l: usize,
        (walker, x): (&Walker, &Vector3<f64>),
        steps: u32,
        max_steps: u32,
    ) -> Result<[f64; 2], Outcome> {
        let distance_sq = round.distance_sq.at(l);
        if distance_sq > from.before_sq.at(l) * GROWTH || !distance_sq.is_finite() {
            return Err(Outcome::Lost);
        }
        let vector = |k: usize| {
            let [x, y, z] = &round.jets[k];
            Vector3::new(x.at(l), y.at(l), z.at(l))
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
        let at = [from.local[0].at(l), from.local[1].at(l)];
        let mut foot = Foot { patch: index, local: at, distance_sq, steps, settled: false };
        let going = if round.plain >> l & 1 != 0 {
            let local = [round.target[0].at(l), round.target[1].at(l)];
            let last = round.last >> l & 1 != 0;
            Move::To { patch: index, local, step: round.step.map(|s| s.at(l)), last }
        } else {
            let model = Model {
                gradient: round.gradient.map(|g| g.at(l)),
                hessian: round.hessian.map(|h| h.at(l)),
                metric: round.metric.map(|m| m.at(l)),
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
                    let (foot, jet) = self.land(x, foot, &jet, (patch, local), step, last);
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

/// The indices of the bits that are set, from the lowest on.
#[inline(always)]
fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        let any = bits != 0;
        bits &= bits.wrapping_sub(1);
        any.then_some(lane)
    })
}

/// What is told about feet side by side.
struct Feet {
    local: [[f64; MOST]; 2],
    point: [[f64; MOST]; 3],
    distance: [f64; MOST],
    side: [f64; MOST],
}

impl Feet {
    #[inline(always)]
    fn new<S: Simd>(round: &Round<S>, landing: &Landing<S>) -> Self {
        let ([s, t], [x, y, z]) = (&round.target, &landing.point);
        Self {
            local: [s.to_array(), t.to_array()],
            point: [x.to_array(), y.to_array(), z.to_array()],
            distance: landing.distance.to_array(),
            side: landing.side.to_array(),
        }
    }

    /// The answer of one that has converged.
    #[inline(always)]
    fn answer(&self, patch: &Patch, l: usize, steps: u32) -> SurfaceFootpoint {
        let ([s, t], [x, y, z], distance) = (&self.local, &self.point, self.distance[l]);
        SurfaceFootpoint {
            shape: patch.shape(),
            parameter: patch.parameter(s[l], t[l]),
            point: Vector3::new(x[l], y[l], z[l]) + patch.centre,
            distance,
            signed_distance: if -self.side[l] < 0.0 { -distance } else { distance },
            status: Status::Converged,
            location: Location::Interior,
            multiplicity: Multiplicity::Unknown,
            lower_bound: 0.0,
            iterations: steps,
        }
    }
}

#[inline(always)]
pub(in crate::global) fn dot<S: Simd>(a: &Wide<S, 3>, b: &Wide<S, 3>) -> Pack<S> {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// Positive inside the unit interval.
#[inline(always)]
pub(in crate::global) fn open<S: Simd>(x: Pack<S>) -> Pack<S> {
    x.min(x.all(1.0) - x)
}

/// The operations of [`descend`](Geometry::descend), in the same order, for the usual case: the Hessian is positive
/// definite and its step stays inside the patch.
#[inline(always)]
fn round<S: Simd, const N: usize, const C: usize>(
    net: &[f64],
    origin: &[Pack<S>; 2],
    from: &At<S>,
    size: f64,
) -> Round<S> {
    let [s, t] = from.local;
    let jets = power::wide_jets(&power::jet::<N, Wide<S, C>>(net, s - origin[0], t - origin[1]));
    let [point, du, dv, duu, duv, dvv] = &jets;
    let r = [point[0] - from.y[0], point[1] - from.y[1], point[2] - from.y[2]];
    let distance_sq = dot(&r, &r);
    let gradient @ [gs, gt] = [dot(du, &r), dot(dv, &r)];
    let metric @ [ess, est, ett] = [dot(du, du), dot(du, dv), dot(dv, dv)];
    let hessian @ [hss, hst, htt] = [ess + dot(duu, &r), est + dot(duv, &r), ett + dot(dvv, &r)];
    let det = hss * htt - hst * hst;
    let inverse = s.all(1.0) / det;
    let step = [(hst * gt - htt * gs) * inverse, (hst * gs - hss * gt) * inverse];
    let target = [s + step[0], t + step[1]];
    let size_sq = size * size;
    let floor = LAST_SHARE[1] * size;
    let length_sq = step[0] * step[0] * ess + step[1] * step[1] * ett;
    // Every condition is that some number is positive; all of them hold if the smallest one is.
    let noise = (distance_sq + s.all(size_sq)) * SLOPE_NOISE_SQ;
    let slope = (gs * gs - noise * ess).max(gt * gt - noise * ett);
    let definite = (det - ess * DEFINITE * ett).min(hss).min(slope);
    let still = s.all(STANDSTILL * STANDSTILL * size_sq);
    let moving = (ess - still).min(ett - still);
    let inside = open(s).min(open(t)).min(open(target[0])).min(open(target[1]));
    // Adds nothing, or NaN where something is not finite.
    let finite = (target[0] + target[1] + distance_sq) * 0.0;
    let good = definite.min(moving).min(inside) + finite;
    let plain = good.positive() & (from.before_sq * GROWTH - distance_sq).not_negative();
    let limit = s.all(LAST_STEP);
    let short = (distance_sq * (LAST_SHARE[0] * LAST_SHARE[0])).max(s.all(floor * floor));
    let small = (limit - step[0].abs()).min(limit - step[1].abs());
    let last = small.positive() & (short - length_sq).not_negative();
    Round { jets, distance_sq, gradient, metric, hessian, step, target, plain, last }
}
