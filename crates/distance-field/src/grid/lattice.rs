//! The nodes of a regular grid over a box.

use crate::Error;
use nalgebra::SVector;

/// Most bytes that the values of a grid may take.
const MOST_BYTES: usize = 16 << 30;

/// Nodes of a regular grid over a box, its ends included: node `i` of `n` along an axis lies at `low + i (high − low)/(n − 1)`.
///
/// Nodes are numbered with the last axis running fastest: `(i, j, k)` of `n × m × l` nodes is `(i m + j) l + k`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice<const D: usize> {
    low: SVector<f64, D>,
    high: SVector<f64, D>,
    counts: [usize; D],
}

impl<const D: usize> Lattice<D> {
    /// The nodes over the box from `low` to `high`, `counts` of them along each axis.
    ///
    /// # Errors
    /// [`Error::Grid`] for less than two nodes along an axis, a box without extent or not finite, and for grids whose values take
    /// more than 16 GiB.
    pub fn new(low: SVector<f64, D>, high: SVector<f64, D>, counts: [usize; D]) -> Result<Self, Error> {
        if let Some(axis) = counts.iter().position(|&count| count < 2) {
            let what = format!("{} nodes along axis {axis}, at least 2 are needed", counts[axis]);
            return Err(Error::Grid { what });
        }
        let is_box = (0..D).all(|k| (high[k] - low[k]).is_finite() && high[k] > low[k]);
        if !is_box {
            let what = format!("the box from {:?} to {:?} has no extent", low.as_slice(), high.as_slice());
            return Err(Error::Grid { what });
        }
        let bytes = counts.iter().try_fold(size_of::<f64>(), |bytes, &count| bytes.checked_mul(count));
        match bytes {
            Some(bytes) if bytes <= MOST_BYTES => Ok(Self { low, high, counts }),
            _ => {
                let bytes: f64 = counts.iter().map(|&count| count as f64).product::<f64>() * 8.0;
                let what =
                    format!("{counts:?} nodes take {bytes:.3e} bytes, more than the {MOST_BYTES} allowed");
                Err(Error::Grid { what })
            }
        }
    }

    /// Number of nodes along each axis.
    #[must_use]
    pub fn counts(&self) -> [usize; D] {
        self.counts
    }

    /// The first node.
    #[must_use]
    pub fn low(&self) -> SVector<f64, D> {
        self.low
    }

    /// The last node.
    #[must_use]
    pub fn high(&self) -> SVector<f64, D> {
        self.high
    }

    /// Number of nodes.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "a grid has at least two nodes along each axis")]
    pub fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// Distance of neighbouring nodes along each axis.
    #[must_use]
    pub fn spacing(&self) -> SVector<f64, D> {
        SVector::from_fn(|k, _| (self.high[k] - self.low[k]) / (self.counts[k] - 1) as f64)
    }

    /// The indices of a node along the axes.
    #[must_use]
    pub fn indices(&self, node: usize) -> [usize; D] {
        let mut rest = node;
        let mut out = [0; D];
        for k in (0..D).rev() {
            out[k] = rest % self.counts[k];
            rest /= self.counts[k];
        }
        out
    }

    /// Where a node lies. The ends are hit exactly.
    #[must_use]
    pub fn point(&self, node: usize) -> SVector<f64, D> {
        let indices = self.indices(node);
        SVector::from_fn(|k, _| {
            let last = self.counts[k] - 1;
            let share = indices[k] as f64 / last as f64;
            if indices[k] == last { self.high[k] } else { self.low[k] + share * (self.high[k] - self.low[k]) }
        })
    }

    /// How far apart neighbours along an axis are numbered.
    #[must_use]
    pub fn stride(&self, axis: usize) -> usize {
        self.counts[axis + 1..].iter().product()
    }

    /// The range of indices along each axis of the nodes in a box grown by `margin`; `None` if there are none.
    pub(super) fn range(
        &self,
        low: &SVector<f64, D>,
        high: &SVector<f64, D>,
        margin: f64,
    ) -> Option<[[usize; 2]; D]> {
        let spacing = self.spacing();
        let mut out = [[0; 2]; D];
        for k in 0..D {
            let first = ((low[k] - margin - self.low[k]) / spacing[k]).ceil().max(0.0);
            let last = ((high[k] + margin - self.low[k]) / spacing[k]).floor();
            let most = (self.counts[k] - 1) as f64;
            // Not so for NaN either.
            let is_some = first <= most && last >= 0.0 && first <= last;
            if !is_some {
                return None;
            }
            out[k] = [first, last.min(most)].map(to_index);
        }
        Some(out)
    }

    /// Calls `visit` with every node of a range of indices.
    pub(super) fn visit(&self, range: &[[usize; 2]; D], mut visit: impl FnMut(usize)) {
        let mut at = range.map(|[first, _]| first);
        loop {
            visit((0..D).map(|k| at[k] * self.stride(k)).sum());
            let Some(axis) = (0..D).rev().find(|&k| at[k] < range[k][1]) else { return };
            at[axis] += 1;
            for k in axis + 1..D {
                at[k] = range[k][0];
            }
        }
    }
}

/// A number that is a small whole one as an index.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 0 and the number of nodes along an axis"
)]
fn to_index(value: f64) -> usize {
    value as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    #[test]
    fn nodes_are_numbered_with_the_last_axis_fastest() {
        let lattice = Lattice::new(Vector3::zeros(), Vector3::new(1.0, 2.0, 3.0), [2, 3, 4]).unwrap();
        assert_eq!((lattice.len(), lattice.stride(0), lattice.stride(2)), (24, 12, 1));
        for node in 0..24 {
            let [i, j, k] = lattice.indices(node);
            assert_eq!((i * 3 + j) * 4 + k, node);
            assert_eq!(lattice.point(node), Vector3::new(i as f64, j as f64, k as f64));
        }
        let mut seen = Vec::new();
        let range = lattice.range(&Vector3::new(0.5, 0.9, 1.9), &Vector3::new(0.6, 1.1, 3.5), 0.5).unwrap();
        assert_eq!(range, [[0, 1], [1, 1], [2, 3]]);
        lattice.visit(&range, |node| seen.push(node));
        assert_eq!(seen, [6, 7, 18, 19]);
    }

    #[test]
    fn what_is_no_grid_is_refused() {
        let zero = Vector2::zeros();
        let one = Vector2::new(1.0, 1.0);
        for (low, high, counts) in [
            (zero, one, [1, 5]),
            (zero, Vector2::new(1.0, 0.0), [5, 5]),
            (zero, Vector2::new(f64::INFINITY, 1.0), [5, 5]),
            (one * f64::NAN, one, [5, 5]),
            (zero, one, [1 << 40, 1 << 40]),
        ] {
            assert!(Lattice::new(low, high, counts).is_err(), "{low} {high} {counts:?}");
        }
        let error = Lattice::new(zero, one, [1 << 20, 1 << 20]).unwrap_err().to_string();
        assert!(error.contains("8.796e12 bytes"), "{error}");
    }
}
