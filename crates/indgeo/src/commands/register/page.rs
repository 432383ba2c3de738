//! One self-contained HTML page of a registration: before and after, residuals, overlap, and the uncertainty of the pose.

use crate::commands::register::field::RegistrationField;
use crate::commands::register::results::{RegistrationResults, TransformFile};
use crate::output::html::{HtmlPage, note, section, swatch, table};
use industrial_geometry::inspection::html::number;
use industrial_geometry::mesh::nalgebra::{Matrix2, Matrix3, SMatrix, SymmetricEigen, Vector2, Vector3};
use industrial_geometry::nurbs::Aabb;
use industrial_geometry::register::Pose;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Most points in a picture.
const SHOWN: usize = 4000;
/// Width and height of a view, and its margin.
const SIDE: f64 = 300.0;
const MARGIN: f64 = 14.0;
/// Colours of residuals, from none to the limit, and of points beyond it.
const BANDS: [&str; 5] = ["#0b6e99", "#35a186", "#a7b73a", "#e0992f", "#c8422b"];
const BEYOND: &str = "#8b7fae";
const MODEL: &str = "#c3cad2";
const BEFORE: &str = "#3f6fb5";
/// Standard deviations of an error that is drawn.
const SIGMAS: f64 = 2.0;
/// Length of the largest error in the picture, at most, as a share of the size of the part.
const DRAWN: f64 = 0.12;

/// What a page shows.
pub(crate) struct Page<'a> {
    pub(crate) model_name: &'a str,
    pub(crate) points_name: &'a str,
    /// Places of the model.
    pub(crate) model: &'a [Vector3<f64>],
    pub(crate) points: &'a [Vector3<f64>],
    pub(crate) pose: &'a Pose<3>,
    pub(crate) start: &'a Pose<3>,
    pub(crate) field: &'a RegistrationField,
    pub(crate) results: &'a RegistrationResults,
}

/// Points of one colour.
struct Layer {
    colour: &'static str,
    points: Vec<Vector3<f64>>,
}

/// Writes the page.
pub(crate) fn write(out: &mut dyn Write, page: &Page<'_>) -> io::Result<()> {
    let motion = &page.results.transform;
    let (passes, verdict) =
        if motion.status == "converged" { (true, "CONVERGED") } else { (false, "NOT TO BE TRUSTED") };
    let (picked, shown) = picked(page.points);
    let before = Layer { colour: BEFORE, points: picked.iter().map(|x| page.start.apply(x)).collect() };
    let model = || Layer { colour: MODEL, points: page.model.to_vec() };
    let moved: Vec<Vector3<f64>> = picked.iter().map(|x| page.pose.apply(x)).collect();
    let distances = page.field.distances(&moved);
    let limit = motion.distance_limit.unwrap_or_else(|| distances.iter().copied().fold(0.0, f64::max));
    let mut after = vec![model()];
    after.extend(by_residual(&moved, &distances, limit));
    let corners = corner_errors(motion, &moved);
    let shown = format!(
        "{shown} of {} points are shown, and places of the model in grey. Views along z, y and x.",
        page.points.len()
    );
    let after = views(&after, &corners) + &legend(limit, &corners) + &note(&shown);
    let mut right = section("Result", &table(&facts(page.results)));
    if !corners.is_empty() {
        let rows: Vec<_> = corners.iter().map(Corner::row).collect();
        let what = "One standard deviation of the position that the pose gives to each corner of the box around the moved points, along its \
                    largest axis, by the covariance of the pose.";
        right += &section("Uncertainty at the corners of the part", &(table(&rows) + &note(what)));
    }
    let page = HtmlPage {
        title: format!("Registration of {}", page.points_name),
        verdict: (passes, verdict.to_owned()),
        headline: headline(motion),
        sentence: format!("{} moved to {}", page.points_name, page.model_name),
        left: section("Before", &views(&[model(), before], &[]))
            + &section("After, coloured by the distance from the model", &after),
        right,
        json: serde_json::to_string(page.results)?,
    };
    page.write(out)
}

fn headline(motion: &TransformFile) -> String {
    format!(
        "rms {} (at the start {}), {} of {} points count",
        number(motion.rms),
        number(motion.initial_rms),
        motion.points_used,
        motion.points
    )
}

/// Finite points, evenly picked, and their number.
fn picked(points: &[Vector3<f64>]) -> (Vec<Vector3<f64>>, usize) {
    let step = points.len().div_ceil(SHOWN).max(1);
    let some: Vec<_> =
        points.iter().step_by(step).copied().filter(|x| x.iter().all(|c| c.is_finite())).collect();
    let count = some.len();
    (some, count)
}

