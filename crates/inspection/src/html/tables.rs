//! The tables of the page.

use super::Page;
use super::text::{cell, escape, number};
use crate::{Along, ColourScale, Deviations, Inspection, Rounding, percent};
use std::fmt::Write;

/// Names of outcomes for a reader.
const OUTCOMES: [(&str, &str); 9] = [
    ("undecided", "undecided, count as not within"),
    ("no_matching_foot", "no foot with a matching normal, count as out of tolerance"),
    ("beyond_max_distance", "beyond the largest distance, not used"),
    ("beyond_boundary", "beyond the boundary of the model, not used"),
    ("no_hit", "line of projection misses the model, not used"),
    ("no_normal", "without a normal, not used"),
    ("not_converged", "search found no footpoint, count as out of tolerance"),
    ("invalid_point", "coordinates not finite, not used"),
    ("cancelled", "cancelled"),
];

/// The statistics of all points.
pub(super) fn statistics(inspection: &Inspection) -> String {
    let total = &inspection.total;
    let mut rows = String::from("<table id=\"statistics\"><tbody>");
    let mut row = |name: &str, key: &str, cells: String| {
        let _ = write!(rows, "<tr data-key=\"{key}\"><th scope=\"row\">{name}</th>{cells}</tr>");
    };
    let counted = |count: u64, rounding: Rounding| {
        let share = percent(count, total.count, rounding);
        format!("<td data-value=\"{count}\">{count}</td><td>{share}</td>")
    };
    row("measured points", "count", format!("<td data-value=\"{0}\">{0}</td><td></td>", total.count));
    row("within tolerance", "within", counted(total.within, Rounding::Down));
    row("above tolerance", "over", counted(total.over, Rounding::Up));
    row("below tolerance", "under", counted(total.under, Rounding::Up));
    for (key, name) in OUTCOMES {
        let count = inspection.outcomes.get(key).copied().unwrap_or(0);
        if count > 0 {
            row(name, key, format!("<td data-value=\"{count}\">{count}</td><td></td>"));
        }
    }
    if let Some(d) = &total.distance {
        let wide = |value: f64| cell(value).replace("<td ", "<td colspan=\"2\" ");
        row("minimum", "min", wide(d.min));
        row("maximum", "max", wide(d.max));
        row("mean", "mean", wide(d.mean));
        row("mean of the positive", "mean_positive", wide(d.mean_positive.unwrap_or(f64::NAN)));
        row("mean of the negative", "mean_negative", wide(d.mean_negative.unwrap_or(f64::NAN)));
        row("RMS", "rms", wide(d.rms));
        row("standard deviation σ", "standard_deviation", wide(d.standard_deviation));
        row("variance", "variance", wide(d.variance));
        for quantile in &d.quantiles {
            if [0.05, 0.5, 0.95].contains(&quantile.share) {
                let percent = number(100.0 * quantile.share);
                row(&format!("{percent} % quantile"), &format!("q{}", quantile.share), wide(quantile.value));
            }
        }
    }
    rows.push_str("</tbody></table>");
    rows
}

/// Everything below the picture: surfaces, worst points, alignment.
pub(super) fn below(page: &Page<'_>) -> String {
    let mut out = String::new();
    out.push_str(&worst(page.inspection));
    if !page.inspection.parts.is_empty() {
        out.push_str(&parts(page.inspection));
    }
    if !page.inspection.shapes.is_empty() {
        out.push_str(&surfaces(page.inspection));
    }
    if let Some(matrix) = &page.alignment {
        out.push_str("<section class=\"wide\"><h2>Alignment applied to the points (4 × 4, row by row)</h2><div class=\"scroll\"><table id=\"alignment\"><tbody>");
        for row in matrix {
            let cells: String = row.iter().map(|&value| cell(value)).collect();
            let _ = write!(out, "<tr>{cells}</tr>");
        }
        out.push_str("</tbody></table></div></section>");
    }
    out
}

