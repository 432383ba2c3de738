//! Writing GLB, the binary form of glTF 2.0: points or triangles with normals and colours.

use std::io::{self, Write};

use crate::shape::{Keeps, Shape};
use crate::wording::counted;

const KEEPS: Keeps = Keeps {
    normals: true,
    colours: true,
    opacity: true,
    scalars: false,
    texts: false,
    triangles: true,
    plane: false,
};

/// Numbers of the specification: types of numbers, targets of buffers, kinds of primitives.
const FLOAT: u32 = 5126;
const U16: u32 = 5123;
const U32: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
const POINTS: u32 = 0;
const TRIANGLES: u32 = 4;

/// The binary part and its description.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Buffer {
    /// Adds an array; `extra` goes into its description. Returns its number.
    fn add(
        &mut self,
        start: usize,
        target: u32,
        number: u32,
        kind: &str,
        count: usize,
        extra: &str,
    ) -> usize {
        let length = self.bytes.len() - start;
        self.views
            .push(format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{length},"target":{target}}}"#));
        self.accessors.push(format!(
            r#"{{"bufferView":{},"componentType":{number},"count":{count},"type":"{kind}"{extra}}}"#,
            self.views.len() - 1
        ));
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        self.accessors.len() - 1
    }

    fn float(&mut self, value: f64) {
        self.bytes.extend(single(value).to_le_bytes());
    }
}

#[expect(clippy::cast_possible_truncation, reason = "coordinates of glTF are single")]
const fn single(value: f64) -> f32 {
    value as f32
}

/// A channel of a colour in the linear scale of glTF, as 16 bits (IEC 61966-2-1).
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 65535")]
fn linear(channel: u8) -> u16 {
    let value = f64::from(channel) / 255.0;
    let linear = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    (linear * 65535.0).round() as u16
}

