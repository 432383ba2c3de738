//! OFF, the Object File Format of Geomview, as text.

mod tokens;
mod vertices;
mod write;

use self::tokens::Tokens;
use self::vertices::Vertices;
use crate::number;
use crate::parsed::{Fans, Parsed};
use crate::source::{Source, quoted};
use crate::wording::counted;
use crate::{Error, Format, Place};

pub(crate) use self::write::write;

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

/// What follows after blank lines and comments.
pub(crate) fn without_comments(data: &[u8]) -> &[u8] {
    let mut rest = data.trim_ascii_start();
    while rest.starts_with(b"#") {
        let length = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
        rest = rest[length..].trim_ascii_start();
    }
    rest
}

/// How the numbers are spread over lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Arrangement {
    /// Whether every vertex has a line of its own, which may hold more than is known.
    vertex_lines: bool,
    /// Numbers of a colour of a vertex, where lines do not tell.
    channels: usize,
    /// Whether what follows a face in its line is a colour.
    face_lines: bool,
}

/// One vertex or face per line, as most programs write it, and then the free form in which lines mean nothing.
const ARRANGEMENTS: [Arrangement; 5] = [
    Arrangement { vertex_lines: true, channels: 0, face_lines: true },
    Arrangement { vertex_lines: false, channels: 4, face_lines: true },
    Arrangement { vertex_lines: false, channels: 4, face_lines: false },
    Arrangement { vertex_lines: false, channels: 3, face_lines: true },
    Arrangement { vertex_lines: false, channels: 3, face_lines: false },
];

/// Reads points with normals and colours, and triangles. Comments may stand anywhere.
pub(crate) fn read(source: Source<'_>) -> Result<Parsed, Error> {
    let start = source.data.len() - without_comments(source.data).len();
    let header = header(&source.data[start..])
        .ok_or_else(|| source.line_error(start, "an OFF file begins with the word OFF", EXPORT))?;
    let mut tokens = Tokens::new(source, start + header.length);
    let (at, first) = tokens.next_or("the number of vertices")?;
    if first == b"BINARY" || header.other_dimension {
        let what = "binary OFF and vertices of four or n coordinates are not read";
        return Err(Error::unsupported(
            Place::Line(source.line_at(at)),
            what,
            "convert the file to ascii OFF or PLY",
        ));
    }
    let line = tokens.line();
    let second = tokens.next_or("the number of faces")?.1;
    let (Some(vertices), Some(faces)) = (number::parse_count(first), number::parse_count(second)) else {
        let what = format!("{} is not the number of vertices, faces and edges", quoted(line.trim_ascii()));
        return Err(source.line_error(at, what, EXPORT));
    };
    // The number of edges means nothing, and may be missing at the end of a line.
    let mut after = tokens.clone();
    let _ = after.next_in_line();
    let next = after.offset();
    let both = vertices.saturating_mul(6).saturating_add(faces.saturating_mul(2));
    source.check_promise(next, format_args!("vertices and {faces} faces"), vertices, 6, true)?;
    source.check_promise(
        next,
        format_args!("characters for {vertices} vertices and {faces} faces"),
        both,
        1,
        true,
    )?;
    let mut error = None;
    for arrangement in ARRANGEMENTS {
        let repeated = arrangement.channels == 3 && !header.colours;
        if repeated {
            continue;
        }
        match read_as(&mut tokens.clone(), header, (vertices, faces), arrangement) {
            Ok(parsed) => return Ok(parsed),
            // The usual arrangement is the one to be told about.
            Err(failed) => error = error.or(Some(failed)),
        }
    }
    Err(error.unwrap_or_else(|| source.line_error(at, "the vertices cannot be read", EXPORT)))
}

fn read_as(
    tokens: &mut Tokens<'_>,
    header: Header,
    (count, faces): (u64, u64),
    arrangement: Arrangement,
) -> Result<Parsed, Error> {
    // The number of edges: the rest of the line, or, where lines mean nothing, one number.
    if arrangement.vertex_lines {
        tokens.skip_line();
    } else {
        let _ = tokens.next_or("the number of edges")?;
    }
    let mut warnings = Vec::new();
    let mut vertices = Vertices::new(header);
    for vertex in 0..count {
        if arrangement.vertex_lines {
            vertices.read_line(tokens, vertex)?;
        } else {
            vertices.read_numbers(tokens, vertex, arrangement.channels)?;
        }
    }
    let cloud = vertices.finish(&mut warnings)?;
    let mut fans = Fans::default();
    let mut coloured = 0usize;
    for _ in 0..faces {
        read_face(tokens, count, &mut fans)?;
        if arrangement.face_lines {
            coloured += usize::from(tokens.skip_line());
        }
    }
    if let Some((at, word)) = tokens.next() {
        let what = format!(
            "{} follows after {count} vertices and {faces} faces, as many as the file says it has",
            quoted(word)
        );
        return Err(tokens.source.line_error(
            at,
            what,
            "correct the numbers of vertices and faces, or export the file again",
        ));
    }
    // Where lines mean nothing, a face without corners is a sign of numbers that were counted wrongly.
    if !arrangement.vertex_lines && fans.too_few > 0 {
        let what = format!("fewer than three corners in {}", counted(fans.too_few, "face"));
        return Err(tokens.source.line_error(tokens.offset(), what, EXPORT));
    }
    if coloured > 0 {
        warnings.push(format!("not read: colours of {}", counted(coloured, "face")));
    }
    let triangles = fans.finish(&mut warnings);
    Ok(Parsed::mesh(Format::Off, cloud, triangles, warnings))
}

/// Reads the corners of a face.
fn read_face(tokens: &mut Tokens<'_>, vertices: u64, fans: &mut Fans) -> Result<(), Error> {
    let (at, word) = tokens.next_or("a face")?;
    let line = tokens.line();
    let length = number::parse_count(word).ok_or_else(|| {
        let what = format!("{} does not begin with a number of corners", quoted(line.trim_ascii()));
        tokens.source.line_error(at, what, EXPORT)
    })?;
    let mut corners = Vec::new();
    for _ in 0..length {
        let index =
            tokens.next().and_then(|(_, word)| number::parse_count(word)).filter(|&index| index < vertices);
        match index.and_then(|index| u32::try_from(index).ok()) {
            Some(index) => corners.push(index),
            None => {
                let what = format!(
                    "{} is not a face over {vertices} vertices (counted from 0)",
                    quoted(line.trim_ascii())
                );
                return Err(tokens.source.line_error(at, what, EXPORT));
            }
        }
    }
    fans.push(&corners);
    Ok(())
}
