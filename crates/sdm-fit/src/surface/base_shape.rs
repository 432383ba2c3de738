//! The kinds of base surfaces, and numbers of control points.

/// What a cloud is projected onto to get parameters to begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum BaseShape {
    /// The one over which the cloud is best described.
    #[default]
    Auto,
    /// The principal plane: an open patch.
    Plane,
    /// A cylinder about a bent axis: closed in u, open ends in v.
    Cylinder,
    /// A sphere: closed in u, poles at both ends of v.
    Sphere,
    /// A torus: closed in u and v.
    Torus,
}

impl std::fmt::Display for BaseShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl BaseShape {
    /// The name used in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Plane => "plane",
            Self::Cylinder => "cylinder",
            Self::Sphere => "sphere",
            Self::Torus => "torus",
        }
    }
}

/// Degrees and numbers of control points of a surface that is to be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct NetSize {
    /// Degrees in u and v; default 3, 3.
    pub degrees: [usize; 2],
    /// Control points in u and v that are not repetitions; default 12, 12.
    pub controls: [usize; 2],
}

impl Default for NetSize {
    fn default() -> Self {
        Self { degrees: [3, 3], controls: [12, 12] }
    }
}
