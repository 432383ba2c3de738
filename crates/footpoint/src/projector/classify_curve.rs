//! Where on a curve a footpoint lies, and whether there are others.

use crate::global::curve::piece::PieceSet;
use crate::global::curve::scratch::{CurveFoot, CurveScratch};
use crate::global::curve::sides::CurveWalk;
use crate::global::gap::Gap;
use crate::tolerance::{FLAT, NO_GAIN, ORTHOGONAL, ORTHOGONAL_FLOOR, SAME_POINT, STANDSTILL};
use crate::{CurveFootpoint, Location, Multiplicity, Status};
use nalgebra::SVector;

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// Turns a place into the public result: everything but the bound and the multiplicity.
    #[inline(always)]
    pub(crate) fn finish(&self, x: &SVector<f64, D>, foot: &CurveFoot) -> CurveFootpoint<D> {
        let out = self.judge(x, foot);
        if out.status == Status::Stalled { self.finish_refined(x, foot) } else { out }
    }

    /// As [`finish`](Self::finish), for a place where a descent has come to rest but the slope has not vanished.
    #[cold]
    fn finish_refined(&self, x: &SVector<f64, D>, foot: &CurveFoot) -> CurveFootpoint<D> {
        let foot = self.refine(x, foot);
        let mut out = self.judge(x, &foot);
        if out.status == Status::Stalled && self.is_level(x, &foot) {
            let at_end = out.location == Location::Edge;
            out.status = if at_end { Status::OnBoundary } else { Status::Converged };
        }
        out
    }

    /// What is to be said about a place.
    #[inline(always)]
    fn judge(&self, x: &SVector<f64, D>, foot: &CurveFoot) -> CurveFootpoint<D> {
        let piece = &self.pieces[foot.piece];
        let jet = self.jet(piece, foot.local);
        let r = jet.point - (x - piece.centre);
        let distance = r.norm();
        let end = usize::from(foot.local > 0.5);
        let at_end = piece.ends[end] && (foot.local - end as f64).abs() <= 1e-12;
        let location = match (at_end, piece.closed) {
            (true, true) => Location::Seam,
            (true, false) => Location::Edge,
            _ => Location::Interior,
        };
        let (slope, speed) = (jet.d1.dot(&r), jet.d1.norm());
        // At a cusp the parameterisation stands still: its direction is that of rounding errors.
        let still = speed <= STANDSTILL * self.size;
        let bend = speed * speed + jet.d2.dot(&r);
        // Or a step of Newton's method would gain nothing: next to a cusp parameters are not known better.
        let no_gain = slope * slope <= NO_GAIN * distance * distance * bend;
        let small = still
            || no_gain
            || slope.abs() <= speed * (ORTHOGONAL * distance).max(ORTHOGONAL_FLOOR * self.size);
        let blocked = (foot.local <= 0.0 && slope > 0.0 && piece.neighbours[0].is_none())
            || (foot.local >= 1.0 && slope < 0.0 && piece.neighbours[1].is_none());
        let status = match (small || blocked, location) {
            // Squares of the coordinates overflow.
            _ if !distance.is_finite() => Status::Diverged,
            (true, Location::Edge) => Status::OnBoundary,
            (true, _) => Status::Converged,
            (false, _) if foot.settled => Status::Stalled,
            (false, _) => Status::MaxIterations,
        };
        CurveFootpoint {
            shape: piece.shape,
            parameter: piece.interval.lerp(foot.local),
            point: jet.point + piece.centre,
            distance,
            status,
            location,
            multiplicity: Multiplicity::Unknown,
            lower_bound: 0.0,
            iterations: foot.steps,
        }
    }

    /// The public result of a walk, which has not converged while the distance falls beyond a kink.
    #[inline(always)]
    pub(crate) fn conclude_walk(&self, x: &SVector<f64, D>, walk: &CurveWalk) -> CurveFootpoint<D> {
        let mut out = self.finish(x, &walk.foot);
        if walk.falls_beyond && out.status.is_converged() {
            out.status = Status::MaxIterations;
        }
        out
    }

    /// Whether another point, apart from the footpoint, is as near.
    pub(crate) fn multiplicity(
        &self,
        x: &SVector<f64, D>,
        foot: &CurveFoot,
        out: &CurveFootpoint<D>,
        gap: &Gap,
        scratch: &mut CurveScratch<K>,
    ) -> Multiplicity {
        if out.distance <= gap.absolute {
            return Multiplicity::Unique;
        }
        if self.continues(x, foot, out, gap) {
            return Multiplicity::Continuum;
        }
        let apart = (SAME_POINT * self.size).max(1e-6 * out.distance);
        let tied = scratch.rivals.iter().any(|other| {
            let piece = &self.pieces[other.piece];
            let point = self.jet(piece, other.local).point + piece.centre;
            gap.is_tie(other.distance_sq, out.distance) && (point - out.point).norm() > apart
        });
        if tied { Multiplicity::Tied } else { Multiplicity::Unique }
    }

    /// Walks a little both ways: where the distance stays, the footpoint is one of many.
    pub(super) fn continues(
        &self,
        x: &SVector<f64, D>,
        foot: &CurveFoot,
        out: &CurveFootpoint<D>,
        gap: &Gap,
    ) -> bool {
        let piece = &self.pieces[foot.piece];
        let jet = self.jet(piece, foot.local);
        let r = jet.point - (x - piece.centre);
        let speed_sq = jet.d1.norm_squared();
        let ratio = (speed_sq + jet.d2.dot(&r)) / speed_sq;
        if out.location == Location::Edge || ratio.is_nan() || ratio.abs() > FLAT {
            return false;
        }
        // Walk a little: on a circle about the query the distance stays.
        let reach = 1e-3 * self.size / speed_sq.sqrt();
        [reach, -reach].into_iter().any(|step| {
            let (index, local) = self.walk(foot.piece, foot.local, step.clamp(-1.0, 1.0));
            let there = self.descend(x, index, local, 30);
            let other = &self.pieces[there.piece];
            let moved = (self.jet(other, there.local).point + other.centre - out.point).norm();
            gap.is_tie(there.distance_sq, out.distance) && moved > 1e-4 * self.size
        })
    }
}
