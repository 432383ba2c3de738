//! STL: text and binary.

use std::io::{self, Write};

use mesh_core::{TriangleMesh, VertexWelder};
use nalgebra::{Point3, Vector3};

use crate::error::Place;
use crate::number;
use crate::parsed::Parsed;
use crate::shape::{Keeps, Shape};
use crate::source::{Source, quoted, words};
use crate::{Error, Format};

const HEADER: usize = 84;
const FACET: usize = 50;

/// Reads triangles; corners at the same position, or apart by rounding only, become one vertex.
pub(crate) fn read(source: Source<'_>) -> Result<Parsed, Error> {
    let mut soup = Soup::default();
    let mut warnings = Vec::new();
    if is_text(source.data) {
        read_text(source, &mut soup)?;
    } else {
        read_binary(source, &mut soup, &mut warnings)?;
    }
    let mesh = TriangleMesh::new(soup.welder.into_vertices(), soup.triangles).map_err(Error::shape)?;
    let (mesh, weld) = mesh.welded();
    if weld.joined > 0 {
        warnings.push(format!(
            "{} corners that differ from others by rounding ({:.1e} at most) were joined with them",
            weld.joined, weld.largest_gap
        ));
    }
    let (vertices, triangles) = mesh.into_parts();
    Ok(Parsed::mesh(Format::Stl, vertices, triangles, warnings))
}

/// Whether the size is exactly that of a binary file with the number of triangles it states.
pub(crate) fn is_binary(data: &[u8]) -> bool {
    let Some(count) = data.get(80..HEADER).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes)
    else {
        return false;
    };
    let exact = HEADER as u64 + FACET as u64 * u64::from(count) == data.len() as u64;
    // An ascii file may have such a size by chance.
    exact && !(starts_like_text(data) && data.is_ascii())
}

/// Whether the first word is that of a text file; the line with the name may be missing.
fn starts_like_text(data: &[u8]) -> bool {
    let text = data.trim_ascii_start();
    let is = |word: &[u8]| text.len() >= word.len() && text[..word.len()].eq_ignore_ascii_case(word);
    is(b"solid") || is(b"facet")
}

/// Whether a beginning is that of a text file with facets, or of one that ends without any.
pub(crate) fn looks_like_text(head: &[u8]) -> bool {
    let mentions = |word: &[u8]| head.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word));
    starts_like_text(head)
        && [b"facet normal".as_slice(), b"vertex", b"endsolid", b"end solid"].into_iter().any(mentions)
}

/// Binary headers may begin with "solid" as well; the rest decides.
fn is_text(data: &[u8]) -> bool {
    let head = &data[..data.len().min(1024)];
    starts_like_text(data) && !head.contains(&0) && !is_binary(data)
}

/// Triangles over welded vertices.
#[derive(Default)]
struct Soup {
    welder: VertexWelder,
    triangles: Vec<[u32; 3]>,
}

impl Soup {
    fn push(&mut self, corners: [Point3<f64>; 3]) -> Result<(), Error> {
        let [a, b, c] = corners.map(|corner| self.welder.insert(corner).map_err(Error::shape));
        self.triangles.push([a?, b?, c?]);
        Ok(())
    }
}

fn read_binary(source: Source<'_>, soup: &mut Soup, warnings: &mut Vec<String>) -> Result<(), Error> {
    let data = source.data;
    let Some(count) = data.get(80..HEADER).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes)
    else {
        return Err(Error::malformed(
            Place::Byte(data.len()),
            format!("a binary STL file begins with {HEADER} bytes, this one has {}", data.len()),
            "the file is truncated or no STL file, export it again",
        ));
    };
    let count = source.check_promise(HEADER, "triangles", u64::from(count), FACET, false)?;
    soup.triangles.reserve(count);
    soup.welder = VertexWelder::with_capacity(count / 2);
    let (facets, rest) = data[HEADER..].split_at(count * FACET);
    for facet in facets.chunks_exact(FACET) {
        let number = |at: usize| {
            let mut bytes = [0; 4];
            bytes.copy_from_slice(&facet[at..at + 4]);
            f64::from(f32::from_le_bytes(bytes))
        };
        soup.push([12, 24, 36].map(|at| Point3::new(number(at), number(at + 4), number(at + 8))))?;
    }
    // Some writers fill the end up; whole triangles there mean that the number is wrong.
    if rest.len() >= FACET && !rest.iter().all(|&byte| byte == 0) {
        return Err(Error::malformed(
            Place::Byte(80),
            format!("{count} triangles are stated, but {} bytes follow after the last", rest.len()),
            "the file is no STL file or its number of triangles is wrong, export it again",
        ));
    }
    if !rest.is_empty() {
        warnings.push(format!("{} bytes follow after the last triangle", rest.len()));
    }
    Ok(())
}

