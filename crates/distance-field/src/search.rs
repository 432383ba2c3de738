//! How hard the foot of a query is looked for.

/// Where an earlier foot was, for a start nearby. Opaque to all but the field that gave it.
///
/// The default is no hint at all: whatever the [`Search`], the foot is then looked for everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hint {
    /// Index of the shape of a model, of the triangle of a mesh, or of the point of a cloud; `u32::MAX` where there is
    /// none.
    pub element: u32,
    /// Parameters on that element.
    pub parameter: [f64; 2],
    /// How far the query may move while its nearest point is known to stay on the same element; 0 where that is not known.
    pub slack: f64,
    /// Whether the element is known to be the nearest to the query that the hint is given for, see [`Hint::moved`].
    pub is_proven: bool,
}

impl Hint {
    /// No hint.
    pub const NONE: Self = Self { element: u32::MAX, parameter: [0.0; 2], slack: 0.0, is_proven: false };

    /// The place of a foot on the element of a shape.
    pub(crate) fn new(element: usize, parameter: [f64; 2]) -> Self {
        Self { element: u32::try_from(element).unwrap_or(u32::MAX), parameter, slack: 0.0, is_proven: false }
    }

    /// The hint for a query that is that far away from the one whose foot it is: where this is less than the slack, the element is
    /// still the nearest, and no other is looked at.
    #[must_use]
    pub fn moved(self, distance: f64) -> Self {
        // False for NaN, too.
        let is_proven = distance < self.slack;
        Self { slack: if is_proven { self.slack - distance } else { 0.0 }, is_proven, ..self }
    }

    /// Index of the element if there is one below `count` and the parameters are numbers.
    pub(crate) fn element_below(&self, count: usize) -> Option<usize> {
        let element = self.element as usize;
        (self.element != u32::MAX && element < count && self.parameter.iter().all(|p| p.is_finite()))
            .then_some(element)
    }
}

impl Default for Hint {
    fn default() -> Self {
        Self::NONE
    }
}

/// How the foot of a query is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Search {
    /// The nearest point of all, certified where the shape allows; hints are not used.
    #[default]
    Global,
    /// The local foot that the iteration from the hint leads to.
    Local,
    /// One step of the iteration from the hint (\[HW05, sec. 5\]): cheaper, exact in the limit of an outer iteration.
    ///
    /// The foot is a point of the shape, but the query need not lie on its normal yet; then the status is
    /// [`MaxIterations`](footpoint::Status::MaxIterations), and the distance is measured along the normal. The step is
    /// repeated where it would not bring the foot nearer.
    OneStep,
}
