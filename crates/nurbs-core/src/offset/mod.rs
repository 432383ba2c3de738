//! Offset curves and surfaces, evaluated exactly.
//!
//! The offset of a shape at the signed distance `d` is `c + d n` with its unit normal `n`. Its second
//! derivatives need the third ones of the base, which [`ThirdOrderCurve`] and [`ThirdOrderSurface`] give.
//!
//! Where the base is not regular it has no normal, and so the offset no point: all numbers of the jet are
//! NaN there (`try_jet` gives `None`). Where `d` equals a radius of curvature the offset itself is singular,
//! beyond it its direction is reversed; self-intersections stay in.

mod curve;
mod surface;

use crate::Break;

pub use curve::{OffsetCurve, ThirdOrderCurve};
pub use surface::{OffsetSurface, SurfaceThird, ThirdOrderSurface};

/// Breaks of an offset from the breaks of its base: the normal costs one order of smoothness.
fn breaks_of_offset(knots: Vec<f64>, base: Vec<Break>) -> Vec<Break> {
    let mut breaks: Vec<Break> =
        base.iter().map(|b| Break { continuity: b.continuity.saturating_sub(1), ..*b }).collect();
    // Knots that are no breaks of the base: its third derivative may jump there.
    let smooth = knots.into_iter().filter(|&t| base.iter().all(|b| b.parameter != t));
    breaks.extend(smooth.map(|parameter| Break { parameter, continuity: 1 }));
    breaks.sort_by(|a, b| a.parameter.total_cmp(&b.parameter));
    breaks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_is_once_less_smooth() {
        let base = vec![Break { parameter: 0.5, continuity: 1 }, Break { parameter: 0.75, continuity: 0 }];
        let breaks = breaks_of_offset(vec![0.25, 0.5, 0.75], base);
        let found: Vec<_> = breaks.iter().map(|b| (b.parameter, b.continuity)).collect();
        assert_eq!(found, [(0.25, 1), (0.5, 0), (0.75, 0)]);
    }
}
