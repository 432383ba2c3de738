//! The sides of a place: walks that go on where patches meet in a kink, or in a pole.
//!
//! The iteration on one patch rests on a border where the distance falls beyond it and the border is not smooth. The
//! patches beyond, and at a pole every parameter line, are other sides of the same point: if the distance falls into one of
//! them, the walk goes on there. A foot at which no side falls is a local minimum of the distance, on a kink too.

use crate::global::surface::descend::STANDSTILL;
use crate::global::surface::foot::Foot;
use crate::global::surface::geometry::Geometry;
use crate::tolerance::{ON_BORDER, ORTHOGONAL, ORTHOGONAL_FLOOR, SAME_POINT};
use nalgebra::Vector3;
use nurbs_core::SurfaceJet;

/// Places on every parameter line through a pole that are looked at, per patch.
const LINES: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

/// How often a walk changes sides.
pub(in crate::global) const ROUNDS: usize = 16;

/// Relative decrease of the squared distance for which a side is changed.
pub(in crate::global) const WORTH: f64 = 1e-14;

/// Where a walk ended.
pub(crate) struct Walk {
    pub(crate) foot: Foot,
    pub(crate) jet: SurfaceJet,
    /// Whether the distance falls on another side of the foot, which the limit on steps kept the walk from taking.
    pub(crate) falls_beyond: bool,
}

impl Geometry {
    /// Follows the distance downhill from a place, across borders of any kind and poles.
    #[inline(always)]
    pub(crate) fn follow(&self, x: &Vector3<f64>, start: (usize, [f64; 2]), max_steps: u32) -> Walk {
        let (patch, local) = self.best_side(x, start);
        let (foot, jet) = self.descend_to_jet(x, patch, local, max_steps);
        self.go_on(x, foot, jet, max_steps)
    }

    /// The side of a place from which the distance falls most.
    #[inline(always)]
    pub(crate) fn best_side(&self, x: &Vector3<f64>, place: (usize, [f64; 2])) -> (usize, [f64; 2]) {
        if !self.may_have_sides(place) {
            return place;
        }
        self.steeper_side(x, place).unwrap_or(place)
    }

    /// Takes a walk that has ended on a border on to the other sides, as long as the distance falls there.
    #[inline(always)]
    pub(crate) fn go_on(&self, x: &Vector3<f64>, foot: Foot, jet: SurfaceJet, max_steps: u32) -> Walk {
        if !self.may_have_sides((foot.patch, foot.local)) {
            return Walk { foot, jet, falls_beyond: false };
        }
        self.change_sides(x, foot, jet, max_steps)
    }

    #[cold]
    fn change_sides(&self, x: &Vector3<f64>, mut foot: Foot, mut jet: SurfaceJet, max_steps: u32) -> Walk {
        for _ in 0..ROUNDS {
            let Some((patch, local)) = self.steeper_side(x, (foot.patch, foot.local)) else {
                return Walk { foot, jet, falls_beyond: false };
            };
            if foot.steps >= max_steps {
                break;
            }
            let (mut found, there) = self.descend_to_jet(x, patch, local, max_steps - foot.steps);
            found.steps += foot.steps;
            if found.distance_sq >= foot.distance_sq * (1.0 - WORTH) {
                // The fall was one of rounding errors.
                return Walk { foot: Foot { steps: found.steps, ..foot }, jet, falls_beyond: false };
            }
            (foot, jet) = (found, there);
        }
        Walk { foot, jet, falls_beyond: true }
    }

    /// Whether a place lies where a patch may meet others in a kink, a seam or a pole.
    #[inline(always)]
    fn may_have_sides(&self, (index, local): (usize, [f64; 2])) -> bool {
        let inside = |s: f64| s > 0.0 && s < 1.0;
        if inside(local[0]) && inside(local[1]) {
            return false;
        }
        let patch = &self.patches[index];
        let cells = &self.cells[patch.shape()];
        (0..2).any(|d| {
            let end = usize::from(local[d] > 0.5);
            !inside(local[d])
                && (!cells.at_end(patch.cell(), d, end) || cells.closed[d] || cells.collapsed[d][end])
        })
    }

