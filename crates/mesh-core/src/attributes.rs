//! What a point can carry besides its position.

use nalgebra::Vector3;

use crate::{Error, TextField};

/// One colour per point, with or without opacity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Colours {
    /// Red, green, blue, 0 to 255 each.
    Rgb(Vec<[u8; 3]>),
    /// Red, green, blue, opacity, 0 to 255 each.
    Rgba(Vec<[u8; 4]>),
}

impl Colours {
    /// Number of colours.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::Rgb(values) => values.len(),
            Self::Rgba(values) => values.len(),
        }
    }

    /// Whether there is no colour at all.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the colours have an opacity of their own.
    #[must_use]
    pub const fn has_alpha(&self) -> bool {
        matches!(self, Self::Rgba(_))
    }

    /// Red, green, blue and opacity (255 where there is none) of the colour at `index`, if it exists.
    #[must_use]
    pub fn rgba(&self, index: usize) -> Option<[u8; 4]> {
        match self {
            Self::Rgb(values) => values.get(index).map(|&[r, g, b]| [r, g, b, 255]),
            Self::Rgba(values) => values.get(index).copied(),
        }
    }

    fn retain(&mut self, keep: &[bool]) {
        match self {
            Self::Rgb(values) => retain(values, keep),
            Self::Rgba(values) => retain(values, keep),
        }
    }
}

/// A named number per point, such as the intensity of the returned laser light.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarField {
    /// What the numbers are called in files.
    pub name: String,
    /// One number per point.
    pub values: Vec<f64>,
}

/// Normals, colours, scalars, names and other texts of the points of a cloud or the vertices of a mesh.
///
/// Scalars and texts keep the order in which they were added.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Attributes {
    normals: Option<Vec<Vector3<f64>>>,
    colours: Option<Colours>,
    scalars: Vec<ScalarField>,
    names: Option<TextField>,
    texts: Vec<TextField>,
}

impl Attributes {
    /// The normals, one per point; of any length, unit length in well-kept files.
    #[must_use]
    pub fn normals(&self) -> Option<&[Vector3<f64>]> {
        self.normals.as_deref()
    }

    /// The colours, one per point.
    #[must_use]
    pub const fn colours(&self) -> Option<&Colours> {
        self.colours.as_ref()
    }

    /// The scalars in the order in which they were added.
    #[must_use]
    pub fn scalars(&self) -> &[ScalarField] {
        &self.scalars
    }

    /// The values of the scalar called `name`.
    #[must_use]
    pub fn scalar(&self, name: &str) -> Option<&[f64]> {
        self.scalars.iter().find(|field| field.name == name).map(|field| field.values.as_slice())
    }

    /// The names of the points, where they have some.
    #[must_use]
    pub const fn names(&self) -> Option<&TextField> {
        self.names.as_ref()
    }

    /// Texts other than names, in the order in which they were added.
    #[must_use]
    pub fn texts(&self) -> &[TextField] {
        &self.texts
    }

    /// Whether there is neither a normal nor a colour nor a scalar nor a text.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.normals.is_none()
            && self.colours.is_none()
            && self.scalars.is_empty()
            && self.names.is_none()
            && self.texts.is_empty()
    }

    /// Removes the normals and returns them.
    pub fn take_normals(&mut self) -> Option<Vec<Vector3<f64>>> {
        self.normals.take()
    }

    /// Sets or removes the normals.
    pub fn set_normals(&mut self, normals: Option<Vec<Vector3<f64>>>) {
        self.normals = normals;
    }

    /// Sets or removes the colours.
    pub fn set_colours(&mut self, colours: Option<Colours>) {
        self.colours = colours;
    }

    /// Sets or removes the names of the points.
    pub fn set_names(&mut self, names: Option<TextField>) {
        self.names = names;
    }

    /// Adds a text other than the name.
    pub fn push_text(&mut self, text: TextField) {
        self.texts.push(text);
    }

    /// Adds a scalar.
    ///
    /// # Errors
    /// [`Error::DuplicateScalar`] if the name is taken.
    pub fn push_scalar(&mut self, name: impl Into<String>, values: Vec<f64>) -> Result<(), Error> {
        let name = name.into();
        if self.scalar(&name).is_some() {
            return Err(Error::DuplicateScalar { name });
        }
        self.scalars.push(ScalarField { name, values });
        Ok(())
    }

    /// Removes the scalar called `name` and returns its values.
    pub fn remove_scalar(&mut self, name: &str) -> Option<Vec<f64>> {
        let index = self.scalars.iter().position(|field| field.name == name)?;
        Some(self.scalars.remove(index).values)
    }

    /// Checks that every attribute has one value per point.
    pub(crate) fn check(&self, points: usize) -> Result<(), Error> {
        let lengths = (self.normals.iter().map(|normals| ("normals", normals.len())))
            .chain(self.colours.iter().map(|colours| ("colours", colours.len())))
            .chain(self.scalars.iter().map(|field| (field.name.as_str(), field.values.len())))
            .chain(self.names.iter().chain(&self.texts).map(|field| (field.name(), field.len())));
        for (name, found) in lengths {
            if found != points {
                return Err(Error::AttributeLength { name: name.to_owned(), found, expected: points });
            }
        }
        Ok(())
    }

    /// The values at the given indices, which must exist.
    pub(crate) fn select(&self, indices: &[u32]) -> Self {
        let colours = self.colours.as_ref().map(|colours| match colours {
            Colours::Rgb(values) => Colours::Rgb(select(values, indices)),
            Colours::Rgba(values) => Colours::Rgba(select(values, indices)),
        });
        let scalars = (self.scalars.iter())
            .map(|field| ScalarField { name: field.name.clone(), values: select(&field.values, indices) })
            .collect();
        Self {
            normals: self.normals.as_ref().map(|normals| select(normals, indices)),
            colours,
            scalars,
            names: self.names.as_ref().map(|names| names.select(indices)),
            texts: self.texts.iter().map(|field| field.select(indices)).collect(),
        }
    }

    /// Drops the values of the points whose flag is false.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        if let Some(normals) = &mut self.normals {
            retain(normals, keep);
        }
        if let Some(colours) = &mut self.colours {
            colours.retain(keep);
        }
        for field in &mut self.scalars {
            retain(&mut field.values, keep);
        }
        self.names.iter_mut().chain(&mut self.texts).for_each(|field| field.retain(keep));
    }
}

/// The values at the given indices, which must exist.
pub(crate) fn select<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().map(|&index| values[index as usize]).collect()
}

/// Drops the values whose flag is false.
pub(crate) fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    values.retain(|_| flags.next().copied().unwrap_or(false));
}
