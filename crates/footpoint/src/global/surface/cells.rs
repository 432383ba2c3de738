//! The grid of patches of one surface: who borders on whom, and how smoothly.

use crate::global::arithmetic::bernstein::unit;
use crate::global::surface::geometry::Geometry;
use crate::global::tree::{bounds, extent};
use nurbs_core::BsplineSurface;

/// Relative agreement of points and first derivatives that lets an iteration cross a border.
const SMOOTH: f64 = 1e-9;

/// Grid of the patches of one surface.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    first: usize,
    /// Number of cells in each direction.
    pub(crate) counts: [usize; 2],
    /// `smooth[d][i]`: whether the border below cell `i` in direction `d` can be crossed by Newton steps
    /// (index 0: the seam of a closed surface).
    smooth: [Vec<bool>; 2],
    /// Whether the surface closes up at the ends of direction `d`, smoothly or not.
    pub(crate) closed: [bool; 2],
    /// Breakpoints of the spans in each direction.
    breaks: [Vec<f64>; 2],
    /// Cells per unit of the parameter.
    density: [f64; 2],
    /// Whether the lower and upper edge of direction `d` is collapsed into a point.
    pub(crate) collapsed: [[bool; 2]; 2],
}

impl Cells {
    pub(crate) fn new(surface: &BsplineSurface, first: usize, columns: usize, set: &Geometry) -> Self {
        let rows = (set.patches.len() - first) / columns;
        let breaks = [surface.knots_u(), surface.knots_v()].map(|knots| {
            let mut breaks: Vec<f64> = knots.spans().map(|i| knots.as_slice()[i]).collect();
            breaks.push(knots.domain().end());
            breaks
        });
        let density = [0, 1].map(|d| {
            let (b, count) = (&breaks[d], [rows, columns][d]);
            count as f64 / (b[count] - b[0])
        });
        let mut cells = Self {
            density,
            first,
            counts: [rows, columns],
            smooth: [vec![false; rows], vec![false; columns]],
            closed: [false; 2],
            breaks,
            collapsed: [[false; 2]; 2],
        };
        let size = extent(&[bounds(surface.control_points())]);
        for d in 0..2 {
            for i in 0..cells.counts[d] {
                let (continuous, smooth) = cells.border(set, d, i, size);
                cells.smooth[d][i] = smooth;
                if i == 0 {
                    cells.closed[d] = continuous;
                }
            }
            for end in 0..2 {
                cells.collapsed[d][end] = cells.is_collapsed(set, d, end, size);
            }
        }
        cells
    }

    /// Index of a patch by its cell.
    pub(crate) fn patch(&self, cell: [usize; 2]) -> usize {
        self.first + cell[0] * self.counts[1] + cell[1]
    }

    /// The cell across the lower (`end` 0) or upper (`end` 1) border of `cell` in direction `d`, if smooth.
    #[inline(always)]
    pub(crate) fn across(&self, cell: [usize; 2], d: usize, end: usize) -> Option<[usize; 2]> {
        let count = self.counts[d];
        let next = if cell[d] + 1 == count { 0 } else { cell[d] + 1 };
        let border = if end == 0 { cell[d] } else { next };
        if !self.smooth[d][border] {
            return None;
        }
        let mut other = cell;
        other[d] = match (end, cell[d]) {
            (0, 0) => count - 1,
            (0, i) => i - 1,
            _ => next,
        };
        Some(other)
    }

    /// Whether `cell` lies at the given end of direction `d`.
    pub(crate) fn at_end(&self, cell: [usize; 2], d: usize, end: usize) -> bool {
        if end == 0 { cell[d] == 0 } else { cell[d] + 1 == self.counts[d] }
    }

    /// The cell that would hold the parameter if all were equally long, as they often are.
    #[inline(always)]
    fn guess(&self, d: usize, parameter: f64) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates; NaN becomes 0"
        )]
        let index = ((parameter - self.breaks[d][0]) * self.density[d]) as usize;
        index.min(self.counts[d] - 1)
    }

    /// The cell that holds the parameter, and the local parameters there.
    #[inline(always)]
    pub(crate) fn locate(&self, parameter: [f64; 2]) -> ([usize; 2], [f64; 2]) {
        let mut cell = [0; 2];
        let mut local = [0.0; 2];
        for d in 0..2 {
            let breaks = &self.breaks[d];
            let mut index = self.guess(d, parameter[d]);
            if !(breaks[index] <= parameter[d] && parameter[d] < breaks[index + 1]) {
                index = breaks.partition_point(|&b| b <= parameter[d]).clamp(1, self.counts[d]) - 1;
            }
            let (low, high) = (breaks[index], breaks[index + 1]);
            cell[d] = index;
            local[d] = unit(parameter[d], low, high);
        }
        (cell, local)
    }

    /// Whether the surface is continuous, and once differentiable, across the border below cell `i`.
    fn border(&self, set: &Geometry, d: usize, i: usize, size: f64) -> (bool, bool) {
        let (mut continuous, mut smooth) = (true, true);
        let below = (i + self.counts[d] - 1) % self.counts[d];
        for other in 0..self.counts[1 - d] {
            let mut cells = [[other; 2]; 2];
            cells[0][d] = below;
            cells[1][d] = i;
            let [a, b] = cells.map(|cell| &set.patches[self.patch(cell)]);
            let samples = 2 * a.degrees()[1 - d] + 1;
            for k in 0..=samples {
                let along = k as f64 / samples as f64;
                let mut at = [[along; 2]; 2];
                at[0][d] = 1.0;
                at[1][d] = 0.0;
                let [ja, jb] = [set.jet(a, at[0][0], at[0][1]), set.jet(b, at[1][0], at[1][1])];
                let gap = (ja.point + a.centre - jb.point - b.centre).norm();
                let [da, db] = [(a, &ja), (b, &jb)]
                    .map(|(p, j)| if d == 0 { j.du } else { j.dv } / p.intervals[d].length());
                let bend = (da - db).norm();
                continuous &= gap <= SMOOTH * size;
                smooth &= bend <= 1e-6 * (da.norm() + db.norm()) || bend == 0.0;
            }
            if !continuous {
                return (false, false);
            }
        }
        (continuous, smooth)
    }

    fn is_collapsed(&self, set: &Geometry, d: usize, end: usize, size: f64) -> bool {
        let mut reference = None;
        for other in 0..self.counts[1 - d] {
            let mut cell = [other; 2];
            cell[d] = if end == 0 { 0 } else { self.counts[d] - 1 };
            let patch = &set.patches[self.patch(cell)];
            let samples = 2 * patch.degrees()[1 - d] + 1;
            for k in 0..=samples {
                let mut at = [k as f64 / samples as f64; 2];
                at[d] = end as f64;
                let point = set.point(patch, at[0], at[1]) + patch.centre;
                let first = *reference.get_or_insert(point);
                if (point - first).norm() > SMOOTH * size {
                    return false;
                }
            }
        }
        true
    }
}
