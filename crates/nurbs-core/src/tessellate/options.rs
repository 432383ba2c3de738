//! What a tessellation is to keep to.

use crate::Error;

/// Chord tolerance and limits of a tessellation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TessellationOptions {
    /// Largest distance between the shape and its chords or triangles, an absolute length.
    pub abs_tolerance: f64,
    /// Most vertices (default 4 million); more is an error, not a coarser result.
    pub max_vertices: usize,
    /// Whether vertices on closed seams and at poles are shared, so that the mesh is closed where the
    /// surface is (default). Otherwise each grid point has a vertex, with parameters of its own.
    pub weld: bool,
}

impl TessellationOptions {
    /// Options for the given chord tolerance, a length.
    #[must_use]
    pub fn new(abs_tolerance: f64) -> Self {
        Self { abs_tolerance, max_vertices: 4_000_000, weld: true }
    }

    /// Sets the most vertices.
    #[must_use]
    pub fn with_max_vertices(self, max_vertices: usize) -> Self {
        Self { max_vertices, ..self }
    }

    /// Sets whether seams and poles share vertices.
    #[must_use]
    pub fn with_weld(self, weld: bool) -> Self {
        Self { weld, ..self }
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        if self.abs_tolerance > 0.0 {
            Ok(())
        } else {
            let what = format!("the chord tolerance is {}; it must be positive", self.abs_tolerance);
            Err(Error::argument(what))
        }
    }

    pub(super) fn too_many(&self) -> Error {
        Error::argument(format!(
            "the chord tolerance {} needs more than {} vertices; allow a larger tolerance or more vertices",
            self.abs_tolerance, self.max_vertices
        ))
    }
}
