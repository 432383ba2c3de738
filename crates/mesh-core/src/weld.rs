//! Merging points at exactly the same position.

use std::hash::{BuildHasher, RandomState};

use nalgebra::Point3;

use crate::Error;

/// Numbers different positions in the order in which they first come, and equal positions equally.
///
/// Zeros of either sign are equal, and so is a NaN to the same NaN.
///
/// ```
/// use mesh_core::{VertexWelder, nalgebra::Point3};
///
/// let mut welder = VertexWelder::default();
/// assert_eq!(welder.insert(Point3::new(0.0, 0.0, 1.0))?, 0);
/// assert_eq!(welder.insert(Point3::new(0.0, 2.0, 1.0))?, 1);
/// assert_eq!(welder.insert(Point3::new(-0.0, 0.0, 1.0))?, 0);
/// assert_eq!(welder.into_vertices().len(), 2);
/// # Ok::<(), mesh_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct VertexWelder {
    vertices: Vec<Point3<f64>>,
    /// Open addressing with linear probing: a vertex number, or [`FREE`]. The length is a power of two.
    slots: Vec<u32>,
    /// Secret of this table, so that no file can be made in which all positions collide.
    seed: u64,
}

const FREE: u32 = u32::MAX;

impl Default for VertexWelder {
    fn default() -> Self {
        Self::with_capacity(0)
    }
}

impl VertexWelder {
    /// A welder with room for that many different positions.
    #[must_use]
    pub fn with_capacity(vertices: usize) -> Self {
        let slots = vertices.saturating_mul(2).max(16).next_power_of_two();
        Self {
            vertices: Vec::with_capacity(vertices),
            slots: vec![FREE; slots],
            seed: RandomState::new().hash_one(0),
        }
    }

    /// The number of a position.
    ///
    /// # Errors
    /// [`Error::TooMany`] beyond 32-bit indices.
    pub fn insert(&mut self, point: Point3<f64>) -> Result<u32, Error> {
        let wanted = key(&point);
        let mask = self.slots.len() - 1;
        let mut place = hash(&wanted, self.seed) & mask;
        loop {
            match self.slots[place] {
                FREE => break,
                number if key(&self.vertices[number as usize]) == wanted => return Ok(number),
                _ => place = (place + 1) & mask,
            }
        }
        let count = self.vertices.len();
        let number = u32::try_from(count).ok().filter(|&number| number != FREE);
        let number = number.ok_or(Error::TooMany { what: "vertices", count })?;
        self.slots[place] = number;
        self.vertices.push(point);
        if 2 * self.vertices.len() > self.slots.len() {
            self.grow();
        }
        Ok(number)
    }

    /// The different positions in the order of their numbers.
    #[must_use]
    pub fn into_vertices(self) -> Vec<Point3<f64>> {
        self.vertices
    }

    fn grow(&mut self) {
        self.slots = vec![FREE; 2 * self.slots.len()];
        let mask = self.slots.len() - 1;
        for (vertex, number) in self.vertices.iter().zip(0u32..) {
            let mut place = hash(&key(vertex), self.seed) & mask;
            while self.slots[place] != FREE {
                place = (place + 1) & mask;
            }
            self.slots[place] = number;
        }
    }
}

fn key(point: &Point3<f64>) -> [u64; 3] {
    [point.x, point.y, point.z].map(|value| (value + 0.0).to_bits())
}

#[expect(clippy::cast_possible_truncation, reason = "the table takes the lower bits anyway")]
fn hash(key: &[u64; 3], seed: u64) -> usize {
    let mixed = key.iter().fold(seed, |hash, &bits| {
        let product = u128::from(hash ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835);
        (product as u64) ^ ((product >> 64) as u64)
    });
    mixed as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_a_grid_twice() {
        let grid = || {
            (0..20_000).map(|i| Point3::new(f64::from(i % 20), f64::from(i / 20 % 50), f64::from(i / 1000)))
        };
        let mut welder = VertexWelder::default();
        for (point, number) in grid().zip(0u32..).chain(grid().zip(0u32..)) {
            assert_eq!(welder.insert(point), Ok(number));
        }
        assert_eq!(welder.into_vertices(), grid().collect::<Vec<_>>());
    }

    #[test]
    fn equal_bits_of_nan_are_equal() {
        let mut welder = VertexWelder::with_capacity(2);
        let nan = Point3::new(f64::NAN, 0.0, 0.0);
        assert_eq!((welder.insert(nan), welder.insert(nan)), (Ok(0), Ok(0)));
    }
}
