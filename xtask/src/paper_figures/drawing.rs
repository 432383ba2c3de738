//! Drawings in SVG: panels with points, lines and shaded surfaces.

use nalgebra::Vector2;
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
}

/// Corners of the box around places.
pub(super) fn bounds<'p>(places: impl IntoIterator<Item = &'p Vector2<f64>>) -> [Vector2<f64>; 2] {
    places
        .into_iter()
        .fold([Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY)], |[low, high], p| {
            [low.inf(p), high.sup(p)]
        })
}
