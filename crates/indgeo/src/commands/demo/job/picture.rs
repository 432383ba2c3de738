//! The picture as a whole: panels, axes, titles, numbers.

use super::bolt::{Bolt, Zones};
use super::scale::{Scale, round_up};
use super::svg::{Anchor, Svg};
use super::{histogram, map, profile, side_view};
use crate::commands::project::job::Projected;
use industrial_geometry::inspection::Statistics;

const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 1086.0;
const INK: &str = "fill=\"#222\"";
const SOFT: &str = "fill=\"#666\"";
const BOLD: &str = "fill=\"#111\" font-weight=\"bold\"";

/// Left and right edge of the panels along the axis.
const LEFT: f64 = 92.0;
const RIGHT: f64 = 1164.0;

/// Draws the deviations of the bolt as SVG.
pub(crate) fn draw(bolt: &Bolt, projected: &Projected, zones: &Zones) -> String {
    let title = "Scan of a stud bolt against its nominal M12 × 1.75-LH thread and shank";
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    svg.text([LEFT - 52.0, 44.0], 25.0, Anchor::Start, BOLD, title);
    let count = projected.points.positions.len();
    let subtitle = format!(
        "{count} scanned points, each projected onto the nominal NURBS surfaces. Colour: signed distance in mm; \
         red lies outside, blue inside."
    );
    svg.text([LEFT - 52.0, 69.0], 14.5, Anchor::Start, SOFT, &subtitle);

    let limit = colour_limit(&zones.inside);
    let height = height_scale(bolt, projected);
    // The side view has the same scale in both directions.
    let scale = (height.pixels[1] - height.pixels[0]) / (height.values[1] - height.values[0]);
    let across = Scale { values: [-6.4, 6.4], pixels: [110.0 + 12.8 * scale, 110.0] };
    side_view::draw(&mut svg, bolt, projected, height, across, limit);
    heading(&mut svg, 106.0, "a  Side view of the scan");

    let top = across.pixels[0] + 44.0;
    let angle = Scale { values: [0.0, 360.0], pixels: [top + 200.0, top] };
    frame(&mut svg, height.pixels, angle.pixels, "#f4f5f7");
    map::draw(&mut svg, bolt, projected, height, angle, limit);
    heading(&mut svg, top - 10.0, "b  Unrolled: one dot per scanned point");
    axes(&mut svg, height, 5.0, angle, 90.0, 0);
    svg.text_upwards([LEFT - 46.0, top + 100.0], 13.0, "angle about the axis, °");
    let below = [0.5 * (LEFT + RIGHT), top + 236.0];
    svg.text(below, 13.0, Anchor::Middle, INK, "position along the axis, mm");

    draw_profile(&mut svg, bolt, projected, limit, top + 286.0);
    draw_numbers(&mut svg, projected, zones, limit, top + 286.0);
    svg.finish()
}

/// Half the range of the colours: a round number that covers 95 % of the points over the model.
fn colour_limit(inside: &Statistics) -> f64 {
    let low = inside.quantile(0.05).unwrap_or(inside.min).abs();
    let high = inside.quantile(0.95).unwrap_or(inside.max).abs();
    round_up(low.max(high).max(f64::MIN_POSITIVE))
}

fn height_scale(bolt: &Bolt, projected: &Projected) -> Scale {
    let heights = projected.points.positions.iter().map(|point| bolt.local(point)[0]);
    let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)));
    Scale { values: [low - 0.4, high + 0.4], pixels: [LEFT, RIGHT] }
}

