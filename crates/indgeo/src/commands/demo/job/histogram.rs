//! How often each deviation occurs; its axis is the legend of the colours.

use super::bolt::is_inside;
use super::colour::{self, STEPS};
use super::scale::Scale;
use super::svg::{Anchor, Svg};
use crate::commands::project::job::Projected;

/// Bars per colour.
const FINE: usize = 2;

/// Draws bars above a strip of colours. `x` maps distances from `-limit` to `limit`, `base` is the lower edge of the bars.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "limited to the number of bars")]
pub(crate) fn draw(svg: &mut Svg, projected: &Projected, x: Scale, base: f64, tall: f64) {
    let limit = x.values[1];
    let bars = STEPS * FINE;
    let mut counts = vec![0usize; bars];
    for foot in projected.feet.iter().filter(|foot| is_inside(foot)) {
        let place = (0.5 + 0.5 * foot.distance / limit) * bars as f64;
        // What exceeds the scale is counted at its ends, like its colour.
        counts[place.clamp(0.0, bars as f64 - 1.0) as usize] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(1).max(1);
    let width = (x.pixels[1] - x.pixels[0]) / bars as f64;
    for (bar, &count) in counts.iter().enumerate() {
        let size = count as f64 / most as f64 * tall;
        let [r, g, b] = colour::colour(bar / FINE, 0.95);
        let fill = format!("#{r:02x}{g:02x}{b:02x}");
        svg.rectangle([x.pixels[0] + bar as f64 * width, base - size], [width - 0.5, size], &fill);
    }
    for step in 0..STEPS {
        let [r, g, b] = colour::colour(step, 1.0);
        let left = x.pixels[0] + (step * FINE) as f64 * width;
        svg.rectangle(
            [left, base + 4.0],
            [width * FINE as f64 + 0.5, 16.0],
            &format!("#{r:02x}{g:02x}{b:02x}"),
        );
    }
    for tick in x.ticks(0.5 * limit) {
        let label = format!("{tick:+.3}").trim_end_matches('0').trim_end_matches('.').to_owned();
        let label = if tick == 0.0 { "0".to_owned() } else { label };
        svg.polyline(&[[x.at(tick), base + 20.0], [x.at(tick), base + 25.0]], "#333", 1.0);
        svg.text([x.at(tick), base + 40.0], 13.0, Anchor::Middle, "fill=\"#333\"", &label);
    }
    svg.polyline(&[[x.pixels[0], base + 2.0], [x.pixels[1], base + 2.0]], "#333", 1.0);
    let caption = [x.pixels[0] + 4.0, base - tall - 6.0];
    svg.text(caption, 12.0, Anchor::Start, "fill=\"#666\"", &format!("highest bar: {most} points"));
}
