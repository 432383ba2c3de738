//! What columns without names mean.

use crate::{Error, Place};

/// Largest deviation of the length of a normal from 1.
const UNIT: f64 = 0.02;
/// Most rows that are looked at.
const SAMPLE: usize = 10_000;

/// Names for the columns of rows without a header.
///
/// Two columns are x y, three x y z. After them a group of three that has unit length in every row is a normal, a
/// group of three (four at the end) that holds nothing but integers from 0 to 255 is a colour, and a single column
/// after the coordinates is an intensity. Other columns are named by their place.
pub(super) fn guess(
    values: &[f64],
    width: usize,
    is_pts: bool,
    warnings: &mut Vec<String>,
) -> Result<Vec<String>, Error> {
    let coordinates = width.min(3);
    let mut names: Vec<String> =
        ["x", "y", "z"].iter().take(coordinates).map(|&name| name.to_owned()).collect();
    let table = Table { values, width };
    let (mut has_normals, mut has_colours) = (false, false);
    while names.len() < width {
        let at = names.len();
        let left = width - at;
        let mut add = |group: &[&str]| names.extend(group.iter().map(|&name| name.to_owned()));
        if left >= 3 && !has_normals && table.is_unit(at) {
            has_normals = true;
            add(&["nx", "ny", "nz"]);
        } else if at == 3 && left == 4 && (is_pts || !table.is_opacity(6)) && table.are_bytes(4, 3) {
            has_colours = true;
            add(&["intensity", "r", "g", "b"]);
        } else if left == 4 && !has_colours && table.are_bytes(at, 4) {
            has_colours = true;
            add(&["r", "g", "b", "a"]);
        } else if left >= 3 && !has_colours && table.are_bytes(at, 3) {
            has_colours = true;
            add(&["r", "g", "b"]);
        } else if at == 3 && left == 1 {
            add(&["intensity"]);
        } else {
            names.push(format!("column_{}", at + 1));
        }
    }
    if width > 3 && !values.is_empty() {
        warnings.push(format!("there is no header; the columns were taken as {}", names.join(" ")));
    }
    if width > 1000 {
        return Err(Error::malformed(
            Place::Whole,
            format!("the lines have {width} columns, which is no list of points"),
            "give a file with one point per line",
        ));
    }
    Ok(names)
}

struct Table<'a> {
    values: &'a [f64],
    width: usize,
}

impl Table<'_> {
    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        let count = self.values.len() / self.width;
        let step = (count / SAMPLE).max(1);
        self.values.chunks_exact(self.width).step_by(step)
    }

    /// Whether three columns have length 1 in almost every row; zero and NaN stand for an unknown normal.
    fn is_unit(&self, at: usize) -> bool {
        let (mut known, mut unit) = (0usize, 0usize);
        for row in self.rows() {
            let length = row[at..at + 3].iter().map(|value| value * value).sum::<f64>().sqrt();
            if length > 0.0 {
                known += 1;
                unit += usize::from((length - 1.0).abs() <= UNIT);
            }
        }
        known > 0 && unit * 100 >= known * 99
    }

    fn are_bytes(&self, at: usize, count: usize) -> bool {
        let is_byte = |&value: &f64| value.fract() == 0.0 && (0.0..=255.0).contains(&value);
        self.rows().all(|row| row[at..at + count].iter().all(is_byte))
    }

    fn is_opacity(&self, at: usize) -> bool {
        self.rows().all(|row| row[at] == 255.0)
    }
}
