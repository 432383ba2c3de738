//! VTI: image data of VTK in XML, one piece.

use super::GridFile;
use super::npy::first_axis_fastest;
use crate::Error;
use crate::error::check_size;

const NAME: &str = "VTI";
/// The name of the array that is taken before others.
const PREFERRED: &str = "distance";
/// The element with a name begins within so many bytes.
const HEAD: usize = 4096;

pub(super) fn is_vti(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD)];
    find(head, b"<VTKFile").is_some_and(|at| find(&head[at..], b"ImageData").is_some())
}

fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    bytes.windows(pattern.len()).position(|window| window == pattern)
}

/// An element's attributes as text, and where its content begins.
struct Element<'a> {
    at: usize,
    attributes: &'a str,
    content: usize,
}

impl<'a> Element<'a> {
    /// The next element with a name from a byte on.
    fn next(bytes: &'a [u8], name: &str, from: usize) -> Option<Self> {
        let at = from + find(bytes.get(from..)?, format!("<{name}").as_bytes())?;
        let end = at + find(&bytes[at..], b">")?;
        let attributes = std::str::from_utf8(&bytes[at + 1 + name.len()..end]).ok()?;
        Some(Self { at, attributes, content: end + 1 })
    }

    fn attribute(&self, name: &str) -> Option<&'a str> {
        let mut rest = self.attributes;
        while let Some((before, after)) = rest.split_once('=') {
            let quote = after.trim_start().chars().next().filter(|c| matches!(c, '"' | '\''))?;
            let (value, next) = after.trim_start()[1..].split_once(quote)?;
            if before.trim() == name {
                return Some(value);
            }
            rest = next;
        }
        None
    }

    fn need(&self, name: &str) -> Result<&'a str, Error> {
        self.attribute(name)
            .ok_or_else(|| Error::malformed(NAME, self.at, format!("the element has no attribute {name}")))
    }

    fn numbers<T: std::str::FromStr>(&self, name: &str, count: usize) -> Result<Vec<T>, Error> {
        let text = self.need(name)?;
        let found: Option<Vec<T>> = text.split_ascii_whitespace().map(|part| part.parse().ok()).collect();
        found.filter(|found| found.len() == count).ok_or_else(|| {
            Error::malformed(NAME, self.at, format!("{name} is \"{text}\", not {count} numbers"))
        })
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<GridFile, Error> {
    let element = |name: &str, from: usize| {
        let missing = || Error::malformed(NAME, bytes.len(), format!("there is no element {name}"));
        Element::next(bytes, name, from).ok_or_else(missing)
    };
    let file = element("VTKFile", 0)?;
    let refuse = |at: usize, what: String| Err(Error::malformed(NAME, at, what));
    if let Some(compressor) = file.attribute("compressor") {
        return refuse(file.at, format!("compressed data ({compressor}) are not read; save without"));
    }
    let is_big_endian = file.attribute("byte_order") == Some("BigEndian");
    let header = if file.attribute("header_type") == Some("UInt64") { 8 } else { 4 };
    let image = element("ImageData", file.content)?;
    let extent: Vec<i64> = image.numbers("WholeExtent", 6)?;
    let mut counts: Vec<u64> = Vec::with_capacity(3);
    for ends in extent.chunks_exact(2) {
        match ends[1].checked_sub(ends[0]).and_then(|steps| u64::try_from(steps).ok()) {
            Some(steps) => counts.push(steps.saturating_add(1)),
            None => return refuse(image.at, format!("the extent {extent:?} is empty")),
        }
    }
    let origin: Vec<f64> = image.numbers("Origin", 3)?;
    let spacing: Vec<f64> = image.numbers("Spacing", 3)?;
    let nodes = check_size(&counts, || format!("{} x {} x {} values", counts[0], counts[1], counts[2]))?;
    let array = preferred(bytes, image.content)
        .ok_or_else(|| Error::malformed(NAME, bytes.len(), "there is no element DataArray"))?;
    if array.attribute("NumberOfComponents").is_some_and(|count| count != "1") {
        return refuse(array.at, "the array has several numbers for each point".to_owned());
    }
    let size = match array.need("type")? {
        "Float64" => 8,
        "Float32" => 4,
        other => {
            return refuse(array.at, format!("numbers of the type {other} are not read; save as Float64"));
        }
    };
    let values = match array.need("format")? {
        "ascii" => {
            let end =
                array.content + find(&bytes[array.content..], b"<").unwrap_or(bytes.len() - array.content);
            let text = String::from_utf8_lossy(&bytes[array.content..end]);
            let found: Option<Vec<f64>> =
                text.split_ascii_whitespace().map(|part| part.parse().ok()).collect();
            match found {
                Some(values) if values.len() == nodes => values,
                Some(values) => {
                    return refuse(array.at, format!("{} values for {nodes} points", values.len()));
                }
                None => return refuse(array.at, "a value is no number".to_owned()),
            }
        }
        "appended" => {
            let offset: Vec<usize> = array.numbers("offset", 1)?;
            let appended = element("AppendedData", array.content)?;
            if appended.attribute("encoding") != Some("raw") {
                return refuse(appended.at, "appended data are read as raw bytes only".to_owned());
            }
            let mark = find(&bytes[appended.content..], b"_");
            let mark =
                mark.ok_or_else(|| Error::malformed(NAME, bytes.len(), "the data have no beginning"))?;
            let first = (appended.content + mark + 1).saturating_add(offset[0]).saturating_add(header);
            let needed = nodes.saturating_mul(size);
            let body = bytes.get(first..).and_then(|rest| rest.get(..needed));
            let Some(body) = body else {
                return refuse(bytes.len(), format!("the file ends: {needed} bytes of values are needed"));
            };
            let join = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
            let number = |part: &[u8]| {
                let bits =
                    if is_big_endian { part.iter().fold(0, join) } else { part.iter().rev().fold(0, join) };
                match size {
                    8 => f64::from_bits(bits),
                    _ => f64::from(f32::from_bits(u32::try_from(bits).unwrap_or(0))),
                }
            };
            body.chunks_exact(size).map(number).collect()
        }
        other => {
            return refuse(
                array.at,
                format!("data in the format {other} are not read; save as appended raw data"),
            );
        }
    };
    let axes = if counts[2] == 1 { 2 } else { 3 };
    let counts: Vec<usize> =
        counts[..axes].iter().map(|&count| usize::try_from(count).unwrap_or(usize::MAX)).collect();
    // The first node of an extent that does not begin at 0.
    let low = (0..axes).map(|k| origin[k] + extent[2 * k] as f64 * spacing[k]).collect();
    let values = first_axis_fastest(&counts, &values);
    Ok(GridFile { counts, place: Some([low, spacing[..axes].to_vec()]), values })
}

/// The array with the preferred name, or else the first one.
fn preferred(bytes: &[u8], from: usize) -> Option<Element<'_>> {
    let first = Element::next(bytes, "DataArray", from)?;
    let mut at = from;
    // Arrays stand before the data.
    let end = find(bytes, b"<AppendedData").unwrap_or(bytes.len());
    while let Some(array) = Element::next(&bytes[..end], "DataArray", at) {
        if array.attribute("Name") == Some(PREFERRED) {
            return Element::next(bytes, "DataArray", array.at);
        }
        at = array.content;
    }
    Some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(data: &str) -> Vec<u8> {
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <ImageData WholeExtent=\"1 2 0 2 0 0\" Origin=\"1 2 0\" Spacing=\"0.5 0.25 1\"><Piece><PointData>\n{data}"
        )
        .into_bytes()
    }

    #[test]
    fn text_and_appended_data_are_read() {
        let inline = text("<DataArray type=\"Float64\" Name=\"d\" format=\"ascii\">0 1 2 3 4 5</DataArray>");
        let found = read(&inline).unwrap();
        assert_eq!(
            (found.counts.as_slice(), found.values.as_slice()),
            (&[2, 3][..], &[0.0, 2.0, 4.0, 1.0, 3.0, 5.0][..])
        );
        assert_eq!(found.place, Some([vec![1.5, 2.0], vec![0.5, 0.25]]));
        let mut raw = text(
            "<DataArray type=\"Float32\" Name=\"distance\" format=\"appended\" offset=\"0\"/></PointData>\
             <AppendedData encoding=\"raw\">\n_",
        );
        raw.extend(24u64.to_le_bytes());
        raw.extend((0u8..6).flat_map(|k| f32::from(k).to_le_bytes()));
        assert!(is_vti(&raw));
        assert_eq!(read(&raw).unwrap().values, found.values);
        for length in 30..raw.len() {
            assert!(read(&raw[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_said() {
        for (data, what) in [
            ("<DataArray type=\"Int8\" format=\"ascii\">0</DataArray>", "type Int8"),
            ("<DataArray type=\"Float64\" format=\"binary\">AAAA</DataArray>", "format binary"),
            ("<DataArray type=\"Float64\" format=\"ascii\">0 1</DataArray>", "2 values for 6 points"),
            ("<DataArray type=\"Float64\" format=\"ascii\">a</DataArray>", "no number"),
            ("", "no element DataArray"),
        ] {
            let error = read(&text(data)).unwrap_err().to_string();
            assert!(error.contains(what), "{error}");
        }
        let huge = String::from_utf8(text("")).unwrap().replace("1 2 0 2 0 0", "0 99999999 0 99999999 0 0");
        assert!(matches!(read(huge.as_bytes()), Err(Error::TooLarge { .. })));
    }
}
