//! OBJ, the text format of Wavefront.

mod free_form;
mod write;

use crate::wording::counted;
use std::borrow::Cow;

use mesh_core::{Attributes, PointCloud};
use nalgebra::{Point3, Vector3};

use self::free_form::FreeForm;
use crate::columns::{Column, Kind, colours};
use crate::number;
use crate::parsed::{Fans, Parsed};
use crate::source::{Lines, Source, quoted, words};
use crate::{Error, Format};

pub(crate) use self::write::write;

const EXPORT: &str = "correct the line or export the file again";

/// Reads vertices with colours and normals and triangles out of polygons, or free-form curves and surfaces where there
/// are no polygons; everything else is passed over. Keywords in capitals are read as well.
pub(crate) fn read(source: Source<'_>) -> Result<Parsed, Error> {
    let mut reader = Reader { source, ..Reader::default() };
    let mut lines = source.lines_from(0);
    while let Some((at, line)) = lines.next() {
        let line = joined(line, &mut lines);
        let Some(word) = words(&line).next() else { continue };
        match word {
            b"v" | b"V" => reader.vertex(at, &line)?,
            b"vn" | b"VN" => reader.normal(at, &line)?,
            b"f" | b"F" | b"fo" | b"FO" => reader.face(at, &line)?,
            b"vt" | b"VT" => reader.texture += 1,
            _ if word.starts_with(b"#") => {}
            _ => {
                let keyword = word.to_ascii_lowercase();
                if !reader.free_form.statement(source, at, &keyword, &line, reader.positions.len())?
                    && !OTHERS.contains(&keyword.as_slice())
                {
                    reader.unknown += 1;
                    reader.first_unknown.get_or_insert(at);
                }
            }
        }
    }
    reader.finish()
}

/// Statements without points.
const OTHERS: [&[u8]; 24] = [
    b"vp",
    b"p",
    b"l",
    b"g",
    b"o",
    b"s",
    b"mg",
    b"mtllib",
    b"usemtl",
    b"maplib",
    b"usemap",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"call",
    b"csh",
    b"con",
    b"res",
    b"cdres",
];

/// The line that begins at an offset.
fn source_line(source: Source<'_>, at: usize) -> &[u8] {
    source.lines_from(at).next().map_or(b"".as_slice(), |(_, line)| line.trim_ascii())
}

/// A line together with those that a backslash at its end joins to it.
fn joined<'a>(line: &'a [u8], lines: &mut Lines<'a>) -> Cow<'a, [u8]> {
    let Some(first) = line.trim_ascii_end().strip_suffix(b"\\") else {
        return Cow::Borrowed(line);
    };
    let mut whole = first.to_vec();
    for (_, next) in lines {
        whole.push(b' ');
        match next.trim_ascii_end().strip_suffix(b"\\") {
            Some(next) => whole.extend_from_slice(next),
            None => {
                whole.extend_from_slice(next);
                break;
            }
        }
    }
    Cow::Owned(whole)
}

/// A 0-based index from one that counts from 1, or backwards from the latest (−1).
fn index_of(source: Source<'_>, at: usize, text: &[u8], count: usize, what: &str) -> Result<u32, Error> {
    let written = std::str::from_utf8(text).ok().and_then(|text| text.parse::<i64>().ok());
    let zero_based = match written {
        Some(positive @ 1..) => positive.checked_sub(1),
        Some(negative @ ..=-1) => i64::try_from(count).ok().and_then(|count| count.checked_add(negative)),
        _ => None,
    };
    zero_based.and_then(|index| u32::try_from(index).ok()).ok_or_else(|| {
        let what = format!("{} is no index of a {what}; {count} have been read so far", quoted(text));
        source.line_error(at, what, "indices count from 1, or backwards from -1; correct the line")
    })
}

/// Where a vertex stands with its normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NormalOf {
    Nothing,
    One(u32),
    Several,
}

