//! What is proven about a deviation, and what follows from it for the verdict.
//!
//! A search ends with a distance `d` and a lower bound `b`: the distance from the shape lies in `[b, d]`. Where the two agree up
//! to the gap that was allowed, `d` is the deviation. Where they do not, or the iteration did not converge, the interval
//! decides: all of it within the tolerance, or all of it beyond. As long as the gap is open another point of the shape may be the
//! nearest one, on whichever side, so that both signs of the interval count.

use crate::{Deviation, InspectionOptions, Outcome, Tolerance};
use footpoint::{Mode, ProjectionOptions, Status};

/// How much larger than the allowed gap one may be that counts as closed: bounds lose a little to rounding.
const ROUNDING: f64 = 8.0;

/// What a status of a search means before the interval is looked at.
pub(super) fn outcome(status: Status, distance: f64) -> Outcome {
    match status {
        // An open certificate leaves a true foot: the gap tells what may be nearer.
        Status::Converged | Status::OnBoundary | Status::Uncertified => Outcome::Measured,
        Status::InvalidPoint => Outcome::InvalidPoint,
        Status::Cancelled => Outcome::Cancelled,
        Status::NoMatchingFoot => Outcome::NoMatchingFoot,
        Status::NoNormal => Outcome::NoNormal,
        _ if distance.is_finite() => Outcome::Undecided,
        _ => Outcome::NotConverged,
    }
}

/// The rules of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judge<'a> {
    options: &'a InspectionOptions,
    /// Largest side of a box around the shape.
    size: f64,
    is_signed: bool,
}

impl<'a> Judge<'a> {
    pub(super) fn new(options: &'a InspectionOptions, size: f64, is_signed: bool) -> Self {
        Self { options, size, is_signed }
    }

    /// Decides whether a deviation counts.
    pub(super) fn judged(&self, mut deviation: Deviation) -> Deviation {
        let options = self.options;
        let distance = deviation.distance.abs();
        if !matches!(deviation.outcome, Outcome::Measured | Outcome::Undecided) {
            return deviation;
        }
        let closed = deviation.gap <= ROUNDING * self.allowed_gap(distance, &options.projection);
        let proven = options.projection.mode == Mode::Certified;
        if !distance.is_finite() {
            deviation.outcome = Outcome::NotConverged;
        } else if closed || deviation.outcome == Outcome::Measured && !proven {
            let is_beyond = distance > options.max_distance;
            deviation.outcome = if is_beyond {
                Outcome::BeyondMaxDistance
            } else if deviation.on_boundary && options.drop_beyond_boundary {
                Outcome::BeyondBoundary
            } else if deviation.outcome == Outcome::Measured || self.is_decided(&deviation, closed) {
                Outcome::Measured
            } else {
                Outcome::Undecided
            };
        } else if distance - deviation.gap > options.max_distance {
            deviation.outcome = Outcome::BeyondMaxDistance;
        } else if distance > options.max_distance || !self.is_decided(&deviation, closed) {
            deviation.outcome = Outcome::Undecided;
        } else {
            deviation.outcome = Outcome::Measured;
        }
        deviation
    }

    fn allowed_gap(&self, distance: f64, projection: &ProjectionOptions) -> f64 {
        projection.relative_gap * distance + projection.size_gap * self.size
    }

    /// Whether all of what the deviation may be lies within the tolerance, or all of it beyond.
    fn is_decided(&self, deviation: &Deviation, closed: bool) -> bool {
        let tolerance = &self.options.tolerance;
        let distance = deviation.distance.abs();
        let low = (distance - deviation.gap).max(0.0);
        let (above, below) = ([low, distance], [-distance, -low]);
        let sides = match (self.is_signed && !closed, deviation.distance < 0.0) {
            (true, _) => vec![above, below],
            (false, true) => vec![below],
            (false, false) => vec![above],
        };
        let is_within = |[low, high]: &[f64; 2]| contains(tolerance, *low) && contains(tolerance, *high);
        let is_beyond = |[low, high]: &[f64; 2]| *low > tolerance.upper || *high < tolerance.lower;
        sides.iter().all(is_within) || sides.iter().all(is_beyond)
    }
}

