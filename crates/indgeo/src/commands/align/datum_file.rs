//! Datum targets, as they come in JSON files and in tables.

use crate::error::Error;
use crate::files;
use industrial_geometry::io::{Content, ReadOptions};
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::mesh::{Attributes, PointCloud};
use serde::Deserialize;
use std::path::Path;

/// Largest coordinate of which sums of squares are finite.
const LARGEST: f64 = 1e150;

const ADVICE: &str = "see `indgeo align --help` for the form of the file";

/// A measured point and what is known about its place in the model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Datum {
    /// Its name, empty if it has none.
    pub(crate) name: String,
    /// Where it was measured.
    pub(crate) measured: Vector3<f64>,
    /// Where it belongs.
    pub(crate) nominal: Vector3<f64>,
    /// Unit vectors along which it is held.
    pub(crate) directions: Vec<Vector3<f64>>,
    /// Weight.
    pub(crate) weight: f64,
}

/// The targets of a file, and how it was read.
#[derive(Debug)]
pub(crate) struct DatumFile {
    /// In their order.
    pub(crate) targets: Vec<Datum>,
    /// `json`, or the format of the table.
    pub(crate) format: String,
    /// What the reader of the table says.
    pub(crate) warnings: Vec<String>,
}

/// Reads the targets of a file: JSON, or a table with named columns.
pub(crate) fn read(path: &Path) -> Result<DatumFile, Error> {
    let bytes = files::read_bytes(path)?;
    let first = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    let content = |what: String| Error::content(path, what, ADVICE);
    let (targets, format, warnings) = if matches!(first, Some(b'{' | b'[')) {
        (of_json(&bytes).map_err(content)?, "json".to_owned(), Vec::new())
    } else {
        let loaded = files::read_from_bytes(&bytes, path, &ReadOptions::default())?;
        let Content::Cloud(cloud) = loaded.content else {
            return Err(content("a table of points is needed".to_owned()));
        };
        let targets = of_table(&cloud).map_err(content)?;
        (targets, loaded.report.format.extension().to_owned(), loaded.report.warnings)
    };
    if targets.is_empty() {
        return Err(content("there are no targets in this file".to_owned()));
    }
    for (index, target) in targets.iter().enumerate() {
        let numbers = target.measured.iter().chain(target.nominal.iter()).chain([&target.weight]);
        if !numbers.chain(target.directions.iter().flatten()).all(|c| c.is_finite()) {
            return Err(content(format!(
                "{} has a number that is missing or not finite",
                called(index, &target.name)
            )));
        }
        let places = target.measured.iter().chain(target.nominal.iter());
        if let Some(coordinate) = places.copied().find(|c| c.abs() > LARGEST) {
            let name = called(index, &target.name);
            return Err(content(format!(
                "{name} has the coordinate {coordinate:e}, of which no square can be computed"
            )));
        }
        if target.weight < 0.0 {
            return Err(content(format!(
                "{} has the negative weight {}",
                called(index, &target.name),
                target.weight
            )));
        }
    }
    Ok(DatumFile { targets, format, warnings })
}

