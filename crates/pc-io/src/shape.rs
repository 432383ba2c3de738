//! What the writers of single formats are given.

use mesh_core::{Attributes, Colours, PointCloud, TextField};
use nalgebra::{Point3, Vector3};

use crate::columns::is_reserved;
use crate::wording::counted;

/// Points, and triangles where there are any.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape<'a> {
    pub(crate) cloud: &'a PointCloud,
    pub(crate) triangles: &'a [[u32; 3]],
}

impl<'a> Shape<'a> {
    pub(crate) fn positions(self) -> &'a [Point3<f64>] {
        self.cloud.positions()
    }

    pub(crate) const fn attributes(self) -> &'a Attributes {
        self.cloud.attributes()
    }

    pub(crate) fn normals(self) -> Option<&'a [Vector3<f64>]> {
        self.attributes().normals()
    }

    pub(crate) const fn colours(self) -> Option<&'a Colours> {
        self.attributes().colours()
    }

    /// The coordinates that a file needs: z is left out of points in the plane.
    pub(crate) const fn axes(self) -> &'static [&'static str] {
        if self.cloud.dimension() == 2 { &["x", "y"] } else { &["x", "y", "z"] }
    }

    /// Names of the scalars as they can be written into a header: without blanks and separators, and none that would
    /// be read back as something else. What had to be changed is told.
    pub(crate) fn scalar_names(self, warnings: &mut Vec<String>) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for field in self.attributes().scalars() {
            let plain = |letter: char| {
                if letter.is_whitespace() || letter.is_control() || ",;\"'#/[]()".contains(letter) {
                    '_'
                } else {
                    letter
                }
            };
            let mut name: String = field.name.chars().map(plain).collect();
            if name.is_empty() || is_reserved(&name) || crate::number::parse(name.as_bytes()).is_some() {
                name = format!("scalar_{name}");
            }
            let taken = |candidate: &String| names.contains(candidate);
            if taken(&name) {
                let numbered =
                    (2usize..).map(|number| format!("{name}_{number}")).find(|candidate| !taken(candidate));
                name = numbered.unwrap_or(name);
            }
            if name != field.name {
                warnings.push(format!("the scalar {:?} was written as {name:?}", field.name));
            }
            names.push(name);
        }
        names
    }

    /// Names of the points and other texts, with the names of their columns as they can be written into a header, none
    /// of which is among `taken`.
    pub(crate) fn texts(self, taken: &[String]) -> Vec<(String, &'a TextField)> {
        let mut texts: Vec<(String, &TextField)> = Vec::new();
        let names = self.attributes().names().into_iter();
        for field in names.chain(self.attributes().texts()) {
            let is_names = texts.is_empty() && self.attributes().names().is_some();
            let plain = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '.';
            let name: String =
                field.name().chars().map(|letter| if plain(letter) { letter } else { '_' }).collect();
            // Names are read back as such only under a name that says so.
            let keeps =
                if is_names { crate::xyz::is_label(&name) } else { !name.is_empty() && !is_reserved(&name) };
            let name = if keeps {
                name
            } else if is_names {
                "name".to_owned()
            } else {
                format!("text_{name}")
            };
            let is_free =
                |name: &String| !taken.contains(name) && texts.iter().all(|(other, _)| other != name);
            let numbered = || (2usize..).map(|number| format!("{name}_{number}")).find(|name| is_free(name));
            let free = if is_free(&name) { Some(name.clone()) } else { numbered() };
            texts.push((free.unwrap_or(name), field));
        }
        texts
    }

    /// Tells which of the attributes a format does not hold.
    pub(crate) fn warn_of_loss(self, keeps: Keeps, warnings: &mut Vec<String>) {
        let mut lost = Vec::new();
        if self.normals().is_some() && !keeps.normals {
            lost.push("normals".to_owned());
        }
        match self.colours() {
            Some(_) if !keeps.colours => lost.push("colours".to_owned()),
            Some(colours) if colours.has_alpha() && !keeps.opacity => lost.push("opacity".to_owned()),
            _ => {}
        }
        if !keeps.scalars {
            lost.extend(self.attributes().scalars().iter().map(|field| format!("scalar {:?}", field.name)));
        }
        if !keeps.texts {
            lost.extend(self.attributes().names().map(|_| "names of the points".to_owned()));
            lost.extend(self.attributes().texts().iter().map(|field| format!("text {:?}", field.name())));
        }
        if !self.triangles.is_empty() && !keeps.triangles {
            lost.push(counted(self.triangles.len(), "triangle"));
        }
        if !lost.is_empty() {
            warnings.push(format!("the format cannot hold and lost: {}", lost.join(", ")));
        }
        if self.cloud.dimension() == 2 && !keeps.plane {
            warnings.push("the points are two-dimensional; they were written with z = 0".to_owned());
        }
    }
}

/// What a format can hold besides positions in space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Keeps {
    pub(crate) normals: bool,
    pub(crate) colours: bool,
    pub(crate) opacity: bool,
    pub(crate) scalars: bool,
    pub(crate) texts: bool,
    pub(crate) triangles: bool,
    pub(crate) plane: bool,
}
