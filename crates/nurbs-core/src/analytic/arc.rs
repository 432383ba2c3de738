//! Circular arcs as rational quadratic B-splines.

use crate::{Error, Interval, KnotVector};
use std::f64::consts::FRAC_PI_2;

/// A control point of an arc of the unit circle: cosine, sine and weight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArcPoint {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) weight: f64,
}

/// Cosine and sine, exact at multiples of the quarter turn: poles and seams must not be off by rounding.
pub(crate) fn cos_sin(angle: f64) -> (f64, f64) {
    let quarter = (angle / FRAC_PI_2).round();
    if (angle - quarter * FRAC_PI_2).abs() > 4.0 * f64::EPSILON * angle.abs().max(1.0) {
        let (sine, cosine) = angle.sin_cos();
        return (cosine, sine);
    }
    match quarter.rem_euclid(4.0) {
        0.0 => (1.0, 0.0),
        1.0 => (0.0, 1.0),
        2.0 => (-1.0, 0.0),
        _ => (0.0, -1.0),
    }
}

/// Knots and control points of the arc of the unit circle over the given angles (one turn at most).
///
/// One quadratic piece for each quarter turn begun; knots are angles ([PT97, sec. 7.5]). The last control
/// point of a whole turn equals the first one exactly.
pub(crate) fn arc_net(arc: Interval) -> Result<(KnotVector, Vec<ArcPoint>), Error> {
    let pieces = [1.0, 2.0, 3.0, 4.0].into_iter().find(|n| arc.length() <= n * FRAC_PI_2 * (1.0 + 1e-9));
    let pieces = pieces.unwrap_or(4.0);
    let step = arc.length() / pieces;
    let cosine = cos_sin(step).0;
    let weight = (0.5 * (1.0 + cosine)).sqrt();
    let mut knots = vec![arc.start()];
    let mut net: Vec<ArcPoint> = Vec::new();
    let mut k = 0.0;
    while k <= pieces {
        let angle = if k == pieces { arc.end() } else { arc.start() + k * step };
        let (x, y) = cos_sin(angle);
        let next = match net.first() {
            Some(first) if k == pieces && super::is_full_turn(arc) => *first,
            _ => ArcPoint { x, y, weight: 1.0 },
        };
        if let Some(last) = net.last().copied() {
            // Where the tangents at the two ends meet.
            let scale = 1.0 / (1.0 + cosine);
            net.push(ArcPoint { x: (last.x + next.x) * scale, y: (last.y + next.y) * scale, weight });
        }
        net.push(next);
        knots.extend([angle; 2]);
        k += 1.0;
    }
    knots.push(arc.end());
    Ok((KnotVector::new(2, knots)?, net))
}
