//! The history of a fit as a chart.

use crate::output::html::{note, swatch};
use industrial_geometry::fit::FitStep;
use industrial_geometry::inspection::html::number;
use std::fmt::Write as _;

const WIDTH: f64 = 396.0;
const HEIGHT: f64 = 190.0;
/// Room for the numbers at the left, and around.
const LEFT: f64 = 58.0;
const MARGIN: f64 = 14.0;
/// Most decades: what is smaller is at the bottom.
const DECADES: f64 = 12.0;
/// What is drawn: a name, a colour, and the number of a step.
type Line = (&'static str, &'static str, fn(&FitStep) -> f64);
const LINES: [Line; 3] = [
    ("rms", "#0b6e99", |step| step.rms),
    ("largest distance", "#c8422b", |step| step.max),
    ("factor of the energy", "#7a8794", |step| step.lambda),
];

/// Logarithms over the iterations; dashed lines are where the control points became more or fewer.
pub(super) fn chart(steps: &[FitStep]) -> String {
    let values = || steps.iter().flat_map(|step| LINES.map(|(_, _, of)| of(step)));
    let positive = || values().filter(|v| *v > 0.0 && v.is_finite());
    let high = positive().fold(f64::NEG_INFINITY, f64::max).log10().ceil();
    if !high.is_finite() {
        return note("All distances are 0.");
    }
    let low = positive().fold(f64::INFINITY, f64::min).log10().floor().max(high - DECADES).min(high - 1.0);
    let bottom = HEIGHT - MARGIN - 14.0;
    let x = |k: usize| LEFT + (WIDTH - LEFT - MARGIN) * k as f64 / (steps.len().max(2) - 1) as f64;
    let y = |value: f64| {
        let share = (value.max(f64::MIN_POSITIVE).log10() - low) / (high - low);
        bottom - (bottom - MARGIN) * share.clamp(0.0, 1.0)
    };
    // Writing to memory cannot fail.
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"100%\" role=\"img\" aria-label=\"Distances and energy over {} iterations\">",
        steps.len()
    );
    let decades = high - low;
    let step = (decades / 6.0).ceil().max(1.0);
    let mut power = low;
    while power <= high {
        let at = y(10f64.powf(power));
        let _ = write!(
            svg,
            "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#d7dce2\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            WIDTH - MARGIN,
            LEFT - 5.0,
            at + 4.0,
            decade(power)
        );
        power += step;
    }
    for (k, pair) in steps.windows(2).enumerate() {
        if pair[0].coefficients != pair[1].coefficients {
            let at = 0.5 * (x(k) + x(k + 1));
            let _ = write!(
                svg,
                "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{MARGIN}\" y2=\"{bottom}\" stroke=\"#b9c1ca\" stroke-dasharray=\"3 3\">\
                 <title>{} control points</title></line>",
                pair[1].coefficients
            );
        }
    }
    for (name, colour, of) in LINES {
        let points: Vec<String> =
            steps.iter().enumerate().map(|(k, s)| format!("{:.1},{:.1}", x(k), y(of(s)))).collect();
        let _ = write!(
            svg,
            "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" points=\"{}\"><title>{name}</title></polyline>",
            points.join(" ")
        );
    }
    let _ = write!(
        svg,
        "<text x=\"{LEFT}\" y=\"{}\">1</text><text x=\"{}\" y=\"{}\" text-anchor=\"end\">{} iterations</text></svg>",
        HEIGHT - 4.0,
        WIDTH - MARGIN,
        HEIGHT - 4.0,
        steps.len()
    );
    let legend: String = LINES.iter().map(|(name, colour, _)| swatch(colour, name)).collect();
    format!(
        "{svg}\n<p class=\"note\">{legend}</p>\n{}",
        note("Dashed lines: the number of control points changes.")
    )
}

/// A power of ten as text.
fn decade(power: f64) -> String {
    if (-4.0..=5.0).contains(&power) {
        number(10f64.powf(power))
    } else {
        format!("1e{power}").replace('-', "−")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(rms: f64, coefficients: usize) -> FitStep {
        FitStep {
            iteration: 1,
            lambda: 0.0,
            rms,
            max: 2.0 * rms,
            cost: rms,
            displacement: 0.0,
            factor: 1.0,
            damping: 0.0,
            evaluations: 1,
            samples: 1,
            coefficients,
            lifted: false,
        }
    }

    #[test]
    fn charts_hold_all_steps_and_stay_in_their_box() {
        let text = chart(&[step(1.0, 4), step(1e-3, 4), step(1e-40, 8)]);
        assert_eq!(text.matches("stroke-dasharray").count(), 1);
        assert_eq!(text.matches("<polyline").count(), LINES.len());
        let inside = |c: f64| (0.0..=WIDTH).contains(&c);
        let numbers = text.split("points=\"").skip(1).filter_map(|t| t.split('"').next());
        let all: Vec<f64> = numbers.flat_map(|t| t.split([' ', ','])).map(|n| n.parse().unwrap()).collect();
        assert_eq!(all.len(), 2 * 3 * LINES.len());
        assert!(all.into_iter().all(inside));
        assert!(chart(&[step(0.0, 4)]).contains("All distances are 0"));
    }
}
