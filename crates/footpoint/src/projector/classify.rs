//! Where a footpoint lies, on which side the query is, and whether there are others.

use crate::global::gap::Gap;
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::{Geometry, Patch};
use crate::global::surface::patch::PatchSet;
use crate::global::surface::polish::flattest;
use crate::global::surface::scratch::Scratch;
use crate::global::surface::sides::Walk;
use crate::tolerance::{
    DEGENERATE_SQ, FLAT, NO_GAIN, ON_BORDER, ORTHOGONAL, ORTHOGONAL_FLOOR, SAME_POINT, STANDSTILL,
};
use crate::{Location, Multiplicity, Status, SurfaceFootpoint};
use nalgebra::Vector3;
use nurbs_core::SurfaceJet;

impl SurfaceFootpoint {
    /// The answer where numbers overflow.
    pub(crate) fn diverged() -> Self {
        Self { status: Status::Diverged, ..Self::invalid() }
    }

    /// The answer for a point that is not finite.
    pub(crate) fn invalid() -> Self {
        Self {
            shape: 0,
            parameter: [f64::NAN; 2],
            point: Vector3::repeat(f64::NAN),
            distance: f64::NAN,
            signed_distance: f64::NAN,
            status: Status::InvalidPoint,
            location: Location::Interior,
            multiplicity: Multiplicity::Unknown,
            lower_bound: 0.0,
            iterations: 0,
        }
    }
}

impl Geometry {
    /// Turns a place into the public result: everything but the bound and the multiplicity.
    #[inline(always)]
    pub(crate) fn finish(&self, x: &Vector3<f64>, foot: &Foot) -> SurfaceFootpoint {
        let [s, t] = foot.local;
        self.conclude(x, foot, &self.jet(&self.patches[foot.patch], s, t))
    }

    /// The public result of a walk, which has not converged while the distance falls beyond a kink.
    #[inline(always)]
    pub(crate) fn conclude_walk(&self, x: &Vector3<f64>, walk: &Walk) -> SurfaceFootpoint {
        let mut out = self.conclude(x, &walk.foot, &walk.jet);
        if walk.falls_beyond && out.status.is_converged() {
            out.status = Status::MaxIterations;
        }
        out
    }

    /// As [`finish`](Self::finish), when the jet at the place is known.
    #[inline(always)]
    pub(crate) fn conclude(&self, x: &Vector3<f64>, foot: &Foot, jet: &SurfaceJet) -> SurfaceFootpoint {
        let out = self.judge(x, foot, jet);
        if out.status == Status::Stalled { self.conclude_refined(x, foot, jet) } else { out }
    }

    /// As [`conclude`](Self::conclude), for a place where a descent has come to rest but the slope has not vanished.
    #[cold]
    fn conclude_refined(&self, x: &Vector3<f64>, foot: &Foot, jet: &SurfaceJet) -> SurfaceFootpoint {
        let (foot, jet) = self.refine(x, foot, jet);
        let mut out = self.judge(x, &foot, &jet);
        if out.status == Status::Stalled && self.is_level(x, &foot, &jet) {
            let at_boundary = matches!(out.location, Location::Edge | Location::Corner);
            out.status = if at_boundary { Status::OnBoundary } else { Status::Converged };
        }
        out
    }

    /// What is to be said about a place.
    #[inline(always)]
    fn judge(&self, x: &Vector3<f64>, foot: &Foot, jet: &SurfaceJet) -> SurfaceFootpoint {
        let patch = &self.patches[foot.patch];
        let [s, t] = foot.local;
        let r = jet.point - (x - patch.centre);
        let distance = r.norm();
        let location = self.location(patch, foot.local, jet);
        let stationary = self.is_stationary(patch, foot.local, jet, &r, distance);
        let at_boundary = matches!(location, Location::Edge | Location::Corner);
        let status = match (stationary, at_boundary) {
            // Squares of the coordinates overflow.
            _ if !distance.is_finite() => Status::Diverged,
            (true, true) => Status::OnBoundary,
            (true, false) => Status::Converged,
            (false, _) if foot.settled => Status::Stalled,
            (false, _) => Status::MaxIterations,
        };
        let side = -outward(foot.local, jet).dot(&r);
        SurfaceFootpoint {
            shape: patch.shape(),
            parameter: patch.parameter(s, t),
            point: jet.point + patch.centre,
            distance,
            signed_distance: if side < 0.0 { -distance } else { distance },
            status,
            location,
            multiplicity: Multiplicity::Unknown,
            lower_bound: 0.0,
            iterations: foot.steps,
        }
    }

