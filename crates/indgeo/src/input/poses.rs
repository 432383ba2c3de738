//! Starting poses, as they come in JSON files.

use crate::error::Error;
use crate::files;
use industrial_geometry::register::Pose;
use serde_json::Value;
use std::path::Path;

const ADVICE: &str =
    "give a matrix of four rows, {\"matrix\": [[r, r, r, t], …, [0, 0, 0, 1]]}, or a list of such";

/// Names under which an object holds its matrix.
const KEYS: [&str; 2] = ["matrix", "T"];

/// Names under which an object holds its list of poses, as the file of `register-views` does.
const LISTS: [&str; 2] = ["views", "poses"];

/// Reads one pose, or a list of poses: 4 × 4 matrices by rows, alone or as the value of `matrix`.
pub(crate) fn read(path: &Path) -> Result<Vec<Pose<3>>, Error> {
    let bytes = files::read_bytes(path)?;
    let document: Value = serde_json::from_slice(&bytes)
        .map_err(|error| Error::content(path, format!("line {}: {error}", error.line()), ADVICE))?;
    parse(&document).map_err(|what| Error::content(path, what, ADVICE))
}

fn parse(document: &Value) -> Result<Vec<Pose<3>>, String> {
    if let Some(rows) = matrix(document) {
        return Ok(vec![pose(&rows)?]);
    }
    let list = LISTS.iter().find_map(|key| document.get(key)).unwrap_or(document);
    let Some(list) = list.as_array().filter(|list| !list.is_empty()) else {
        return Err("there is no pose in this file".to_owned());
    };
    let one = |(index, value): (usize, &Value)| {
        let rows = matrix(value)
            .ok_or_else(|| format!("entry {index} (from 0) is not a matrix of 4 × 4 numbers"))?;
        pose(&rows).map_err(|what| format!("entry {index} (from 0): {what}"))
    };
    list.iter().enumerate().map(one).collect()
}

fn matrix(value: &Value) -> Option<[[f64; 4]; 4]> {
    let inner = KEYS.iter().find_map(|key| value.get(key)).unwrap_or(value);
    serde_json::from_value(inner.clone()).ok()
}

fn pose(rows: &[[f64; 4]; 4]) -> Result<Pose<3>, String> {
    Pose::<3>::from_row_major(rows).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn one_pose_or_several() {
        let quarter = json!([[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]);
        for (document, count) in [
            (quarter.clone(), 1),
            (json!({"matrix": quarter, "rms": 0.5}), 1),
            (json!([quarter, quarter]), 2),
            (json!([{"T": quarter}, {"matrix": quarter}, quarter]), 3),
            (json!({"status": "converged", "views": [{"matrix": quarter}, {"matrix": quarter}]}), 2),
        ] {
            let poses = parse(&document).unwrap();
            assert_eq!(poses.len(), count, "{document}");
            assert_eq!(poses[count - 1].to_row_major()[0], [0.0, -1.0, 0.0, 5.0]);
        }
        assert!(parse(&json!([])).unwrap_err().contains("no pose"));
        assert!(parse(&json!([quarter, [1, 2]])).unwrap_err().contains("entry 1"));
        let mirror = json!([[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
        assert!(parse(&mirror).unwrap_err().contains("not a rigid motion"));
    }
}
