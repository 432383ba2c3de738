//! OFF, the Object File Format of Geomview, as text.

use std::io::{self, Write};

use mesh_core::{Attributes, PointCloud};
use nalgebra::{Point3, Vector3};

use crate::columns::{Column, Kind, colours};
use crate::parsed::{Fans, Parsed};
use crate::shape::{Keeps, Shape};
use crate::source::{Lines, Source, is_blank, quoted, words};
use crate::{Error, Format, Place};
use crate::{number, write_number};

const EXPORT: &str = "correct the line or export the file again";

/// What the first word says about the vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Header {
    texture: bool,
    colours: bool,
    normals: bool,
    /// Four coordinates, or a dimension of its own.
    other_dimension: bool,
    /// Length of the word.
    length: usize,
}

/// The header word `[ST][C][N][4][n]OFF`, to be followed by a separator or a digit.
pub(crate) fn header(text: &[u8]) -> Option<Header> {
    let mut at = 0;
    let mut eat = |word: &[u8]| {
        let found = text[at..].starts_with(word);
        at += if found { word.len() } else { 0 };
        found
    };
    let (texture, colours, normals) = (eat(b"ST"), eat(b"C"), eat(b"N"));
    let other_dimension = eat(b"4") | eat(b"n");
    let found = eat(b"OFF");
    let follows =
        text.get(at).is_none_or(|byte| byte.is_ascii_whitespace() || byte.is_ascii_digit() || *byte == b'#');
    (found && follows).then_some(Header { texture, colours, normals, other_dimension, length: at })
}

/// The lines that hold something, without comments.
struct Rows<'a> {
    source: Source<'a>,
    lines: Lines<'a>,
}

impl<'a> Rows<'a> {
    fn next(&mut self, what: &str) -> Result<(usize, &'a [u8]), Error> {
        let rows = self
            .lines
            .by_ref()
            .map(|(at, line)| (at, line.split(|&byte| byte == b'#').next().unwrap_or(line)));
        rows.into_iter().find(|(_, line)| !line.iter().all(|&byte| is_blank(byte))).ok_or_else(|| {
            self.source.line_error(
                self.source.data.len(),
                format!("the file ends where {what} is expected"),
                "the file is truncated or its counts are wrong, export it again",
            )
        })
    }
}

/// Reads points with normals and colours, and triangles.
pub(crate) fn read(source: Source<'_>) -> Result<Parsed, Error> {
    let start = source.data.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
    let header = header(&source.data[start..])
        .ok_or_else(|| source.line_error(start, "an OFF file begins with the word OFF", EXPORT))?;
    let mut rows = Rows { source, lines: source.lines_from(start + header.length) };
    let (at, line) = rows.next("the number of vertices")?;
    if line.trim_ascii().starts_with(b"BINARY") || header.other_dimension {
        let what = "binary OFF and vertices of four or n coordinates are not read";
        return Err(Error::unsupported(
            Place::Line(source.line_at(at)),
            what,
            "convert the file to ascii OFF or PLY",
        ));
    }
    let mut counts = words(line).map(number::parse_count);
    let (Some(Some(vertices)), Some(Some(faces))) = (counts.next(), counts.next()) else {
        let what = format!("{} is not the number of vertices, faces and edges", quoted(line.trim_ascii()));
        return Err(source.line_error(at, what, EXPORT));
    };
    let next = rows.lines.offset();
    let both = vertices.saturating_mul(6).saturating_add(faces.saturating_mul(2));
    source.check_promise(next, format_args!("vertices and {faces} faces"), vertices, 6, true)?;
    source.check_promise(
        next,
        format_args!("characters for {vertices} vertices and {faces} faces"),
        both,
        1,
        true,
    )?;

    let mut warnings = Vec::new();
    let cloud = read_vertices(&mut rows, header, vertices, &mut warnings)?;
    let mut fans = Fans::default();
    let mut coloured = 0usize;
    for _ in 0..faces {
        coloured += usize::from(read_face(&mut rows, vertices, &mut fans)?);
    }
    if coloured > 0 {
        warnings.push(format!("not read: colours of {coloured} faces"));
    }
    Ok(Parsed { format: Format::Off, cloud, triangles: Some(fans.finish(&mut warnings)), warnings })
}

