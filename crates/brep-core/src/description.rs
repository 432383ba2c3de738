//! What a CAD file says, as plain data.
//!
//! Readers of STEP and IGES produce a [`ModelDescription`], writers consume one. Nothing here is checked or computed:
//! indices may be wrong and curves may miss their surfaces until a model is built from it.
//!
//! Lengths are in the unit of the file ([`ModelDescription::unit`]), angles always in radians (readers convert).
//! Within a part, edges and vertices are shared: faces name them by their index in the tables of the part.

use nalgebra::{Matrix3, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface, Frame};
use std::sync::Arc;

/// A whole file: parts, where they stand, and what was not read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelDescription {
    /// Name of the model or of the file; may be empty.
    pub name: String,
    /// Unit of length of all coordinates; `None` when the file states none.
    pub unit: Option<LengthUnit>,
    /// Distance below which the file holds points to be equal, in the unit of the file.
    pub uncertainty: Option<f64>,
    /// Parts, each in coordinates of its own.
    pub parts: Vec<PartDescription>,
    /// Where the parts stand. A part without an instance does not show up in the model.
    pub instances: Vec<InstanceDescription>,
    /// Entities of the file that hold geometry and were not read.
    pub unread: Vec<Unread>,
    /// Surfaces that the file has in another form than the carriers of their faces.
    pub converted: Vec<Converted>,
    /// Tolerances and dimensions that the file states about its faces.
    pub tolerances: Vec<PmiTolerance>,
}

impl ModelDescription {
    /// Keeps only those faces for which `keep` says so; shells that lose one bound no volume any more, curves that bound
    /// no face go too.
    pub fn retain_faces(&mut self, mut keep: impl FnMut(&PartDescription, &FaceDescription) -> bool) {
        for part in &mut self.parts {
            let kept: Vec<bool> = part.faces.iter().map(|face| keep(part, face)).collect();
            part.curves.clear();
            for shell in &mut part.shells {
                let before = shell.faces.len();
                shell.faces.retain(|face| kept.get(*face).copied().unwrap_or(true));
                shell.closed &= shell.faces.len() == before;
            }
        }
    }
}

/// A unit of length.
#[derive(Clone, Debug, PartialEq)]
pub struct LengthUnit {
    /// Name as reports print it: `mm`, `m`, `inch`, …
    pub name: String,
    /// Length of one unit in metres; positive and finite.
    pub metres: f64,
}

impl LengthUnit {
    /// Millimetre.
    #[must_use]
    pub fn millimetre() -> Self {
        Self { name: "mm".to_owned(), metres: 1e-3 }
    }

    /// Metre.
    #[must_use]
    pub fn metre() -> Self {
        Self { name: "m".to_owned(), metres: 1.0 }
    }

    /// Inch, 25.4 mm.
    #[must_use]
    pub fn inch() -> Self {
        Self { name: "inch".to_owned(), metres: 0.0254 }
    }
}

/// Number of an entity in its file: `#123` of STEP, the directory entry of IGES. 0: not from a file.
pub type EntityNumber = u64;

/// Something that the file holds and the reader left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// Number of the entity.
    pub source: EntityNumber,
    /// Kind of entity, in the words of the format (`SURFACE_OF_REVOLUTION`, `type 128`).
    pub kind: String,
    /// Why it was left out.
    pub why: String,
}

/// A face on a surface that became a B-spline or another kind of carrier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Converted {
    /// Number of the face.
    pub face: EntityNumber,
    /// What the surface is in the file: `extrusion`, `revolution` or `offset`.
    pub kind: &'static str,
}

