//! Knots where the error is.

use crate::Error;
use distance_field::PrincipalFrame;
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, Direction, KnotVector};

/// Share of the spans with the largest excess that are halved at once, at least.
const SHARE: f64 = 0.35;
/// Points that must lie along a span for it to be halved.
const FEWEST: usize = 8;

/// The same surface with as many control points in u and v (not counting repetitions) as are asked for: knots are inserted in the
/// middle of the longest spans.
///
/// # Errors
/// [`Error::Option`] when it has more of them already: knots of a surface that does not need them are removed by
/// [`BsplineSurface::remove_all_within`].
pub fn with_controls(surface: BsplineSurface, controls: [usize; 2]) -> Result<BsplineSurface, Error> {
    let mut result = surface;
    for (d, direction) in [Direction::U, Direction::V].into_iter().enumerate() {
        let knots = [result.knots_u(), result.knots_v()][d];
        let Some(missing) = controls[d].checked_sub(knots.distinct_count()) else {
            let value = controls[d] as f64;
            let allowed = "at least as many as the start has in each direction";
            return Err(Error::Option { name: "controls", value, allowed });
        };
        let mut pieces: Vec<(f64, f64)> = knots
            .spans()
            .map(|span| knots.span_interval(span))
            .map(|interval| (interval.start(), interval.end()))
            .collect();
        let mut new = Vec::with_capacity(missing);
        for _ in 0..missing {
            // The first of the longest, up to rounding, so that equal spans are halved one after the other.
            let longest = pieces.iter().map(|(a, b)| b - a).fold(0.0, f64::max) * (1.0 - 1e-9);
            let Some(at) = pieces.iter().position(|(a, b)| b - a >= longest) else { break };
            let (a, b) = pieces[at];
            let middle = 0.5 * (a + b);
            new.push(middle);
            pieces[at] = (a, middle);
            pieces.insert(at + 1, (middle, b));
        }
        if !new.is_empty() {
            new.sort_by(f64::total_cmp);
            result = result.refine(direction, &new)?;
        }
    }
    Ok(result)
}

/// The surface with a knot more in the middle of the spans along which points are further away than the tolerance ([YWS04]), or along
/// which cells are folded; `None` if no span can be halved under the cap of control points.
///
/// A row of cells counts what lies beyond the tolerance in all of them; the direction with the longer cells goes first.
pub(super) fn refined(
    surface: &BsplineSurface,
    frames: &[PrincipalFrame<3>],
    (tolerance, folded): (f64, &[[usize; 2]]),
    max_controls: usize,
) -> Result<Option<BsplineSurface>, Error> {
    let knots = [surface.knots_u(), surface.knots_v()];
    let spans = knots.map(|k| k.spans().collect::<Vec<_>>());
    let mut excess = [vec![0.0; spans[0].len()], vec![0.0; spans[1].len()]];
    let mut counts = [vec![0usize; spans[0].len()], vec![0usize; spans[1].len()]];
    for frame in frames.iter().filter(|f| f.is_finite()) {
        let beyond = (frame.distance.abs() - tolerance).max(0.0);
        for d in 0..2 {
            let span = knots[d].span(knots[d].normalize(frame.hint.parameter[d]));
            let place = spans[d].partition_point(|&s| s < span).min(spans[d].len() - 1);
            excess[d][place] += beyond * beyond;
            counts[d][place] += 1;
        }
    }
    for cell in folded {
        for d in 0..2 {
            excess[d][cell[d]] += tolerance * tolerance;
            counts[d][cell[d]] = counts[d][cell[d]].max(FEWEST);
        }
    }
    let lengths = cell_lengths(surface, &spans);
    let longer = usize::from(lengths[1] > lengths[0]);
    // Cells become square first; then both directions at once.
    let both = lengths[longer] < 1.5 * lengths[1 - longer];
    let mut result = None;
    for d in [longer, 1 - longer] {
        if d != longer && !both {
            break;
        }
        let current = result.as_ref().unwrap_or(surface);
        let other = [current.knots_u(), current.knots_v()][1 - d].distinct_count();
        let here = [current.knots_u(), current.knots_v()][d].distinct_count();
        let room = (max_controls / other.max(1)).saturating_sub(here);
        let new = middles(knots[d], &spans[d], &excess[d], &counts[d], room);
        if !new.is_empty() {
            let direction = if d == 0 { Direction::U } else { Direction::V };
            result = Some(current.refine(direction, &new)?);
        }
    }
    Ok(result)
}

