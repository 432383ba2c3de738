//! How hard the foot of a query is looked for.

/// Where an earlier foot was, for a start nearby. Opaque to all but the field that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Hint {
    /// Index of the shape of a model, of the triangle of a mesh, or of the point of a cloud; `u32::MAX` where there is
    /// none.
    pub element: u32,
    /// Parameters on that element.
    pub parameter: [f64; 2],
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
    OneStep,
}
