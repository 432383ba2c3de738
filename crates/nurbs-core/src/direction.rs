//! The two parameter directions of a surface.

/// A parameter direction of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// The first parameter, which runs along the rows' index `i` of the control net.
    U,
    /// The second parameter, which runs along the columns' index `j` of the control net.
    V,
}

impl Direction {
    /// Both directions, `U` first.
    pub const BOTH: [Self; 2] = [Self::U, Self::V];

    /// The other direction.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::U => Self::V,
            Self::V => Self::U,
        }
    }

    /// `0` for `U`, `1` for `V`: the place in arrays such as the domain of a surface.
    #[must_use]
    pub fn index(self) -> usize {
        match self {
            Self::U => 0,
            Self::V => 1,
        }
    }
}

impl std::fmt::Display for Direction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::U => "u",
            Self::V => "v",
        })
    }
}
