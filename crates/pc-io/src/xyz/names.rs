//! What the names of columns mean.

use crate::columns::{is_axis, is_position};

/// Words beside the one that counts: `x coordinate`, `pos_x`, `Rechtswert (m)`.
const FILLERS: [&str; 22] = [
    "coordinate",
    "coordinates",
    "coord",
    "coords",
    "koordinate",
    "position",
    "pos",
    "value",
    "wert",
    "axis",
    "achse",
    "measured",
    "meas",
    "actual",
    "act",
    "ist",
    "in",
    "utm",
    "grid",
    "local",
    "of",
    "the",
];
const UNITS: [&str; 36] = [
    "m",
    "mm",
    "cm",
    "dm",
    "km",
    "um",
    "µm",
    "μm",
    "nm",
    "micron",
    "microns",
    "micrometer",
    "micrometre",
    "meter",
    "meters",
    "metre",
    "metres",
    "millimeter",
    "millimeters",
    "millimetre",
    "millimetres",
    "centimeter",
    "centimetre",
    "in",
    "inch",
    "inches",
    "ft",
    "foot",
    "feet",
    "usft",
    "ftus",
    "yd",
    "mil",
    "mils",
    "thou",
    "zoll",
];
/// Words of a row of units for columns that are no lengths.
const OTHER_UNITS: [&str; 16] = [
    "deg", "rad", "gon", "s", "sec", "db", "v", "%", "°", "float", "double", "real", "text", "string", "int",
    "integer",
];
/// Names of coordinates in surveying, east before north.
const SURVEY: [&[&str]; 3] = [
    &[
        "easting",
        "eastings",
        "east",
        "e",
        "rechtswert",
        "rechts",
        "ost",
        "ostwert",
        "est",
        "xcoord",
        "coordx",
        "posx",
    ],
    &[
        "northing",
        "northings",
        "north",
        "n",
        "hochwert",
        "hoch",
        "nord",
        "nordwert",
        "ycoord",
        "coordy",
        "posy",
    ],
    &[
        "elevation",
        "elev",
        "height",
        "hgt",
        "h",
        "höhe",
        "hoehe",
        "altitude",
        "alt",
        "level",
        "quota",
        "zcoord",
        "coordz",
        "posz",
    ],
];
/// Names of columns that name points.
const LABELS: [&str; 27] = [
    "name",
    "names",
    "label",
    "labels",
    "id",
    "ids",
    "point",
    "points",
    "pointname",
    "pointid",
    "pointno",
    "pt",
    "ptid",
    "ptname",
    "ptno",
    "pnt",
    "punkt",
    "punktnummer",
    "punktname",
    "punktnr",
    "pktnr",
    "nr",
    "no",
    "number",
    "station",
    "target",
    "bezeichnung",
];

/// A name in lower case without what stands in brackets, as words.
fn words(name: &str) -> Vec<String> {
    let name = name.trim().trim_matches('"').trim_start_matches(['/', '#']);
    let mut depth = 0usize;
    let outside = |letter: &char| {
        match letter {
            '[' | '(' | '{' | '<' => depth += 1,
            ']' | ')' | '}' | '>' => depth = depth.saturating_sub(1),
            _ => return depth == 0,
        }
        false
    };
    let plain: String = name.chars().filter(outside).collect::<String>().to_lowercase();
    let parts = plain.split(|letter: char| !letter.is_alphanumeric() && letter != 'µ' && letter != 'μ');
    parts.filter(|part| !part.is_empty()).map(str::to_owned).collect()
}

/// The words that count.
fn telling(name: &str) -> Vec<String> {
    let all = words(name);
    let is_extra = |word: &String| FILLERS.contains(&word.as_str()) || UNITS.contains(&word.as_str());
    let rest: Vec<String> = all.iter().filter(|word| !is_extra(word)).cloned().collect();
    if rest.is_empty() { all } else { rest }
}

