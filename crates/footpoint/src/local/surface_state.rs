//! A point of a surface as the bounded iteration sees it.

use super::axis::{Axis, Cell};
use super::curve::VANISHING;
use super::options::residual_noise;
use super::step::{Tangent, parameter_line, surface_tangent};
use nalgebra::Vector3;
use nurbs_core::{CurveJet, ParametricSurface, SurfaceJet};

/// A surface point, seen from inside one smooth cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Here {
    pub(crate) cells: [Cell; 2],
    /// Parameters in terms of the cells.
    pub(crate) at: [f64; 2],
    pub(crate) jet: SurfaceJet,
    /// `w = x − s`.
    pub(crate) residual: Vector3<f64>,
    pub(crate) distance: f64,
    /// Expected rounding error of the residual.
    pub(crate) noise: f64,
    /// Whether `s_u`, `s_v` vanish.
    pub(crate) dead: [bool; 2],
    /// `⟨w, s_u⟩/|s_u|` and `⟨w, s_v⟩/|s_v|`, 0 where the derivative vanishes.
    pub(crate) slopes: [f64; 2],
    pub(crate) tangent: Tangent,
}

impl Here {
    pub(crate) fn new<S: ParametricSurface + ?Sized>(
        surface: &S,
        axes: &[Axis; 2],
        x: &Vector3<f64>,
        cells: [Cell; 2],
        at: [f64; 2],
    ) -> Self {
        let [u, v] = [0, 1].map(|k| axes[k].evaluation(&cells[k], at[k]));
        let jet = surface.jet(u, v);
        let residual = x - jet.point;
        let lines = [0, 1].map(|k| parameter_line(&jet, k));
        let travel = [0, 1].map(|k| lines[k].d1.norm() * axes[k].domain.length());
        let magnitude = jet.point.norm();
        // Rounding of a derivative is that of the control points, which are as large as the point or as
        // far from it as the other derivative reaches.
        let dead = [0, 1].map(|k| travel[k] <= VANISHING * (magnitude + travel[1 - k]));
        let slopes =
            [0, 1].map(|k| if dead[k] { 0.0 } else { residual.dot(&lines[k].d1) / lines[k].d1.norm() });
        Self {
            cells,
            at,
            residual,
            distance: residual.norm(),
            noise: residual_noise(magnitude + x.norm()),
            dead,
            slopes,
            tangent: surface_tangent(&jet),
            jet,
        }
    }

    /// Whether a parameter is at an end of its cell.
    pub(crate) fn at_end(&self, k: usize) -> bool {
        let [low, high] = self.cells[k].at(self.at[k]);
        low || high
    }

    /// Whether a bound of the cell is active: the distance does not decrease towards the inside.
    pub(crate) fn blocked(&self, k: usize) -> bool {
        let [low, high] = self.cells[k].at(self.at[k]);
        (low && self.slopes[k] <= 0.0) || (high && self.slopes[k] >= 0.0)
    }

    /// By how much the optimality condition of one parameter is violated, as a length.
    pub(crate) fn violation_along(&self, k: usize) -> f64 {
        if self.blocked(k) { 0.0 } else { self.slopes[k].abs() }
    }

    /// By how much the optimality conditions of the cell are violated, as a length: in the interior the
    /// tangential part of the residual.
    pub(crate) fn violation(&self) -> f64 {
        match self.tangent {
            Tangent::Plane(plane) if !(0..2).any(|k| self.dead[k] || self.at_end(k)) => {
                (self.residual - plane.normal * self.residual.dot(&plane.normal)).norm()
            }
            _ => self.violation_along(0).max(self.violation_along(1)),
        }
    }

    /// The jet of the parameter line in direction `k`.
    pub(crate) fn line(&self, k: usize) -> CurveJet<3> {
        parameter_line(&self.jet, k)
    }
}