fn read_vertices(
    rows: &mut Rows<'_>,
    header: Header,
    count: u64,
    warnings: &mut Vec<String>,
) -> Result<PointCloud, Error> {
    let mut positions = Vec::new();
    let mut normals = Vec::new();
    let mut channels: Vec<Column> = Vec::new();
    let mut surplus = 0usize;
    let colours_at = if header.normals { 6 } else { 3 };
    for vertex in 0..count {
        let (at, line) = rows.next(&format!("vertex {vertex}"))?;
        let mut numbers = [0.0; 12];
        let mut length = 0;
        for word in words(line) {
            let Some(value) = number::parse(word) else {
                return Err(rows.source.line_error(at, format!("{} is not a number", quoted(word)), EXPORT));
            };
            if let Some(place) = numbers.get_mut(length) {
                *place = value;
                length += 1;
            }
        }
        if length < colours_at {
            let what = format!("vertex {vertex} has {length} numbers where {colours_at} are expected");
            return Err(rows.source.line_error(at, what, EXPORT));
        }
        positions.push(Point3::new(numbers[0], numbers[1], numbers[2]));
        if header.normals {
            normals.push(Vector3::new(numbers[3], numbers[4], numbers[5]));
        }
        let rest = &numbers[colours_at..length];
        if header.colours {
            let texture = if header.texture { 2 } else { 0 };
            let rest = &rest[..rest.len().saturating_sub(texture)];
            if vertex == 0 && matches!(rest.len(), 3 | 4) {
                let kind = if words(line).skip(colours_at).any(|word| word.contains(&b'.')) {
                    Kind::Float
                } else {
                    Kind::Integer
                };
                channels =
                    rest.iter().map(|_| Column { name: String::new(), kind, values: Vec::new() }).collect();
            }
            if channels.len() == rest.len() {
                channels.iter_mut().zip(rest).for_each(|(channel, &value)| channel.values.push(value));
            }
        } else {
            surplus += usize::from(!rest.is_empty());
        }
    }
    if surplus > 0 {
        warnings
            .push(format!("{surplus} vertices have numbers after their coordinates, which were not read"));
    }
    let mut attributes = Attributes::default();
    if header.normals {
        attributes.set_normals(Some(normals));
    }
    if header.colours && count > 0 {
        if !channels.is_empty() && channels.iter().all(|channel| channel.values.len() == positions.len()) {
            attributes.set_colours(colours(&channels.iter().collect::<Vec<_>>(), warnings));
        } else {
            warnings.push(
                "the vertices have not three or four colour numbers each; colours were not read".to_owned(),
            );
        }
    }
    PointCloud::new(positions).with_attributes(attributes).map_err(Error::shape)
}

/// Reads one face and tells whether it had a colour.
fn read_face(rows: &mut Rows<'_>, vertices: u64, fans: &mut Fans) -> Result<bool, Error> {
    let (at, line) = rows.next("a face")?;
    let mut words = words(line);
    let length = words.next().and_then(number::parse_count);
    let mut corners = Vec::new();
    for _ in 0..length.unwrap_or(0) {
        let index = words.next().and_then(number::parse_count).filter(|&index| index < vertices);
        match index.and_then(|index| u32::try_from(index).ok()) {
            Some(index) => corners.push(index),
            None => {
                let what = format!(
                    "{} is not a face over {vertices} vertices (counted from 0)",
                    quoted(line.trim_ascii())
                );
                return Err(rows.source.line_error(at, what, EXPORT));
            }
        }
    }
    if length.is_none() {
        let what = format!("{} does not begin with a number of corners", quoted(line.trim_ascii()));
        return Err(rows.source.line_error(at, what, EXPORT));
    }
    fans.push(&corners);
    Ok(words.next().is_some())
}

const KEEPS: Keeps =
    Keeps { normals: true, colours: true, opacity: true, scalars: false, triangles: true, plane: false };

/// Writes `OFF`, `NOFF`, `COFF` or `CNOFF`; colours as integers.
pub(crate) fn write(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let colours = if shape.colours().is_some() { "C" } else { "" };
    let normals = if shape.normals().is_some() { "N" } else { "" };
    write!(out, "{colours}{normals}OFF\n{} {} 0\n", shape.positions().len(), shape.triangles.len())?;
    for (index, point) in shape.positions().iter().enumerate() {
        let normal = shape.normals().and_then(|normals| normals.get(index));
        let numbers = point.iter().chain(normal.iter().flat_map(|normal| normal.iter()));
        for (place, &value) in numbers.enumerate() {
            out.write_all(if place == 0 { b"" } else { b" " })?;
            write_number(out, value)?;
        }
        if let Some((colours, rgba)) =
            shape.colours().and_then(|colours| Some((colours, colours.rgba(index)?)))
        {
            for channel in &rgba[..if colours.has_alpha() { 4 } else { 3 }] {
                write!(out, " {channel}")?;
            }
        }
        out.write_all(b"\n")?;
    }
    for [a, b, c] in shape.triangles {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    Ok(())
}
