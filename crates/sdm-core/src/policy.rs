//! How footpoints are found in an iteration.

use distance_field::Search;

/// How footpoints are found after the first time, which is always a global search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum FootpointPolicy {
    /// From the last footpoints while the shape moves little, by a global search otherwise.
    #[default]
    Adaptive,
    /// The nearest point of all, each time.
    Global,
    /// The iteration from the last footpoint until it converges: points stay on the branch on which they are.
    Local,
    /// One step of the iteration from the last footpoint (\[HW05, sec. 5\]).
    OneStep,
}

impl FootpointPolicy {
    /// The search for a state that is near the last one, or not.
    #[must_use]
    pub fn search(self, is_near: bool) -> Search {
        match self {
            Self::Global => Search::Global,
            Self::Local => Search::Local,
            Self::OneStep => Search::OneStep,
            Self::Adaptive if is_near => Search::Local,
            Self::Adaptive => Search::Global,
        }
    }
}
