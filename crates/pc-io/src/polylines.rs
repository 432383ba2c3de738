//! Polylines, such as tessellated curves, for programs that know no NURBS.

use std::fmt;
use std::io::{self, Write};

use crate::number::write_number;

/// A format that holds polylines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PolylineFormat {
    /// Wavefront OBJ, one `l` element per polyline.
    Obj,
    /// PLY with an element `edge`, as text.
    Ply,
    /// Scalable Vector Graphics, of polylines in planes `z = constant`; y points up.
    Svg,
    /// Drawing Interchange Format (R12), one `POLYLINE` in space per polyline.
    Dxf,
}

impl PolylineFormat {
    /// The format with a file name extension (without dot, in upper or lower case).
    #[must_use]
    pub fn from_extension(extension: &str) -> Option<Self> {
        Some(match extension.to_ascii_lowercase().as_str() {
            "obj" => Self::Obj,
            "ply" => Self::Ply,
            "svg" => Self::Svg,
            "dxf" => Self::Dxf,
            _ => return None,
        })
    }

    /// The usual extension, without dot.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Svg => "svg",
            Self::Dxf => "dxf",
        }
    }
}

impl fmt::Display for PolylineFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.extension().to_ascii_uppercase())
    }
}

/// Writes polylines, each a list of vertices in order, with full precision. One whose last vertex is its first one is closed.
///
/// SVG shows x and y; what lies in planes `z = constant` keeps its shape there. Lengths have the unit of the vertices.
///
/// # Errors
/// Those of the writer.
pub fn write_polylines(
    mut out: impl Write,
    polylines: &[Vec<[f64; 3]>],
    format: PolylineFormat,
) -> io::Result<()> {
    let out = &mut out;
    match format {
        PolylineFormat::Obj => write_obj(out, polylines),
        PolylineFormat::Ply => write_ply(out, polylines),
        PolylineFormat::Svg => write_svg(out, polylines),
        PolylineFormat::Dxf => write_dxf(out, polylines),
    }
}

/// The vertices that are written: without the last one of a closed polyline, and whether it is closed.
fn open(polyline: &[[f64; 3]]) -> (&[[f64; 3]], bool) {
    match polyline {
        [first, inner @ .., last] if first == last && inner.len() > 1 => {
            (&polyline[..polyline.len() - 1], true)
        }
        _ => (polyline, false),
    }
}

fn write_point(out: &mut impl Write, point: &[f64]) -> io::Result<()> {
    for (k, value) in point.iter().enumerate() {
        if k > 0 {
            out.write_all(b" ")?;
        }
        write_number(out, *value)?;
    }
    Ok(())
}

fn write_obj(out: &mut impl Write, polylines: &[Vec<[f64; 3]>]) -> io::Result<()> {
    let mut next = 1;
    for polyline in polylines {
        let (vertices, closed) = open(polyline);
        for vertex in vertices {
            out.write_all(b"v ")?;
            write_point(out, vertex)?;
            out.write_all(b"\n")?;
        }
        out.write_all(b"l")?;
        for index in next..next + vertices.len() {
            write!(out, " {index}")?;
        }
        if closed {
            write!(out, " {next}")?;
        }
        out.write_all(b"\n")?;
        next += vertices.len();
    }
    Ok(())
}

fn write_ply(out: &mut impl Write, polylines: &[Vec<[f64; 3]>]) -> io::Result<()> {
    let (mut points, mut edges) = (0, 0);
    for polyline in polylines {
        let (vertices, closed) = open(polyline);
        points += vertices.len();
        edges += (vertices.len() + usize::from(closed)).saturating_sub(1);
    }
    writeln!(out, "ply\nformat ascii 1.0\nelement vertex {points}")?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    writeln!(out, "element edge {edges}\nproperty int vertex1\nproperty int vertex2\nend_header")?;
    for vertex in polylines.iter().flat_map(|polyline| open(polyline).0) {
        write_point(out, vertex)?;
        out.write_all(b"\n")?;
    }
    let mut first = 0;
    for polyline in polylines {
        let (vertices, closed) = open(polyline);
        let end = first + vertices.len();
        for start in first..end.saturating_sub(1) {
            writeln!(out, "{start} {}", start + 1)?;
        }
        if closed {
            writeln!(out, "{} {first}", end - 1)?;
        }
        first = end;
    }
    Ok(())
}

/// Share of the size that is left free around a picture.
const MARGIN: f64 = 0.02;