fn contains(tolerance: &Tolerance, value: f64) -> bool {
    (tolerance.lower..=tolerance.upper).contains(&value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn judged(lower: f64, upper: f64, outcome: Outcome, distance: f64, bound: f64) -> Outcome {
        let options = InspectionOptions::new(Tolerance::new(lower, upper).unwrap());
        let foot = Point3::origin();
        let gap = distance.abs() - bound;
        Judge::new(&options, 1.0, true)
            .judged(Deviation { foot, distance, gap, ..Deviation::none(outcome) })
            .outcome
    }

    #[test]
    fn intervals_decide_where_a_search_does_not() {
        use Outcome::{Measured, Undecided};
        for (limits, before, distance, bound, expected) in [
            // Within, whatever the side.
            ([-0.1, 0.1], Undecided, 0.05, 0.0, Measured),
            ([-0.1, 0.1], Undecided, -0.1, 0.0, Measured),
            // Beyond, whatever the side.
            ([-0.1, 0.1], Undecided, 0.3, 0.2, Measured),
            // Across a limit.
            ([-0.1, 0.1], Undecided, 0.12, 0.05, Undecided),
            ([-0.1, 0.1], Measured, 0.12, 0.05, Undecided),
            // On one side within, on the other not.
            ([-0.01, 0.1], Undecided, 0.05, 0.04, Undecided),
            ([-0.01, 0.1], Measured, 0.05, 0.04, Undecided),
            // The gap is closed, the side known.
            ([-0.01, 0.1], Undecided, 0.05, 0.05, Measured),
            ([-0.1, 0.01], Undecided, -0.05, 0.05, Measured),
            ([-0.01, 0.1], Undecided, -0.05, 0.05, Measured),
            // A converged distance counts as it is, though the allowed gap reaches across the limit.
            ([-0.1, 0.1], Measured, 0.1, 0.1 - 5e-9, Measured),
            ([0.05, 0.1], Measured, 0.05, 0.05 - 4e-9, Measured),
            // One that did not converge is taken at its word only as far as it is proven.
            ([0.05, 0.1], Undecided, 0.05, 0.05 - 4e-9, Undecided),
        ] {
            let found = judged(limits[0], limits[1], before, distance, bound);
            assert_eq!(found, expected, "{limits:?} {before:?} {distance} {bound}");
        }
    }

    #[test]
    fn the_largest_distance_is_proven_too() {
        let mut options = InspectionOptions::new(Tolerance::symmetric(0.1).unwrap()).with_max_distance(1.0);
        let at = |options: &InspectionOptions, outcome, distance: f64, bound: f64| {
            let deviation = Deviation {
                distance,
                gap: distance.abs() - bound,
                on_boundary: true,
                ..Deviation::none(outcome)
            };
            Judge::new(options, 1.0, true).judged(deviation).outcome
        };
        assert_eq!(at(&options, Outcome::Measured, 1.5, 1.5), Outcome::BeyondMaxDistance);
        assert_eq!(at(&options, Outcome::Undecided, 1.5, 1.2), Outcome::BeyondMaxDistance);
        assert_eq!(at(&options, Outcome::Undecided, 1.5, 0.9), Outcome::Undecided);
        options = options.with_drop_beyond_boundary(true);
        assert_eq!(at(&options, Outcome::Measured, 0.5, 0.5), Outcome::BeyondBoundary);
        // Whether the nearest point lies on the boundary is not known: the point is judged.
        assert_eq!(at(&options, Outcome::Measured, 0.5, 0.3), Outcome::Measured);
        assert_eq!(at(&options, Outcome::Measured, f64::INFINITY, 0.3), Outcome::NotConverged);
    }

    #[test]
    fn without_a_proof_asked_for_convergence_is_enough() {
        let options = InspectionOptions::new(Tolerance::symmetric(0.1).unwrap())
            .with_projection(ProjectionOptions::default().with_mode(Mode::Fast));
        let at = |outcome, distance: f64| {
            let deviation = Deviation { distance, gap: distance, ..Deviation::none(outcome) };
            Judge::new(&options, 1.0, true).judged(deviation).outcome
        };
        assert_eq!(at(Outcome::Measured, 0.2), Outcome::Measured);
        assert_eq!(at(Outcome::Undecided, 0.05), Outcome::Measured);
        assert_eq!(at(Outcome::Undecided, 0.2), Outcome::Undecided);
    }
}