#[derive(Default)]
struct Reader<'a> {
    source: Source<'a>,
    positions: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    /// Red, green, blue and perhaps opacity of the vertices that have a colour, one after another.
    colours: Vec<f64>,
    coloured: usize,
    channels: usize,
    fans: Fans,
    /// Corners of all faces: vertex and normal.
    normal_of: Vec<NormalOf>,
    /// The largest vertex that a face refers to, and where.
    last_vertex: Option<(u64, usize)>,
    texture: usize,
    free_form: FreeForm,
    /// Weights of the vertices up to the last that has one.
    weights: Vec<f64>,
    /// Lines that are no statements.
    unknown: usize,
    first_unknown: Option<usize>,
    cut_numbers: Option<(usize, usize)>,
}

impl Reader<'_> {
    /// The numbers after the keyword; of a word that only begins like a number, that beginning.
    fn numbers<const N: usize>(&mut self, at: usize, line: &[u8]) -> Result<([f64; N], usize), Error> {
        let mut numbers = [0.0; N];
        let mut length = 0;
        for word in words(line).skip(1).take_while(|word| !word.starts_with(b"#")).take(N) {
            let Some((value, used)) = number::lex(word) else {
                return Err(self.source.line_error(at, format!("{} is not a number", quoted(word)), EXPORT));
            };
            if used < word.len() {
                let (_, count) = self.cut_numbers.unwrap_or((at, 0));
                self.cut_numbers = Some((self.cut_numbers.map_or(at, |(first, _)| first), count + 1));
            }
            numbers[length] = value;
            length += 1;
        }
        if length < 3 {
            let what = format!("{} has {length} numbers where three are expected", quoted(line.trim_ascii()));
            return Err(self.source.line_error(at, what, EXPORT));
        }
        Ok((numbers, length))
    }

    fn vertex(&mut self, at: usize, line: &[u8]) -> Result<(), Error> {
        let (numbers, length) = self.numbers::<7>(at, line)?;
        self.positions.push(Point3::new(numbers[0], numbers[1], numbers[2]));
        match length {
            4 if numbers[3] != 1.0 => {
                self.weights.resize(self.positions.len() - 1, 1.0);
                self.weights.push(numbers[3]);
            }
            6 | 7 => {
                if self.coloured == 0 {
                    self.channels = length - 3;
                }
                if self.channels == length - 3 {
                    self.coloured += 1;
                    self.colours.extend_from_slice(&numbers[3..length]);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn normal(&mut self, at: usize, line: &[u8]) -> Result<(), Error> {
        let (numbers, _) = self.numbers::<3>(at, line)?;
        self.normals.push(Vector3::from(numbers));
        Ok(())
    }

    fn face(&mut self, at: usize, line: &[u8]) -> Result<(), Error> {
        let mut corners: Vec<u32> = Vec::new();
        for word in words(line).skip(1).take_while(|word| !word.starts_with(b"#")) {
            let mut parts = word.split(|&byte| byte == b'/');
            let vertex =
                index_of(self.source, at, parts.next().unwrap_or_default(), self.positions.len(), "vertex")?;
            let normal = match parts.nth(1).filter(|part| !part.is_empty()) {
                Some(part) => Some(index_of(self.source, at, part, self.normals.len(), "normal")?),
                None => None,
            };
            if self.last_vertex.is_none_or(|(last, _)| u64::from(vertex) > last) {
                self.last_vertex = Some((u64::from(vertex), at));
            }
            if let Some(normal) = normal {
                self.note_normal(vertex, normal);
            }
            corners.push(vertex);
        }
        self.fans.push(&corners);
        Ok(())
    }

    fn note_normal(&mut self, vertex: u32, normal: u32) {
        let vertex = vertex as usize;
        // A vertex that is still to come has no place yet; an index far beyond must not make one.
        if self.normal_of.len() <= vertex && vertex < self.positions.len() {
            self.normal_of.resize(self.positions.len(), NormalOf::Nothing);
        }
        if let Some(known) = self.normal_of.get_mut(vertex) {
            let same = |one: u32| self.normals.get(one as usize) == self.normals.get(normal as usize);
            *known = match *known {
                NormalOf::Nothing => NormalOf::One(normal),
                NormalOf::One(one) if one == normal || same(one) => NormalOf::One(one),
                _ => NormalOf::Several,
            };
        }
    }

    fn finish(mut self) -> Result<Parsed, Error> {
        let count = self.positions.len();
        if let Some((index, at)) = self.last_vertex.filter(|&(index, _)| index >= count as u64) {
            let what = format!("a face refers to vertex {}, but there are {count}", index + 1);
            return Err(self.source.line_error(at, what, "correct the face or export the file again"));
        }
        if self.positions.is_empty()
            && let Some(at) = self.first_unknown
        {
            let line = source_line(self.source, at);
            let what = format!("{} is no statement of an OBJ file, and no vertex follows", quoted(line));
            return Err(self.source.line_error(at, what, "give a file with lines \"v X Y Z\""));
        }
        let mut warnings = Vec::new();
        if let Some(at) = self.first_unknown {
            warnings.push(format!(
                "passed over: {} without a statement of an OBJ file (first in line {})",
                counted(self.unknown, "line"),
                self.source.line_at(at)
            ));
        }
        if let Some((at, count)) = self.cut_numbers {
            warnings.push(format!(
                "ignored: other characters after {} (first in line {})",
                counted(count, "number"),
                self.source.line_at(at)
            ));
        }
        let mut attributes = Attributes::default();
        attributes.set_normals(self.vertex_normals(&mut warnings));
        if self.coloured > 0 {
            attributes.set_colours(self.vertex_colours(&mut warnings));
        }
        if self.texture > 0 {
            warnings.push(format!("not read: {} texture coordinates", self.texture));
        }
        let triangles = self.fans.finish(&mut warnings);
        let free_form = std::mem::take(&mut self.free_form);
        self.weights.resize(count, 1.0);
        if triangles.is_empty() && free_form.any() {
            let model = free_form.into_model(self.source, &self.positions, &self.weights, &mut warnings)?;
            if !model.shapes().is_empty() {
                return Ok(Parsed::model(Format::Obj, model, warnings));
            }
        } else if free_form.any() {
            warnings.push(format!(
                "not read: {} free-form curves and surfaces beside polygons",
                free_form.count()
            ));
        }
        let weighted = self.weights.iter().filter(|&&weight| weight != 1.0).count();
        if weighted > 0 {
            warnings.push(format!("not read: weights other than 1 (number of vertices: {weighted})"));
        }
        let cloud = PointCloud::new(self.positions).with_attributes(attributes).map_err(Error::shape)?;
        Ok(Parsed::mesh(Format::Obj, cloud, triangles, warnings))
    }

    /// One normal per vertex, where the faces, or without faces the order, say which.
    fn vertex_normals(&mut self, warnings: &mut Vec<String>) -> Option<Vec<Vector3<f64>>> {
        let (given, vertices) = (self.normals.len(), self.positions.len());
        if given == 0 {
            if !self.normal_of.is_empty() {
                warnings.push("faces refer to normals, but there are none".to_owned());
            }
            return None;
        }
        let in_order = self.normal_of.iter().zip(0u32..).all(|(normal, index)| match normal {
            NormalOf::Nothing => true,
            NormalOf::One(normal) => *normal == index,
            NormalOf::Several => false,
        });
        if given == vertices && in_order {
            return Some(std::mem::take(&mut self.normals));
        }
        let by_face = |normal: &NormalOf| match normal {
            NormalOf::One(index) => self.normals.get(*index as usize).copied(),
            _ => None,
        };
        let normals: Option<Vec<_>> = self.normal_of.iter().map(by_face).collect();
        let normals = normals.filter(|normals| normals.len() == vertices);
        if normals.is_none() {
            warnings.push(format!("not read: {given} normals, because not every vertex has exactly one"));
        }
        normals
    }

    fn vertex_colours(&self, warnings: &mut Vec<String>) -> Option<mesh_core::Colours> {
        if self.coloured != self.positions.len() {
            warnings.push(format!("not read: colours, because only {} vertices have one", self.coloured));
            return None;
        }
        let columns: Vec<Column> = (0..self.channels)
            .map(|channel| Column {
                name: String::new(),
                kind: Kind::Float,
                values: self.colours.iter().skip(channel).step_by(self.channels).copied().collect(),
            })
            .collect();
        colours(&columns.iter().collect::<Vec<_>>(), warnings)
    }
}
