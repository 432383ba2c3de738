//! The foot of a point on the zero set of a spline.

use super::grid::Grid;
use super::spline::GridSpline;
use crate::implicit::{LagrangeStep, Taylor};
use footpoint::Status;
use nalgebra::SVector;

/// Limit of the iteration to a foot.
const MAX_STEPS: usize = 40;
/// Longest step, in cells: seeds are at most one cell from the feet that they lead to.
const LONGEST: f64 = 1.0;
/// Steps towards a foot along tangents, and steps back to the zero set after each of them.
const TANGENT_STEPS: usize = 12;
const STEPS_BACK: usize = 6;
/// Longest step of these, in cells.
const SHORT: f64 = 0.4;
/// A residual, as a share of the size of the grid, that counts as none.
const SETTLED: f64 = 1e-13;
/// Distance from the zero set, in cells, at which a place is on it.
const RETURNED: f64 = 1e-9;
/// Gradient, as a share of the largest value per cell, below which a point of the zero set is singular.
const SINGULAR: f64 = 1e-9;

/// A place on the zero set.
pub(crate) struct Foot<const D: usize> {
    /// In units of the spacing.
    pub(crate) place: SVector<f64, D>,
    /// The spline there, derivatives by the coordinates.
    pub(crate) taylor: Taylor<D>,
    /// How it was found.
    pub(crate) status: Status,
}

/// The zero set of the spline through the values of a grid.
pub(crate) struct ZeroSet<'a, const D: usize> {
    pub(crate) grid: &'a Grid<D>,
    pub(crate) spline: &'a GridSpline<D>,
    /// Largest jump of the values between neighbouring nodes.
    pub(crate) jump: f64,
    /// Size of the zero set.
    pub(crate) size: f64,
}

impl<const D: usize> ZeroSet<'_, D> {
    /// Value and derivatives by the coordinates.
    pub(crate) fn taylor(&self, place: &SVector<f64, D>) -> Taylor<D> {
        let mut t = self.spline.taylor(place);
        let h = self.grid.spacing();
        t.gradient.component_div_assign(h);
        for i in 0..D {
            for j in 0..D {
                t.hessian[(i, j)] /= h[i] * h[j];
            }
        }
        t
    }

    /// Solves `min |x − y|²` subject to `f(y) = 0` by Newton's method on the equations of Lagrange, from a place nearby.
    pub(crate) fn foot(&self, x: &SVector<f64, D>, start: &SVector<f64, D>) -> Foot<D> {
        let mut place = *start;
        let counts = self.grid.counts();
        let longest = LONGEST * self.grid.spacing().min();
        let mut taylor = self.taylor(&place);
        for _ in 0..MAX_STEPS {
            let slope = taylor.gradient.norm();
            // False for NaN too.
            let steep = slope * longest > SINGULAR * self.jump;
            if !steep {
                return Foot { place, taylor, status: Status::Stalled };
            }
            let residual = x - self.grid.point(&place);
            let LagrangeStep { along, across, mut step, .. } = taylor.lagrange_step(&residual);
            if along.norm().max(across.abs()) <= SETTLED * (self.size + residual.norm()) {
                return Foot { place, taylor, status: Status::Converged };
            }
            let length = step.norm();
            if !length.is_finite() {
                return Foot { place, taylor, status: Status::Diverged };
            }
            if length > longest {
                step *= longest / length;
            }
            let target = place + step.component_div(self.grid.spacing());
            let next = SVector::from_fn(|d, _| target[d].clamp(0.0, (counts[d] - 1) as f64));
            if next == place {
                let on_border = next != target;
                let status = if on_border { Status::OnBoundary } else { Status::Converged };
                return Foot { place, taylor, status };
            }
            place = next;
            taylor = self.taylor(&place);
        }
        // At the border of the grid the iteration slides along it: the zero set ends there.
        let border = (0..D).any(|d| place[d] == 0.0 || place[d] == (counts[d] - 1) as f64);
        Foot { place, taylor, status: if border { Status::OnBoundary } else { Status::MaxIterations } }
    }

    /// A place of the zero set nearer to a point than a given one, on the way along tangents with a return to the zero set after each step.
    ///
    /// Where the zero set bends within a cell, Newton's method leaves the region in which it converges; short steps do not.
    pub(crate) fn nearer(&self, x: &SVector<f64, D>, start: &SVector<f64, D>) -> SVector<f64, D> {
        let h = self.grid.spacing();
        let counts = self.grid.counts();
        let limited = |step: SVector<f64, D>, most: f64| {
            let length = step.norm();
            if length > most { step * (most / length) } else { step }
        };
        let moved = |place: &SVector<f64, D>, step: &SVector<f64, D>| -> SVector<f64, D> {
            let target = place + step.component_div(h);
            SVector::from_fn(|d, _| target[d].clamp(0.0, (counts[d] - 1) as f64))
        };
        let far = |place: &SVector<f64, D>| (x - self.grid.point(place)).norm();
        let mut most = SHORT * h.min();
        let (mut best, mut least) = (*start, far(start));
        for _ in 0..TANGENT_STEPS {
            let taylor = self.taylor(&best);
            let normal = taylor.gradient / taylor.gradient.norm();
            let residual = x - self.grid.point(&best);
            let along = residual - normal * residual.dot(&normal);
            let mut place = moved(&best, &limited(along, most));
            for _ in 0..STEPS_BACK {
                let taylor = self.taylor(&place);
                let step = taylor.gradient * (-taylor.value / taylor.gradient.norm_squared());
                place = moved(&place, &limited(step, most));
            }
            let taylor = self.taylor(&place);
            let is_on = taylor.value.abs() <= RETURNED * taylor.gradient.norm() * h.min();
            let distance = far(&place);
            // False for what is not a number too.
            if is_on && distance < least {
                (best, least) = (place, distance);
            } else {
                most *= 0.5;
            }
        }
        best
    }
}