fn draw_profile(svg: &mut Svg, bolt: &Bolt, projected: &Projected, limit: f64, top: f64) {
    let scale = 245.0;
    let x =
        Scale { values: [-0.5 * bolt.pitch, 0.5 * bolt.pitch], pixels: [LEFT, LEFT + bolt.pitch * scale] };
    let y = Scale { values: [4.9, 6.1], pixels: [top + 1.2 * scale, top] };
    frame(svg, x.pixels, y.pixels, "#f4f5f7");
    profile::draw(svg, bolt, projected, x, y, limit);
    heading(svg, top - 10.0, "c  All turns laid over each other; black: nominal");
    axes(svg, x, 0.25, y, 0.2, 2);
    svg.text_upwards([LEFT - 46.0, top + 0.6 * scale], 13.0, "distance from the axis, mm");
    let below = [0.5 * (x.pixels[0] + x.pixels[1]), top + 1.2 * scale + 36.0];
    svg.text(below, 13.0, Anchor::Middle, INK, "position within the pitch, mm");
}

fn draw_numbers(svg: &mut Svg, projected: &Projected, zones: &Zones, limit: f64, top: f64) {
    let left = 620.0;
    svg.text([left, top - 10.0], 15.0, Anchor::Start, BOLD, "d  Signed distance, mm (legend of a, b and c)");
    let x = Scale { values: [-limit, limit], pixels: [left, RIGHT] };
    histogram::draw(svg, projected, x, top + 112.0, 90.0);

    let columns = [left + 218.0, left + 306.0, left + 384.0, left + 462.0, left + 540.0];
    let row_at = |row: f64| top + 186.0 + row * 21.0;
    for (x, name) in columns.iter().zip(["points", "mean", "std dev", "5 %", "95 %"]) {
        svg.text([*x, row_at(0.0)], 13.0, Anchor::End, SOFT, name);
    }
    let rows = [
        ("crests of the thread", &zones.crests),
        ("flanks", &zones.flanks),
        ("roots", &zones.roots),
        ("thread and shank", &zones.inside),
    ];
    for (row, (name, statistics)) in rows.into_iter().enumerate() {
        let y = row_at(row as f64 + 1.0);
        svg.text([left, y], 13.5, Anchor::Start, INK, name);
        let quantile = |share| statistics.quantile(share).unwrap_or(f64::NAN);
        let numbers = [
            statistics.count.to_string(),
            format!("{:+.3}", statistics.mean),
            format!("{:.3}", statistics.standard_deviation),
            format!("{:+.3}", quantile(0.05)),
            format!("{:+.3}", quantile(0.95)),
        ];
        for (x, number) in columns.iter().zip(numbers) {
            svg.text([*x, y], 13.5, Anchor::End, INK, &number);
        }
    }
    let notes = [
        format!("Grey: {} points beyond the modelled surfaces (run-outs, necks, point). Their", zones.beyond),
        "closest point is on the boundary of the model, so their distance is no deviation.".to_owned(),
    ];
    for (row, note) in notes.iter().enumerate() {
        svg.text([left, row_at(5.2 + 0.85 * row as f64)], 13.0, Anchor::Start, SOFT, note);
    }
}

fn heading(svg: &mut Svg, y: f64, text: &str) {
    svg.text([LEFT, y], 15.0, Anchor::Start, BOLD, text);
}

fn frame(svg: &mut Svg, x: [f64; 2], y: [f64; 2], fill: &str) {
    svg.rectangle([x[0], y[1]], [x[1] - x[0], y[0] - y[1]], fill);
}

/// Ticks with numbers below and to the left.
fn axes(svg: &mut Svg, x: Scale, step_x: f64, y: Scale, step_y: f64, digits: usize) {
    let [bottom, _] = y.pixels;
    let [left, right] = x.pixels;
    svg.polyline(&[[left, y.pixels[1]], [left, bottom], [right, bottom]], "#333", 1.0);
    for tick in x.ticks(step_x) {
        let at = x.at(tick);
        svg.polyline(&[[at, bottom], [at, bottom + 5.0]], "#333", 1.0);
        svg.text([at, bottom + 19.0], 12.5, Anchor::Middle, INK, &format!("{tick:.digits$}"));
    }
    for tick in y.ticks(step_y) {
        let at = y.at(tick);
        svg.polyline(&[[left - 5.0, at], [left, at]], "#333", 1.0);
        svg.text([left - 9.0, at + 4.0], 12.5, Anchor::End, INK, &format!("{tick:.digits$}"));
    }
}
