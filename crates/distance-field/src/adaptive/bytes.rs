//! An adaptively sampled distance field as bytes, to be kept in a file.

use super::tree::LEAF;
use super::{AdaptiveField, polynomial};
use crate::Error;
use nalgebra::SVector;
use nurbs_core::Aabb;

/// The first bytes: what this is, and the version of the form.
const MAGIC: &[u8; 8] = b"IGADF\0\0\x01";

impl<const D: usize> AdaptiveField<D> {
    /// The field as bytes: magic, dimension and degree, box, box of the zero set, tolerance, number of cells and of coefficients,
    /// then children, leaves and coefficients; little endian, numbers of eight bytes but for the cells (four).
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(128 + 8 * (self.children.len() + self.coefficients.len()));
        out.extend_from_slice(MAGIC);
        let mut whole = |value: usize| out.extend_from_slice(&(value as u64).to_le_bytes());
        [D, self.degree, self.children.len(), self.coefficients.len()].into_iter().for_each(&mut whole);
        let ends = [&self.low, &self.high, &self.bounds.min, &self.bounds.max];
        for value in ends.iter().flat_map(|end| end.iter()).chain([&self.abs_tolerance]) {
            out.extend_from_slice(&value.to_le_bytes());
        }
        for value in self.children.iter().chain(&self.leaf) {
            out.extend_from_slice(&value.to_le_bytes());
        }
        for value in &self.coefficients {
            out.extend_from_slice(&value.to_le_bytes());
        }
        out
    }

    /// The field that [`AdaptiveField::to_bytes`] has written.
    ///
    /// # Errors
    /// [`Error::Grid`] for anything else: it says at which byte.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader { bytes, at: 0 };
        if reader.take(8)? != MAGIC {
            return Err(refused(0, "this is no adaptively sampled distance field of version 1"));
        }
        let [dimension, degree, cells, count] =
            [reader.whole()?, reader.whole()?, reader.whole()?, reader.whole()?];
        if dimension != D as u64 {
            return Err(refused(8, &format!("the field has dimension {dimension}, not {D}")));
        }
        if !(1..=polynomial::MOST as u64).contains(&degree) || cells == 0 {
            return Err(refused(16, &format!("degree {degree} with {cells} cells")));
        }
        let degree = usize::try_from(degree).unwrap_or(polynomial::MOST);
        // What is announced must be there before anything is allocated.
        let needed = 8 * (4 * D as u128 + 1) + 8 * u128::from(cells) + 8 * u128::from(count);
        let left = bytes.len() - reader.at;
        if needed != left as u128 {
            return Err(refused(reader.at, &format!("{needed} bytes are announced, {left} follow")));
        }
        let mut corner = || -> Result<SVector<f64, D>, Error> {
            let mut out = SVector::<f64, D>::zeros();
            for value in out.iter_mut() {
                *value = reader.number()?;
            }
            Ok(out)
        };
        let [low, high, min, max] = [corner()?, corner()?, corner()?, corner()?];
        let abs_tolerance = reader.number()?;
        if (0..D).any(|k| high[k] <= low[k] || max[k] < min[k]) || abs_tolerance <= 0.0 {
            return Err(refused(40, "a box has no extent, or the tolerance is not positive"));
        }
        let from = reader.at;
        let children = reader.cells(cells)?;
        let leaf = reader.cells(cells)?;
        let per_leaf = polynomial::count::<D>(degree) as u64;
        for (cell, (&first, &number)) in children.iter().zip(&leaf).enumerate() {
            // Children come after their parent: no way down the tree is a circle.
            let is_inner = first as usize > cell && u64::from(first) + (1 << D) <= cells;
            let is_leaf = first == LEAF && (u64::from(number) + 1) * per_leaf <= count;
            if !is_inner && !is_leaf {
                return Err(refused(from + 4 * cell, &format!("cell {cell} (from 0) refers to nothing")));
            }
        }
        let mut coefficients = Vec::with_capacity(usize::try_from(count).unwrap_or(0));
        for _ in 0..count {
            coefficients.push(reader.number()?);
        }
        let bounds = Aabb { min, max };
        Ok(Self { low, high, degree, abs_tolerance, children, leaf, coefficients, bounds })
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let out = self.bytes.get(self.at..).and_then(|rest| rest.get(..count));
        let out = out.ok_or_else(|| refused(self.at, "the file ends too early"))?;
        self.at += count;
        Ok(out)
    }

    fn whole(&mut self) -> Result<u64, Error> {
        let mut eight = [0; 8];
        eight.copy_from_slice(self.take(8)?);
        Ok(u64::from_le_bytes(eight))
    }

    fn number(&mut self) -> Result<f64, Error> {
        let at = self.at;
        let value = f64::from_bits(self.whole()?);
        if value.is_finite() { Ok(value) } else { Err(refused(at, &format!("{value} is no finite number"))) }
    }

    fn cells(&mut self, count: u64) -> Result<Vec<u32>, Error> {
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        let four = |part: &[u8]| {
            let mut four = [0; 4];
            four.copy_from_slice(part);
            u32::from_le_bytes(four)
        };
        Ok(self.take(count.saturating_mul(4))?.chunks_exact(4).map(four).collect())
    }
}

fn refused(byte: usize, what: &str) -> Error {
    Error::Grid { what: format!("byte {byte}: {what}") }
}
