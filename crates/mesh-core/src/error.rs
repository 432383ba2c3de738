//! What can be wrong with discrete shapes.

/// Why a shape cannot be built or a query cannot be answered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A per-point attribute has another length than the positions.
    ///
    /// ```
    /// use mesh_core::{Error, PointCloud, nalgebra::{Point3, Vector3}};
    ///
    /// let cloud = PointCloud::new(vec![Point3::origin(); 2]);
    /// let error = cloud.with_normals(vec![Vector3::z()]).unwrap_err();
    /// assert!(matches!(error, Error::AttributeLength { found: 1, expected: 2, .. }));
    /// ```
    #[error("{name} has {found} values for {expected} points")]
    AttributeLength {
        /// Which attribute: `normals`, `colours` or the name of the scalar.
        name: String,
        /// Number of values given.
        found: usize,
        /// Number of points.
        expected: usize,
    },
    /// A subdivision surface has no limit that could be evaluated.
    #[error("subdivision surface: {what}")]
    Subdivision {
        /// What is wrong with the control mesh.
        what: &'static str,
    },
    /// Two scalars have the same name.
    #[error("there is already a scalar named {name:?}")]
    DuplicateScalar {
        /// The name used twice.
        name: String,
    },
    /// A point of a two-dimensional cloud does not lie in the plane z = 0.
    #[error("point {index} of a two-dimensional cloud has z = {z}; its z must be 0")]
    NotPlanar {
        /// Index of the point.
        index: usize,
        /// Its third coordinate.
        z: f64,
    },
    /// A point is asked for that does not exist.
    #[error("there is no point {index}: there are {points} points (0-based)")]
    PointIndex {
        /// The index asked for.
        index: u32,
        /// Number of points.
        points: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    ///
    /// ```
    /// use mesh_core::{Error, TriangleMesh, nalgebra::Point3};
    ///
    /// let error = TriangleMesh::new(vec![Point3::origin(); 3], vec![[0, 1, 3]]).unwrap_err();
    /// assert_eq!(error, Error::VertexIndex { triangle: 0, corner: 2, index: 3, vertices: 3 });
    /// ```
    #[error(
        "corner {corner} of triangle {triangle} refers to vertex {index}, but there are {vertices} vertices (0-based)"
    )]
    VertexIndex {
        /// Index of the triangle.
        triangle: usize,
        /// Corner of the triangle: 0, 1 or 2.
        corner: usize,
        /// The vertex it asks for.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// More vertices or triangles than a 32-bit index can tell apart.
    #[error("{count} {what} are too many for 32-bit indices")]
    TooMany {
        /// `vertices`, `triangles` or `points`.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// Fewer of something than the method needs.
    #[error("{count} {what} are too few: at least {least} are needed")]
    TooFew {
        /// What is counted, such as `neighbours`.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many are needed.
        least: usize,
    },
    /// A vertex of a curve is not finite.
    #[error("vertex {index} has a coordinate that is NaN or infinite")]
    NonFiniteVertex {
        /// Index of the vertex.
        index: usize,
    },
    /// A size or number that must be positive, and not too small for the extent of the points, is not.
    #[error("{what} is {value}, but must be positive, finite and not below {least}")]
    OutOfRange {
        /// Which number, such as `voxel size`.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The least value that is possible.
        least: f64,
    },
    /// Points cannot be spread over a mesh without area.
    #[error("the mesh has no area ({triangles} triangles)")]
    NoArea {
        /// Number of triangles.
        triangles: usize,
    },
    /// A mesh without any triangle of finite coordinates has no closest point.
    #[error("the mesh has no triangle with finite coordinates ({triangles} triangles in all)")]
    NoTriangles {
        /// Number of triangles, all of them unusable.
        triangles: usize,
    },
    /// The point to project has a coordinate that is NaN or infinite.
    #[error("the point to project has the coordinates ({x}, {y}, {z}), which are not finite")]
    NonFinitePoint {
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
        /// Third coordinate.
        z: f64,
    },
    /// A query has a coordinate that is NaN or infinite, or lies so far away that its squared distance overflows.
    #[error("the query {x:?} is not finite, or so far away that its squared distance overflows")]
    NonFiniteQuery {
        /// Its coordinates.
        x: Vec<f64>,
    },
    /// The squared distance from the point to the mesh overflows a double.
    #[error("the point ({x}, {y}, {z}) is too far from the mesh: its squared distance overflows")]
    DistanceOverflow {
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
        /// Third coordinate.
        z: f64,
    },
}
