//! How values are distributed: quantiles and histograms out of parts that can be merged.

use crate::Error;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Bits of the mantissa that tell cells apart.
const CELL_BITS: u32 = 12;
/// Bits of a double below those.
const CUT_BITS: u32 = 52 - CELL_BITS;

/// Values in order, or, when there are more than a limit, how many fall into each of many small cells.
///
/// A cell holds the doubles that agree in sign, exponent and the first 12 bits of the mantissa, so that its values
/// differ by a relative `2⁻¹²` at most, and its middle stands for them with a relative error below `1.3e-4`. Which of the
/// two forms it has, and every number in it, depends on the values and the limit alone, not on how they were split into
/// parts or in which order these were merged.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub struct Distribution {
    limit: usize,
    values: Values,
}

/// Keys are those of [`key`]: integers in the order of the doubles, so that files keep every bit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
enum Values {
    /// The keys of all values, ascending.
    Exact(Vec<i64>),
    /// Keys of cells (without the bits cut) and numbers of values, ascending.
    Cells(Vec<(i64, u64)>),
}

impl Distribution {
    /// No values yet; `limit` of them are kept as they are.
    #[must_use]
    pub fn new(limit: usize) -> Self {
        Self { limit, values: Values::Exact(Vec::new()) }
    }

    /// Adds values. NaN and infinities are ignored.
    pub fn extend(&mut self, values: impl IntoIterator<Item = f64>) {
        let mut keys: Vec<i64> = values.into_iter().filter(|value| value.is_finite()).map(key).collect();
        keys.sort_unstable();
        self.merge_values(&Values::Exact(keys));
    }

    /// Adds the values of another distribution.
    ///
    /// # Errors
    /// [`Error::DifferentOptions`] if the limits differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        if self.limit != other.limit {
            return Err(Error::DifferentOptions);
        }
        self.merge_values(&other.values);
        Ok(())
    }

    fn merge_values(&mut self, other: &Values) {
        match (&mut self.values, other) {
            (Values::Exact(keys), Values::Exact(more)) => *keys = merged(keys, more),
            (mine, other) => {
                let (cells, more) = (mine.cells(), other.cells());
                *mine = Values::Cells(merged_cells(&cells, &more));
            }
        }
        if matches!(&self.values, Values::Exact(keys) if keys.len() > self.limit) {
            self.values = Values::Cells(self.values.cells());
        }
    }

    /// Number of values.
    #[must_use]
    pub fn count(&self) -> u64 {
        match &self.values {
            Values::Exact(keys) => keys.len() as u64,
            Values::Cells(cells) => cells.iter().map(|(_, count)| count).sum(),
        }
    }

    /// Counts the values in cells from now on, as if there were more than the limit.
    pub(crate) fn count_in_cells(&mut self) {
        if self.is_exact() {
            self.values = Values::Cells(self.values.cells());
        }
    }

    /// Whether the values themselves are kept.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        matches!(self.values, Values::Exact(_))
    }

    /// The values in order, each with how often it counts; middles of cells where the values are not kept.
    pub(crate) fn weighted(&self) -> Box<dyn Iterator<Item = (f64, u64)> + '_> {
        match &self.values {
            Values::Exact(keys) => Box::new(keys.iter().map(|&key| (value(key), 1))),
            Values::Cells(cells) => Box::new(cells.iter().map(|&(cell, count)| (middle(cell), count))),
        }
    }

    /// The values below which the given shares (ascending, 0 to 1) lie, interpolated linearly at `share · (n − 1)` between
    /// neighbours in order. Empty without values.
    #[must_use]
    pub fn quantiles(&self, shares: &[f64]) -> Vec<f64> {
        let count = self.count();
        if count == 0 {
            return Vec::new();
        }
        let mut values = self.weighted();
        let mut current = values.next();
        let mut passed = 0u64;
        let mut at = |rank: u64| -> f64 {
            while let Some((_, weight)) = current
                && rank >= passed + weight
            {
                passed += weight;
                current = values.next();
            }
            current.map_or(f64::NAN, |(value, _)| value)
        };
        let places: Vec<f64> =
            shares.iter().map(|share| share.clamp(0.0, 1.0) * (count - 1) as f64).collect();
        // Ranks ascend, but the upper neighbour of one share may lie above the lower one of the next.
        let mut ranks: Vec<u64> = places.iter().flat_map(|&place| [floor(place), floor(place) + 1]).collect();
        ranks.sort_unstable();
        ranks.dedup();
        let found: BTreeMap<u64, f64> =
            ranks.into_iter().map(|rank| (rank, at(rank.min(count - 1)))).collect();
        let value_at = |rank: u64| found.get(&rank).copied().unwrap_or(f64::NAN);
        let interpolate = |place: &f64| {
            let part = place - place.floor();
            let (below, above) = (value_at(floor(*place)), value_at(floor(*place) + 1));
            if part == 0.0 { below } else { below * (1.0 - part) + above * part }
        };
        places.iter().map(interpolate).collect()
    }
}

