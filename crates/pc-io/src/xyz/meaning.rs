//! What columns without names mean.

use super::layout::Layout;
use super::rows::Rows;

/// Largest deviation of the length of a normal from 1.
const UNIT: f64 = 0.02;
/// Most rows that are looked at.
pub(super) const SAMPLE: usize = 10_000;

/// Names for the columns of rows without a header.
///
/// Two columns of numbers are x y, three x y z. After them a group of three that has unit length in every row is a
/// normal, a group of three (four at the end) that holds nothing but integers from 0 to 255 is a colour, and a single
/// column after the coordinates is an intensity. Columns of text name the points, or are named by their place, as are
/// other columns.
pub(super) fn guess(rows: &Rows, layout: &Layout, warnings: &mut Vec<String>) -> Vec<String> {
    let is_number = |place: &usize| !layout.texts.contains(place) && !layout.blanks.contains(place);
    let places: Vec<usize> = (0..rows.width).filter(is_number).collect();
    let table = Table { values: &rows.values, width: rows.width, places: &places };
    let by_place = |place: usize| format!("column_{}", place + 1);
    let found = guess_numbers(&table, layout.promised.is_some());
    let mut names: Vec<String> = (0..rows.width).map(by_place).collect();
    for (&place, name) in places.iter().zip(found) {
        names[place] = name.unwrap_or_else(|| by_place(place));
    }
    layout.blanks.iter().filter(|&&place| place < rows.width).for_each(|&place| names[place].clear());
    if let Some(label) = layout.label.filter(|&label| label < rows.width) {
        "name".clone_into(&mut names[label]);
    }
    if rows.width - layout.blanks.len().min(rows.width) > 3 && !rows.values.is_empty() {
        warnings.push(format!("there is no header; the columns were taken as {}", names.join(" ")));
    }
    names
}

/// Names of the columns of numbers; `None` for those that are named by their place.
fn guess_numbers(table: &Table<'_>, is_pts: bool) -> Vec<Option<String>> {
    let width = table.places.len();
    let mut names: Vec<Option<String>> =
        ["x", "y", "z"].iter().take(width).map(|&name| Some(name.to_owned())).collect();
    let (mut has_normals, mut has_colours) = (false, false);
    while names.len() < width {
        let at = names.len();
        let left = width - at;
        let mut add = |group: &[&str]| names.extend(group.iter().map(|&name| Some(name.to_owned())));
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
            names.push(None);
        }
    }
    names
}

struct Table<'a> {
    values: &'a [f64],
    width: usize,
    /// The columns that hold numbers.
    places: &'a [usize],
}

impl Table<'_> {
    /// Rows of the columns from number `at` on.
    fn rows<'a>(
        &'a self,
        at: usize,
        count: usize,
    ) -> impl Iterator<Item = impl Iterator<Item = f64> + 'a> + 'a {
        let rows = self.values.len() / self.width;
        let step = (rows / SAMPLE).max(1);
        let places = &self.places[at..at + count];
        self.values
            .chunks_exact(self.width)
            .step_by(step)
            .map(move |row| places.iter().map(move |&place| row[place]))
    }

    /// Whether three columns have length 1 in almost every row; zero and NaN stand for an unknown normal.
    fn is_unit(&self, at: usize) -> bool {
        let (mut known, mut unit) = (0usize, 0usize);
        for row in self.rows(at, 3) {
            let length = row.map(|value| value * value).sum::<f64>().sqrt();
            if length > 0.0 {
                known += 1;
                unit += usize::from((length - 1.0).abs() <= UNIT);
            }
        }
        known > 0 && unit * 100 >= known * 99
    }

    fn are_bytes(&self, at: usize, count: usize) -> bool {
        let is_byte = |value: f64| value.fract() == 0.0 && (0.0..=255.0).contains(&value);
        self.rows(at, count).all(|mut row| row.all(is_byte))
    }

    fn is_opacity(&self, at: usize) -> bool {
        self.rows(at, 1).all(|mut row| row.all(|value| value == 255.0))
    }
}