fn by_residual(points: &[Vector3<f64>], distances: &[f64], limit: f64) -> Vec<Layer> {
    let colours = std::iter::once(BEYOND).chain(BANDS);
    let mut layers: Vec<Layer> = colours.map(|colour| Layer { colour, points: Vec::new() }).collect();
    for (x, distance) in points.iter().zip(distances) {
        // Where all distances are 0 all are in the first band.
        let share = if *distance <= 0.0 { 0.0 } else { distance / limit };
        let upper = (1..=BANDS.len()).find(|&band| share <= band as f64 / BANDS.len() as f64);
        layers[upper.unwrap_or(0)].points.push(*x);
    }
    layers
}

/// A corner of the box around the part, and the covariance of its position.
struct Corner {
    place: Vector3<f64>,
    covariance: Matrix3<f64>,
}

impl Corner {
    /// The standard deviation along the largest axis.
    fn sigma(&self) -> f64 {
        self.covariance.symmetric_eigenvalues().max().max(0.0).sqrt()
    }

    fn row(&self) -> (String, String) {
        let [x, y, z] = [0, 1, 2].map(|axis| number(self.place[axis]));
        (format!("({x}, {y}, {z})"), number(self.sigma()))
    }
}

/// The errors of the corners by the covariance of the pose; none where that is not known.
///
/// A displacement `t` of the origin `o` and a rotation vector `r` move the place `x` by `t + r × (x − o)`, and growth by `g (x − o)`.
fn corner_errors(motion: &TransformFile, moved: &[Vector3<f64>]) -> Vec<Corner> {
    let Some(covariance) = motion.covariance.as_ref().filter(|c| matches!(c.rows.len(), 6 | 7)) else {
        return Vec::new();
    };
    let Some(bounds) = Aabb::of_points(moved) else { return Vec::new() };
    let entry =
        |i: usize, j: usize| covariance.rows.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
    let full = SMatrix::<f64, 7, 7>::from_fn(entry);
    let corner = |k: u32| {
        Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { bounds.max[axis] } else { bounds.min[axis] })
    };
    (0..8u32)
        .map(|k| {
            let place = corner(k);
            let arm = place - covariance.origin;
            let mut motion = SMatrix::<f64, 3, 7>::zeros();
            motion.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
            motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-arm.cross_matrix()));
            motion.fixed_view_mut::<3, 1>(0, 6).copy_from(&arm);
            Corner { place, covariance: motion * full * motion.transpose() }
        })
        .filter(|corner| corner.covariance.iter().all(|value| value.is_finite()))
        .collect()
}

/// By which power of ten errors are drawn larger than they are.
fn exaggeration(corners: &[Corner]) -> f64 {
    let bounds = Aabb::of_points(corners.iter().map(|corner| &corner.place));
    let size = bounds.map_or(0.0, |bounds| bounds.sides().max());
    let largest = SIGMAS * corners.iter().map(Corner::sigma).fold(0.0, f64::max);
    let factor = 10f64.powf((DRAWN * size / largest).log10().floor());
    if factor.is_finite() && factor > 0.0 { factor } else { 1.0 }
}

/// Three views of layers, along z, y and x, to the same scale.
fn views(layers: &[Layer], corners: &[Corner]) -> String {
    let all = || layers.iter().flat_map(|layer| &layer.points);
    let Some(bounds) = Aabb::of_points(all()) else { return "<p>There is nothing to show.</p>\n".to_owned() };
    let size = bounds.sides().max().max(f64::MIN_POSITIVE);
    let scale = (SIDE - 2.0 * MARGIN) / size;
    let middle = bounds.centre();
    let factor = exaggeration(corners);
    let mut out = "<div class=\"views\">\n".to_owned();
    for (axes, name) in [([0, 1], "x, y"), ([0, 2], "x, z"), ([1, 2], "y, z")] {
        let flat = |x: &Vector3<f64>| {
            let [u, v] = axes.map(|axis| (x[axis] - middle[axis]) * scale);
            Vector2::new(0.5 * SIDE + u, 0.5 * SIDE - v)
        };
        // Writing to memory cannot fail.
        let _ = write!(
            out,
            "<svg width=\"{SIDE}\" height=\"{SIDE}\" viewBox=\"0 0 {SIDE} {SIDE}\" role=\"img\" aria-label=\"view in {name}\">"
        );
        for layer in layers.iter().filter(|layer| !layer.points.is_empty()) {
            let _ = write!(
                out,
                "<path fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\" stroke-linecap=\"round\" d=\"",
                layer.colour
            );
            for x in &layer.points {
                let at = flat(x);
                let _ = write!(out, "M{:.1} {:.1}h0", at.x, at.y);
            }
            out.push_str("\"/>");
        }
        for corner in corners {
            ellipse(&mut out, &flat(&corner.place), corner, axes, SIGMAS * factor * scale);
        }
        let _ = writeln!(out, "<text x=\"6\" y=\"{}\">{name}</text></svg>", SIDE - 6.0);
    }
    out.push_str("</div>\n");
    out
}

