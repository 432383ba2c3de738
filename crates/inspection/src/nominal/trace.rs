//! Where a line meets smooth surfaces: steps that miss nothing, and Newton's method at the end.
//!
//! No point of the shape lies within the distance `d(y)` of a point `y`, so that a step of that length along the line
//! jumps over none (sphere tracing, \[Ha96\]). From the point to be measured both senses are followed, the shorter one
//! first, until they have passed a crossing that Newton's method has found from one of the footpoints on the way; it is
//! then the nearest one.

use super::signed;
use crate::{Deviation, Outcome, Place};
use footpoint::Facing;
use nalgebra::{Matrix3, Point3, Vector3};
use nurbs_core::{Aabb, Interval, SurfaceJet};

/// Steps along the line before a proof is given up.
const MAX_STEPS: usize = 400;
/// Steps of Newton's method.
const MAX_ITERATIONS: usize = 30;
/// Share of the size of the model that counts as nothing.
const NOTHING: f64 = 1e-10;
/// How far from a point of the line that is within nothing of the shape a crossing may be, in units of nothing.
const CLOSE_BY: f64 = 1e4;
/// How much larger than its slack the gap of a proven crossing may be.
const PROVEN: f64 = 4.0;
/// Share of a domain within which a parameter counts as its end.
const END: f64 = 1e-9;
/// Share of the offset of a crossing within which another one may be nearer.
const RELATIVE_SLACK: f64 = 1e-7;

/// The closest point of a shape, and a distance that is proven.
pub(super) struct Near {
    pub(super) bound: f64,
    pub(super) shape: usize,
    pub(super) parameter: [f64; 2],
    pub(super) point: Vector3<f64>,
}

/// Smooth surfaces that can be traced.
pub(super) trait Traceable {
    /// The closest point; `None` for a query so far away that distances overflow.
    fn near(&self, x: &Vector3<f64>) -> Option<Near>;
    fn jet(&self, shape: usize, parameter: [f64; 2]) -> SurfaceJet;
    /// Domain and periods.
    fn domain(&self, shape: usize) -> ([Interval; 2], [Option<f64>; 2]);
    /// A box that holds all surfaces.
    fn bounds(&self) -> &Aabb<3>;
    /// The closest point among those where the normal agrees, if there is one.
    fn facing_near(&self, x: &Vector3<f64>, facing: &Facing) -> Option<Near>;
}

/// A point that line and shape have in common.
#[derive(Clone, Copy)]
struct Hit {
    offset: f64,
    shape: usize,
    parameter: [f64; 2],
    jet: SurfaceJet,
}

/// What following a line has shown.
struct Traced {
    hit: Option<Hit>,
    /// Up to this absolute offset there is proven to be no other hit that counts.
    free: f64,
    /// The smallest absolute offset of a hit that does not count, infinite without any.
    refused: f64,
}

/// The deviation of `x` along a line in a direction of length 1, followed up to `reach` in both senses, to where the normal
/// agrees with a direction if one is given.
pub(super) fn along<T: Traceable>(
    surfaces: &T,
    x: &Point3<f64>,
    direction: &Vector3<f64>,
    reach: f64,
    facing: Option<&Facing>,
) -> Deviation {
    let Some([start, end]) = inside(surfaces.bounds(), &x.coords, direction, reach) else {
        return Deviation::none(Outcome::NoHit);
    };
    let size = surfaces.bounds().diagonal();
    let line = Line { surfaces, x: x.coords, direction: *direction, nothing: NOTHING * size, facing };
    let (hit, free, refused) = match line.nearest(start, end) {
        Traced { hit: Some(hit), free, refused } => (hit, free, refused),
        Traced { hit: None, free, .. } if free < f64::INFINITY => {
            return Deviation::none(Outcome::NotConverged);
        }
        Traced { refused, .. } if refused == f64::INFINITY => return Deviation::none(Outcome::NoHit),
        // Whether there is another crossing, too far away, makes a difference.
        Traced { .. } if reach < f64::INFINITY => {
            return along(surfaces, x, direction, f64::INFINITY, facing);
        }
        Traced { .. } => return Deviation::none(Outcome::NoMatchingFoot),
    };
    let normal = hit.jet.unit_normal().unwrap_or_default();
    let distance = signed(hit.offset.abs(), &(direction * -hit.offset), &normal);
    let (place, on_boundary) = place(surfaces, &hit);
    let gap = (hit.offset.abs() - free).max(0.0);
    let is_proven = gap <= PROVEN * (line.nothing + RELATIVE_SLACK * hit.offset.abs());
    Deviation {
        outcome: if is_proven { Outcome::Measured } else { Outcome::Undecided },
        foot: hit.jet.point.into(),
        normal,
        distance,
        gap,
        parameter: hit.parameter,
        shape: u32::try_from(hit.shape).unwrap_or(u32::MAX),
        triangle: u32::MAX,
        place,
        corner: 0,
        on_boundary,
        is_restricted: refused < hit.offset.abs(),
    }
}

