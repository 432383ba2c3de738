//! PLY, the Polygon File Format: text and both byte orders.

mod header;
mod pieces;
mod rows;
mod texts;
mod write;

use self::header::{Element, Property};
use self::rows::{Rows, Visitor};
use self::texts::{Texts, is_text};
use crate::columns::{Column, assemble, names_a_position};
use crate::error::Place;
use crate::number_type::warn_of_wide;
use crate::parsed::{Fans, Parsed};
use crate::source::Source;
use crate::wording::counted;
use crate::{Error, Format, not_points};

pub(crate) use self::pieces::{HEAD, PointRows};
pub(crate) use self::write::{write, write_first, write_more};

/// Reads points, and triangles out of faces and triangle strips.
pub(crate) fn read(source: Source<'_>) -> Result<Parsed, Error> {
    let header = header::read(source)?;
    let elements = &header.elements;
    let mut warnings = Vec::new();
    let points = points_element(elements);
    if points.is_none() && elements.iter().any(|element| element.count > 0) {
        return Err(no_points(elements));
    }
    let point_count = points.map_or(0, |index| elements[index].count);

    let mut rows = Rows::new(source, header.encoding, header.end);
    let mut columns = Vec::new();
    let mut texts = Texts::default();
    let mut fans = Fans::default();
    let mut not_read = Vec::new();
    for (index, element) in elements.iter().enumerate() {
        if Some(index) == points {
            (columns, texts) = read_points(&mut rows, element, &mut warnings)?;
        } else if let Some((property, is_strip)) = face_list(element) {
            let corners = Vec::new();
            rows.visit(element, &mut Faces { property, is_strip, point_count, corners, fans: &mut fans })?;
            let others = element.properties.iter().enumerate().filter(|&(other, _)| other != property);
            not_read.extend(others.map(|(_, other)| format!("{} of the faces", other.name)));
        } else {
            if element.count > 0 {
                not_read.push(format!("the element {:?}", element.name));
            }
            rows.skip(element)?;
        }
    }
    if !not_read.is_empty() {
        warnings.push(format!("not read: {}", not_read.join(", ")));
    }
    if rows.overlong > 0 {
        warnings.push(format!(
            "more numbers than the header has properties in {}",
            counted(rows.overlong, "row")
        ));
    }
    rows.check_end(elements, &mut warnings)?;
    let cloud = match points {
        Some(_) => assemble(columns, &mut warnings).map_err(not_points)?,
        None => mesh_core::PointCloud::new(Vec::new()),
    };
    let cloud = texts.attach(cloud)?;
    let triangles = fans.finish(&mut warnings);
    Ok(Parsed::mesh(Format::Ply, cloud, triangles, warnings))
}

fn scalar_names(element: &Element) -> impl Iterator<Item = &str> + Clone {
    element
        .properties
        .iter()
        .filter(|property| property.list.is_none())
        .map(|property| property.name.as_str())
}

/// The element `vertex`, else the first that has coordinates.
fn points_element(elements: &[Element]) -> Option<usize> {
    let with_coordinates = |&(_, element): &(usize, &Element)| names_a_position(scalar_names(element));
    let candidates = || elements.iter().enumerate().filter(with_coordinates);
    (candidates().find(|(_, element)| element.name == "vertex"))
        .or_else(|| candidates().next())
        .map(|(index, _)| index)
}

fn no_points(elements: &[Element]) -> Error {
    let found: Vec<_> = elements
        .iter()
        .map(|element| {
            let names: Vec<_> = element.properties.iter().map(|property| property.name.as_str()).collect();
            format!("{} ({})", element.name, names.join(", "))
        })
        .collect();
    Error::malformed(
        Place::Whole,
        format!("no element has the properties x and y; there is {}", found.join(", ")),
        "export the file with coordinates",
    )
}

