//! Texts of points: lists of bytes.

use mesh_core::{PointCloud, TextField};

use super::header::{Element, Property};
use crate::Error;
use crate::columns::to_byte;
use crate::number_type::NumberType;
use crate::source::decode_name;
use crate::xyz::is_label;

/// Whether the lists of a property are texts.
pub(super) fn is_text(property: &Property) -> bool {
    property.list.is_some() && matches!(property.value, NumberType::U8 | NumberType::I8)
}

/// The texts of the points read so far.
#[derive(Debug, Default)]
pub(super) struct Texts {
    /// Property, texts, and the bytes of the row that is being read.
    fields: Vec<(usize, TextField, Vec<u8>)>,
}

impl Texts {
    pub(super) fn of(element: &Element) -> Self {
        let properties = element.properties.iter().enumerate().filter(|(_, property)| is_text(property));
        let field = |(place, property): (usize, &Property)| {
            (place, TextField::new(property.name.as_str()), Vec::new())
        };
        Self { fields: properties.map(field).collect() }
    }

    pub(super) fn add(&mut self, property: usize, value: f64) {
        if let Some((.., bytes)) = self.fields.iter_mut().find(|(place, ..)| *place == property) {
            // Signed bytes are written for letters beyond ASCII, too.
            bytes.push(to_byte(if value < 0.0 { value + 256.0 } else { value }));
        }
    }

    pub(super) fn end_row(&mut self) {
        for (_, field, bytes) in &mut self.fields {
            field.push(&decode_name(bytes));
            bytes.clear();
        }
    }

    /// Hands the texts over: the first that names points as names.
    pub(super) fn attach(self, cloud: PointCloud) -> Result<PointCloud, Error> {
        let mut attributes = cloud.attributes().clone();
        for (_, field, _) in self.fields {
            if attributes.names().is_none() && is_label(field.name()) {
                attributes.set_names(Some(field));
            } else {
                attributes.push_text(field);
            }
        }
        cloud.with_attributes(attributes).map_err(Error::shape)
    }
}
