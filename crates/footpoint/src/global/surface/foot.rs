//! A place on a model of patches and its distance.

/// A place on the model and its distance from the query.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    pub(crate) patch: usize,
    /// Local parameters in `[0, 1]²`.
    pub(crate) local: [f64; 2],
    pub(crate) distance_sq: f64,
    /// Jets evaluated on the way.
    pub(crate) steps: u32,
    /// Whether the steps became negligible.
    pub(crate) settled: bool,
}

impl Foot {
    pub(crate) const NONE: Self =
        Self { patch: usize::MAX, local: [0.0; 2], distance_sq: f64::INFINITY, steps: 0, settled: false };
}
