//! Writing PLY.

use std::io::{self, Write};

use mesh_core::TextField;

use crate::shape::{Keeps, Shape};
use crate::write_number;

const KEEPS: Keeps = Keeps {
    normals: true,
    colours: true,
    opacity: true,
    scalars: true,
    texts: true,
    triangles: true,
    plane: true,
};

/// Writes doubles, as text or as little endian binary.
pub(crate) fn write(
    out: &mut dyn Write,
    shape: Shape<'_>,
    ascii: bool,
    warnings: &mut Vec<String>,
) -> io::Result<()> {
    write_first(out, shape, shape.positions().len(), ascii, warnings)?;
    let mut row = Row { ascii, bytes: Vec::new() };
    for triangle in shape.triangles {
        row.triangle(triangle)?;
        row.end(out)?;
    }
    Ok(())
}

/// Writes the header of a file of `count` points, and the first of them.
pub(crate) fn write_first(
    out: &mut dyn Write,
    shape: Shape<'_>,
    count: usize,
    ascii: bool,
    warnings: &mut Vec<String>,
) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let names = shape.scalar_names(warnings);
    let texts = shape.texts(&names);
    let texts: Vec<Text<'_>> = texts.into_iter().map(|(name, field)| Text::new(name, field)).collect();
    write_header(out, shape, count, ascii, &names, &texts)?;
    write_points(out, shape, ascii, &texts)
}

/// Writes more points, which have no texts.
pub(crate) fn write_more(out: &mut dyn Write, shape: Shape<'_>, ascii: bool) -> io::Result<()> {
    write_points(out, shape, ascii, &[])
}

fn write_points(out: &mut dyn Write, shape: Shape<'_>, ascii: bool, texts: &[Text<'_>]) -> io::Result<()> {
    let mut row = Row { ascii, bytes: Vec::new() };
    for (index, point) in shape.positions().iter().enumerate() {
        row.doubles(&point.coords.as_slice()[..shape.cloud.dimension()])?;
        if let Some(normal) = shape.normals().and_then(|normals| normals.get(index)) {
            row.doubles(normal.as_slice())?;
        }
        if let Some((colours, rgba)) =
            shape.colours().and_then(|colours| Some((colours, colours.rgba(index)?)))
        {
            row.colour(if colours.has_alpha() { &rgba } else { &rgba[..3] })?;
        }
        for field in shape.attributes().scalars() {
            row.doubles(&field.values[index..=index])?;
        }
        for text in texts {
            row.text(text, text.field.get(index).unwrap_or_default())?;
        }
        row.end(out)?;
    }
    Ok(())
}

/// Texts as lists of bytes, whose lengths take one byte if all are short.
struct Text<'a> {
    name: String,
    field: &'a TextField,
    is_long: bool,
}

impl<'a> Text<'a> {
    fn new(name: String, field: &'a TextField) -> Self {
        Self { name, field, is_long: field.iter().any(|text| text.len() > 255) }
    }
}

fn write_header(
    out: &mut dyn Write,
    shape: Shape<'_>,
    count: usize,
    ascii: bool,
    names: &[String],
    texts: &[Text<'_>],
) -> io::Result<()> {
    let format = if ascii { "ascii" } else { "binary_little_endian" };
    write!(out, "ply\nformat {format} 1.0\nelement vertex {count}\n")?;
    let normals = if shape.normals().is_some() { ["nx", "ny", "nz"].as_slice() } else { &[] };
    for name in shape.axes().iter().chain(normals) {
        writeln!(out, "property double {name}")?;
    }
    if let Some(colours) = shape.colours() {
        let channels = ["red", "green", "blue", "alpha"];
        for name in &channels[..if colours.has_alpha() { 4 } else { 3 }] {
            writeln!(out, "property uchar {name}")?;
        }
    }
    for name in names {
        writeln!(out, "property double {name}")?;
    }
    for text in texts {
        writeln!(out, "property list {} uchar {}", if text.is_long { "uint" } else { "uchar" }, text.name)?;
    }
    if !shape.triangles.is_empty() {
        write!(out, "element face {}\nproperty list uchar uint vertex_indices\n", shape.triangles.len())?;
    }
    out.write_all(b"end_header\n")
}

/// A row in the making.
struct Row {
    ascii: bool,
    bytes: Vec<u8>,
}

impl Row {
    fn separate(&mut self) {
        if !self.bytes.is_empty() {
            self.bytes.push(b' ');
        }
    }

    fn doubles(&mut self, values: &[f64]) -> io::Result<()> {
        for &value in values {
            if self.ascii {
                self.separate();
                write_number(&mut self.bytes, value)?;
            } else {
                self.bytes.extend(value.to_le_bytes());
            }
        }
        Ok(())
    }

    fn colour(&mut self, channels: &[u8]) -> io::Result<()> {
        for &channel in channels {
            if self.ascii {
                self.separate();
                write!(self.bytes, "{channel}")?;
            } else {
                self.bytes.push(channel);
            }
        }
        Ok(())
    }

    fn text(&mut self, text: &Text<'_>, value: &str) -> io::Result<()> {
        if self.ascii {
            self.separate();
            write!(self.bytes, "{}", value.len())?;
            return value.bytes().try_for_each(|byte| write!(self.bytes, " {byte}"));
        }
        // No text is longer than the memory that indices of 32 bits reach.
        let length = u32::try_from(value.len()).map_err(io::Error::other)?;
        let length = length.to_le_bytes();
        self.bytes.extend_from_slice(if text.is_long { &length } else { &length[..1] });
        self.bytes.extend(value.bytes());
        Ok(())
    }

    fn triangle(&mut self, corners: &[u32; 3]) -> io::Result<()> {
        let [a, b, c] = corners;
        if self.ascii {
            return write!(self.bytes, "3 {a} {b} {c}");
        }
        self.bytes.push(3);
        for corner in corners {
            self.bytes.extend(corner.to_le_bytes());
        }
        Ok(())
    }

    fn end(&mut self, out: &mut dyn Write) -> io::Result<()> {
        if self.ascii {
            self.bytes.push(b'\n');
        }
        out.write_all(&self.bytes)?;
        self.bytes.clear();
        Ok(())
    }
}