fn worst(inspection: &Inspection) -> String {
    if inspection.worst.is_empty() {
        return String::new();
    }
    let scale = ColourScale::new(inspection.options.tolerance);
    let mut out = String::from(
        "<section class=\"wide\"><h2>Largest deviations</h2><div class=\"scroll\"><table id=\"worst\"><thead><tr><th scope=\"col\">show</th>\
         <th scope=\"col\">deviation</th><th scope=\"col\">state</th><th scope=\"col\">point</th><th scope=\"col\">x</th><th scope=\"col\">y</th><th scope=\"col\">z</th>\
         <th scope=\"col\">surface</th></tr></thead><tbody>",
    );
    for (place, point) in inspection.worst.iter().enumerate() {
        let [r, g, b] = scale.colour(point.distance);
        let state = match inspection.options.tolerance.class(point.distance) {
            crate::Class::Under => "below",
            crate::Class::Within => "within",
            crate::Class::Over => "above",
        };
        let [x, y, z] = point.point.map(cell);
        let _ = write!(
            out,
            "<tr><td><button type=\"button\" data-worst=\"{place}\" aria-label=\"Show point {index}\">{rank}</button></td>{distance}\
             <td><span class=\"swatch\" style=\"background:rgb({r},{g},{b})\"></span>{state}</td><td>{index}{name}</td>{x}{y}{z}<td>{shape}</td></tr>",
            rank = place + 1,
            index = point.index,
            distance = cell(point.distance),
            shape = point.shape,
            name = point.name.as_deref().map(|name| format!(" {}", escape(name))).unwrap_or_default(),
        );
    }
    out.push_str("</tbody></table></div></section>");
    out
}

/// A table of what the points of each surface, or of each part, deviate.
fn groups<'a>(
    title: &str,
    id: &str,
    what: &str,
    rows: impl Iterator<Item = (u32, String, &'a Deviations)>,
) -> String {
    let mut out = format!(
        "<section class=\"wide\"><h2>{title}</h2><div class=\"scroll\"><table id=\"{id}\"><thead><tr><th scope=\"col\">{what}</th><th scope=\"col\">points</th>\
         <th scope=\"col\">within</th><th scope=\"col\">share</th><th scope=\"col\">above</th><th scope=\"col\">below</th><th scope=\"col\">min</th><th scope=\"col\">max</th>\
         <th scope=\"col\">mean</th><th scope=\"col\">RMS</th><th scope=\"col\">σ</th><th scope=\"col\">on boundary</th></tr></thead><tbody>",
    );
    for (index, name, d) in rows {
        let _ = write!(
            out,
            "<tr><th scope=\"row\">{index} {name}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
            d.count,
            d.within,
            percent(d.within, d.count, Rounding::Down),
            d.over,
            d.under
        );
        let values = d.distance.as_ref().map(|s| [s.min, s.max, s.mean, s.rms, s.standard_deviation]);
        values.unwrap_or([f64::NAN; 5]).iter().for_each(|&value| out.push_str(&cell(value)));
        let _ = write!(out, "<td>{}</td></tr>", d.on_boundary);
    }
    out.push_str("</tbody></table></div></section>");
    out
}

fn parts(inspection: &Inspection) -> String {
    let rows = inspection.parts.iter().map(|part| (part.index, escape(&part.name), &part.deviations));
    groups("Parts", "parts", "part", rows)
}

fn surfaces(inspection: &Inspection) -> String {
    let rows = inspection.shapes.iter().map(|shape| {
        let name = shape.info.name.as_deref().map_or_else(|| shape.info.kind.to_owned(), escape);
        (shape.index, name, &shape.deviations)
    });
    groups("Surfaces", "shapes", "surface", rows)
}

/// How it was measured, in a sentence or two.
pub(super) fn method(page: &Page<'_>) -> String {
    let options = &page.inspection.options;
    let along = match options.along {
        Along::Shortest => "along the shortest line to the exact shape".to_owned(),
        Along::Normal => {
            "along the normals of the points, to the nearest crossing with the exact shape".to_owned()
        }
        Along::Direction(direction) => {
            let [x, y, z] = direction.map(number);
            format!("along the direction ({x}, {y}, {z}), to the nearest crossing with the exact shape")
        }
    };
    let mut out = format!(
        "Deviations are measured {along}; they are positive on the side to which its normal points. \
         No other point of the shape that counts is nearer by more than {}. The grey triangles only show the model. Lengths are in the unit of the files. ",
        number(page.inspection.largest_gap)
    );
    if let Some(angle) = options.angle_limit() {
        let _ = write!(
            out,
            "Only places of the shape count where its normal is within {}° of the point's: for {} points another one is nearer. ",
            number(angle.to_degrees()),
            page.inspection.restricted
        );
    }
    if options.max_distance.is_finite() {
        let _ = write!(out, "Points farther away than {} are not used. ", number(options.max_distance));
    }
    if page.inspection.total.distance.as_ref().is_some_and(|distance| !distance.quantiles_exact) {
        out.push_str("Quantiles and histogram come from cells of a relative width of 2⁻¹². ");
    }
    let _ = write!(
        out,
        "Model: {}. Points: {}. Written by {}.",
        escape(page.model),
        escape(page.cloud),
        escape(page.program)
    );
    out
}
