//! Collapsed edges: a whole parameter line on one point.
//!
//! At a pole the parameter along the collapsed edge has no effect, but it is the direction in which the
//! other parameter leaves. The point is a footpoint if the distance decreases in none of these
//! directions, whatever the value of that parameter.

use super::axis::{Axis, Side};
use super::curve::VANISHING;
use super::surface_state::Here;
use nalgebra::Vector3;
use nurbs_core::ParametricSurface;

/// Directions looked at before the best is refined.
const DIRECTIONS: usize = 24;

/// Steps of the refinement by golden sections: each gains a factor of 0.618.
const REFINEMENTS: usize = 40;

/// What a survey of all directions at a pole found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pole {
    /// The pole, with the parameter along the collapsed edge set to the direction of steepest descent.
    pub(crate) steepest: Here,
    /// Rate at which the distance decreases in that direction, in terms of the residual: `⟨w, direction⟩`.
    pub(crate) slope: f64,
    /// The smallest of all such rates.
    pub(crate) least_slope: f64,
}

/// Surveys the directions at a point where the derivative of parameter `dead` vanishes.
///
/// `None` if it is not a pole: the parameter line does not stay at the point.
pub(crate) fn survey<S: ParametricSurface + ?Sized>(
    surface: &S,
    axes: &[Axis; 2],
    x: &Vector3<f64>,
    here: &Here,
    dead: usize,
) -> Option<Pole> {
    let (axis, other) = (&axes[dead], 1 - dead);
    let [low, high] = here.cells[other].at(here.at[other]);
    let look = |t: f64| {
        let (cell, t) = axis.cell(t, Side::Above);
        let (mut cells, mut at) = (here.cells, here.at);
        cells[dead] = cell;
        at[dead] = t;
        let there = Here::new(surface, axes, x, cells, at);
        let slope = there.slopes[other];
        // Inwards from an end; both ways if the collapsed line lies inside the domain.
        (
            there,
            if low && !high {
                slope
            } else if high && !low {
                -slope
            } else {
                slope.abs()
            },
        )
    };
    let parameter = |i: usize| axis.domain.lerp(i as f64 / DIRECTIONS as f64);
    let (mut best, mut slope, mut least_slope) = (0, f64::NEG_INFINITY, f64::INFINITY);
    for i in 0..=DIRECTIONS {
        let (there, s) = look(parameter(i));
        let magnitude = there.jet.point.norm() + there.line(other).d1.norm() * axes[other].domain.length();
        if (there.jet.point - here.jet.point).norm() > VANISHING * magnitude {
            return None;
        }
        if s > slope {
            (best, slope) = (i, s);
        }
        least_slope = least_slope.min(s);
    }
    let (mut a, mut b) = (parameter(best.saturating_sub(1)), parameter((best + 1).min(DIRECTIONS)));
    let (mut steepest, _) = look(parameter(best));
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..REFINEMENTS {
        let (p, q) = (b - ratio * (b - a), a + ratio * (b - a));
        let ((at_p, slope_p), (at_q, slope_q)) = (look(p), look(q));
        let (candidate, s) = if slope_p >= slope_q { (at_p, slope_p) } else { (at_q, slope_q) };
        if slope_p >= slope_q {
            b = q;
        } else {
            a = p;
        }
        if s > slope {
            (steepest, slope) = (candidate, s);
        }
    }
    Some(Pole { steepest, slope, least_slope })
}
