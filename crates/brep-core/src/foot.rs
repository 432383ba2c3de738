//! The closest point of a model.

use nalgebra::Vector3;

/// What a foot lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum On {
    /// Inside a face, at parameters of its carrier.
    Face {
        /// Index of the face.
        face: usize,
        /// Parameters.
        uv: [f64; 2],
    },
    /// On an edge, at a parameter of its curve.
    Edge {
        /// Index of the edge.
        edge: usize,
        /// Parameter.
        t: f64,
    },
    /// At an end of an edge.
    Vertex {
        /// Index of the edge.
        edge: usize,
        /// Its start (0) or its end (1).
        end: usize,
    },
    /// At a vertex that is a loop of its own, or at the apex of a cone.
    Apex {
        /// Index of the face.
        face: usize,
    },
}

/// On which side of the surface a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// On the side of the normal: outside of the material.
    Positive,
    /// On the other side.
    Negative,
    /// Not decided: where more than two faces meet in an edge, where normals cancel, where the point lies in the tangent
    /// plane of the boundary of an open shell, or on the surface itself.
    Undecided,
}

/// The closest point of a part or a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Index of the instance (0 for a part alone).
    pub instance: usize,
    /// Index of a face that holds the foot; `None` on a curve that bounds no face.
    pub face: Option<usize>,
    /// What the foot lies on.
    pub on: On,
    /// The foot, a point of the model.
    pub point: Vector3<f64>,
    /// Distance from the foot.
    pub distance: f64,
    /// No point of the model is nearer than this.
    pub lower_bound: f64,
    /// The side of the surface.
    pub side: Side,
    /// Unit normal at the foot, that of the face or the mean of those at an edge; zero where there is none.
    pub normal: Vector3<f64>,
    /// The foot lies on the boundary of an open shell.
    pub beyond_boundary: bool,
}

impl Foot {
    /// How much nearer another point could be at most.
    #[must_use]
    pub fn gap(&self) -> f64 {
        self.distance - self.lower_bound
    }

    /// The distance, negative on the inner side; `None` when the side is not decided and the distance is not 0.
    #[must_use]
    pub fn signed_distance(&self) -> Option<f64> {
        match self.side {
            Side::Positive => Some(self.distance),
            Side::Negative => Some(-self.distance),
            Side::Undecided => (self.distance == 0.0).then_some(0.0),
        }
    }
}
