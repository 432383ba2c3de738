//! A box of the local parameter square of a patch.

/// A box of the local parameter square of a patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
    pub(crate) depth: u32,
    /// Rounding errors of its rows.
    pub(crate) noise: f64,
}

impl Region {
    pub(crate) const UNIT: Self = Self { low: [0.0; 2], high: [1.0; 2], depth: 0, noise: 0.0 };

    /// Parameters of the patch at box parameters.
    #[inline(always)]
    pub(crate) fn place(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| ((1.0 - at[d]) * self.low[d] + at[d] * self.high[d]).min(1.0))
    }

    /// The box parameters nearest to a place of the patch.
    #[inline(always)]
    pub(crate) fn local(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|d| ((place[d] - self.low[d]) / (self.high[d] - self.low[d])).clamp(0.0, 1.0))
    }

    /// Whether the lower or upper side in direction `d` is a side of the patch.
    #[inline(always)]
    pub(crate) fn at_border(&self, d: usize, end: usize) -> bool {
        if end == 0 { self.low[d] == 0.0 } else { self.high[d] == 1.0 }
    }

    /// The two parts below and above the box parameter `at` in direction `d`.
    #[inline(always)]
    pub(crate) fn split(&self, d: usize, at: f64) -> [Self; 2] {
        let mut low = Self { depth: self.depth + 1, ..*self };
        let mut high = low;
        let middle = low.low[d] + at * (low.high[d] - low.low[d]);
        low.high[d] = middle;
        high.low[d] = middle;
        [low, high]
    }
}
