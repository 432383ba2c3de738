//! Values on grids as files hold them: NPY (`NumPy`) and VTI (image data of VTK).

mod npy;
mod vti;

use crate::Error;
use distance_field::Grid;
use nalgebra::SVector;

/// Sizes of values that are taken as they are.
const USUAL: std::ops::Range<f64> = 1e-60..1e60;

/// Values at the nodes of a regular grid in the plane or in space.
#[derive(Clone, Debug, PartialEq)]
pub struct GridFile {
    /// Nodes along each axis: two or three.
    pub counts: Vec<usize>,
    /// The first node and the distance of neighbouring nodes along each axis, where the file has them (VTI); NPY has none.
    pub place: Option<[Vec<f64>; 2]>,
    /// The values, the last index running fastest: `[i][j][k]` is node `i` along x, `j` along y, `k` along z.
    pub values: Vec<f64>,
}

impl GridFile {
    /// Whether bytes begin as a grid of a format that can be read.
    #[must_use]
    pub fn is_grid(bytes: &[u8]) -> bool {
        npy::is_npy(bytes) || vti::is_vti(bytes)
    }

    /// The grid that the bytes of a file hold, recognised by content.
    ///
    /// NPY: two or three axes, floating point or whole numbers, either byte order and order of axes. VTI: one piece, one array at its
    /// points (the first, or the one called `distance`), as text or appended as it is.
    ///
    /// # Errors
    /// [`Error::Malformed`] for anything else and for files that end too early, [`Error::TooLarge`], and [`Error::NotFinite`] for values
    /// that are no numbers, such as nodes that cannot be reached.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let found = Self::as_it_is(bytes)?;
        match found.values.iter().position(|value| !value.is_finite()) {
            Some(index) => Err(Error::NotFinite { index, value: found.values[index] }),
            None => Ok(found),
        }
    }

    /// The same, whatever the values are: NaN and infinite ones stay.
    ///
    /// # Errors
    /// As [`GridFile::from_bytes`], but for [`Error::NotFinite`].
    pub fn as_it_is(bytes: &[u8]) -> Result<Self, Error> {
        if npy::is_npy(bytes) {
            npy::read(bytes)
        } else if vti::is_vti(bytes) {
            vti::read(bytes)
        } else {
            Err(Error::malformed("grid", 0, "neither NPY nor VTI begins like this"))
        }
    }

    /// The level function `value − level` in the plane (`D = 2`) or in space, in another unit for values beyond 1e±60; `ends` are the first and the last node, by default as in the
    /// file, or whole numbers from 0 on.
    ///
    /// # Errors
    /// [`Error::Level`] for a level that is not between the values, [`Error::Malformed`] for another number of axes,
    /// [`Error::Field`] for ends that are no box, and for less than four nodes along an axis.
    pub fn level_function<const D: usize>(
        &self,
        level: f64,
        ends: Option<[SVector<f64, D>; 2]>,
    ) -> Result<Grid<D>, Error> {
        let counts: [usize; D] = self.counts.as_slice().try_into().map_err(|_| {
            Error::malformed("grid", 0, format!("{} axes, where {D} are needed", self.counts.len()))
        })?;
        let fold = |[low, high]: [f64; 2], value: &f64| [low.min(*value), high.max(*value)];
        let [least, most] = self.values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], fold);
        if !(least < level && level < most) {
            return Err(Error::Level { level, least, most });
        }
        let (origin, spacing) = match (ends, &self.place) {
            (Some([low, high]), _) => {
                (low, SVector::from_fn(|k, _| (high[k] - low[k]) / (counts[k].max(2) - 1) as f64))
            }
            (None, Some([origin, spacing])) => {
                (SVector::from_fn(|k, _| origin[k]), SVector::from_fn(|k, _| spacing[k]))
            }
            (None, None) => (SVector::zeros(), SVector::repeat(1.0)),
        };
        // Where squares of the values would be no numbers, their unit changes: the zero set stays what it is.
        let size = least.abs().max(most.abs());
        let unit = if USUAL.contains(&size) { 1.0 } else { size };
        let values = self.values.iter().map(|value| value / unit - level / unit).collect();
        Ok(Grid::new(origin, spacing, counts, values)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    #[test]
    fn grids_have_their_places() {
        let file = GridFile { counts: vec![4, 5], place: None, values: (0..20).map(f64::from).collect() };
        let grid = file.level_function::<2>(7.5, None).unwrap();
        assert_eq!((grid.position(6), grid.values()[6]), (Vector2::new(1.0, 1.0), -1.5));
        let ends = Some([Vector2::new(-1.0, 0.0), Vector2::new(2.0, 2.0)]);
        assert_eq!(file.level_function::<2>(7.5, ends).unwrap().position(6), Vector2::new(0.0, 0.5));
        assert!(matches!(file.level_function::<3>(7.5, None), Err(Error::Malformed { .. })));
        assert!(matches!(file.level_function::<2>(19.0, None), Err(Error::Level { .. })));
        let large =
            GridFile { values: file.values.iter().map(|value| value * 1e300).collect(), ..file.clone() };
        let function = large.level_function::<2>(7.5e300, None).unwrap();
        assert!((function.values()[7] + 0.5 / 19.0).abs() < 1e-15 && function.values()[8] > 0.0);
        let flat = Some([Vector2::zeros(), Vector2::x()]);
        assert!(matches!(file.level_function::<2>(7.5, flat), Err(Error::Field(_))));
        let place = Some([vec![1.0, 2.0, 3.0], vec![0.5; 3]]);
        let file = GridFile { counts: vec![4; 3], place, values: (0..64).map(f64::from).collect() };
        assert_eq!(file.level_function::<3>(1.5, None).unwrap().position(0), Vector3::new(1.0, 2.0, 3.0));
    }
}
