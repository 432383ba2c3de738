//! Newton's method for eight queries side by side on one patch.

use super::lanes::{Lanes, WIDTH};
use super::patch::{Homogeneous, Patch, PatchSet};
use crate::{Location, Multiplicity, Status, SurfaceFootpoint};
use nalgebra::Vector3;

/// Rounds before a lane is left to the scalar iteration.
const ROUNDS: usize = 7;
/// Local step after which the next evaluation is the last.
const LAST_STEP: f64 = 1e-7;
/// Feet nearer than this to the border of the patch, in local parameters, are left to the scalar iteration.
const MARGIN: f64 = 1e-9;

/// Coordinates of eight points or vectors; the fourth is the weight.
type Wide = [Lanes; 4];

impl<const K: usize> PatchSet<K> {
    /// Feet of eight points from local starts on the same patch.
    ///
    /// `None` where the iteration is not a plain convergence to the inside of the patch: those lanes need the
    /// scalar iteration, with its active set, its step control and its way across borders.
    #[inline(always)]
    pub(crate) fn newton_lanes(
        &self,
        index: usize,
        points: &[Vector3<f64>; WIDTH],
        starts: &[[f64; 2]; WIDTH],
    ) -> [Option<SurfaceFootpoint>; WIDTH] {
        let patch = &self.patches[index];
        match patch.degrees {
            [3, 3] => self.iterate::<4, 4>(patch, points, starts),
            [2, 2] => self.iterate::<3, 3>(patch, points, starts),
            _ => [None; WIDTH],
        }
    }

    #[inline(always)]
    fn iterate<const M: usize, const N: usize>(
        &self,
        patch: &Patch,
        points: &[Vector3<f64>; WIDTH],
        starts: &[[f64; 2]; WIDTH],
    ) -> [Option<SurfaceFootpoint>; WIDTH] {
        let net = self.net(patch);
        let mut y = [Lanes::splat(0.0); 3];
        let (mut s, mut t) = (Lanes::splat(0.0), Lanes::splat(0.0));
        for l in 0..WIDTH {
            for c in 0..3 {
                y[c].0[l] = points[l][c] - patch.centre[c];
            }
            (s.0[l], t.0[l]) = (starts[l][0], starts[l][1]);
        }
        let mut finishing = [false; WIDTH];
        let mut failed = [false; WIDTH];
        let mut previous = Lanes::splat(f64::INFINITY);
        let short = (1e-10 * self.size) * (1e-10 * self.size);
        for round in 1..=ROUNDS {
            let jet = jets::<M, N>(net, s, t, patch.rational);
            let [point, du, dv, duu, duv, dvv] = &jet;
            let r = [point[0] - y[0], point[1] - y[1], point[2] - y[2]];
            let distance_sq = dot(&r, &r);
            let (gs, gt) = (dot(du, &r), dot(dv, &r));
            let (ess, ett, est) = (dot(du, du), dot(dv, dv), dot(du, dv));
            let (hss, hst, htt) = (ess + dot(duu, &r), est + dot(duv, &r), ett + dot(dvv, &r));
            let det = hss * htt - hst * hst;
            let (ns, nt) = (hst * gt - htt * gs, hst * gs - hss * gt);
            let mut open = false;
            for l in 0..WIDTH {
                let definite = det.0[l] > 1e-12 * ess.0[l] * ett.0[l] && hss.0[l] > 0.0;
                let falling = distance_sq.0[l] <= previous.0[l] * (1.0 + 1e-14);
                let (ds, dt) = (ns.0[l] / det.0[l], nt.0[l] / det.0[l]);
                let (next_s, next_t) = (s.0[l] + ds, t.0[l] + dt);
                let inside =
                    MARGIN < next_s && next_s < 1.0 - MARGIN && MARGIN < next_t && next_t < 1.0 - MARGIN;
                let good = finishing[l] || (definite && falling && inside);
                failed[l] |= !good;
                let length_sq = ds * ds * ess.0[l] + dt * dt * ett.0[l];
                let last =
                    ds.abs().max(dt.abs()) < LAST_STEP && length_sq <= (1e-8 * distance_sq.0[l]).max(short);
                let moves = good && !finishing[l];
                open |= moves;
                if moves {
                    (s.0[l], t.0[l]) = (next_s, next_t);
                    finishing[l] = last;
                }
            }
            previous = distance_sq;
            if !open {
                return self.collect(patch, [s, t], &jet, &r, distance_sq, &failed, round);
            }
        }
        [None; WIDTH]
    }

