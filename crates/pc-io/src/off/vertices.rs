//! The vertices of an OFF file.

use crate::wording::counted;
use mesh_core::{Attributes, PointCloud};
use nalgebra::{Point3, Vector3};

use super::tokens::Tokens;
use super::{EXPORT, Header};
use crate::columns::{Column, Kind, colours};
use crate::source::quoted;
use crate::{Error, number};

/// Positions, normals and colours read so far.
#[derive(Debug)]
pub(super) struct Vertices {
    header: Header,
    positions: Vec<Point3<f64>>,
    normals: Vec<Vector3<f64>>,
    channels: Vec<Column>,
    surplus: usize,
}

impl Vertices {
    pub(super) const fn new(header: Header) -> Self {
        Self { header, positions: Vec::new(), normals: Vec::new(), channels: Vec::new(), surplus: 0 }
    }

    /// Numbers before the colour.
    const fn least(&self) -> usize {
        if self.header.normals { 6 } else { 3 }
    }

    const fn texture(&self) -> usize {
        if self.header.texture { 2 } else { 0 }
    }

    /// Reads the vertex that the next line holds.
    pub(super) fn read_line(&mut self, tokens: &mut Tokens<'_>, vertex: u64) -> Result<(), Error> {
        let mut numbers = [0.0; 12];
        let mut length = 0;
        let mut has_point = false;
        let (at, mut word) = tokens.next_or(&format!("vertex {vertex}"))?;
        loop {
            let value = parse(tokens, at, word)?;
            if let Some(place) = numbers.get_mut(length) {
                *place = value;
                has_point |= length >= self.least() && word.contains(&b'.');
                length += 1;
            }
            let Some(next) = tokens.next_in_line() else { break };
            word = next;
        }
        let expected = self.least();
        if length < expected {
            let what = format!("vertex {vertex} has {length} numbers where {expected} are expected");
            return Err(tokens.source.line_error(at, what, EXPORT));
        }
        self.push(&numbers[..length], has_point);
        Ok(())
    }

    /// Reads as many numbers as a vertex has, whatever the lines are.
    pub(super) fn read_numbers(
        &mut self,
        tokens: &mut Tokens<'_>,
        vertex: u64,
        channels: usize,
    ) -> Result<(), Error> {
        let mut numbers = [0.0; 12];
        let channels = if self.header.colours { channels } else { 0 };
        let length = self.least() + channels + self.texture();
        let mut has_point = false;
        for (place, number) in numbers.iter_mut().enumerate().take(length) {
            let (at, word) = tokens.next_or(&format!("vertex {vertex}"))?;
            *number = parse(tokens, at, word)?;
            has_point |= place >= self.least() && word.contains(&b'.');
        }
        self.push(&numbers[..length], has_point);
        Ok(())
    }

    fn push(&mut self, numbers: &[f64], has_point: bool) {
        self.positions.push(Point3::new(numbers[0], numbers[1], numbers[2]));
        if self.header.normals {
            self.normals.push(Vector3::new(numbers[3], numbers[4], numbers[5]));
        }
        let rest = &numbers[self.least()..];
        if !self.header.colours {
            self.surplus += usize::from(rest.len() > self.texture());
            return;
        }
        let rest = &rest[..rest.len().saturating_sub(self.texture())];
        if self.positions.len() == 1 && matches!(rest.len(), 3 | 4) {
            let kind = if has_point { Kind::Float } else { Kind::Integer };
            let column = |_| Column { name: String::new(), kind, values: Vec::new() };
            self.channels = rest.iter().map(column).collect();
        }
        if self.channels.len() == rest.len() {
            self.channels.iter_mut().zip(rest).for_each(|(channel, &value)| channel.values.push(value));
        }
    }

    pub(super) fn finish(self, warnings: &mut Vec<String>) -> Result<PointCloud, Error> {
        let Self { header, positions, normals, channels, surplus } = self;
        if surplus > 0 {
            warnings.push(format!("not read: numbers after the coordinates in {}", counted(surplus, "row")));
        }
        if header.texture && !positions.is_empty() {
            warnings.push("not read: texture coordinates".to_owned());
        }
        let mut attributes = Attributes::default();
        if header.normals {
            attributes.set_normals(Some(normals));
        }
        if header.colours && !positions.is_empty() {
            if !channels.is_empty() && channels.iter().all(|channel| channel.values.len() == positions.len())
            {
                attributes.set_colours(colours(&channels.iter().collect::<Vec<_>>(), warnings));
            } else {
                warnings.push(
                    "the vertices have not three or four colour numbers each; colours were not read"
                        .to_owned(),
                );
            }
        }
        PointCloud::new(positions).with_attributes(attributes).map_err(Error::shape)
    }
}

fn parse(tokens: &Tokens<'_>, at: usize, word: &[u8]) -> Result<f64, Error> {
    number::parse(word)
        .ok_or_else(|| tokens.source.line_error(at, format!("{} is not a number", quoted(word)), EXPORT))
}