/// The list of vertex indices of an element, and whether it is a strip.
fn face_list(element: &Element) -> Option<(usize, bool)> {
    let place = element.properties.iter().position(|property| {
        property.list.is_some()
            && matches!(
                property.name.as_str(),
                "vertex_indices" | "vertex_index" | "vertex_indicies" | "vertices"
            )
    })?;
    match element.name.as_str() {
        "face" | "faces" => Some((place, false)),
        "tristrips" | "tristrip" => Some((place, true)),
        _ => None,
    }
}

fn read_points(
    rows: &mut Rows<'_>,
    element: &Element,
    warnings: &mut Vec<String>,
) -> Result<(Vec<Column>, Texts), Error> {
    let count = rows.checked_count(element)?;
    let column = |property: &Property| {
        property.list.is_none().then(|| Column {
            name: property.name.clone(),
            kind: property.value.kind(),
            values: Vec::with_capacity(count),
        })
    };
    let columns = element.properties.iter().map(column).collect();
    let mut points = Points { columns, texts: Texts::of(element) };
    rows.visit(element, &mut points)?;
    let lists = element.properties.iter().filter(|property| property.list.is_some() && !is_text(property));
    let names: Vec<_> = lists.map(|property| property.name.as_str()).collect();
    if !names.is_empty() {
        warnings.push(format!("lists per point are not read: {}", names.join(", ")));
    }
    let columns: Vec<_> = points.columns.into_iter().flatten().collect();
    for column in &columns {
        warn_of_wide(&column.name, column.kind, &column.values, warnings);
    }
    Ok((columns, points.texts))
}

/// Collects the numbers of points, one column per property that is not a list.
struct Points {
    columns: Vec<Option<Column>>,
    texts: Texts,
}

impl Visitor for Points {
    #[inline]
    fn scalar(&mut self, property: usize, value: f64) {
        if let Some(column) = &mut self.columns[property] {
            column.values.push(value);
        }
    }

    fn values(&mut self, property: usize) -> Option<&mut Vec<f64>> {
        self.columns[property].as_mut().map(|column| &mut column.values)
    }

    fn item(&mut self, property: usize, value: f64) {
        self.texts.add(property, value);
    }

    fn end_row(&mut self, _: Place) -> Result<(), Error> {
        self.texts.end_row();
        Ok(())
    }
}

/// Collects the triangles of faces or strips.
struct Faces<'a> {
    property: usize,
    is_strip: bool,
    point_count: u64,
    corners: Vec<f64>,
    fans: &'a mut Fans,
}

impl Visitor for Faces<'_> {
    fn scalar(&mut self, _: usize, _: f64) {}

    fn values(&mut self, _: usize) -> Option<&mut Vec<f64>> {
        None
    }

    #[inline]
    fn item(&mut self, property: usize, value: f64) {
        if property == self.property {
            self.corners.push(value);
        }
    }

    fn end_row(&mut self, place: Place) -> Result<(), Error> {
        let valid = |index: f64| index >= 0.0 && index.fract() == 0.0 && index < self.point_count as f64;
        if let Some(bad) =
            self.corners.iter().find(|&&index| !(valid(index) || self.is_strip && index == -1.0))
        {
            return Err(Error::malformed(
                place,
                format!(
                    "the face refers to vertex {bad}, but there are {} (counted from 0)",
                    self.point_count
                ),
                "correct the face or export the file again",
            ));
        }
        if self.is_strip {
            let strip: Vec<_> =
                self.corners.iter().map(|&index| valid(index).then(|| to_index(index))).collect();
            self.fans.push_strip(&strip);
        } else if let [a, b, c] = *self.corners {
            self.fans.push(&[to_index(a), to_index(b), to_index(c)]);
        } else {
            let corners: Vec<_> = self.corners.iter().map(|&index| to_index(index)).collect();
            self.fans.push(&corners);
        }
        self.corners.clear();
        Ok(())
    }
}

/// An index that is known to be below the number of points; one beyond 32 bits is refused when the mesh is built.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
const fn to_index(index: f64) -> u32 {
    index as u32
}
