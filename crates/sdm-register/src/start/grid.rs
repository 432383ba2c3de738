//! A grid of nearest samples: what lies near a place, in a few nanoseconds.

use nalgebra::Vector3;

use super::OrientedPoints;

/// For every cell of a grid around a shape the sample nearest to the centre of the cell.
#[derive(Debug)]
pub(crate) struct SampleGrid {
    origin: Vector3<f64>,
    per_cell: f64,
    dims: [usize; 3],
    nearest: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl SampleGrid {
    /// A grid with cells of the side `cell` that knows the samples nearer than about `reach`.
    pub(crate) fn new(samples: &OrientedPoints, cell: f64, reach: f64) -> Self {
        let Some(bounds) = samples.bounding_box() else {
            return Self { origin: Vector3::zeros(), per_cell: 1.0, dims: [0; 3], nearest: Vec::new() };
        };
        let bounds = bounds.inflated(reach + cell);
        let (origin, sides) = (bounds.min, bounds.sides());
        let dims = [0, 1, 2].map(|axis| whole(sides[axis] / cell) + 1);
        let mut grid =
            Self { origin, per_cell: 1.0 / cell, dims, nearest: vec![NONE; dims[0] * dims[1] * dims[2]] };
        let mut best = vec![f64::INFINITY; grid.nearest.len()];
        // First one sample per cell, the one nearest to its centre; then those are spread to the cells around.
        for (index, point) in (0u32..).zip(samples.points()) {
            let at = grid.cell_of(point);
            if let Some(place) = grid.place(at) {
                let distance_sq = (grid.centre(at) - point).norm_squared();
                if distance_sq < best[place] {
                    best[place] = distance_sq;
                    grid.nearest[place] = index;
                }
            }
        }
        let mut seeds: Vec<u32> = grid.nearest.iter().copied().filter(|&index| index != NONE).collect();
        seeds.sort_unstable();
        let span = whole(reach / cell).cast_signed() + 1;
        for index in seeds {
            let point = samples.points()[index as usize];
            let home = grid.cell_of(&point);
            for i in -span..=span {
                for j in -span..=span {
                    for k in -span..=span {
                        let at = [home[0] + i, home[1] + j, home[2] + k];
                        let distance_sq = (grid.centre(at) - point).norm_squared();
                        let Some(place) = grid.place(at) else { continue };
                        if distance_sq < best[place] {
                            best[place] = distance_sq;
                            grid.nearest[place] = index;
                        }
                    }
                }
            }
        }
        grid
    }

    /// Index of a sample that is nearest to `x` but for the width of a cell; `None` far from all of them.
    #[inline]
    pub(crate) fn nearest(&self, x: &Vector3<f64>) -> Option<usize> {
        let place = self.place(self.cell_of(x))?;
        let index = self.nearest[place];
        (index != NONE).then_some(index as usize)
    }

    #[inline]
    #[allow(
        clippy::cast_possible_truncation,
        reason = "far outside the grid is outside however it is rounded"
    )]
    fn cell_of(&self, x: &Vector3<f64>) -> [isize; 3] {
        let local = (x - self.origin) * self.per_cell;
        [local.x.floor() as isize, local.y.floor() as isize, local.z.floor() as isize]
    }

    fn centre(&self, at: [isize; 3]) -> Vector3<f64> {
        self.origin + Vector3::from(at.map(|i| i as f64 + 0.5)) / self.per_cell
    }

    #[inline]
    fn place(&self, at: [isize; 3]) -> Option<usize> {
        let [i, j, k] = at.map(isize::cast_unsigned);
        let [nx, ny, nz] = self.dims;
        (i < nx && j < ny && k < nz).then(|| (i * ny + j) * nz + k)
    }
}

/// A number of cells: never more than a grid can have along one side.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped before the cast")]
fn whole(value: f64) -> usize {
    value.clamp(0.0, 512.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::start::random::Random;

    #[test]
    fn finds_what_brute_force_finds_but_for_a_cell() {
        let mut random = Random::new(1);
        let mut vector = |scale: f64| Vector3::from_fn(|_, _| random.unit() * scale);
        let points: Vec<_> = (0..300).map(|_| vector(0.5)).collect();
        let queries: Vec<_> = (0..500).map(|_| vector(0.7) - Vector3::repeat(0.1)).collect();
        let samples = OrientedPoints::new(&points, &vec![Vector3::z(); 300]).unwrap();
        let (cell, reach) = (0.01, 0.05);
        let grid = SampleGrid::new(&samples, cell, reach);
        for x in queries {
            let nearest = points.iter().map(|p| (p - x).norm()).fold(f64::INFINITY, f64::min);
            match grid.nearest(&x) {
                Some(index) => assert!((points[index] - x).norm() <= nearest + 3.5 * cell),
                None => assert!(nearest > reach - cell),
            }
        }
        assert_eq!(grid.nearest(&Vector3::repeat(f64::NAN)), None);
        assert_eq!(grid.nearest(&Vector3::repeat(1e300)), None);
    }
}