/// The surface without the knots that can be removed so that it moves by no more than a length in all ([PT97, A9.8]); `None` where
/// none can.
pub(super) fn coarser(surface: &BsplineSurface, tolerance: f64) -> Result<Option<BsplineSurface>, Error> {
    let (first, in_u) = surface.remove_all_within(Direction::U, 0.5 * tolerance)?;
    let (both, in_v) = first.remove_all_within(Direction::V, 0.5 * tolerance)?;
    Ok((in_u.removed + in_v.removed > 0).then_some(both))
}

/// Middles of the spans with the largest excess.
fn middles(knots: &KnotVector, spans: &[usize], excess: &[f64], counts: &[usize], room: usize) -> Vec<f64> {
    let mut order: Vec<usize> =
        (0..spans.len()).filter(|&k| excess[k] > 0.0 && counts[k] >= FEWEST).collect();
    order.sort_by(|&a, &b| excess[b].total_cmp(&excess[a]).then(a.cmp(&b)));
    let total: f64 = excess.iter().sum();
    let (mut covered, mut new) = (0.0, Vec::new());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
    let least = (spans.len() as f64 * SHARE).ceil() as usize;
    for k in order.into_iter().take(room) {
        if new.len() >= least && covered >= 0.9 * total {
            break;
        }
        covered += excess[k];
        new.push(knots.span_interval(spans[k]).midpoint());
    }
    new.sort_by(f64::total_cmp);
    new
}

/// Mean lengths of a cell in u and in v, from the control net.
fn cell_lengths(surface: &BsplineSurface, spans: &[Vec<usize>; 2]) -> [f64; 2] {
    let (n_u, n_v) = (surface.n_u(), surface.n_v());
    let leg = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm();
    let mut sums = [0.0; 2];
    for i in 0..n_u {
        for j in 0..n_v {
            if i + 1 < n_u {
                sums[0] += leg(surface.control_point(i, j), surface.control_point(i + 1, j)) / n_v as f64;
            }
            if j + 1 < n_v {
                sums[1] += leg(surface.control_point(i, j), surface.control_point(i, j + 1)) / n_u as f64;
            }
        }
    }
    [0, 1].map(|d| sums[d] / spans[d].len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nurbs_core::ParametricSurface;

    #[test]
    fn knots_that_carry_nothing_are_removed() {
        let (u, v) =
            (KnotVector::uniform_clamped(3, 6).unwrap(), KnotVector::uniform_periodic(3, 7).unwrap());
        let point = |k: usize| {
            let (i, a) = ((k / 10) as f64, std::f64::consts::TAU * (k % 10 % 7) as f64 / 7.0);
            Vector3::new((2.0 + (3.0 * i).sin()) * a.cos(), (2.0 + (2.0 * i).cos()) * a.sin(), i)
        };
        let surface = BsplineSurface::new(u, v, (0..60).map(point).collect(), None).unwrap();
        let finer = with_controls(surface.clone(), [9, 12]).unwrap();
        let back = coarser(&finer, 1e-9).unwrap().unwrap();
        assert_eq!((back.n_u(), back.knots_v().distinct_count()), (6, 7));
        assert!((back.point(0.3, 1.7) - surface.point(0.3, 1.7)).norm() < 1e-9);
        assert!(coarser(&surface, 1e-9).unwrap().is_none());
    }
}
