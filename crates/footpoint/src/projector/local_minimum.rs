//! Whether a place is a local minimum of the distance, seen from everything that meets there.
//!
//! Every patch or piece around the place, and at a pole every parameter line, has a say: the distance must not
//! decrease into any of them, neither by its slope nor, where this vanishes, by its curvature.

use crate::global::curve::piece::PieceSet;
use crate::global::curve::scratch::CurveFoot;
use crate::global::surface::foot::Foot;
use crate::global::surface::patch::PatchSet;
use crate::global::surface::polish::flattest;
use crate::tolerance::{FLAT, ON_BORDER, ORTHOGONAL, ORTHOGONAL_FLOOR, SAME_POINT, STANDSTILL};
use nalgebra::{SVector, Vector3};

/// Relative decrease of the squared distance that is not a rounding error.
const DECREASE: f64 = 1e-13;

/// Share of the size of the model that is walked where slope and curvature do not decide.
const STRIDE: f64 = 1e-3;

impl<const K: usize> PatchSet<K> {
    /// Whether the distance grows, or stays, in all directions on the surface.
    pub(crate) fn is_minimum(&self, x: &Vector3<f64>, foot: &Foot) -> bool {
        let here = self.place(foot.patch, foot.local);
        let mut around = self.around(foot.patch, foot.local).into_iter();
        around.all(|(index, local)| {
            let same = (self.place(index, local) - here).norm() <= SAME_POINT * self.size;
            !same || self.is_minimum_seen_from(x, index, local)
        })
    }

    /// Whether the distance does not decrease from a place into its patch.
    fn is_minimum_seen_from(&self, x: &Vector3<f64>, index: usize, local: [f64; 2]) -> bool {
        let patch = &self.patches[index];
        let jet = self.jet(patch, local[0], local[1]);
        let r = jet.point - (x - patch.centre);
        let small = (ORTHOGONAL * r.norm()).max(ORTHOGONAL_FLOOR * self.size);
        let metric = [jet.du.norm_squared(), jet.du.dot(&jet.dv), jet.dv.norm_squared()];
        let hessian = [metric[0] + jet.duu.dot(&r), metric[1] + jet.duv.dot(&r), metric[2] + jet.dvv.dot(&r)];
        // At a pole the parameters are exact, and so are the slopes of the lines that leave it.
        let at_pole = [jet.du, jet.dv].iter().any(|tangent| tangent.norm() <= STANDSTILL * self.size);
        let small = if at_pole { 1e-12 * (r.norm() + self.size) } else { small };
        let mut free = [true; 2];
        // The sign of the only way into the patch, at a border.
        let mut inward = [0.0; 2];
        for (d, tangent) in [jet.du, jet.dv].into_iter().enumerate() {
            let speed = tangent.norm();
            if speed <= STANDSTILL * self.size {
                // A pole: no way leads along this direction.
                free[d] = false;
                continue;
            }
            let slope = tangent.dot(&r);
            inward[d] = if local[d] <= 0.0 {
                1.0
            } else if local[d] >= 1.0 {
                -1.0
            } else {
                0.0
            };
            if slope.abs() > small * speed {
                if slope * inward[d] <= 0.0 {
                    return false;
                }
                free[d] = false;
            }
        }
        let (ratio, direction) = match free {
            [false, false] => return true,
            [true, true] => {
                let (ratio, direction) = flattest(&metric, &hessian);
                // In a corner only directions between the two edges count.
                let saddle = inward[0] * inward[1] * hessian[1] >= 0.0 && inward[0] * inward[1] != 0.0;
                if ratio < 0.0 && saddle {
                    return hessian[0] >= -FLAT * metric[0] && hessian[2] >= -FLAT * metric[2];
                }
                (ratio, direction)
            }
            _ => {
                let d = usize::from(free[1]);
                let mut direction = [0.0; 2];
                direction[d] = 1.0 / metric[2 * d].sqrt();
                (hessian[2 * d] / metric[2 * d], direction)
            }
        };
        if ratio.is_nan() || ratio.abs() > FLAT {
            return ratio > 0.0;
        }
        [1.0, -1.0].into_iter().all(|sign| {
            let step = direction.map(|c| (sign * c * STRIDE * self.size).clamp(-1.0, 1.0));
            let (other, there) = self.walk(index, local, step);
            self.distance_sq(x, other, there) >= r.norm_squared() * (1.0 - DECREASE)
        })
    }
}

impl<const D: usize, const K: usize> PieceSet<D, K> {
    /// Whether the distance grows, or stays, in both directions on the curve.
    pub(crate) fn is_minimum(&self, x: &SVector<f64, D>, foot: &CurveFoot) -> bool {
        let end = usize::from(foot.local > 0.5);
        let border = end as f64;
        if (foot.local - border).abs() > ON_BORDER {
            return self.is_minimum_seen_from(x, foot.piece, foot.local);
        }
        let beyond = self.beyond(foot.piece, end);
        self.is_minimum_seen_from(x, foot.piece, border)
            && beyond.is_none_or(|other| self.is_minimum_seen_from(x, other, 1.0 - border))
    }

    /// Whether the distance does not decrease from a place into its piece.
    fn is_minimum_seen_from(&self, x: &SVector<f64, D>, index: usize, local: f64) -> bool {
        let piece = &self.pieces[index];
        let jet = self.jet(piece, local);
        let r = jet.point - (x - piece.centre);
        let (slope, speed) = (jet.d1.dot(&r), jet.d1.norm());
        let small = (ORTHOGONAL * r.norm()).max(ORTHOGONAL_FLOOR * self.size);
        if slope.abs() > small * speed {
            return (local <= 0.0 && slope > 0.0) || (local >= 1.0 && slope < 0.0);
        }
        let ratio = (speed * speed + jet.d2.dot(&r)) / (speed * speed);
        if ratio > FLAT {
            return true;
        }
        if ratio < -FLAT && speed > 1e-9 * self.size {
            return false;
        }
        // At a cusp, or in the centre of curvature: a look at both sides.
        let stride = (STRIDE * self.size / speed).min(STRIDE.sqrt());
        [stride, -stride].into_iter().all(|step| {
            let (other, there) = self.walk(index, local, step);
            self.distance_sq(x, other, there) >= r.norm_squared() * (1.0 - DECREASE)
        })
    }
}
