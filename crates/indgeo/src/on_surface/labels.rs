//! Labels of the vertices of a mesh.

use crate::error::Error;
use crate::files;
use industrial_geometry::mesh::TriangleMesh;
use std::path::Path;

/// The labels that a name stands for: a scalar of the mesh, or a file of whole numbers, one per vertex in any arrangement of lines.
pub(crate) fn read(name: &Path, mesh: &TriangleMesh, of: &Path) -> Result<Vec<i64>, Error> {
    let count = mesh.vertices().len();
    if let Some(values) = mesh.attributes().scalar(&name.to_string_lossy()) {
        return values
            .iter()
            .enumerate()
            .map(|(vertex, &value)| {
                whole(value).ok_or_else(|| {
                    let what = format!("`{}` is {value} at vertex {vertex} (from 0)", name.display());
                    Error::content(of, what, "labels are whole numbers, 0 for no region")
                })
            })
            .collect();
    }
    let bytes = files::read_bytes(name)?;
    let text = String::from_utf8_lossy(&bytes);
    let mut labels = Vec::with_capacity(count);
    for (line, words) in text.lines().enumerate() {
        for word in words.split([' ', '\t', ',', ';']).filter(|word| !word.is_empty()) {
            let value = word.parse().ok().and_then(whole);
            // A header is the only thing that may be no number.
            match value {
                Some(value) => labels.push(value),
                None if labels.is_empty() && line == 0 => {}
                None => {
                    let what = format!("line {}: `{word}` is no whole number", line + 1);
                    return Err(Error::content(name, what, "give one label per vertex, 0 for no region"));
                }
            }
        }
    }
    if labels.len() != count {
        let what = format!("{} labels for {count} vertices of {}", labels.len(), of.display());
        return Err(Error::content(name, what, "give one label per vertex, in their order"));
    }
    Ok(labels)
}

#[expect(clippy::cast_possible_truncation, reason = "whole numbers below 2^53")]
fn whole(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() < 9e15).then_some(value as i64)
}