/// A tolerance or a dimension of the model (product and manufacturing information), as the file states it.
///
/// Lengths are in the unit of the file, angles in radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PmiTolerance {
    /// Number of the entity.
    pub source: EntityNumber,
    /// Kind: `position`, `surface profile`, `flatness`, …, `dimensional size`, `angular location`, …
    pub kind: String,
    /// Name in the file; of dimensions what they measure (`diameter`, `linear distance`).
    pub name: String,
    /// Size of the tolerance zone, or nominal value of the dimension; `None` when the file states none that can be read.
    pub value: Option<f64>,
    /// Least and largest allowed deviation from the nominal value of a dimension.
    pub limits: Option<[f64; 2]>,
    /// Class of a fit (`H7`) that stands for the limits; may be empty.
    pub fit: String,
    /// Letters of the datums, the primary one first; those of a common datum are joined (`A-B`).
    pub datums: Vec<String>,
    /// Modifiers (`maximum material requirement`).
    pub modifiers: Vec<String>,
    /// Numbers of the faces of which it is stated. None: of the whole part, or of what [`others`](Self::others) names.
    pub faces: Vec<EntityNumber>,
    /// Numbers of other entities (edges, points, solids) of which it is stated.
    pub others: Vec<EntityNumber>,
}

/// A part: faces with their shared edges and vertices, and free curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartDescription {
    /// Name; may be empty.
    pub name: String,
    /// Number of the entity that holds the part.
    pub source: EntityNumber,
    /// Shells. Every face belongs to exactly one.
    pub shells: Vec<ShellDescription>,
    /// Faces.
    pub faces: Vec<FaceDescription>,
    /// Edges.
    pub edges: Vec<EdgeDescription>,
    /// Vertices.
    pub vertices: Vec<VertexDescription>,
    /// Curves that bound no face.
    pub curves: Vec<FreeCurve>,
}

/// A part in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceDescription {
    /// Index of the part in [`ModelDescription::parts`].
    pub part: usize,
    /// Name of this instance; may be empty.
    pub name: String,
    /// From the coordinates of the part to those of the model.
    pub placement: Placement,
}

/// A similarity: `x ↦ scale · rotation · x + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Orthogonal matrix; a determinant of −1 is a mirror image.
    pub rotation: Matrix3<f64>,
    /// Translation, applied last.
    pub translation: Vector3<f64>,
    /// Positive factor.
    pub scale: f64,
}

impl Placement {
    /// The placement that moves nothing.
    pub const IDENTITY: Self = Self {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        translation: Vector3::new(0.0, 0.0, 0.0),
        scale: 1.0,
    };

    /// The image of a point.
    #[must_use]
    pub fn point(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * x * self.scale + self.translation
    }

    /// The point whose image is `x`.
    #[must_use]
    pub fn inverse_point(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.tr_mul(&(x - self.translation)) / self.scale
    }

    /// The image of a direction, without the scale.
    #[must_use]
    pub fn direction(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * direction
    }

    /// This placement applied after `inner`.
    #[must_use]
    pub fn after(&self, inner: &Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation: self.point(&inner.translation),
            scale: self.scale * inner.scale,
        }
    }
}

/// Faces that hang together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShellDescription {
    /// Name; may be empty.
    pub name: String,
    /// Number of the entity.
    pub source: EntityNumber,
    /// Indices of the faces in [`PartDescription::faces`].
    pub faces: Vec<usize>,
    /// The file says that the shell bounds a volume. Normals then point out of the material.
    pub closed: bool,
}

/// A piece of a surface bounded by loops.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceDescription {
    /// Name; may be empty.
    pub name: String,
    /// Number of the entity.
    pub source: EntityNumber,
    /// The surface that the face is part of.
    pub carrier: Carrier,
    /// The normal of the face is that of its carrier; otherwise it is the opposite.
    pub same_sense: bool,
    /// Boundary, in any order and orientation. None: the whole carrier, bounded by its own domain.
    pub loops: Vec<LoopDescription>,
}

