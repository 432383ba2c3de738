//! Writing SVG.

use std::fmt::Write;

/// Where a text stands relative to its point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// A drawing in the making. Lengths are pixels, `y` points down.
#[derive(Debug)]
pub(crate) struct Svg {
    text: String,
}

impl Svg {
    /// A white sheet.
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Self {
        let mut svg = Self { text: String::new() };
        svg.put(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n<title>{}</title>\n",
            escape(title)
        ));
        svg.rectangle([0.0, 0.0], [width, height], "#ffffff");
        svg
    }

    /// The finished file.
    pub(crate) fn finish(mut self) -> String {
        self.put(format_args!("</svg>\n"));
        self.text
    }

    fn put(&mut self, args: std::fmt::Arguments<'_>) {
        // Writing to memory cannot fail.
        let _ = self.text.write_fmt(args);
    }

    /// A text; `style` is any further attributes.
    pub(crate) fn text(&mut self, [x, y]: [f64; 2], size: f64, anchor: Anchor, style: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escape(text);
        self.put(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" text-anchor=\"{anchor}\" {style}>{text}</text>\n"
        ));
    }

    /// A text that runs upwards, centred on its point.
    pub(crate) fn text_upwards(&mut self, [x, y]: [f64; 2], size: f64, text: &str) {
        let style = format!("transform=\"rotate(-90 {x:.1} {y:.1})\" fill=\"#333\"");
        self.text([x, y], size, Anchor::Middle, &style, text);
    }

    /// A filled rectangle.
    pub(crate) fn rectangle(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], fill: &str) {
        self.put(format_args!(
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{fill}\"/>\n"
        ));
    }

    /// A line through points.
    pub(crate) fn polyline(&mut self, points: &[[f64; 2]], stroke: &str, width: f64) {
        self.put(format_args!(
            "<polyline fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{width}\" points=\""
        ));
        for [x, y] in points {
            self.put(format_args!("{x:.1},{y:.1} "));
        }
        self.put(format_args!("\"/>\n"));
    }

    /// Round dots of one colour.
    pub(crate) fn dots(&mut self, points: &[[f64; 2]], diameter: f64, colour: [u8; 3]) {
        let [r, g, b] = colour;
        self.put(format_args!(
            "<path fill=\"none\" stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"{diameter}\" \
             stroke-linecap=\"round\" d=\""
        ));
        for [x, y] in points {
            self.put(format_args!("M{x:.1} {y:.1}h0"));
        }
        self.put(format_args!("\"/>\n"));
    }

    /// Triangles of one colour; a hairline of the same colour closes the gaps between neighbours.
    pub(crate) fn triangles(&mut self, triangles: &[[[f64; 2]; 3]], colour: [u8; 3]) {
        let [r, g, b] = colour;
        let hex = format!("#{r:02x}{g:02x}{b:02x}");
        self.put(format_args!("<path fill=\"{hex}\" stroke=\"{hex}\" stroke-width=\".5\" d=\""));
        for [[ax, ay], [bx, by], [cx, cy]] in triangles {
            let [p, q] = [[bx - ax, by - ay], [cx - bx, cy - by]];
            self.put(format_args!("M{ax:.1} {ay:.1}l{:.1} {:.1} {:.1} {:.1}z", p[0], p[1], q[0], q[1]));
        }
        self.put(format_args!("\"/>\n"));
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
