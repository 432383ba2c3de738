//! Values of a function at the nodes of a regular grid.

use crate::Error;
use nalgebra::SVector;

/// Least number of nodes in each direction: a cubic needs four.
pub(super) const LEAST: usize = 4;

/// Values at the nodes `origin + (i · spacing₀, j · spacing₁, …)` of a regular grid in the plane or in space.
///
/// Values are stored with the last index running fastest: node `(i, j)` of `m × n` nodes is value `i n + j`.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<const D: usize> {
    origin: SVector<f64, D>,
    spacing: SVector<f64, D>,
    counts: [usize; D],
    values: Vec<f64>,
}

impl<const D: usize> Grid<D> {
    /// A grid with given values.
    ///
    /// # Errors
    /// [`Error::Grid`] when there are less than four nodes in a direction, when the number of values is not the product of
    /// the counts, when a spacing is not positive, or when a number is not finite.
    pub fn new(
        origin: SVector<f64, D>,
        spacing: SVector<f64, D>,
        counts: [usize; D],
        values: Vec<f64>,
    ) -> Result<Self, Error> {
        let nodes = counts.iter().try_fold(1usize, |product, &count| product.checked_mul(count));
        if let Some(direction) = counts.iter().position(|&count| count < LEAST) {
            let what = format!("{} nodes in direction {direction}, {LEAST} are needed", counts[direction]);
            return Err(Error::Grid { what });
        }
        if nodes != Some(values.len()) {
            return Err(Error::Grid { what: format!("{} values for {counts:?} nodes", values.len()) });
        }
        let sizes = spacing.iter().all(|h| h.is_finite() && *h > 0.0);
        if !sizes || !origin.iter().all(|c| c.is_finite()) {
            let what = format!("origin {:?} and spacing {:?}", origin.as_slice(), spacing.as_slice());
            return Err(Error::Grid { what: what + " must be finite, and the spacing positive" });
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(Error::Grid {
                what: format!("value {index} is {}, not a finite number", values[index]),
            });
        }
        Ok(Self { origin, spacing, counts, values })
    }

    /// The values of a function.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn sample(
        origin: SVector<f64, D>,
        spacing: SVector<f64, D>,
        counts: [usize; D],
        function: impl Fn(&SVector<f64, D>) -> f64,
    ) -> Result<Self, Error> {
        let nodes = counts.iter().try_fold(1usize, |product, &count| product.checked_mul(count)).unwrap_or(0);
        let at = |node: usize| origin + spacing.component_mul(&coordinates(node, &counts));
        let values = (0..nodes).map(|node| function(&at(node))).collect();
        Self::new(origin, spacing, counts, values)
    }

    /// The first node.
    #[must_use]
    pub fn origin(&self) -> &SVector<f64, D> {
        &self.origin
    }

    /// The distance of neighbouring nodes in each direction.
    #[must_use]
    pub fn spacing(&self) -> &SVector<f64, D> {
        &self.spacing
    }

    /// Number of nodes in each direction.
    #[must_use]
    pub fn counts(&self) -> [usize; D] {
        self.counts
    }

    /// The values, the last index running fastest.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The values by value, in the order of [`Grid::values`].
    #[must_use]
    pub fn into_values(self) -> Vec<f64> {
        self.values
    }

    /// Where a node lies.
    #[must_use]
    pub fn position(&self, node: usize) -> SVector<f64, D> {
        self.point(&self.node(node))
    }

    /// The same grid with other values.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn with_values(&self, values: Vec<f64>) -> Result<Self, Error> {
        Self::new(self.origin, self.spacing, self.counts, values)
    }

    /// Where a node is, in units of the spacing from the origin.
    pub(crate) fn node(&self, node: usize) -> SVector<f64, D> {
        coordinates(node, &self.counts)
    }

    /// How far apart in `values` neighbours in a direction are.
    pub(crate) fn stride(&self, direction: usize) -> usize {
        self.counts[direction + 1..].iter().product()
    }

    /// The point at a place in units of the spacing.
    pub(crate) fn point(&self, place: &SVector<f64, D>) -> SVector<f64, D> {
        self.origin + self.spacing.component_mul(place)
    }

    /// The place of a point in units of the spacing.
    pub(crate) fn place(&self, point: &SVector<f64, D>) -> SVector<f64, D> {
        (point - self.origin).component_div(&self.spacing)
    }
}

/// The indices of a node as numbers.
fn coordinates<const D: usize>(node: usize, counts: &[usize; D]) -> SVector<f64, D> {
    let mut rest = node;
    let mut out = SVector::zeros();
    for d in (0..D).rev() {
        out[d] = (rest % counts[d]) as f64;
        rest /= counts[d];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn nodes_and_values_agree() {
        let grid =
            Grid::sample(Vector2::new(1.0, -2.0), Vector2::new(0.5, 0.25), [4, 5], |p| p.x + 10.0 * p.y)
                .unwrap();
        assert_eq!(grid.stride(0), 5);
        for node in 0..20 {
            let point = grid.point(&grid.node(node));
            assert_eq!(grid.values()[node], point.x + 10.0 * point.y);
            assert_eq!(grid.place(&point), grid.node(node));
        }
    }

    #[test]
    fn bad_grids_are_refused() {
        let unit = Vector2::repeat(1.0);
        let message =
            |spacing, counts, values| Grid::new(unit, spacing, counts, values).unwrap_err().to_string();
        assert!(message(unit, [3, 4], vec![0.0; 12]).contains("3 nodes in direction 0"));
        assert!(message(unit, [4, 4], vec![0.0; 15]).contains("15 values"));
        assert!(message(-unit, [4, 4], vec![0.0; 16]).contains("spacing"));
        let mut values = vec![0.0; 16];
        values[7] = f64::NAN;
        assert!(message(unit, [4, 4], values).contains("value 7"));
        assert!(message(unit, [usize::MAX, 4], Vec::new()).contains("0 values"));
    }
}
