//! Drawings in SVG: panels with points, lines and shaded surfaces.

use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineSurface, ParametricSurface};
use std::fmt::Write as _;

pub(super) const GREY: &str = "#9aa3ae";
pub(super) const RED: &str = "#d1342f";
pub(super) const BLUE: &str = "#1f5fa8";
pub(super) const BLACK: &str = "#20242a";
/// Height of the line of text over a panel, and room around it.
const TITLE: f64 = 26.0;
const MARGIN: f64 = 12.0;
/// Width of a character of the caption, at most.
const CHARACTER: f64 = 7.2;
/// Share of a surface, at each end, in which the inside of a tube is drawn.
const OPEN: f64 = 0.2;

/// A row of panels with titles, and a caption.
pub(super) struct Drawing {
    text: String,
    /// Where the next panel begins.
    x: f64,
    height: f64,
    caption: String,
}

/// A rectangle of a drawing with coordinates of its own, y upwards.
pub(super) struct Panel<'a> {
    drawing: &'a mut Drawing,
    low: Vector2<f64>,
    scale: f64,
    left: f64,
    bottom: f64,
}

impl Drawing {
    pub(super) fn new(height: f64, caption: &str) -> Self {
        Self { text: String::new(), x: 0.0, height, caption: caption.to_owned() }
    }

    /// A panel for the rectangle from `low` to `high`.
    pub(super) fn panel(&mut self, title: &str, low: Vector2<f64>, high: Vector2<f64>) -> Panel<'_> {
        let size = high - low;
        let scale = self.height / size.y;
        let width = (size.x * scale).max(7.4 * title.chars().count() as f64);
        let left = self.x + MARGIN + 0.5 * (width - size.x * scale);
        let middle = self.x + MARGIN + 0.5 * width;
        let _ = writeln!(
            self.text,
            r#"<text x="{middle:.0}" y="{:.0}" text-anchor="middle" font-size="14">{title}</text>"#,
            TITLE - 8.0
        );
        self.x += width + 2.0 * MARGIN;
        let bottom = TITLE + self.height;
        Panel { drawing: self, low, scale, left, bottom }
    }

    pub(super) fn finish(self) -> String {
        let width = self.x;
        // The caption in as many lines as it takes.
        let mut lines = vec![String::new()];
        for word in self.caption.split(' ') {
            let last = lines.len() - 1;
            if CHARACTER * (lines[last].chars().count() + word.chars().count()) as f64 > width - 2.0 * MARGIN
            {
                lines.push(String::new());
            }
            let last = lines.len() - 1;
            lines[last].push_str(word);
            lines[last].push(' ');
        }
        let mut caption = String::new();
        for (k, line) in lines.iter().enumerate() {
            let y = TITLE + self.height + 26.0 + 17.0 * k as f64;
            let _ = writeln!(
                caption,
                r#"<text x="{MARGIN}" y="{y:.0}" font-size="13">{}</text>"#,
                line.trim_end()
            );
        }
        let height = TITLE + self.height + 20.0 + 17.0 * lines.len() as f64;
        format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0} {height:.0}" font-family="sans-serif" fill="{BLACK}">
<rect width="{width:.0}" height="{height:.0}" fill="white"/>
{}{caption}</svg>
"#,
            self.text
        )
    }
}