/// A hit ends on the boundary with a probability of nothing; where it does, the point is not beyond the shape.
fn place<T: Traceable>(surfaces: &T, hit: &Hit) -> (Place, bool) {
    let (domain, period) = surfaces.domain(hit.shape);
    let at_end = |axis: usize| {
        let value = hit.parameter[axis];
        period[axis].is_none() && (value <= domain[axis].start() || value >= domain[axis].end())
    };
    let place = match (at_end(0), at_end(1)) {
        (true, true) => Place::Corner,
        (false, false) => Place::Interior,
        _ => Place::Edge,
    };
    (place, false)
}

/// Between which offsets the line is in the box, grown by a little, and within reach.
fn inside(bounds: &Aabb<3>, x: &Vector3<f64>, direction: &Vector3<f64>, reach: f64) -> Option<[f64; 2]> {
    let margin = 1e-9 * (bounds.diagonal() + bounds.min.amax().max(bounds.max.amax()));
    let (mut start, mut end) = (-reach, reach);
    for axis in 0..3 {
        let (low, high) = (bounds.min[axis] - margin - x[axis], bounds.max[axis] + margin - x[axis]);
        if direction[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (low / direction[axis], high / direction[axis]);
        start = start.max(a.min(b));
        end = end.min(a.max(b));
    }
    (start <= end && start.is_finite() && end.is_finite()).then_some([start, end])
}

struct Line<'a, T> {
    surfaces: &'a T,
    x: Vector3<f64>,
    direction: Vector3<f64>,
    /// A length that counts as nothing.
    nothing: f64,
    /// What the normal at a hit that counts agrees with.
    facing: Option<&'a Facing>,
}

