//! From named columns of numbers to a point cloud.

use mesh_core::{Attributes, Colours, PointCloud};
use nalgebra::{Point3, Vector3};

/// How the numbers of a column were written, which decides how they can be colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Unsigned 8-bit integers.
    Byte,
    /// Other integers.
    Integer,
    /// Floating point numbers.
    Float,
    /// Text, which leaves it open.
    Text,
}

/// A named number per point.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) values: Vec<f64>,
}

/// Why columns are not points.
#[derive(Debug)]
pub(crate) enum NotPoints {
    /// There is no column of that name.
    Missing(&'static str),
    /// There are several columns of that name.
    Twice(&'static str),
    /// The columns do not fit together.
    Shape(mesh_core::Error),
}

const POSITION: [&[&str]; 3] = [
    &["x", "points:0", "points_0", "coordinates:0"],
    &["y", "points:1", "points_1", "coordinates:1"],
    &["z", "points:2", "points_2", "coordinates:2"],
];
const NORMAL: [&[&str]; 3] = [
    &["nx", "normal_x", "normalx", "normals:0", "normals_0"],
    &["ny", "normal_y", "normaly", "normals:1", "normals_1"],
    &["nz", "normal_z", "normalz", "normals:2", "normals_2"],
];
const COLOUR: [&[&str]; 3] = [
    &["red", "r", "diffuse_red", "rgb:0"],
    &["green", "g", "diffuse_green", "rgb:1"],
    &["blue", "b", "diffuse_blue", "rgb:2"],
];
const ALPHA: &[&str] = &["alpha", "a", "diffuse_alpha"];

/// Whether a column of this name would be read as something else than a scalar.
pub(crate) fn is_reserved(name: &str) -> bool {
    let plain = plain_name(name);
    (POSITION.iter().chain(&NORMAL).chain(&COLOUR))
        .chain([&ALPHA])
        .any(|names| names.contains(&plain.as_str()))
        || matches!(plain.as_str(), "rgb" | "rgba" | "_")
}

/// A name in lower case, without quotes and without a unit in brackets.
fn plain_name(name: &str) -> String {
    let name = name.trim().trim_matches('"').trim_start_matches('/');
    let name = name.split(['[', '(']).next().unwrap_or(name);
    name.trim().to_ascii_lowercase()
}

/// Whether a name is that of a coordinate.
pub(crate) fn is_position(name: &str) -> bool {
    POSITION.iter().any(|names| names.contains(&plain_name(name).as_str()))
}

/// Whether a name is that of the coordinate of an axis, 0 to 2.
pub(crate) fn is_axis(name: &str, axis: usize) -> bool {
    POSITION[axis].contains(&plain_name(name).as_str())
}

/// The names of coordinates that occur among `names`.
pub(crate) fn names_a_position<'a>(names: impl Iterator<Item = &'a str> + Clone) -> bool {
    let has = |axis: usize| names.clone().any(|name| POSITION[axis].contains(&plain_name(name).as_str()));
    has(0) && has(1)
}

/// Takes the columns of positions, normals and colours; the others become scalars in their order.
///
/// Without a column z the points are two-dimensional. What does not fit is kept as scalars and told in `warnings`.
pub(crate) fn assemble(columns: Vec<Column>, warnings: &mut Vec<String>) -> Result<PointCloud, NotPoints> {
    let mut columns: Vec<Option<Column>> = columns.into_iter().map(Some).collect();
    let find = |columns: &[Option<Column>], names: &[&str]| {
        let mut places = (0..columns.len()).filter(|&at| {
            columns[at].as_ref().is_some_and(|column| names.contains(&plain_name(&column.name).as_str()))
        });
        (places.next(), places.next().is_some())
    };
    let mut take = |names: &'static [&'static str]| match find(&columns, names) {
        (_, true) => Err(NotPoints::Twice(names[0])),
        (place, _) => Ok(place.and_then(|at| columns[at].take())),
    };
    let x = take(POSITION[0])?.ok_or(NotPoints::Missing("x"))?;
    let y = take(POSITION[1])?.ok_or(NotPoints::Missing("y"))?;
    let z = take(POSITION[2])?;
    let planar = z.is_none();
    let positions: Vec<Point3<f64>> = match z {
        Some(z) => zip3([&x, &y, &z]).map(|[x, y, z]| Point3::new(x, y, z)).collect(),
        None => x.values.iter().zip(&y.values).map(|(&x, &y)| Point3::new(x, y, 0.0)).collect(),
    };
    drop((x, y));

