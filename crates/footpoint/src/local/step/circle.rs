//! Projection onto a curvature circle in closed form.
//!
//! In the plane of the circle let the current point be the origin, the tangent the first axis and the
//! direction of the centre the second; the test point is `(L, ν)`, the curvature `κ`. With `m = 1 − κν`
//! and `h = √((κL)² + m²)` (distance of the test point from the centre, in radii) the foot on the
//! circle is
//!
//! ```text
//! q = ( L/h , (1 − m/h)/κ ),     |q|² = L² · 2/(h(h+m)) .
//! ```
//!
//! Neither the centre nor the limit `κ → 0` needs to be treated: for a straight line `h = m = 1`.

/// The circle at a point, seen from the test point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circle {
    /// `κL`.
    turn: f64,
    /// `m = 1 − κν`.
    m: f64,
    /// `h`.
    h: f64,
}

impl Circle {
    /// From `L`, `κ` and `κν`.
    pub(crate) fn new(tangential: f64, curvature: f64, offset: f64) -> Self {
        let (turn, m) = (curvature * tangential, 1.0 - offset);
        Self { turn, m, h: f64::hypot(turn, m) }
    }

    /// `⟨q, tangent⟩ / L = 1/h`; 1 (the first order step) at the centre, where every point is a foot.
    pub(crate) fn tangential_factor(&self) -> f64 {
        if self.h > 0.0 { 1.0 / self.h } else { 1.0 }
    }

    /// `|q| / |L|`, the chord that stands for `Δt` in [HW05, eq. (7)]; 1 at the centre.
    ///
    /// Beyond the centre (`m < 0`) the foot is on the far side, where the sum `h + m` cancels.
    pub(crate) fn chord_factor(&self) -> f64 {
        if self.h == 0.0 {
            1.0
        } else if self.m >= 0.0 {
            (2.0 / (self.h * (self.h + self.m))).sqrt()
        } else {
            (2.0 * (self.h - self.m) / self.h).sqrt() / self.turn.abs()
        }
    }

    /// `|q|² / (2 L²) = 1/(h(h+m))`; 0 at the centre.
    pub(crate) fn half_square_factor(&self) -> f64 {
        if self.h == 0.0 {
            0.0
        } else if self.m >= 0.0 {
            1.0 / (self.h * (self.h + self.m))
        } else {
            (self.h - self.m) / (self.h * self.turn * self.turn)
        }
    }
}