/// Only the vertices between `outer loop` and `endloop` count; normals follow from them.
///
/// Lines with the name of a solid may be missing or stand between facets; `end facet` is read as `endfacet`.
fn read_text(source: Source<'_>, soup: &mut Soup) -> Result<(), Error> {
    let mut corners: Vec<Point3<f64>> = Vec::new();
    let mut in_facet = false;
    for (at, line) in source.lines_from(0) {
        if line.trim_ascii_start().starts_with(b"#") || line.trim_ascii_start().starts_with(b"//") {
            continue;
        }
        let mut words = words(line).peekable();
        // Some writers put several statements on a line; names of solids may hold any word.
        while let Some(word) = words.next() {
            let keyword = if word.eq_ignore_ascii_case(b"end") {
                [b"end", words.next().unwrap_or_default()].concat().to_ascii_lowercase()
            } else {
                word.to_ascii_lowercase()
            };
            match keyword.as_slice() {
                b"solid" | b"endsolid" => {
                    if in_facet {
                        return Err(source.line_error(at, "the solid ends within a facet", EXPORT));
                    }
                    break;
                }
                b"facet" if in_facet => {
                    return Err(source.line_error(at, "a facet begins within another", EXPORT));
                }
                b"facet" => (in_facet, corners) = (true, Vec::new()),
                b"vertex" => {
                    let mut next = || words.next().and_then(number::parse);
                    match (next(), next(), next()) {
                        (Some(x), Some(y), Some(z)) => corners.push(Point3::new(x, y, z)),
                        _ => {
                            let what = format!("{} is not \"vertex X Y Z\"", quoted(line.trim_ascii()));
                            return Err(source.line_error(at, what, EXPORT));
                        }
                    }
                    if corners.len() > 3 {
                        return Err(source.line_error(at, "a facet has more than three vertices", EXPORT));
                    }
                }
                b"endfacet" => {
                    let [a, b, c] = *corners.as_slice() else {
                        let what = format!("a facet has {} vertices instead of three", corners.len());
                        return Err(source.line_error(at, what, EXPORT));
                    };
                    soup.push([a, b, c])?;
                    (in_facet, corners) = (false, Vec::new());
                }
                b"normal" => {
                    // The three numbers are passed over one by one, whatever they are.
                    for _ in 0..3 {
                        words.next_if(|word| number::parse(word).is_some());
                    }
                }
                // Colours and other remarks of some writers.
                b"color" | b"colour" | b"attribute" => break,
                b"outer" | b"loop" | b"outerloop" | b"endloop" => {}
                _ => {
                    let what = format!("{} is not part of an STL file", quoted(word));
                    return Err(source.line_error(at, what, EXPORT));
                }
            }
        }
    }
    if in_facet {
        return Err(source.line_error(source.data.len(), "the file ends within a facet", EXPORT));
    }
    Ok(())
}

const EXPORT: &str = "correct the line or export the file again";

const KEEPS: Keeps = Keeps {
    normals: false,
    colours: false,
    opacity: false,
    scalars: false,
    texts: false,
    triangles: true,
    plane: false,
};

/// Writes binary STL: single precision, normals from the vertices.
pub(crate) fn write(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let mut largest_change = 0.0f64;
    for value in shape.positions().iter().flat_map(|point| point.iter()) {
        let change = (f64::from(single(*value)) - value).abs();
        largest_change = if change > largest_change { change } else { largest_change };
    }
    if largest_change > 0.0 {
        warnings
            .push(format!("coordinates were rounded to single precision, by {largest_change:.1e} at most"));
    }
    let mut used = vec![false; shape.positions().len()];
    shape.triangles.iter().flatten().for_each(|&index| used[index as usize] = true);
    let unused = used.iter().filter(|&&used| !used).count();
    if unused > 0 {
        warnings.push(format!("{unused} vertices that belong to no triangle were left out"));
    }
    let mut header = [0; 80];
    let title = b"binary STL, single precision";
    header[..title.len()].copy_from_slice(title);
    out.write_all(&header)?;
    let count = u32::try_from(shape.triangles.len()).map_err(io::Error::other)?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in shape.triangles {
        let [a, b, c] = triangle.map(|index| shape.positions()[index as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::zeros);
        let mut facet = [0; FACET];
        let numbers = [normal, a.coords, b.coords, c.coords];
        for (place, value) in numbers.iter().flat_map(|vector| vector.iter()).enumerate() {
            facet[4 * place..4 * place + 4].copy_from_slice(&single(*value).to_le_bytes());
        }
        out.write_all(&facet)?;
    }
    Ok(())
}

#[expect(clippy::cast_possible_truncation, reason = "the format holds single precision; the loss is told")]
const fn single(value: f64) -> f32 {
    value as f32
}