    let mut attributes = Attributes::default();
    if let Some([x, y, z]) = triple(&columns, &NORMAL) {
        let taken = [x, y, z].map(|at| columns[at].take());
        if let [Some(x), Some(y), Some(z)] = &taken {
            attributes.set_normals(Some(zip3([x, y, z]).map(|[x, y, z]| Vector3::new(x, y, z)).collect()));
        }
    }
    if let Some(places) = triple(&columns, &COLOUR) {
        let alpha = find(&columns, ALPHA).0;
        let group: Vec<usize> = places.into_iter().chain(alpha).collect();
        let channels: Vec<&Column> = group.iter().filter_map(|&at| columns[at].as_ref()).collect();
        if let Some(colours) = colours(&channels, warnings) {
            attributes.set_colours(Some(colours));
            for at in group {
                columns[at] = None;
            }
        }
    }
    for column in columns.into_iter().flatten() {
        let name = free_name(&attributes, column.name, warnings);
        attributes.push_scalar(name, column.values).map_err(NotPoints::Shape)?;
    }
    let cloud = PointCloud::new(positions);
    let cloud = if planar { cloud.into_planar().map_err(NotPoints::Shape)? } else { cloud };
    cloud.with_attributes(attributes).map_err(NotPoints::Shape)
}

/// The places of x, y and z, and of normals where there are any, of columns of which [`assemble`] makes points in space without
/// anything to tell; `None` for all others.
pub(crate) fn point_columns(columns: &[(&str, Kind)]) -> Option<([usize; 3], Option<[usize; 3]>)> {
    let empty =
        |&(name, kind): &(&str, Kind)| Some(Column { name: name.to_owned(), kind, values: Vec::new() });
    let found: Vec<Option<Column>> = columns.iter().map(empty).collect();
    let positions = triple(&found, &POSITION)?;
    let is_repeated =
        |(place, (name, _)): (usize, &(&str, Kind))| columns[..place].iter().any(|(other, _)| other == name);
    if columns.iter().enumerate().any(is_repeated) {
        return None;
    }
    // Other colours than bytes have to be looked at.
    let is_colour =
        |name: &str| COLOUR.iter().chain([&ALPHA]).any(|names| names.contains(&plain_name(name).as_str()));
    if columns.iter().any(|(name, kind)| is_colour(name) && *kind != Kind::Byte) {
        return None;
    }
    Some((positions, triple(&found, &NORMAL)))
}

/// The places of three columns, if each occurs exactly once.
fn triple(columns: &[Option<Column>], names: &[&[&str]; 3]) -> Option<[usize; 3]> {
    let mut places = [0; 3];
    for (place, names) in places.iter_mut().zip(names) {
        let mut found = (0..columns.len()).filter(|&at| {
            columns[at].as_ref().is_some_and(|column| names.contains(&plain_name(&column.name).as_str()))
        });
        *place = found.next()?;
        if found.next().is_some() {
            return None;
        }
    }
    Some(places)
}

fn zip3<'a>([x, y, z]: [&'a Column; 3]) -> impl Iterator<Item = [f64; 3]> + 'a {
    x.values.iter().zip(&y.values).zip(&z.values).map(|((&x, &y), &z)| [x, y, z])
}

/// A name that no scalar has yet.
pub(crate) fn free_name(attributes: &Attributes, name: String, warnings: &mut Vec<String>) -> String {
    if attributes.scalar(&name).is_none() {
        return name;
    }
    let free = (2usize..)
        .map(|number| format!("{name}_{number}"))
        .find(|candidate| attributes.scalar(candidate).is_none());
    let free = free.unwrap_or_else(|| name.clone());
    warnings.push(format!("several columns are named {name:?}; one of them is now {free:?}"));
    free
}

/// Colours from three or four columns of numbers; `None`, with a warning, where the numbers are no colours.
pub(crate) fn colours(channels: &[&Column], warnings: &mut Vec<String>) -> Option<Colours> {
    let all_bytes = channels.iter().all(|column| column.kind == Kind::Byte);
    let scale = if all_bytes { 1.0 } else { colour_scale(channels, warnings)? };
    let mut rounded = false;
    let colours = scaled_colours(channels, scale, &mut rounded)?;
    if rounded {
        warnings.push(ROUNDED_COLOURS.to_owned());
    }
    Some(colours)
}

