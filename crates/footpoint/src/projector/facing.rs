//! The nearest foot among those where the normal agrees with a direction.
//!
//! The nearest point of all is the answer if a normal there agrees. Otherwise all local minima of the distance up to a limit
//! are listed, and the limit grows until one of them agrees or nothing of the model is left beyond. The list is proven to
//! hold every minimum, so that the answer is certified among the feet that count.

use super::classify::outward;
use crate::global::gap::Gap;
use crate::global::surface::foot::Foot;
use crate::global::surface::patch::PatchSet;
use crate::tolerance::SAME_POINT;
use crate::{Facing, ProjectionOptions, Status, SurfaceFootpoint};
use nalgebra::Vector3;

/// The first limit of the distance, as a multiple of that of the nearest point and a share of the size of the model.
const FIRST: [f64; 2] = [2.0, 0.01];
/// Factor by which the limit grows.
const GROWTH: f64 = 4.0;
/// Relative difference of distances that a continuum of feet may have.
const LEVEL: f64 = 1e-7;

/// How far a query is moved to tell the feet of a continuum apart, as shares of their distance.
const MOVES: [f64; 3] = [1e-2, 1e-4, 1e-6];

/// What was found up to a limit of the distance.
struct Listed {
    best: Option<SurfaceFootpoint>,
    /// No foot that counts is nearer than this.
    bound: f64,
}

/// The foot that counts, when `nearest` is the nearest point of all.
pub(super) fn restricted<const K: usize>(
    set: &PatchSet<K>,
    x: &Vector3<f64>,
    nearest: &SurfaceFootpoint,
    facing: &Facing,
    options: &ProjectionOptions,
) -> SurfaceFootpoint {
    if !nearest.distance.is_finite() || nearest.shape >= set.cells.len() {
        return *nearest;
    }
    let (cell, local) = set.cells[nearest.shape].locate(nearest.parameter);
    let place = (set.cells[nearest.shape].patch(cell), local);
    match set.facing_side(place, facing) {
        Some(side) if side == place => return *nearest,
        Some((patch, local)) => {
            let foot = Foot { patch, local, distance_sq: nearest.distance.powi(2), steps: 0, settled: true };
            let out = set.finish(x, &foot);
            return SurfaceFootpoint {
                lower_bound: nearest.lower_bound.min(out.distance),
                multiplicity: nearest.multiplicity,
                iterations: nearest.iterations,
                // The foot was judged with all its sides.
                status: nearest.status,
                ..out
            };
        }
        None => {}
    }
    let gap = Gap::new(options, set.size);
    // No point of the model is farther away than its nearest point and its diagonal together.
    let farthest = 1.001 * (nearest.distance + 2.0 * set.size);
    let mut limit = FIRST[0] * nearest.distance + FIRST[1] * set.size;
    loop {
        limit = limit.min(farthest);
        let Listed { best, bound } = set.feet_facing(x, limit, nearest, facing, &gap);
        match best {
            Some(best) if best.distance <= limit => {
                // Numbers of a foot are exact up to the gap that is allowed anyhow.
                let bound = bound.min(gap.limit_sq(best.distance.powi(2)).sqrt());
                return SurfaceFootpoint { lower_bound: bound.max(0.0), ..best };
            }
            _ if limit >= farthest => {
                return SurfaceFootpoint {
                    status: Status::NoMatchingFoot,
                    lower_bound: bound,
                    ..SurfaceFootpoint::invalid()
                };
            }
            _ => limit *= GROWTH,
        }
    }
}

impl<const K: usize> PatchSet<K> {
    /// The place itself, or the same point seen from another patch of its surface, if the normal there agrees.
    fn facing_side(&self, place: (usize, [f64; 2]), facing: &Facing) -> Option<(usize, [f64; 2])> {
        let agrees = |&(index, local): &(usize, [f64; 2])| {
            let patch = &self.patches[index];
            facing.agrees(&outward(local, &self.jet(patch, local[0], local[1])))
        };
        if agrees(&place) {
            return Some(place);
        }
        let here = self.place(place.0, place.1);
        let is_here =
            |side: &(usize, [f64; 2])| (self.place(side.0, side.1) - here).norm() <= SAME_POINT * self.size;
        self.around(place.0, place.1).into_iter().find(|side| is_here(side) && agrees(side))
    }

    /// The nearest of the feet up to a limit of the distance whose normals agree.
    fn feet_facing(
        &self,
        x: &Vector3<f64>,
        limit: f64,
        nearest: &SurfaceFootpoint,
        facing: &Facing,
        gap: &Gap,
    ) -> Listed {
        let harvest = self.minima(x, limit * limit, gap);
        let mut best: Option<SurfaceFootpoint> = None;
        let mut offer = |foot: &Foot| {
            let Some((patch, local)) = self.facing_side((foot.patch, foot.local), facing) else {
                return false;
            };
            let out = self.finish(x, &Foot { patch, local, ..*foot });
            let rank = |foot: &SurfaceFootpoint| (foot.distance, foot.shape, foot.parameter);
            let nearer = best.as_ref().is_none_or(|best| rank(&out) < rank(best));
            // The test of a minimum is the dearest one.
            if nearer && out.distance.is_finite() && self.is_minimum(x, foot) {
                best = Some(out);
            }
            true
        };
        for foot in &harvest.feet {
            offer(foot);
        }
        // Of whole curves and areas of feet only some points are known. The foot there whose normal agrees best lies in that
        // direction, or in the opposite one.
        let mut open = f64::INFINITY;
        let mut tried: Vec<f64> = Vec::new();
        for (foot, _) in &harvest.flats {
            let level = foot.distance_sq.sqrt();
            if !level.is_finite() || level > limit || offer(foot) {
                continue;
            }
            open = open.min(level * (1.0 - LEVEL));
            if tried.iter().any(|known| (known - level).abs() <= LEVEL * level) {
                continue;
            }
            tried.push(level);
            for sense in [1.0, -1.0] {
                if let Some(foot) = self.foot_towards(x, &(facing.direction() * sense), level, gap) {
                    offer(&foot);
                }
            }
        }
        let listed = best.as_ref().map_or(limit, |best| best.distance);
        let bound = if harvest.unresolved { nearest.lower_bound } else { listed.min(open) };
        Listed { best, bound }
    }

    /// The foot at a known distance that lies in a direction, among those of a continuum.
    ///
    /// A query that is moved a little in that direction has a single nearest foot there, and the less it is moved, the nearer that is
    /// to a foot of `x` itself. Where all points are as near, rounding alone would say which one is lower.
    fn foot_towards(
        &self,
        x: &Vector3<f64>,
        direction: &Vector3<f64>,
        level: f64,
        gap: &Gap,
    ) -> Option<Foot> {
        let moved = |share: f64| x + direction * (share * level);
        let there = moved(MOVES[0]);
        let found = self.scratch.with(|scratch| {
            let mut found = self.search(&there, true, gap, scratch);
            self.improve_open(&there, &mut found, gap, scratch);
            found.foot
        });
        if found.patch == usize::MAX {
            return None;
        }
        let foot = (MOVES[1..].iter())
            .fold(found, |foot, share| self.descend(&moved(*share), foot.patch, foot.local, 50));
        let distance_sq = self.distance_sq(x, foot.patch, foot.local);
        ((distance_sq.sqrt() - level).abs() <= LEVEL * level).then_some(Foot { distance_sq, ..foot })
    }
}