/// The error of a corner in a view.
fn ellipse(out: &mut String, at: &Vector2<f64>, corner: &Corner, axes: [usize; 2], scale: f64) {
    let eigen = SymmetricEigen::new(Matrix2::from_fn(|i, j| corner.covariance[(axes[i], axes[j])]));
    let radius = |k: usize| (eigen.eigenvalues[k].max(0.0).sqrt() * scale).max(0.5);
    let direction = eigen.eigenvectors.column(0);
    // Heights grow downwards in the picture.
    let angle = (-direction[1]).atan2(direction[0]).to_degrees();
    let _ = write!(
        out,
        "<ellipse cx=\"{x:.2}\" cy=\"{y:.2}\" rx=\"{:.2}\" ry=\"{:.2}\" transform=\"rotate({angle:.2} {x:.2} {y:.2})\" fill=\"#1d273322\" \
         stroke=\"#1d2733\"/>",
        radius(0),
        radius(1),
        x = at.x,
        y = at.y
    );
}

fn legend(limit: f64, corners: &[Corner]) -> String {
    let mut swatches = String::new();
    for (band, colour) in BANDS.iter().enumerate() {
        let upper = limit * (band + 1) as f64 / BANDS.len() as f64;
        swatches += &swatch(colour, &format!("up to {}", number(upper)));
    }
    swatches += &swatch(BEYOND, "beyond the limit, not counted");
    let mut out = format!("<p class=\"note\">{swatches}</p>\n");
    if !corners.is_empty() {
        out += &note(&format!(
            "Ellipses: {SIGMAS} standard deviations of the corners of the part by the covariance of the pose, drawn {} times as large as \
             they are.",
            number(exaggeration(corners))
        ));
    }
    out
}

/// What is in the table of the result.
fn facts(results: &RegistrationResults) -> Vec<(String, String)> {
    let motion = &results.transform;
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let mut rows = vec![
        ("status".to_owned(), motion.status.to_owned()),
        ("doubt".to_owned(), motion.support.doubt.map_or("none", |doubt| doubt.name()).to_owned()),
        ("rms at the start".to_owned(), number(motion.initial_rms)),
        ("rms".to_owned(), number(motion.rms)),
        ("points that count".to_owned(), percent(motion.support.share)),
        ("rms as a share of their size".to_owned(), percent(motion.support.relative_rms)),
    ];
    if let Some(best) = results.starts.get(results.best_start) {
        rows.push(("points near the model".to_owned(), percent(best.share_near)));
        rows.push(("estimated overlap".to_owned(), percent(best.overlap)));
    }
    if let Some(coverage) = &motion.coverage {
        rows.push(("of what could be seen of the model, has points".to_owned(), percent(coverage.covered)));
        rows.push(("of the whole model, has points".to_owned(), percent(coverage.model)));
    }
    for space in &motion.free_space {
        rows.push((
            format!("floating in front of what the rays of the {} met", space.scan),
            percent(space.found.share()),
        ));
    }
    for free in &motion.free_motions {
        rows.push(("not fixed".to_owned(), free.clone()));
    }
    rows.push(("turned by".to_owned(), format!("{}°", number(motion.rotation.angle.to_degrees()))));
    rows.push(("moved by".to_owned(), motion.translation.map(number).join(", ")));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_fall_into_their_bands() {
        let points = [Vector3::zeros(); 5];
        let layers = by_residual(&points, &[0.0, 0.19, 0.5, 1.0, 1.01], 1.0);
        assert_eq!(layers.iter().map(|layer| layer.points.len()).collect::<Vec<_>>(), [1, 2, 0, 1, 0, 1]);
        let none = by_residual(&points, &[0.0; 5], 0.0);
        assert_eq!(none[1].points.len(), 5);
    }

    #[test]
    fn errors_are_drawn_by_powers_of_ten() {
        let corner = |x: f64, sigma: f64| Corner {
            place: Vector3::x() * x,
            covariance: Matrix3::identity() * sigma * sigma,
        };
        assert_eq!(exaggeration(&[corner(0.0, 1e-4), corner(1.0, 2e-4)]), 100.0);
        assert_eq!(exaggeration(&[corner(0.0, 0.0), corner(1.0, 0.0)]), 1.0);
        assert_eq!(exaggeration(&[]), 1.0);
    }
}