    /// Whether the derivative of the distance vanishes, or points out of the domain, in each direction; or, where the
    /// surface bends so much that parameters are not known well enough for that, whether a step of Newton's method
    /// would gain nothing.
    #[inline(always)]
    fn is_stationary(
        &self,
        patch: &Patch,
        local: [f64; 2],
        jet: &SurfaceJet,
        r: &Vector3<f64>,
        distance: f64,
    ) -> bool {
        let mut free = [true; 2];
        let mut slopes = [0.0; 2];
        let stationary = (0..2).fold(true, |all, d| {
            let tangent = if d == 0 { &jet.du } else { &jet.dv };
            let (slope, speed_sq) = (tangent.dot(r), tangent.norm_squared());
            slopes[d] = slope;
            // At a pole or cusp the parameterisation stands still: its direction is that of rounding errors.
            let (standstill, tolerance) =
                (STANDSTILL * self.size, (ORTHOGONAL * distance).max(ORTHOGONAL_FLOOR * self.size));
            let still = speed_sq <= standstill * standstill;
            let small = still || slope * slope <= speed_sq * (tolerance * tolerance);
            let blocked = (local[d] <= 0.0 && slope > 0.0) || (local[d] >= 1.0 && slope < 0.0);
            // Inside the model a border of a patch blocks only where the surface has a kink.
            let end = usize::from(local[d] >= 1.0);
            free[d] = !(still || blocked && self.cells[patch.shape()].across(patch.cell(), d, end).is_none());
            all && (small || !free[d])
        });
        let bends =
            [(&jet.du, &jet.du, &jet.duu), (&jet.du, &jet.dv, &jet.duv), (&jet.dv, &jet.dv, &jet.dvv)];
        stationary || {
            let [hss, hst, htt] = bends.map(|(a, b, second)| a.dot(b) + second.dot(r));
            let [gs, gt] = slopes;
            let gain = match free {
                [true, true] => {
                    let det = hss * htt - hst * hst;
                    let product = htt * gs * gs - 2.0 * hst * gs * gt + hss * gt * gt;
                    if hss > 0.0 && det > 0.0 { product / det } else { f64::INFINITY }
                }
                [true, false] if hss > 0.0 => gs * gs / hss,
                [false, true] if htt > 0.0 => gt * gt / htt,
                _ => f64::INFINITY,
            };
            gain <= NO_GAIN * distance * distance
        }
    }

    #[inline(always)]
    fn location(&self, patch: &Patch, local: [f64; 2], jet: &SurfaceJet) -> Location {
        let cells = &self.cells[patch.shape()];
        let mut edges = 0;
        let mut seam = false;
        for d in 0..2 {
            let end = usize::from(local[d] > 0.5);
            let gap = (local[d] - end as f64).abs();
            if !cells.at_end(patch.cell(), d, end) {
                continue;
            }
            let tangent = if d == 0 { &jet.du } else { &jet.dv };
            if cells.collapsed[d][end] && gap * tangent.norm() <= 1e-9 * self.size {
                return Location::Pole;
            }
            if gap <= ON_BORDER {
                if cells.closed[d] {
                    seam = true;
                } else {
                    edges += 1;
                }
            }
        }
        match (edges, seam) {
            (2, _) => Location::Corner,
            (1, _) => Location::Edge,
            (_, true) => Location::Seam,
            _ => Location::Interior,
        }
    }
}