impl<T: Traceable> Line<'_, T> {
    /// The nearest hit between two offsets.
    fn nearest(&self, start: f64, end: f64) -> Traced {
        let mut best: Option<Hit> = None;
        // What has been passed in either sense, as absolute offsets; a line may enter the box at a distance only.
        let mut passed = [(-end).max(0.0), start.max(0.0)];
        let limits = [-start, end];
        let mut refused = f64::INFINITY;
        // Behind a hit that does not count steps are short again.
        let most = if self.facing.is_some() { 4 * MAX_STEPS } else { MAX_STEPS };
        for _ in 0..most {
            let goal = |sense: usize| best.map_or(limits[sense], |hit| limits[sense].min(hit.offset.abs()));
            let slack = self.nothing.max(best.map_or(0.0, |hit| RELATIVE_SLACK * hit.offset.abs()));
            let open = |sense: usize| passed[sense] < goal(sense) - if best.is_some() { slack } else { 0.0 };
            let sense = match (open(0), open(1)) {
                (false, false) => break,
                (true, false) => 0,
                (false, true) => 1,
                (true, true) => usize::from(passed[1] < passed[0]),
            };
            let offset = if sense == 0 { -passed[0] } else { passed[1] };
            let Some(near) = self.surfaces.near(&(self.x + self.direction * offset)) else { break };
            let crossing = self.newton(&near);
            if let Some(hit) = crossing
                && (start - slack..=end + slack).contains(&hit.offset)
                && best.is_none_or(|best| hit.offset.abs() < best.offset.abs())
            {
                match self.counted(&hit) {
                    Some(hit) => best = Some(hit),
                    None => refused = refused.min(hit.offset.abs()),
                }
            }
            if near.bound <= self.nothing {
                // The line meets the shape here, or touches it: if Newton's method finds no crossing close by, where a
                // flat angle delays it, this is the point.
                let is_crossed =
                    crossing.is_some_and(|hit| (hit.offset - offset).abs() <= CLOSE_BY * self.nothing);
                if !is_crossed && best.is_none_or(|hit| hit.offset.abs() > passed[sense] + self.nothing) {
                    let jet = self.surfaces.jet(near.shape, near.parameter);
                    let distance = (self.x + self.direction * offset - near.point).norm();
                    if distance <= self.nothing {
                        let hit = Hit { offset, shape: near.shape, parameter: near.parameter, jet };
                        match self.counted(&hit) {
                            Some(hit) => best = Some(hit),
                            None => refused = refused.min(hit.offset.abs()),
                        }
                    }
                }
                passed[sense] += self.nothing;
            } else {
                passed[sense] += near.bound;
            }
        }
        let free = |sense: usize| if passed[sense] >= limits[sense] { f64::INFINITY } else { passed[sense] };
        Traced { hit: best, free: free(0).min(free(1)), refused }
    }

    /// The hit, if the normal there agrees; on a border, that of another surface through the same point counts as well.
    fn counted(&self, hit: &Hit) -> Option<Hit> {
        let Some(facing) = self.facing else { return Some(*hit) };
        if facing.agrees(&hit.jet.normal_direction()) {
            return Some(*hit);
        }
        let (domain, _) = self.surfaces.domain(hit.shape);
        let at_end = |axis: usize| {
            let slack = END * domain[axis].length();
            hit.parameter[axis] - domain[axis].start() <= slack
                || domain[axis].end() - hit.parameter[axis] <= slack
        };
        if !(at_end(0) || at_end(1)) {
            return None;
        }
        let near = self.surfaces.facing_near(&hit.jet.point, facing)?;
        let is_same = (near.point - hit.jet.point).norm() <= CLOSE_BY * self.nothing;
        let jet = self.surfaces.jet(near.shape, near.parameter);
        (is_same && facing.agrees(&jet.normal_direction())).then_some(Hit {
            shape: near.shape,
            parameter: near.parameter,
            jet,
            ..*hit
        })
    }

    /// Solves `s(u, v) = x + t · direction` from the parameters of a footpoint.
    fn newton(&self, near: &Near) -> Option<Hit> {
        let (domain, period) = self.surfaces.domain(near.shape);
        let mut parameter = near.parameter;
        let mut jet = self.surfaces.jet(near.shape, parameter);
        let mut offset = (near.point - self.x).dot(&self.direction);
        let rounding = 8.0 * f64::EPSILON * (self.x.amax() + offset.abs() + jet.point.amax());
        let mut residual = self.x + self.direction * offset - jet.point;
        for _ in 0..MAX_ITERATIONS {
            let size = residual.norm();
            if size <= rounding {
                break;
            }
            let matrix = Matrix3::from_columns(&[jet.du, jet.dv, -self.direction]);
            let step = matrix.lu().solve(&residual)?;
            let mut moved = parameter;
            for axis in 0..2 {
                moved[axis] = parameter[axis] + step[axis];
                match period[axis] {
                    Some(period) => {
                        moved[axis] =
                            domain[axis].start() + (moved[axis] - domain[axis].start()).rem_euclid(period);
                    }
                    // A hit beyond the boundary is none, but the way to one inside may touch the boundary.
                    None => moved[axis] = moved[axis].clamp(domain[axis].start(), domain[axis].end()),
                }
            }
            let next = self.surfaces.jet(near.shape, moved);
            let next_offset = (next.point - self.x).dot(&self.direction);
            let next_residual = self.x + self.direction * next_offset - next.point;
            if next_residual.norm().is_nan() || next_residual.norm() >= size {
                break;
            }
            (parameter, jet, offset, residual) = (moved, next, next_offset, next_residual);
        }
        let tolerance = rounding.max(1e-3 * self.nothing);
        (residual.norm() <= tolerance).then_some(Hit { offset, shape: near.shape, parameter, jet })
    }
}
