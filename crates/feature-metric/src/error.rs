//! Errors of this crate.

/// What can be wrong with the input of a distance on a surface.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] mesh_core::Error),
    /// A mesh without a triangle that has an area.
    #[error("the mesh has no triangle with different finite corners, so there is no surface to measure on")]
    NoSurface,
    /// A mesh too small or too large to compute with: squares of its lengths would underflow or overflow.
    #[error("the longest edge is {length}, but lengths must lie between 1e-70 and 1e70; scale the mesh")]
    Magnitude {
        /// Length of the longest edge.
        length: f64,
    },
    /// An option outside its range.
    #[error("option {name} is {value}, but must be {allowed}")]
    Option {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A source or target that the mesh does not have.
    #[error("vertex {vertex} is none of the {count} vertices (from 0) that belong to a triangle")]
    Vertex {
        /// Its number.
        vertex: usize,
        /// Number of vertices of the mesh.
        count: usize,
    },
    /// No source was given.
    #[error("a distance needs at least one source")]
    NoSource,
    /// A list with one entry per vertex has another length.
    #[error("{found} labels were given for {expected} vertices")]
    Labels {
        /// Number of entries.
        found: usize,
        /// Number of vertices.
        expected: usize,
    },
    /// A point or parameter that is not finite or outside the domain of the surface.
    #[error("the parameters ({u}, {v}) do not lie in the domain of the surface, [{}, {}] x [{}, {}]", .domain[0], .domain[1], .domain[2], .domain[3])]
    Parameters {
        /// First parameter.
        u: f64,
        /// Second parameter.
        v: f64,
        /// Low and high end of `u`, then of `v`.
        domain: [f64; 4],
    },
    /// The refined mesh would be too large.
    #[error(
        "the image of the mesh under normals would have more than {most} vertices; take a finer mesh or a smaller width"
    )]
    TooLarge {
        /// Most vertices.
        most: usize,
    },
    /// A mesh that is no patch with the topology of a disc.
    #[error(
        "a patch is one connected oriented manifold with one boundary and no handles, but the mesh has {parts} part(s), {boundaries} \
         boundary curve(s), Euler characteristic {euler} (1 for a disc){}",
        if *.is_manifold { "" } else { ", and edges or vertices that are not manifold" }
    )]
    NotADisc {
        /// Number of connected parts.
        parts: usize,
        /// Number of boundary curves.
        boundaries: usize,
        /// Vertices − edges + triangles.
        euler: i64,
        /// Whether the mesh is an oriented manifold.
        is_manifold: bool,
    },
    /// Corners of a square that are not four different vertices of the boundary.
    #[error(
        "the corners of a square are four different vertices of the boundary, which has {boundary}{}",
        .vertex.map_or_else(String::new, |vertex| format!("; vertex {vertex} (from 0) is none of these, or given twice"))
    )]
    Corners {
        /// Number of vertices of the boundary.
        boundary: usize,
        /// The vertex that was given.
        vertex: Option<usize>,
    },
    /// Triangles so thin that no weights of their vertices can be computed.
    #[error("the parameters cannot be computed: triangles of the mesh have no area but for rounding")]
    Unsolvable,
}