/// The axis that a name stands for beside the plain x, y, z.
fn axis_of(name: &str) -> Option<usize> {
    let telling = telling(name);
    let [word] = telling.as_slice() else { return None };
    (0..3).find(|&axis| ["x", "y", "z"][axis] == word || SURVEY[axis].contains(&word.as_str()))
}

/// Gives coordinates that have other names (`Easting`, `x_mm`) the names x, y and z, where these are free; returns the
/// names that were taken for them.
pub(super) fn resolve(names: &mut [String]) -> Vec<String> {
    let mut taken = Vec::new();
    let mut places = [None; 3];
    for (axis, place) in places.iter_mut().enumerate() {
        if names.iter().any(|name| is_axis(name, axis)) {
            continue;
        }
        let mut found =
            (0..names.len()).filter(|&at| !is_position(&names[at]) && axis_of(&names[at]) == Some(axis));
        *place = found.next().filter(|_| found.next().is_none());
    }
    // A single letter such as h says nothing without its fellows.
    let whole = (0..2).all(|axis| places[axis].is_some() || names.iter().any(|name| is_axis(name, axis)));
    for (axis, place) in places.into_iter().enumerate() {
        if let Some(place) = place.filter(|_| whole) {
            taken.push(std::mem::replace(&mut names[place], ["x", "y", "z"][axis].to_owned()));
        }
    }
    taken
}

/// Whether a column of this name names points.
pub(crate) fn is_label(name: &str) -> bool {
    let words = words(name);
    !words.is_empty()
        && words.iter().all(|word| LABELS.contains(&word.as_str()) || FILLERS.contains(&word.as_str()))
        && words.iter().any(|word| LABELS.contains(&word.as_str()))
}

/// The unit of length that a cell of a row of units names, empty for none; `None` if it is no unit.
pub(super) fn unit(cell: &str) -> Option<String> {
    let plain = cell.trim().trim_matches(|letter: char| "[](){}<>\"".contains(letter)).trim().to_lowercase();
    let plain = plain.replace([' ', '.', '-', '_'], "");
    if plain.is_empty() || OTHER_UNITS.contains(&plain.as_str()) {
        return Some(String::new());
    }
    UNITS.contains(&plain.as_str()).then_some(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(line: &str) -> Vec<String> {
        let mut names: Vec<String> = line.split(',').map(str::to_owned).collect();
        let _ = resolve(&mut names);
        names
    }

    #[test]
    fn finds_coordinates_under_other_names() {
        assert_eq!(resolved("Point,Northing (m),Easting (m),Elev."), ["Point", "y", "x", "z"]);
        assert_eq!(resolved("Nr,Rechtswert,Hochwert,Höhe"), ["Nr", "x", "y", "z"]);
        assert_eq!(resolved("x_mm,Y-Koordinate,pos z"), ["x", "y", "z"]);
        assert_eq!(resolved("X/mm,Y in mm,Z <mm>"), ["x", "y", "z"]);
        assert_eq!(resolved("X,Y,h"), ["X", "Y", "z"]);
        // What is there under its own name, or twice, is left alone.
        assert_eq!(resolved("x,y,z,height"), ["x", "y", "z", "height"]);
        assert_eq!(resolved("E,N,north"), ["E", "N", "north"]);
        assert_eq!(resolved("h,e,t"), ["h", "e", "t"]);
        assert_eq!(resolved("Nominal X,Actual X,Actual Y"), ["Nominal X", "x", "y"]);
    }

    #[test]
    fn knows_names_and_units() {
        for name in ["Name", "Point ID", "Pt. No.", "label", "PUNKTNUMMER"] {
            assert!(is_label(name), "{name}");
        }
        for name in ["intensity", "x", "value", "point density", ""] {
            assert!(!is_label(name), "{name}");
        }
        assert_eq!(unit("[mm]").as_deref(), Some("mm"));
        assert_eq!((unit("-").as_deref(), unit("P1")), (Some(""), None));
    }
}