impl Panel<'_> {
    fn at(&self, p: &Vector2<f64>) -> (f64, f64) {
        let d = (p - self.low) * self.scale;
        (self.left + d.x, self.bottom - d.y)
    }

    pub(super) fn points<'p>(
        &mut self,
        points: impl IntoIterator<Item = &'p Vector2<f64>>,
        radius: f64,
        colour: &str,
    ) {
        let mut path = String::new();
        for p in points {
            let (x, y) = self.at(p);
            let _ = write!(path, "M{x:.1} {y:.1}h0");
        }
        let _ = writeln!(
            self.drawing.text,
            r#"<path d="{path}" stroke="{colour}" stroke-width="{:.1}" stroke-linecap="round"/>"#,
            2.0 * radius
        );
    }

    pub(super) fn line(&mut self, points: &[Vector2<f64>], closed: bool, width: f64, colour: &str) {
        let mut path = String::new();
        for (k, p) in points.iter().enumerate() {
            let (x, y) = self.at(p);
            let _ = write!(path, "{}{x:.1} {y:.1}", if k == 0 { 'M' } else { 'L' });
        }
        let end = if closed { "Z" } else { "" };
        let _ = writeln!(
            self.drawing.text,
            r#"<path d="{path}{end}" fill="none" stroke="{colour}" stroke-width="{width}"/>"#
        );
    }

    /// A line of which nothing is seen outside the panel.
    pub(super) fn clipped_line(&mut self, points: &[Vector2<f64>], closed: bool, width: f64, colour: &str) {
        // Places far outside make numbers that some programs cannot draw.
        let limit = 1e4 / self.scale;
        let near: Vec<Vector2<f64>> = points.iter().map(|p| p.map(|c| c.clamp(-limit, limit))).collect();
        let (left, top) = (self.left, TITLE);
        let name = format!("clip-{}", self.drawing.text.len());
        let right = self.drawing.x - MARGIN;
        let _ = writeln!(
            self.drawing.text,
            r##"<clipPath id="{name}"><rect x="{left:.1}" y="{top}" width="{:.1}" height="{:.1}"/></clipPath><g clip-path="url(#{name})">"##,
            right - left,
            self.bottom - top
        );
        self.line(&near, closed, width, colour);
        self.drawing.text.push_str("</g>\n");
    }

    pub(super) fn label(&mut self, at: &Vector2<f64>, text: &str, colour: &str) {
        let (x, y) = self.at(at);
        let _ = writeln!(
            self.drawing.text,
            r#"<text x="{x:.0}" y="{y:.0}" text-anchor="middle" font-size="13" fill="{colour}">{text}</text>"#
        );
    }

    /// A surface seen by `camera`, lit from the upper left, in so many cells. Of the inside of a tube only what is near its ends
    /// can be seen.
    pub(super) fn surface(&mut self, surface: &BsplineSurface, camera: &Camera, [m, n]: [usize; 2]) {
        let [u, v] = surface.domain();
        let place =
            |i: usize, j: usize| surface.point(u.lerp(i as f64 / m as f64), v.lerp(j as f64 / n as f64));
        let net: Vec<Vec<Vector3<f64>>> =
            (0..=m).map(|i| (0..=n).map(|j| camera.seen(&place(i, j))).collect()).collect();
        let mut cells = Vec::new();
        for i in 0..m {
            for j in 0..n {
                let corners = [net[i][j], net[i + 1][j], net[i + 1][j + 1], net[i][j + 1]];
                let normal = (corners[2] - corners[0]).cross(&(corners[3] - corners[1]));
                let Some(normal) = normal.try_normalize(0.0) else { continue };
                let share = (j as f64 + 0.5) / n as f64;
                if normal.z < 0.0 && (OPEN..1.0 - OPEN).contains(&share) {
                    continue;
                }
                let depth = corners.iter().map(|c| c.z).sum::<f64>();
                cells.push((depth, corners, normal));
            }
        }
        // The farthest first.
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        let light = Vector3::new(-0.45, 0.55, 0.7).normalize();
        // Without smoothed edges no background shows between cells.
        let _ = writeln!(self.drawing.text, r#"<g shape-rendering="crispEdges">"#);
        for (_, corners, normal) in cells {
            // The inside of a tube is darker.
            let (inside, normal) = if normal.z < 0.0 { (0.55, -normal) } else { (1.0, normal) };
            let bright = (inside * (0.35 + 0.65 * normal.dot(&light).max(0.0))).min(1.0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 255")]
            let [r, g, b] = [214.0, 222.0, 235.0].map(|c: f64| (c * bright).round() as u8);
            let places = corners.map(|corner| self.at(&corner.xy()));
            // Relative places with one digit, which is enough and short.
            let rounded = places.map(|(x, y)| [x, y].map(|c| (10.0 * c).round()));
            let _ =
                write!(self.drawing.text, r#"<path d="m{} {}l"#, rounded[0][0] / 10.0, rounded[0][1] / 10.0);
            for pair in rounded.windows(2) {
                let [dx, dy] = [0, 1].map(|k| (pair[1][k] - pair[0][k]) / 10.0);
                let _ = write!(self.drawing.text, "{dx} {dy} ");
            }
            let _ = writeln!(self.drawing.text, r##"z" fill="#{r:02x}{g:02x}{b:02x}"/>"##);
        }
        self.drawing.text.push_str("</g>\n");
    }
}

/// A direction of view: points become right, up and towards the eye.
pub(super) struct Camera {
    axes: [Vector3<f64>; 3],
}

impl Camera {
    /// With the direction `up` upwards in the picture, seen from a little above.
    pub(super) fn new(up: &Vector3<f64>, side: &Vector3<f64>) -> Self {
        let back = up.cross(side).normalize();
        let towards = (back + up * 0.35).normalize();
        let right = up.cross(&towards).normalize();
        Self { axes: [right, towards.cross(&right), towards] }
    }

    pub(super) fn seen(&self, p: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from(self.axes.map(|axis| axis.dot(p)))
    }
}

/// Corners of the box around places.
pub(super) fn bounds<'p>(places: impl IntoIterator<Item = &'p Vector2<f64>>) -> [Vector2<f64>; 2] {
    places
        .into_iter()
        .fold([Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY)], |[low, high], p| {
            [low.inf(p), high.sup(p)]
        })
}
