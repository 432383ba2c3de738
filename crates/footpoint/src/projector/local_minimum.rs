//! Whether a place is a local minimum of the distance, seen from everything that meets there.
//!
//! Every patch or piece around the place, and at a pole every parameter line, has a say: the distance must not
//! decrease into any of them, neither by its slope nor, where this vanishes, by its curvature.

use super::classify::{FLAT, ON_BORDER, ORTHOGONAL, SAME_POINT, STANDSTILL};
use crate::global::descend::Foot;
use crate::global::patch::PatchSet;
use crate::global::piece::PieceSet;
use crate::global::polish::flattest;
use crate::global::search_curve::CurveFoot;
use nalgebra::{SVector, Vector3};

/// Relative decrease of the squared distance that is not a rounding error.
const DECREASE: f64 = 1e-13;

/// Share of the size of the model that is walked where slope and curvature do not decide.
const STRIDE: f64 = 1e-3;

/// Places on every parameter line through a pole that are looked at, per patch.
const LINES: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

impl<const K: usize> PatchSet<K> {
    /// Whether the distance grows, or stays, in all directions on the surface.
    pub(crate) fn is_minimum(&self, x: &Vector3<f64>, foot: &Foot) -> bool {
        let place = |index: usize, local: [f64; 2]| {
            let patch = &self.patches[index];
            self.point(patch, local[0], local[1]) + patch.centre
        };
        let here = place(foot.patch, foot.local);
        let mut around = self.around(foot).into_iter();
        around.all(|(index, local)| {
            let same = (place(index, local) - here).norm() <= SAME_POINT * self.size;
            !same || self.is_minimum_seen_from(x, index, local)
        })
    }

    /// All places, by patch and local parameters, that are the same point of the surface.
    fn around(&self, foot: &Foot) -> Vec<(usize, [f64; 2])> {
        let patch = &self.patches[foot.patch];
        let cells = &self.cells[patch.shape];
        let mut options = [0, 1].map(|d| vec![(patch.cell[d], foot.local[d])]);
        let mut pole = None;
        for d in 0..2 {
            let end = usize::from(foot.local[d] > 0.5);
            let border = end as f64;
            let at_end = cells.at_end(patch.cell, d, end);
            let gap = (foot.local[d] - border).abs();
            if at_end && cells.collapsed[d][end] {
                let jet = self.jet(patch, foot.local[0], foot.local[1]);
                let speed = if d == 0 { jet.du } else { jet.dv }.norm();
                if gap * speed <= 1e-9 * self.size {
                    options[d] = vec![(patch.cell[d], border)];
                    pole = Some(d);
                    continue;
                }
            }
            if gap > ON_BORDER || (at_end && !cells.closed[d]) {
                continue;
            }
            let count = cells.counts[d];
            let beyond = if end == 0 { patch.cell[d] + count - 1 } else { patch.cell[d] + 1 } % count;
            options[d] = vec![(patch.cell[d], border), (beyond, 1.0 - border)];
        }
        if let Some(d) = pole {
            let lines = |cell| LINES.map(|s| (cell, s));
            options[1 - d] = (0..cells.counts[1 - d]).flat_map(lines).collect();
        }
        let [u, v] = &options;
        let places = u.iter().flat_map(|&(row, s)| v.iter().map(move |&(column, t)| ([row, column], [s, t])));
        places.map(|(cell, local)| (cells.patch(cell), local)).collect()
    }

    /// Whether the distance does not decrease from a place into its patch.
    fn is_minimum_seen_from(&self, x: &Vector3<f64>, index: usize, local: [f64; 2]) -> bool {
        let patch = &self.patches[index];
        let jet = self.jet(patch, local[0], local[1]);
        let r = jet.point - (x - patch.centre);
        let small = (ORTHOGONAL * r.norm()).max(1e-11 * self.size);
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
        let piece = &self.pieces[foot.piece];
        let end = usize::from(foot.local > 0.5);
        let border = end as f64;
        if (foot.local - border).abs() > ON_BORDER {
            return self.is_minimum_seen_from(x, foot.piece, foot.local);
        }
        let beyond = match (piece.ends[end], end) {
            (false, 0) => Some(foot.piece - 1),
            (false, _) => Some(foot.piece + 1),
            (true, _) if !piece.closed => None,
            (true, 0) => self.locate(piece.shape, f64::INFINITY).map(|p| p.0),
            (true, _) => self.locate(piece.shape, f64::NEG_INFINITY).map(|p| p.0),
        };
        self.is_minimum_seen_from(x, foot.piece, border)
            && beyond.is_none_or(|other| self.is_minimum_seen_from(x, other, 1.0 - border))
    }

    /// Whether the distance does not decrease from a place into its piece.
    fn is_minimum_seen_from(&self, x: &SVector<f64, D>, index: usize, local: f64) -> bool {
        let piece = &self.pieces[index];
        let jet = self.jet(piece, local);
        let r = jet.point - (x - piece.centre);
        let (slope, speed) = (jet.d1.dot(&r), jet.d1.norm());
        let small = (ORTHOGONAL * r.norm()).max(1e-11 * self.size);
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