/// A surface without bounds of its own (but for those of a B-spline).
///
/// Parameters and normals (`S_u × S_v`, normalised) of the analytic carriers, in the axes `x`, `y`, `z` of the frame
/// with origin `m` and `e(u) = cos u · x + sin u · y`, are those of STEP (ISO 10303-42):
#[derive(Clone, Debug, PartialEq)]
pub enum Carrier {
    /// `m + u x + v y`; normal `z`.
    Plane {
        /// Position.
        frame: Frame,
    },
    /// `m + r e(u) + v z`; normal away from the axis.
    Cylinder {
        /// Position; `z` is the axis.
        frame: Frame,
        /// Radius `r > 0`.
        radius: f64,
    },
    /// `m + (r + v tan α) e(u) + v z`; normal away from the axis on the nappe where `r + v tan α > 0`.
    Cone {
        /// Position; `z` is the axis.
        frame: Frame,
        /// Radius `r ≥ 0` in the plane `v = 0`.
        radius: f64,
        /// Angle `α` between axis and generators, `0 < |α| < π/2`; positive when the cone widens along `z`.
        half_angle: f64,
    },
    /// `m + r cos v e(u) + r sin v z`; normal outwards.
    Sphere {
        /// Position; `z` points to the pole `v = π/2`.
        frame: Frame,
        /// Radius `r > 0`.
        radius: f64,
    },
    /// `m + (R + r cos v) e(u) + r sin v z`; normal away from the middle of the tube.
    Torus {
        /// Position; `z` is the axis.
        frame: Frame,
        /// Radius `R` of the middle of the tube. `0 ≤ R < r`: the tube meets itself, and the face lies on the outer
        /// part (apple); `R < 0`: on the inner part (lemon).
        major_radius: f64,
        /// Radius `r > 0` of the tube.
        minor_radius: f64,
    },
    /// A B-spline or NURBS surface.
    Nurbs(Arc<BsplineSurface>),
}

/// A closed boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum LoopDescription {
    /// Edges, each beginning where the one before ends.
    Edges(Vec<EdgeUse>),
    /// A single point: the index of a vertex. It bounds nothing; files have it at the apex of a cone.
    Vertex(usize),
}

/// An edge as part of a loop.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeUse {
    /// Index of the edge in [`PartDescription::edges`].
    pub edge: usize,
    /// The loop runs along the edge from its start to its end.
    pub forward: bool,
    /// The edge in the parameters of a NURBS carrier, where the file has it, in the direction of the edge (not of the
    /// loop); the parameter interval is its own. The curve in space is the one that counts.
    pub pcurve: Option<Arc<BsplineCurve<2>>>,
}

/// A piece of a curve between two vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeDescription {
    /// Number of the entity.
    pub source: EntityNumber,
    /// The curve.
    pub curve: EdgeCurve,
    /// Parameters of start and end, increasing: edges run along their curve. On circles and ellipses the end may
    /// exceed `2π`, and the length is at most `2π`.
    pub range: [f64; 2],
    /// Vertex at the start; the same as the end on closed edges. `None`: the file names none.
    pub start: Option<usize>,
    /// Vertex at the end.
    pub end: Option<usize>,
}

/// A curve in space.
#[derive(Clone, Debug, PartialEq)]
pub enum EdgeCurve {
    /// `origin + t direction`.
    Line {
        /// Point at `t = 0`.
        origin: Vector3<f64>,
        /// Derivative, of any length but 0.
        direction: Vector3<f64>,
    },
    /// `m + r (cos t · x + sin t · y)`.
    Circle {
        /// Position; the circle lies in the plane of `x` and `y`.
        frame: Frame,
        /// Radius `r > 0`.
        radius: f64,
    },
    /// `m + a cos t · x + b sin t · y`.
    Ellipse {
        /// Position; the ellipse lies in the plane of `x` and `y`.
        frame: Frame,
        /// Semi-axes `a` and `b`, both positive.
        semi_axes: [f64; 2],
    },
    /// A B-spline or NURBS curve.
    Nurbs(Arc<BsplineCurve<3>>),
}

/// A vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexDescription {
    /// Number of the entity.
    pub source: EntityNumber,
    /// Position.
    pub point: Vector3<f64>,
}

/// A curve that bounds no face.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeCurve {
    /// Name; may be empty.
    pub name: String,
    /// Number of the entity.
    pub source: EntityNumber,
    /// The curve.
    pub curve: EdgeCurve,
    /// Parameters of start and end, increasing.
    pub range: [f64; 2],
}
