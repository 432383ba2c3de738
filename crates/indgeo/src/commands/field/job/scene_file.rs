//! Scenes of a source and obstacles, as they come in JSON files.

use crate::error::Error;
use industrial_geometry::mesh::nalgebra::Vector2;
use serde::Deserialize;
use std::path::Path;

const ADVICE: &str =
    "give {\"domain\": [0, 1], \"source\": [x, y], \"polys\": [[[x, y], …], …], \"targets\": [[x, y], …]}";

/// A scene as read.
#[derive(Debug)]
pub(super) struct SceneFile {
    /// The rectangle.
    pub(super) low: Vector2<f64>,
    pub(super) high: Vector2<f64>,
    /// Where distances are measured from.
    pub(super) source: Vector2<f64>,
    /// Polygons.
    pub(super) obstacles: Vec<Vec<Vector2<f64>>>,
    /// Where ways are to lead.
    pub(super) targets: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
struct Document {
    domain: Domain,
    source: [f64; 2],
    #[serde(default)]
    polys: Vec<Vec<[f64; 2]>>,
    #[serde(default)]
    targets: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Domain {
    /// The same range for x and y.
    Square([f64; 2]),
    /// `[[x0, x1], [y0, y1]]`.
    Ranges([[f64; 2]; 2]),
}

/// The scene that the bytes of a file hold; `None` if they are something else.
pub(super) fn of_bytes(bytes: &[u8], path: &Path) -> Result<Option<SceneFile>, Error> {
    if bytes.iter().find(|byte| !byte.is_ascii_whitespace()) != Some(&b'{') {
        return Ok(None);
    }
    let Ok(value) = serde_json::from_slice::<serde_json::Value>(bytes) else { return Ok(None) };
    if value.get("source").is_none() || value.get("kind").is_some() {
        return Ok(None);
    }
    let document: Document =
        serde_json::from_value(value).map_err(|error| Error::content(path, error.to_string(), ADVICE))?;
    let ([x0, x1], [y0, y1]) = match document.domain {
        Domain::Square(range) => (range, range),
        Domain::Ranges([x, y]) => (x, y),
    };
    Ok(Some(SceneFile {
        low: Vector2::new(x0, y0),
        high: Vector2::new(x1, y1),
        source: document.source.into(),
        obstacles: document
            .polys
            .into_iter()
            .map(|poly| poly.into_iter().map(Vector2::from).collect())
            .collect(),
        targets: document.targets,
    }))
}