fn write_svg(out: &mut impl Write, polylines: &[Vec<[f64; 3]>]) -> io::Result<()> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for vertex in polylines.iter().flatten() {
        for axis in 0..2 {
            low[axis] = low[axis].min(vertex[axis]);
            high[axis] = high[axis].max(vertex[axis]);
        }
    }
    if polylines.iter().all(Vec::is_empty) {
        (low, high) = ([0.0; 2], [1.0; 2]);
    }
    let extent = (high[0] - low[0]).max(high[1] - low[1]);
    let margin = if extent > 0.0 { extent * MARGIN } else { 1.0 };
    let [width, height] = [0, 1].map(|axis| high[axis] - low[axis] + 2.0 * margin);
    // The y axis of SVG points down.
    write!(out, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"")?;
    write_point(out, &[low[0] - margin, -high[1] - margin, width, height])?;
    writeln!(out, "\">\n<g fill=\"none\" stroke=\"black\" stroke-width=\"1\" transform=\"scale(1 -1)\">")?;
    for polyline in polylines {
        let (vertices, closed) = open(polyline);
        write!(out, "<path vector-effect=\"non-scaling-stroke\" d=\"")?;
        for (k, vertex) in vertices.iter().enumerate() {
            out.write_all(if k == 0 { b"M" } else { b" L" })?;
            write_point(out, &vertex[..2])?;
        }
        writeln!(out, "{}\"/>", if closed { " Z" } else { "" })?;
    }
    writeln!(out, "</g>\n</svg>")
}

fn write_dxf(out: &mut impl Write, polylines: &[Vec<[f64; 3]>]) -> io::Result<()> {
    writeln!(out, "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n0\nSECTION\n2\nENTITIES")?;
    for polyline in polylines {
        let (vertices, closed) = open(polyline);
        // 66: vertices follow; 70: 8 for a polyline in space, 1 for a closed one.
        writeln!(out, "0\nPOLYLINE\n8\n0\n66\n1\n10\n0\n20\n0\n30\n0\n70\n{}", 8 + i32::from(closed))?;
        for vertex in vertices {
            write!(out, "0\nVERTEX\n8\n0")?;
            for (code, value) in [10, 20, 30].iter().zip(vertex) {
                write!(out, "\n{code}\n")?;
                write_number(out, *value)?;
            }
            // 32: a vertex of a polyline in space.
            writeln!(out, "\n70\n32")?;
        }
        writeln!(out, "0\nSEQEND\n8\n0")?;
    }
    writeln!(out, "0\nENDSEC\n0\nEOF")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(format: PolylineFormat) -> String {
        let triangle = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.5, 0.0], [0.0, 0.0, 0.0]];
        let segment = vec![[3.0, 0.0, 1.0], [3.0, 1.0, 1.0]];
        let mut out = Vec::new();
        write_polylines(&mut out, &[triangle, segment], format).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn closed_and_open_polylines_are_told_apart() {
        assert_eq!(
            written(PolylineFormat::Obj),
            "v 0 0 0\nv 1 0 0\nv 0 2.5 0\nl 1 2 3 1\nv 3 0 1\nv 3 1 1\nl 4 5\n"
        );
        let ply = written(PolylineFormat::Ply);
        assert!(ply.contains("element vertex 5\n") && ply.contains("element edge 4\n"), "{ply}");
        assert!(ply.ends_with("0 1\n1 2\n2 0\n3 4\n"), "{ply}");
        let svg = written(PolylineFormat::Svg);
        assert!(svg.contains("d=\"M0 0 L1 0 L0 2.5 Z\"") && svg.contains("d=\"M3 0 L3 1\""), "{svg}");
        let dxf = written(PolylineFormat::Dxf);
        assert_eq!((dxf.matches("\nVERTEX\n").count(), dxf.matches("\n70\n9\n").count()), (5, 1));
        assert!(dxf.ends_with("0\nENDSEC\n0\nEOF\n") && dxf.contains("\n20\n2.5\n"), "{dxf}");
    }

    #[test]
    fn the_picture_holds_all_vertices() {
        let svg = written(PolylineFormat::Svg);
        let start = svg.find("viewBox=\"").unwrap() + 9;
        let numbers: Vec<f64> =
            svg[start..].split('"').next().unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
        let [x, y, width, height] = numbers[..] else { panic!("{svg}") };
        assert!(x < 0.0 && x + width > 3.0 && y < -2.5 && y + height > 0.0, "{numbers:?}");
    }
}
