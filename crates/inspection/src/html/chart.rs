//! The histogram, which is the legend of the colours too.

use super::text::number;
use crate::{ColourScale, Deviations, Tolerance, diverging};
use std::fmt::Write;

const WIDTH: f64 = 396.0;
const BASE: f64 = 150.0;
const TOP: f64 = 14.0;

/// A vector picture; a sentence when nothing was measured.
pub(super) fn histogram(total: &Deviations, tolerance: &Tolerance) -> String {
    let Some(histogram) = &total.histogram else {
        return "<p class=\"note\">No point was measured.</p>".to_owned();
    };
    let bars = histogram.counts.len() as f64;
    let end = histogram.start + histogram.width * bars;
    let span = (end - histogram.start).max(f64::MIN_POSITIVE);
    let x = |value: f64| 4.0 + (WIDTH - 8.0) * ((value - histogram.start) / span).clamp(0.0, 1.0);
    let most = histogram.counts.iter().copied().max().unwrap_or(1).max(1) as f64;
    let scale = ColourScale::new(*tolerance);
    let colour = |value: f64| {
        let [r, g, b] = scale.colour(value);
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    let mut svg = format!(
        "<svg id=\"histogram\" viewBox=\"0 0 {WIDTH} 206\" width=\"100%\" role=\"img\" aria-label=\"Histogram of {} deviations from {} to {}\">",
        total.count,
        number(histogram.start),
        number(end)
    );
    // Writing to memory cannot fail.
    for (place, &count) in histogram.counts.iter().enumerate() {
        let from = histogram.start + histogram.width * place as f64;
        let middle = from + 0.5 * histogram.width;
        let height = (BASE - TOP) * count as f64 / most;
        let (left, right) = (x(from), x(from + histogram.width));
        let _ = write!(
            svg,
            "<rect x=\"{left:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{height:.2}\" fill=\"{}\" stroke=\"#333\" stroke-width=\".4\"><title>{} to {}: {count} points</title></rect>",
            BASE - height,
            (right - left).max(0.5),
            colour(middle),
            number(from),
            number(from + histogram.width),
        );
    }
    let _ =
        write!(svg, "<line x1=\"4\" x2=\"{}\" y1=\"{BASE}\" y2=\"{BASE}\" stroke=\"#333\"/>", WIDTH - 4.0);
    strip(&mut svg, &colour, histogram.start, span);
    let inside = |value: f64| value >= histogram.start && value <= end;
    for limit in [tolerance.lower, tolerance.upper].into_iter().filter(|&limit| inside(limit)) {
        let at = x(limit);
        let _ = write!(
            svg,
            "<line x1=\"{at:.2}\" x2=\"{at:.2}\" y1=\"6\" y2=\"170\" stroke=\"#000\" stroke-dasharray=\"4 2\"/>"
        );
    }
    let mut last = f64::NEG_INFINITY;
    let mut marks = vec![histogram.start, tolerance.lower, tolerance.target(), tolerance.upper, end];
    marks.retain(|&mark| inside(mark));
    marks.sort_unstable_by(f64::total_cmp);
    let important = |mark: f64| mark == tolerance.lower || mark == tolerance.upper;
    for &mark in &marks {
        let at = x(mark);
        let crowded =
            marks.iter().any(|&other| important(other) && other != mark && (x(other) - at).abs() < 44.0);
        if at - last < 44.0 || crowded && !important(mark) {
            continue;
        }
        last = at;
        let anchor = if at < 30.0 {
            "start"
        } else if at > WIDTH - 30.0 {
            "end"
        } else {
            "middle"
        };
        let _ = write!(svg, "<text x=\"{at:.2}\" y=\"183\" text-anchor=\"{anchor}\">{}</text>", number(mark));
    }
    let [under, over] = [diverging(-1.0), diverging(1.0)].map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}"));
    let _ = write!(
        svg,
        "<rect x=\"4\" y=\"192\" width=\"10\" height=\"10\" fill=\"{under}\" stroke=\"#000\"/><text x=\"19\" y=\"201\">below the tolerance</text>\
         <rect x=\"{}\" y=\"192\" width=\"10\" height=\"10\" fill=\"{over}\" stroke=\"#000\"/><text x=\"{}\" y=\"201\" text-anchor=\"end\">above the tolerance</text></svg>",
        WIDTH - 14.0,
        WIDTH - 19.0,
    );
    let outside = histogram.below + histogram.above;
    if outside > 0 {
        let _ = write!(
            svg,
            "<p class=\"note\">Not drawn: {} points farther below, {} farther above (see minimum and maximum).</p>",
            histogram.below, histogram.above
        );
    }
    svg
}

/// The colours along the axis.
fn strip(svg: &mut String, colour: &dyn Fn(f64) -> String, start: f64, span: f64) {
    const STEPS: usize = 97;
    let step = (WIDTH - 8.0) / STEPS as f64;
    for place in 0..STEPS {
        let value = start + span * (place as f64 + 0.5) / STEPS as f64;
        let _ = write!(
            svg,
            "<rect x=\"{:.2}\" y=\"156\" width=\"{:.2}\" height=\"12\" fill=\"{}\"/>",
            4.0 + step * place as f64,
            step + 0.4,
            colour(value)
        );
    }
}