/// Says that colours are not what they were.
pub(crate) const ROUNDED_COLOURS: &str = "colours were rounded to 8 bits per channel";

/// Colours from columns of numbers that a scale makes bytes; `rounded` becomes true where they were none.
pub(crate) fn scaled_colours(channels: &[&Column], scale: f64, rounded: &mut bool) -> Option<Colours> {
    let mut byte = |value: f64| {
        let scaled = value * scale;
        let nearest = scaled.round();
        // A colour written as a float is still meant to be the byte it came from.
        *rounded |= (scaled - nearest).abs() > 1e-3;
        to_byte(nearest)
    };
    Some(match channels {
        [r, g, b] => Colours::Rgb(zip3([*r, *g, *b]).map(|colour| colour.map(&mut byte)).collect()),
        [r, g, b, a] => Colours::Rgba(
            (zip3([*r, *g, *b]).zip(&a.values)).map(|([r, g, b], &a)| [r, g, b, a].map(&mut byte)).collect(),
        ),
        _ => return None,
    })
}

/// What turns the numbers into bytes.
fn colour_scale(channels: &[&Column], warnings: &mut Vec<String>) -> Option<f64> {
    let values = || channels.iter().flat_map(|column| column.values.iter().copied());
    let largest = values().fold(0.0, f64::max);
    if !values().all(|value| (0.0..=65535.0).contains(&value)) {
        warnings
            .push("colours that are negative, above 65535 or not numbers were kept as scalars".to_owned());
        return None;
    }
    let fractions = match channels.first()?.kind {
        Kind::Float => largest <= 1.0,
        Kind::Text => largest <= 1.0 && values().any(|value| value.fract() != 0.0),
        Kind::Byte | Kind::Integer => false,
    };
    Some(if fractions { 255.0 } else { integer_scale(largest) })
}

/// What turns integers of which this is the largest into bytes.
pub(crate) fn integer_scale(largest: f64) -> f64 {
    if largest <= 255.0 { 1.0 } else { 1.0 / 257.0 }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the value is limited to 0..=255 first"
)]
pub(crate) const fn to_byte(value: f64) -> u8 {
    value.clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(name: &str, kind: Kind, values: &[f64]) -> Column {
        Column { name: name.into(), kind, values: values.to_vec() }
    }

    #[test]
    fn sorts_columns_by_name() {
        let names = ["B", "Z", "Y [mm]", "X", "ny", "nx", "nz", "r", "g", "time"];
        let columns = names.iter().map(|name| column(name, Kind::Byte, &[1.0, 2.0])).collect();
        let cloud = assemble(columns, &mut Vec::new()).unwrap();
        assert_eq!(cloud.positions()[1], Point3::new(2.0, 2.0, 2.0));
        assert_eq!(cloud.attributes().colours(), Some(&Colours::Rgb(vec![[1; 3], [2; 3]])));
        assert_eq!(cloud.attributes().scalars().len(), 1);
        let planar =
            assemble(vec![column("x", Kind::Text, &[1.0]), column("y", Kind::Text, &[1.0])], &mut Vec::new());
        assert_eq!(planar.unwrap().dimension(), 2);
    }

    #[test]
    fn scales_colours_and_keeps_what_is_none() {
        let convert = |kind: Kind, values: [f64; 3]| {
            let columns: Vec<_> = values.iter().map(|&value| column("c", kind, &[value])).collect();
            colours(&columns.iter().collect::<Vec<_>>(), &mut Vec::new())
        };
        assert_eq!(convert(Kind::Float, [0.0, 1.0, 0.2]), Some(Colours::Rgb(vec![[0, 255, 51]])));
        assert_eq!(convert(Kind::Float, [117.0, 73.0, 0.0]), Some(Colours::Rgb(vec![[117, 73, 0]])));
        assert_eq!(convert(Kind::Integer, [65535.0, 257.0, 0.0]), Some(Colours::Rgb(vec![[255, 1, 0]])));
        assert_eq!(convert(Kind::Text, [1.0, 0.0, 1.0]), Some(Colours::Rgb(vec![[1, 0, 1]])));
        assert_eq!(convert(Kind::Float, [f64::NAN, 0.0, 0.0]), None);
        assert_eq!(convert(Kind::Integer, [-1.0, 0.0, 0.0]), None);
    }
}
