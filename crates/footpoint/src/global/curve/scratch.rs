//! Working memory of a search on curves, reused from query to query.

use crate::global::proof::line::Segment;
use crate::global::tree::Visit;

/// A place on the curves and its distance from the query.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurveFoot {
    pub(crate) piece: usize,
    /// Local parameter in `[0, 1]`.
    pub(crate) local: f64,
    pub(crate) distance_sq: f64,
    pub(crate) steps: u32,
    pub(crate) settled: bool,
}

impl CurveFoot {
    pub(crate) const NONE: Self =
        Self { piece: usize::MAX, local: 0.0, distance_sq: f64::INFINITY, steps: 0, settled: false };
}

/// Buffers of one search at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct CurveScratch<const K: usize> {
    pub(crate) visits: Vec<Visit>,
    pub(super) candidates: Vec<(usize, f64)>,
    pub(super) segments: Vec<Segment<K>>,
    /// Places that may be as near as the footpoint.
    pub(crate) ties: Vec<(usize, f64)>,
    /// Where the iterations from there ended, but for the footpoint.
    pub(crate) rivals: Vec<CurveFoot>,
}
