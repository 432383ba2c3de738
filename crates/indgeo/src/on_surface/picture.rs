//! The picture of values on a mesh: shaded triangles in an oblique view, isolines, curves, and a scale.

use crate::error::Error;
use crate::files;
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::mesh::nalgebra::{Point3, Rotation3, Vector3};
use std::fmt::Write;
use std::path::Path;

/// Width and height of the longer side, in pixels; free space around; width of the scale.
const SIZE: f64 = 720.0;
const MARGIN: f64 = 24.0;
const SCALE: f64 = 100.0;
/// Isolines.
const LINES: usize = 16;
/// Most triangles that are drawn.
const MOST: usize = 200_000;
/// How far curves are drawn before the surface, as a share of the depth.
const BEFORE: f64 = 0.01;

/// Makes sure that the picture can have its format.
pub(crate) fn check(path: &Path) -> Result<(), Error> {
    if files::extension(path) == "svg" || files::is_stream(path) {
        return Ok(());
    }
    Err(Error::content(path, "pictures are SVG", "choose a name that ends in .svg"))
}

/// Makes sure that a picture of the mesh is not too large to be looked at.
pub(crate) fn check_size(mesh: &TriangleMesh, path: &Path) -> Result<(), Error> {
    let count = mesh.triangles().len();
    if count <= MOST {
        return Ok(());
    }
    let what = format!("a picture of {count} triangles would be too large, at most {MOST} are drawn");
    Err(Error::content(path, what, "leave out --picture, and colour the PLY by its scalar"))
}

/// Draws one value per vertex, and curves.
pub(crate) fn draw(mesh: &TriangleMesh, values: &[f64], curves: &[&[[f64; 3]]]) -> String {
    let view = Rotation3::from_axis_angle(&Vector3::x_axis(), -1.1)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), -0.6);
    let seen: Vec<Point3<f64>> = mesh.vertices().iter().map(|point| view * point).collect();
    let finite = |point: &Point3<f64>| point.iter().all(|c| c.is_finite());
    let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for point in seen.iter().filter(|point| finite(point)) {
        (low, high) = (low.inf(&point.coords), high.sup(&point.coords));
    }
    let sides = high - low;
    let zoom = SIZE / sides.x.max(sides.y).max(f64::MIN_POSITIVE);
    let place = |point: &Point3<f64>| [MARGIN + (point.x - low.x) * zoom, MARGIN + (high.y - point.y) * zoom];
    let shown = values.iter().copied().filter(|value| value.is_finite());
    let (min, max) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let (min, max) = if max > min { (min, max) } else { (min.min(0.0), min.min(0.0) + 1.0) };
    let (width, height) = (sides.x * zoom + 2.0 * MARGIN + SCALE, sides.y * zoom + 2.0 * MARGIN);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.1} {height:.1}\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    // From far to near.
    let mut order: Vec<(f64, String)> = Vec::new();
    let light = Vector3::new(0.35, 0.5, 0.8).normalize();
    for triangle in mesh.triangles().iter() {
        let corners = triangle.map(|index| seen[index as usize]);
        if !corners.iter().all(finite) {
            continue;
        }
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let normal = normal / normal.norm().max(f64::MIN_POSITIVE);
        let heights = triangle.map(|index| values.get(index as usize).copied().unwrap_or(f64::NAN));
        let mean = heights.iter().sum::<f64>() / 3.0;
        let base = if mean.is_finite() { colour((mean - min) / (max - min)) } else { [200, 200, 200] };
        let shade = 0.62 + 0.38 * normal.dot(&light).abs();
        let [r, g, b] = base.map(|c| f64::from(c) * shade);
        let [p, q, s] = corners.map(|corner| place(&corner));
        let mut drawn = format!(
            "<path d=\"M{:.2} {:.2}L{:.2} {:.2}L{:.2} {:.2}Z\" fill=\"rgb({r:.0},{g:.0},{b:.0})\" stroke=\"rgb({r:.0},{g:.0},{b:.0})\" \
             stroke-width=\".4\"/>\n",
            p[0], p[1], q[0], q[1], s[0], s[1]
        );
        for line in 1..LINES {
            let level = min + (max - min) * line as f64 / LINES as f64;
            if let Some([a, b]) = crossed(&corners, heights, level) {
                let ([a, b], [c, d]) = (place(&a), place(&b));
                let _ = writeln!(
                    drawn,
                    "<path d=\"M{a:.2} {b:.2}L{c:.2} {d:.2}\" stroke=\"#1b1f24\" stroke-width=\".8\" fill=\"none\"/>"
                );
            }
        }
        order.push((corners.iter().map(|corner| corner.z).sum::<f64>() / 3.0, drawn));
    }
    for curve in curves {
        for pair in curve.windows(2) {
            let [one, other] = [pair[0], pair[1]].map(|point| view * Point3::from(point));
            let ([a, b], [c, d]) = (place(&one), place(&other));
            let drawn = format!(
                "<path d=\"M{a:.2} {b:.2}L{c:.2} {d:.2}\" stroke=\"#d81b60\" stroke-width=\"3\" stroke-linecap=\"round\"/>\n"
            );
            order.push((0.5 * (one.z + other.z) + BEFORE * sides.z.max(sides.x), drawn));
        }
    }
    order.sort_by(|one, other| one.0.total_cmp(&other.0));
    out.extend(order.into_iter().map(|(_, drawn)| drawn));
    scale(&mut out, [min, max], width - SCALE, height);
    out.push_str("</svg>\n");
    out
}