    /// The results of the lanes that have come to rest inside the patch.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "all of them are the lanes of one evaluation")]
    fn collect(
        &self,
        patch: &Patch,
        [s, t]: [Lanes; 2],
        jet: &[Wide; 6],
        r: &[Lanes; 3],
        distance_sq: Lanes,
        failed: &[bool; WIDTH],
        round: usize,
    ) -> [Option<SurfaceFootpoint>; WIDTH] {
        let [point, du, dv, ..] = jet;
        let normal =
            [du[1] * dv[2] - du[2] * dv[1], du[2] * dv[0] - du[0] * dv[2], du[0] * dv[1] - du[1] * dv[0]];
        let side = dot(&normal, r);
        let (area_sq, eu, ev) = (dot(&normal, &normal), dot(du, du), dot(dv, dv));
        let mut out = [None; WIDTH];
        for l in 0..WIDTH {
            // Next to a pole the side is found from higher derivatives.
            if failed[l] || area_sq.0[l] <= 1e-12 * eu.0[l] * ev.0[l] {
                continue;
            }
            let distance = distance_sq.0[l].sqrt();
            out[l] = Some(SurfaceFootpoint {
                shape: patch.shape,
                parameter: patch.parameter(s.0[l], t.0[l]),
                point: Vector3::new(point[0].0[l], point[1].0[l], point[2].0[l]) + patch.centre,
                distance,
                signed_distance: if side.0[l] > 0.0 { -distance } else { distance },
                status: Status::Converged,
                location: Location::Interior,
                multiplicity: Multiplicity::Unknown,
                lower_bound: 0.0,
                iterations: u32::try_from(round).unwrap_or(0),
            });
        }
        out
    }
}

#[inline(always)]
fn dot<const A: usize, const B: usize>(a: &[Lanes; A], b: &[Lanes; B]) -> Lanes {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// Value, first and second derivatives of the Bernstein polynomials of degree `M − 1` (2 or 3).
#[inline(always)]
fn basis<const M: usize>(s: Lanes) -> [[Lanes; 3]; M] {
    let one = Lanes::splat(1.0);
    let r = one - s;
    let mut out = [[Lanes::splat(0.0); 3]; M];
    let (rr, rs, ss) = (r * r, r * s * 2.0, s * s);
    if M == 3 {
        out[0] = [rr, r * -2.0, one * 2.0];
        out[1] = [rs, (r - s) * 2.0, one * -4.0];
        out[2] = [ss, s * 2.0, one * 2.0];
    } else {
        out[0] = [rr * r, rr * -3.0, r * 6.0];
        out[1] = [rs * r * 1.5, (rr - rs) * 3.0, (s - r * 2.0) * 6.0];
        out[2] = [rs * s * 1.5, (rs - ss) * 3.0, (r - s * 2.0) * 6.0];
        out[M - 1] = [ss * s, ss * 3.0, s * 6.0];
    }
    out
}

/// Value, u, v, uu, uv, vv of eight places of one net.
#[inline(always)]
fn jets<const M: usize, const N: usize>(
    net: &[Homogeneous],
    s: Lanes,
    t: Lanes,
    rational: bool,
) -> [Wide; 6] {
    let (bu, bv) = (basis::<M>(s), basis::<N>(t));
    let zero = Lanes::splat(0.0);
    let mut a = [[zero; 4]; 6];
    // The weights of a polynomial patch are not summed: three coordinates are enough.
    let coordinates = if rational { 4 } else { 3 };
    for i in 0..M {
        for c in 0..coordinates {
            let mut row = [zero; 3];
            for j in 0..N {
                let value = net[i * N + j][c];
                for d in 0..3 {
                    row[d] = row[d] + bv[j][d] * value;
                }
            }
            for (slot, (k, d)) in [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)].into_iter().enumerate() {
                a[slot][c] = a[slot][c] + row[d] * bu[i][k];
            }
        }
    }
    if rational {
        divide(&mut a);
    }
    a
}

/// The quotient rule, lane by lane.
#[inline(always)]
fn divide(a: &mut [Wide; 6]) {
    let w = [a[0][3], a[1][3], a[2][3], a[3][3], a[4][3], a[5][3]];
    let mut inverse = w[0];
    for l in 0..WIDTH {
        inverse.0[l] = 1.0 / w[0].0[l];
    }
    for c in 0..3 {
        let p = a[0][c] * inverse;
        let u = (a[1][c] - p * w[1]) * inverse;
        let v = (a[2][c] - p * w[2]) * inverse;
        a[3][c] = (a[3][c] - u * w[1] * 2.0 - p * w[3]) * inverse;
        a[4][c] = (a[4][c] - u * w[2] - v * w[1] - p * w[4]) * inverse;
        a[5][c] = (a[5][c] - v * w[2] * 2.0 - p * w[5]) * inverse;
        (a[0][c], a[1][c], a[2][c]) = (p, u, v);
    }
}
