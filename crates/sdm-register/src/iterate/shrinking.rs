//! How fast the steps of an iteration shrink.

use crate::report::RegisterStep;

/// How much longer than a motion the steps may be which tell how fast those of its length shrink.
const LONGER: f64 = 30.0;

/// The largest ratio of a whole step to the one before, of steps that are as long as a motion or somewhat longer; infinite if there
/// were none.
pub(super) fn shrinking(history: &[RegisterStep], motion: f64) -> f64 {
    let is_whole = |step: &RegisterStep| step.factor == 1.0 && step.damping == 0.0;
    let ratios = history.windows(2).filter_map(|pair| {
        let [one, next] = pair else { return None };
        let alike = one.stage == next.stage && one.points == next.points && is_whole(one) && is_whole(next);
        (alike && (motion..=LONGER * motion).contains(&one.motion)).then(|| next.motion / one.motion)
    });
    ratios.reduce(f64::max).unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(motion: f64, points: usize) -> RegisterStep {
        RegisterStep {
            stage: "fit",
            step: "newton",
            points,
            rms: 1.0,
            motion,
            angle: 0.0,
            damping: 0.0,
            factor: 1.0,
            evaluations: 1,
            scale: None,
        }
    }

    #[test]
    fn steps_of_about_the_length_tell_how_fast_they_shrink() {
        let history = [step(1e-2, 9), step(2e-3, 9), step(2e-5, 9), step(1e-8, 9), step(5e-9, 99)];
        assert!((shrinking(&history, 1e-5) - 5e-4).abs() < 1e-12);
        assert!((shrinking(&history, 1e-3) - 0.2).abs() < 1e-12);
        // None so long, and one of other points.
        assert_eq!(shrinking(&history, 1.0), f64::INFINITY);
        assert_eq!(shrinking(&history[3..], 1e-8), f64::INFINITY);
    }
}