/// Where a level crosses a triangle.
fn crossed(corners: &[Point3<f64>; 3], values: [f64; 3], level: f64) -> Option<[Point3<f64>; 2]> {
    let mut ends = Vec::with_capacity(2);
    for k in 0..3 {
        let (a, b) = (values[k], values[(k + 1) % 3]);
        if (a < level) != (b < level) && (b - a).is_finite() {
            ends.push(corners[k] + (corners[(k + 1) % 3] - corners[k]) * ((level - a) / (b - a)));
        }
    }
    <[Point3<f64>; 2]>::try_from(ends).ok()
}

/// From dark blue over green to yellow.
fn colour(share: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 57.0, 130.0],
        [49.0, 104.0, 142.0],
        [53.0, 155.0, 133.0],
        [130.0, 200.0, 90.0],
        [250.0, 230.0, 80.0],
    ];
    let at = share.clamp(0.0, 1.0) * 4.0;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 3")]
    let k = (at.floor() as usize).min(3);
    let mix = |c: usize| STOPS[k][c] + (STOPS[k + 1][c] - STOPS[k][c]) * (at - k as f64);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 255")]
    let byte = |value: f64| value.round() as u8;
    [0, 1, 2].map(|c| byte(mix(c)))
}

fn scale(out: &mut String, [min, max]: [f64; 2], left: f64, height: f64) {
    let (top, bottom) = (MARGIN, height - MARGIN);
    let steps = 64;
    for step in 0..steps {
        let share = (f64::from(step) + 0.5) / f64::from(steps);
        let [r, g, b] = colour(share);
        let size = (bottom - top) / f64::from(steps);
        let y = bottom - (f64::from(step) + 1.0) * size;
        let _ = writeln!(
            out,
            "<rect x=\"{left:.1}\" y=\"{y:.2}\" width=\"16\" height=\"{:.2}\" fill=\"rgb({r},{g},{b})\"/>",
            size + 0.4
        );
    }
    for tick in 0..=4 {
        let share = f64::from(tick) / 4.0;
        let (value, y) = (min + (max - min) * share, bottom - (bottom - top) * share);
        let _ = writeln!(out, "<text x=\"{:.1}\" y=\"{:.1}\">{value:.4}</text>", left + 22.0, y + 4.0);
    }
}