impl Values {
    fn cells(&self) -> Vec<(i64, u64)> {
        match self {
            Self::Cells(cells) => cells.clone(),
            Self::Exact(keys) => {
                let mut cells: Vec<(i64, u64)> = Vec::new();
                for cell in keys.iter().map(|key| key >> CUT_BITS) {
                    match cells.last_mut() {
                        Some((last, count)) if *last == cell => *count += 1,
                        _ => cells.push((cell, 1)),
                    }
                }
                cells
            }
        }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ place < 2⁶⁴")]
fn floor(place: f64) -> u64 {
    place.floor() as u64
}

/// An integer that orders like the doubles; zeros of either sign are one.
fn key(value: f64) -> i64 {
    let bits = (value + 0.0).to_bits().cast_signed();
    if bits < 0 { i64::MIN.wrapping_sub(bits) } else { bits }
}

/// The double of a key.
fn value(key: i64) -> f64 {
    let bits = if key < 0 { i64::MIN.wrapping_sub(key) } else { key };
    f64::from_bits(bits.cast_unsigned())
}

/// The middle of a cell: the double halfway between its first and last key; 0 for the cell of zero itself.
fn middle(cell: i64) -> f64 {
    if cell == 0 { 0.0 } else { value((cell << CUT_BITS) | 1 << (CUT_BITS - 1)) }
}

/// Two ascending lists of cells in one, in which each cell occurs once.
fn merged_cells(a: &[(i64, u64)], b: &[(i64, u64)]) -> Vec<(i64, u64)> {
    let mut out = Vec::with_capacity(a.len().max(b.len()));
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let (left, right) = (a[i], b[j]);
        out.push(match left.0.cmp(&right.0) {
            Ordering::Less => left,
            Ordering::Greater => right,
            Ordering::Equal => (left.0, left.1 + right.1),
        });
        i += usize::from(left.0 <= right.0);
        j += usize::from(right.0 <= left.0);
    }
    out.extend_from_slice(&a[i..]);
    out.extend_from_slice(&b[j..]);
    out
}

/// Two ascending lists in one.
fn merged(a: &[i64], b: &[i64]) -> Vec<i64> {
    let mut out = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        if a[i] <= b[j] {
            out.push(a[i]);
            i += 1;
        } else {
            out.push(b[j]);
            j += 1;
        }
    }
    out.extend_from_slice(&a[i..]);
    out.extend_from_slice(&b[j..]);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_order_like_doubles_and_come_back() {
        let values = [f64::MIN, -1.5, -1e-300, -5e-324, 0.0, 5e-324, 1e-300, 1.5, f64::MAX];
        assert!(values.windows(2).all(|pair| key(pair[0]) < key(pair[1])));
        assert!(values.iter().all(|&v| value(key(v)).to_bits() == v.to_bits()));
        assert_eq!(key(-0.0), key(0.0));
    }

    #[test]
    fn quantiles_interpolate() {
        let mut values = Distribution::new(1000);
        values.extend((0..=100).rev().map(f64::from));
        assert_eq!(values.quantiles(&[0.0, 0.005, 0.25, 0.255, 1.0]), [0.0, 0.5, 25.0, 25.5, 100.0]);
        assert!(Distribution::new(5).quantiles(&[0.5]).is_empty());
        values = Distribution::new(5);
        values.extend([7.0]);
        assert_eq!(values.quantiles(&[0.0, 0.5, 1.0]), [7.0; 3]);
    }

    #[test]
    fn the_limit_itself_is_kept_and_zeros_stay_zeros() {
        let mut values = Distribution::new(3);
        values.extend([1.0, 2.0]);
        values.extend([-1.0]);
        assert!(values.is_exact());
        values.extend([0.0]);
        assert!(!values.is_exact());
        let mut zeros = Distribution::new(3);
        zeros.extend([0.0, -0.0, 0.0, 0.0, 5e-324]);
        assert_eq!((zeros.is_exact(), zeros.count()), (false, 5));
        assert_eq!(zeros.quantiles(&[0.0, 0.5, 1.0]), [0.0; 3]);
        // The neighbours of the cell of zero are none of its own.
        let mut tiny = Distribution::new(1);
        tiny.extend([-1e-300, 0.0, 1e-300]);
        let quantiles = tiny.quantiles(&[0.0, 0.5, 1.0]);
        assert!(quantiles[0] < -9e-301 && quantiles[1] == 0.0 && quantiles[2] > 9e-301, "{quantiles:?}");
    }

    #[test]
    fn cells_are_close_and_do_not_depend_on_the_parts() {
        let all: Vec<f64> = (0..5000).map(|i| (f64::from(i) * 0.7).sin() * 0.1).collect();
        let mut exact = Distribution::new(10_000);
        exact.extend(all.iter().copied());
        let mut whole = Distribution::new(700);
        whole.extend(all.iter().copied());
        assert!(!whole.is_exact() && exact.is_exact());
        for size in [1, 600, 1300, 5000] {
            let mut parts = Distribution::new(700);
            for chunk in all.rchunks(size) {
                let mut part = Distribution::new(700);
                part.extend(chunk.iter().copied());
                parts.merge(&part).unwrap();
            }
            assert_eq!(parts, whole, "{size}");
        }
        let shares = [0.01, 0.3, 0.5, 0.9];
        for (a, b) in whole.quantiles(&shares).iter().zip(exact.quantiles(&shares)) {
            assert!((a - b).abs() <= 1.3e-4 * b.abs() + 2e-4 * 0.1, "{a} {b}");
        }
        assert_eq!(whole.count(), 5000);
        assert!(whole.merge(&exact).is_err());
    }
}