impl<const K: usize> PatchSet<K> {
    /// Whether another point, apart from the footpoint, is as near.
    pub(crate) fn multiplicity(
        &self,
        x: &Vector3<f64>,
        foot: &Foot,
        out: &SurfaceFootpoint,
        gap: &Gap,
        scratch: &mut Scratch<K>,
    ) -> Multiplicity {
        if out.distance <= gap.absolute {
            return Multiplicity::Unique;
        }
        if self.continues(x, foot, out, gap) {
            return Multiplicity::Continuum;
        }
        let apart = SAME_POINT * self.size;
        let tied = scratch.rivals.iter().any(|other| {
            let p = &self.patches[other.patch];
            let point = self.point(p, other.local[0], other.local[1]) + p.centre;
            gap.is_tie(other.distance_sq, out.distance)
                && (point - out.point).norm() > apart.max(1e-6 * out.distance)
        });
        if tied { Multiplicity::Tied } else { Multiplicity::Unique }
    }

    /// Walks a little along the flattest direction: where the distance stays, the footpoint is one of many.
    pub(super) fn continues(&self, x: &Vector3<f64>, foot: &Foot, out: &SurfaceFootpoint, gap: &Gap) -> bool {
        let patch = &self.patches[foot.patch];
        let jet = self.jet(patch, foot.local[0], foot.local[1]);
        let r = jet.point - (x - patch.centre);
        let metric = [jet.du.norm_squared(), jet.du.dot(&jet.dv), jet.dv.norm_squared()];
        let hessian = [metric[0] + jet.duu.dot(&r), metric[1] + jet.duv.dot(&r), metric[2] + jet.dvv.dot(&r)];
        let reach = 1e-3 * self.size;
        let (ratio, direction) = match out.location {
            Location::Pole | Location::Corner => return false,
            Location::Edge => {
                // Only the direction along the edge is free.
                let cells = &self.cells[patch.shape()];
                let on = |d: usize| {
                    let end = usize::from(foot.local[d] > 0.5);
                    (foot.local[d] - end as f64).abs() <= ON_BORDER
                        && cells.at_end(patch.cell(), d, end)
                        && !cells.closed[d]
                };
                let along = usize::from(on(0));
                let mut direction = [0.0; 2];
                direction[along] = 1.0 / metric[2 * along].sqrt();
                (hessian[2 * along] / metric[2 * along], direction)
            }
            Location::Interior | Location::Seam => flattest(&metric, &hessian),
        };
        if ratio.is_nan() || ratio.abs() > FLAT {
            return false;
        }
        [1.0, -1.0].into_iter().any(|sign| {
            // In small strides, each brought back onto the valley.
            let mut at = *foot;
            for _ in 0..4 {
                let step = direction.map(|c| sign * c * 0.25 * reach);
                if !step.iter().all(|c| c.is_finite()) {
                    return false;
                }
                let (index, local) = self.walk(at.patch, at.local, step.map(|c| c.clamp(-1.0, 1.0)));
                at = Foot { patch: index, local, ..at };
            }
            let p = &self.patches[at.patch];
            let point = self.point(p, at.local[0], at.local[1]) + p.centre;
            let settled = self.descend(x, at.patch, at.local, 30);
            let q = &self.patches[settled.patch];
            let end = self.point(q, settled.local[0], settled.local[1]) + q.centre;
            let moved = (end - out.point).norm();
            gap.is_tie(settled.distance_sq, out.distance)
                && moved > 0.5 * (point - out.point).norm()
                && moved > 0.1 * reach
        })
    }
}

/// A vector along the normal; at a pole the limit of the normals along the parameter line.
#[inline(always)]
pub(crate) fn outward([s, t]: [f64; 2], jet: &SurfaceJet) -> Vector3<f64> {
    let normal = jet.du.cross(&jet.dv);
    let (lu, lv) = (jet.du.norm_squared(), jet.dv.norm_squared());
    if normal.norm_squared() > DEGENERATE_SQ * lu.max(lv) * lu.max(lv) {
        return normal;
    }
    // The collapsed direction grows like the mixed derivative times the distance to the edge.
    if lu < lv {
        jet.duv.cross(&jet.dv) * if t < 0.5 { 1.0 } else { -1.0 }
    } else {
        jet.du.cross(&jet.duv) * if s < 0.5 { 1.0 } else { -1.0 }
    }
}