/// A target in a message.
pub(crate) fn called(index: usize, name: &str) -> String {
    if name.is_empty() {
        format!("target {index} (from 0)")
    } else {
        format!("target {index} (from 0, {name:?})")
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `measured` and `nominal`")]
struct Entry {
    #[serde(default)]
    name: String,
    measured: [f64; 3],
    nominal: [f64; 3],
    direction: Option<[f64; 3]>,
    fix: Option<String>,
    weight: Option<f64>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Document {
    List(Vec<serde_json::Value>),
    Object { targets: Vec<serde_json::Value> },
}

fn of_json(bytes: &[u8]) -> Result<Vec<Datum>, String> {
    let value: serde_json::Value =
        serde_json::from_slice(bytes).map_err(|error| format!("line {}: {error}", error.line()))?;
    let document: Document =
        serde_json::from_value(value).map_err(|_| "there is no list of targets in this file".to_owned())?;
    let (Document::List(entries) | Document::Object { targets: entries }) = document;
    let one = |(index, value): (usize, serde_json::Value)| {
        let entry: Entry =
            serde_json::from_value(value).map_err(|error| format!("target {index} (from 0): {error}"))?;
        let directions = directions(entry.direction.map(Vector3::from), entry.fix.as_deref())
            .map_err(|what| format!("{}: {what}", called(index, &entry.name)))?;
        Ok(Datum {
            name: entry.name,
            measured: entry.measured.into(),
            nominal: entry.nominal.into(),
            directions,
            weight: entry.weight.unwrap_or(1.0),
        })
    };
    entries.into_iter().enumerate().map(one).collect()
}

fn of_table(cloud: &PointCloud) -> Result<Vec<Datum>, String> {
    let attributes = cloud.attributes();
    let nominal = triple(attributes, "nominal")?
        .ok_or("the table has no columns nominal_x, nominal_y, nominal_z, named in its first line")?;
    let direction = triple(attributes, "direction")?;
    let weights = attributes.scalar("weight");
    let fixes = attributes.texts().iter().find(|text| text.name().eq_ignore_ascii_case("fix"));
    let one = |(index, measured): (usize, &Vector3<f64>)| {
        let name = attributes.names().and_then(|names| names.get(index)).unwrap_or_default().to_owned();
        // An empty direction is none.
        let direction =
            direction.as_ref().map(|values| values[index]).filter(|d| !d.iter().all(|c| c.is_nan()));
        let fix = fixes.and_then(|fixes| fixes.get(index)).map(str::trim).filter(|fix| !fix.is_empty());
        let directions =
            directions(direction, fix).map_err(|what| format!("{}: {what}", called(index, &name)))?;
        let weight = weights.map_or(1.0, |weights| weights[index]);
        Ok(Datum { name, measured: *measured, nominal: nominal[index], directions, weight })
    };
    let measured: Vec<Vector3<f64>> = cloud.positions().iter().map(|point| point.coords).collect();
    measured.iter().enumerate().map(one).collect()
}

/// The columns `what_x`, `what_y`, `what_z`; `None` if there is none of them.
fn triple(attributes: &Attributes, what: &str) -> Result<Option<Vec<Vector3<f64>>>, String> {
    let names = ["x", "y", "z"].map(|axis| format!("{what}_{axis}"));
    let columns = names.each_ref().map(|name| attributes.scalar(name));
    match columns {
        [None, None, None] => Ok(None),
        [Some(x), Some(y), Some(z)] => {
            Ok(Some((0..x.len()).map(|i| Vector3::new(x[i], y[i], z[i])).collect()))
        }
        _ => {
            let missing = names.iter().zip(&columns).find(|(_, column)| column.is_none());
            Err(format!("the column {} is missing", missing.map_or("", |(name, _)| name)))
        }
    }
}

/// The unit vectors along which a target is held: a direction, the axes named, or all three.
fn directions(direction: Option<Vector3<f64>>, fix: Option<&str>) -> Result<Vec<Vector3<f64>>, String> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    match (direction, fix) {
        (Some(_), Some(_)) => Err("give a direction or axes to fix, not both".to_owned()),
        (Some(direction), None) => {
            let unit = direction.try_normalize(0.0).filter(|unit| unit.iter().all(|c| c.is_finite()));
            unit.map(|unit| vec![unit])
                .ok_or_else(|| format!("the direction {:?} has no length", direction.as_slice()))
        }
        (None, Some(fix)) => {
            let index = |letter: char| "xyz".find(letter.to_ascii_lowercase());
            let mut held = [false; 3];
            for letter in fix.chars() {
                let axis =
                    index(letter).ok_or_else(|| format!("{fix:?} names no axes: use letters of xyz"))?;
                held[axis] = true;
            }
            Ok(axes.into_iter().zip(held).filter(|(_, held)| *held).map(|(axis, _)| axis).collect())
        }
        (None, None) => Ok(axes.to_vec()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_hold_a_direction_some_axes_or_all() {
        let text = br#"{"targets": [{"name": "A1", "measured": [1, 2, 3], "nominal": [1, 2, 0], "direction": [0, 0, 2]},
            {"measured": [1, 2, 3], "nominal": [1, 2, 0], "fix": "zX", "weight": 2},
            {"measured": [1, 2, 3], "nominal": [1, 2, 0]}]}"#;
        let targets = of_json(text).unwrap();
        assert_eq!(targets[0].directions, [Vector3::z()]);
        assert_eq!((&*targets[0].name, targets[1].weight), ("A1", 2.0));
        assert_eq!(targets[1].directions, [Vector3::x(), Vector3::z()]);
        assert_eq!(targets[2].directions.len(), 3);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let fails = |text: &str| of_json(text.as_bytes()).unwrap_err();
        assert!(fails("{\"targets\": [}").contains("line 1"));
        assert!(fails("{\"points\": []}").contains("no list of targets"));
        let one = |rest: &str| format!("[{{\"measured\": [1, 2, 3], \"nominal\": [1, 2, 0]{rest}}}]");
        assert!(fails(&one(", \"direction\": [0, 0, 0]")).contains("no length"));
        assert!(fails(&one(", \"fix\": \"w\"")).contains("letters of xyz"));
        assert!(fails(&one(", \"direction\": [0, 0, 1], \"fix\": \"x\"")).contains("not both"));
        assert!(fails(&one(", \"weigth\": 1")).contains("weigth"));
    }
}