    /// The side of a place from which the distance falls most, if it falls more there than on the side given.
    #[cold]
    fn steeper_side(&self, x: &Vector3<f64>, (index, local): (usize, [f64; 2])) -> Option<(usize, [f64; 2])> {
        let here = self.place(index, local);
        let distance = (here - x).norm();
        let noise = (ORTHOGONAL * distance).max(ORTHOGONAL_FLOOR * self.size);
        let fall = |(index, local)| {
            let fall = self.fall(x, index, local);
            if fall > noise { fall } else { 0.0 }
        };
        let mut best = (fall((index, local)) * (1.0 + 1e-9), None);
        for side in self.around(index, local) {
            if (self.place(side.0, side.1) - here).norm() <= SAME_POINT * self.size {
                let fall = fall(side);
                if fall > best.0 {
                    best = (fall, Some(side));
                }
            }
        }
        best.1
    }

    /// How fast the distance to `x` falls, per length, on the way that a patch offers at a place, times the distance.
    fn fall(&self, x: &Vector3<f64>, index: usize, local: [f64; 2]) -> f64 {
        let patch = &self.patches[index];
        let jet = self.jet(patch, local[0], local[1]);
        let r = jet.point - (x - patch.centre);
        let fall = |d: usize| {
            let tangent = if d == 0 { jet.du } else { jet.dv };
            let speed = tangent.norm();
            if speed <= STANDSTILL * self.size {
                return 0.0;
            }
            let slope = tangent.dot(&r) / speed;
            let end = usize::from(local[d] > 0.5);
            let at_border = local[d] <= 0.0 || local[d] >= 1.0;
            if at_border && self.cells[patch.shape()].across(patch.cell(), d, end).is_none() {
                (if end == 0 { -slope } else { slope }).max(0.0)
            } else {
                slope.abs()
            }
        };
        fall(0).hypot(fall(1))
    }

    /// The point at the local parameters of a patch.
    pub(crate) fn place(&self, index: usize, local: [f64; 2]) -> Vector3<f64> {
        let patch = &self.patches[index];
        self.point(patch, local[0], local[1]) + patch.centre
    }

    /// All places, by patch and local parameters, that may be the same point of the surface: those across borders, and at
    /// a pole some on every line through it.
    pub(crate) fn around(&self, index: usize, local: [f64; 2]) -> Vec<(usize, [f64; 2])> {
        let patch = &self.patches[index];
        let cells = &self.cells[patch.shape()];
        let mut options = [0, 1].map(|d| vec![(patch.cell()[d], local[d])]);
        let mut pole = None;
        for d in 0..2 {
            let end = usize::from(local[d] > 0.5);
            let border = end as f64;
            let at_end = cells.at_end(patch.cell(), d, end);
            let gap = (local[d] - border).abs();
            if at_end && cells.collapsed[d][end] {
                let jet = self.jet(patch, local[0], local[1]);
                let speed = if d == 0 { jet.du } else { jet.dv }.norm();
                if gap * speed <= 1e-9 * self.size {
                    options[d] = vec![(patch.cell()[d], border)];
                    pole = Some(d);
                    continue;
                }
            }
            if gap > ON_BORDER || (at_end && !cells.closed[d]) {
                continue;
            }
            let count = cells.counts[d];
            let beyond = if end == 0 { patch.cell()[d] + count - 1 } else { patch.cell()[d] + 1 } % count;
            options[d] = vec![(patch.cell()[d], border), (beyond, 1.0 - border)];
        }
        if let Some(d) = pole {
            let lines = |cell| LINES.map(|s| (cell, s));
            options[1 - d] = (0..cells.counts[1 - d]).flat_map(lines).collect();
        }
        let [u, v] = &options;
        let places = u.iter().flat_map(|&(row, s)| v.iter().map(move |&(column, t)| ([row, column], [s, t])));
        places.map(|(cell, local)| (cells.patch(cell), local)).collect()
    }
}