/// Writes one mesh. Coordinates are single from the middle of the points on, which is the translation of the node and double:
/// far from the origin nothing is lost but digits below a ten millionth of the size.
pub(crate) fn write(out: &mut dyn Write, shape: Shape<'_>, warnings: &mut Vec<String>) -> io::Result<()> {
    shape.warn_of_loss(KEEPS, warnings);
    let finite = |row: usize| shape.positions()[row].iter().all(|value| value.is_finite());
    let kept: Vec<usize> = (0..shape.positions().len()).filter(|&row| finite(row)).collect();
    let mut places = vec![u32::MAX; shape.positions().len()];
    for (place, &row) in (0u32..).zip(&kept) {
        places[row] = place;
    }
    if kept.len() < places.len() {
        let lost = counted(places.len() - kept.len(), "point");
        warnings.push(format!("left out: {lost} whose coordinates are not finite, which GLB cannot hold"));
    }
    let bounds = kept.iter().fold([(f64::INFINITY, f64::NEG_INFINITY); 3], |bounds, &row| {
        [0, 1, 2].map(|axis| {
            let value = shape.positions()[row][axis];
            (bounds[axis].0.min(value), bounds[axis].1.max(value))
        })
    });
    let middle = bounds.map(|(low, high)| if low <= high { low / 2.0 + high / 2.0 } else { 0.0 });
    let is_too_large =
        |axis: usize| bounds[axis].0 <= bounds[axis].1 && !single(bounds[axis].1 - middle[axis]).is_finite();
    if (0..3).any(is_too_large) {
        return Err(io::Error::other(
            "the coordinates are beyond the range of single numbers; choose ply or csv",
        ));
    }
    let mut buffer = Buffer::default();
    let mut parts = Vec::new();
    if !kept.is_empty() {
        parts = vertices(&mut buffer, shape, &kept, middle);
        let triangles: Vec<[u32; 3]> = (shape.triangles.iter())
            .map(|corners| corners.map(|corner| places.get(corner as usize).copied().unwrap_or(u32::MAX)))
            .filter(|corners| corners.iter().all(|&corner| corner != u32::MAX))
            .collect();
        let is_mesh = !shape.triangles.is_empty();
        if is_mesh && !triangles.is_empty() {
            let start = buffer.bytes.len();
            for corner in triangles.iter().flatten() {
                buffer.bytes.extend(corner.to_le_bytes());
            }
            let number = buffer.add(start, INDICES, U32, "SCALAR", triangles.len() * 3, "");
            parts.push(format!(r#""indices":{number}"#));
        }
        let mode = if is_mesh && !triangles.is_empty() { TRIANGLES } else { POINTS };
        parts.push(format!(r#""mode":{mode}"#));
    }
    assemble(out, &buffer, &parts, middle)
}

/// Adds positions, normals and colours; returns how the primitive refers to them.
fn vertices(buffer: &mut Buffer, shape: Shape<'_>, kept: &[usize], middle: [f64; 3]) -> Vec<String> {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for &row in kept {
        for axis in 0..3 {
            let value = shape.positions()[row][axis] - middle[axis];
            low[axis] = low[axis].min(single(value));
            high[axis] = high[axis].max(single(value));
            buffer.float(value);
        }
    }
    let list = |values: [f32; 3]| values.map(|value| value.to_string()).join(",");
    let limits = format!(r#","min":[{}],"max":[{}]"#, list(low), list(high));
    let position = buffer.add(0, VERTICES, FLOAT, "VEC3", kept.len(), &limits);
    let mut attributes = format!(r#""POSITION":{position}"#);
    if let Some(normals) = shape.normals() {
        let start = buffer.bytes.len();
        for &row in kept {
            // Normals must have length 1; where there is none any will do.
            let normal =
                normals[row].try_normalize(0.0).filter(|normal| normal.iter().all(|value| value.is_finite()));
            let normal = normal.unwrap_or_else(nalgebra::Vector3::z);
            normal.iter().for_each(|&value| buffer.float(value));
        }
        let number = buffer.add(start, VERTICES, FLOAT, "VEC3", kept.len(), "");
        attributes.push_str(&format!(r#","NORMAL":{number}"#));
    }
    if let Some(colours) = shape.colours() {
        let start = buffer.bytes.len();
        for &row in kept {
            let [r, g, b, a] = colours.rgba(row).unwrap_or([255; 4]);
            for value in [linear(r), linear(g), linear(b), u16::from(a) * 257] {
                buffer.bytes.extend(value.to_le_bytes());
            }
        }
        let number = buffer.add(start, VERTICES, U16, "VEC4", kept.len(), r#","normalized":true"#);
        attributes.push_str(&format!(r#","COLOR_0":{number}"#));
    }
    vec![format!(r#""attributes":{{{attributes}}}"#)]
}

/// Writes the head, the description and the binary part.
fn assemble(out: &mut dyn Write, buffer: &Buffer, parts: &[String], middle: [f64; 3]) -> io::Result<()> {
    let asset =
        concat!(r#""asset":{"version":"2.0","generator":"pc-io "#, env!("CARGO_PKG_VERSION"), r#""}"#);
    let mut text = format!("{{{asset}");
    if parts.is_empty() {
        text.push_str(r#","scene":0,"scenes":[{}]"#);
    } else {
        let shift = middle.map(|value| format!("{value:?}")).join(",");
        text.push_str(&format!(
            r#","scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"translation":[{shift}]}}],"meshes":[{{"primitives":[{{{}}}]}}],"accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]"#,
            parts.join(","),
            buffer.accessors.join(","),
            buffer.views.join(","),
            buffer.bytes.len()
        ));
    }
    text.push('}');
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let binary = if parts.is_empty() { 0 } else { 8 + buffer.bytes.len() };
    let length = |value: usize| {
        u32::try_from(value).map_err(|_| io::Error::other("a GLB file holds up to 4 GB; choose ply or las"))
    };
    out.write_all(b"glTF")?;
    out.write_all(&2u32.to_le_bytes())?;
    out.write_all(&length(12 + 8 + text.len() + binary)?.to_le_bytes())?;
    out.write_all(&length(text.len())?.to_le_bytes())?;
    out.write_all(b"JSON")?;
    out.write_all(text.as_bytes())?;
    if binary > 0 {
        out.write_all(&length(buffer.bytes.len())?.to_le_bytes())?;
        out.write_all(b"BIN\0")?;
        out.write_all(&buffer.bytes)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::{Colours, PointCloud};
    use nalgebra::Point3;

    #[test]
    fn points_far_from_the_origin_keep_their_digits() {
        let far = 4_500_000.0;
        let positions = [0.0, 0.25, 1.0, f64::NAN].map(|x| Point3::new(far + x, 2.0, -far));
        let colours = Colours::Rgb(vec![[255, 0, 128]; 4]);
        let cloud = PointCloud::new(positions.to_vec()).with_colours(colours).unwrap();
        let (mut bytes, mut warnings) = (Vec::new(), Vec::new());
        write(&mut bytes, Shape { cloud: &cloud, triangles: &[] }, &mut warnings).unwrap();
        assert_eq!(&bytes[..8], b"glTF\x02\0\0\0");
        assert_eq!(u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize, bytes.len());
        let text = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + text]).unwrap();
        assert_eq!(json["nodes"][0]["translation"], serde_json::json!([far + 0.5, 2.0, -far]));
        assert_eq!(json["meshes"][0]["primitives"][0]["mode"], 0);
        assert_eq!(json["accessors"][0]["count"], 3);
        let data = &bytes[20 + text + 8..];
        let float = |at: usize| f32::from_le_bytes(data[at..at + 4].try_into().unwrap());
        assert_eq!([float(0), float(12), float(24)], [-0.5, -0.25, 0.5]);
        // 128 of 255 is 0.2158605 in the linear scale.
        assert_eq!(u16::from_le_bytes(data[40..42].try_into().unwrap()), 14146);
        assert!(warnings.iter().any(|warning| warning.contains("1 point ")), "{warnings:?}");
    }
}
