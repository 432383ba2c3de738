//! Files of labels.

use industrial_geometry::mesh::nalgebra::Point3;
use std::io::{BufWriter, Write};

/// `x,y,z,label`, one row per point in the order of the input.
pub(super) fn write_csv(out: &mut dyn Write, points: &[Point3<f64>], labels: &[i64]) -> std::io::Result<()> {
    let mut out = BufWriter::new(out);
    writeln!(out, "x,y,z,label")?;
    for (p, label) in points.iter().zip(labels) {
        writeln!(out, "{},{},{},{label}", p.x, p.y, p.z)?;
    }
    out.flush()
}

/// Points with a colour per region and their label as a whole number, and the triangles of a mesh.
pub(super) fn write_ply(
    out: &mut dyn Write,
    points: &[Point3<f64>],
    triangles: &[[u32; 3]],
    labels: &[i64],
) -> std::io::Result<()> {
    let mut out = BufWriter::new(out);
    write!(
        out,
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int label\n",
        points.len()
    )?;
    if !triangles.is_empty() {
        write!(out, "element face {}\nproperty list uchar int vertex_indices\n", triangles.len())?;
    }
    writeln!(out, "end_header")?;
    for (p, &label) in points.iter().zip(labels) {
        let [r, g, b] = colour(label);
        writeln!(out, "{} {} {} {r} {g} {b} {label}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in triangles {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    out.flush()
}

/// Colour of a region: hues apart by the golden angle; grey for no region.
fn colour(label: i64) -> [u8; 3] {
    if label < 0 {
        return [128; 3];
    }
    let hue = (label as f64 * 0.618_033_988_75).fract() * 6.0;
    let value = if label % 2 == 0 { 235.0 } else { 175.0 };
    let channel = |shift: f64| {
        let k = (shift + hue) % 6.0;
        let level = value * (1.0 - 0.65 * k.min(4.0 - k).clamp(0.0, 1.0));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "levels lie in 0..=235")]
        let byte = level as u8;
        byte
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_the_first_regions_differ() {
        let colours: std::collections::BTreeSet<[u8; 3]> = (-1..60).map(colour).collect();
        assert_eq!(colours.len(), 61);
    }
}
