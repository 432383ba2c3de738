//! Parts: faces with their shared edges, ready for queries.

use crate::Error;
use crate::description::PartDescription;
use crate::edge::Edge;
use crate::face::Face;
use crate::parallel;
use crate::tree::Tree;
use nalgebra::Vector3;
use nurbs_core::Aabb;

/// A part in its own coordinates.
#[derive(Clone, Debug)]
pub struct Part {
    pub(crate) name: String,
    pub(crate) source: u64,
    pub(crate) faces: Vec<Face>,
    pub(crate) edges: Vec<Edge>,
    /// Points of the vertices, those of the file first.
    pub(crate) vertices: Vec<Vector3<f64>>,
    /// Edges that end at each vertex.
    pub(crate) stars: Vec<Vec<usize>>,
    pub(crate) shells: Vec<Shell>,
    pub(crate) tree: Tree,
    /// What the boxes of the tree hold.
    pub(crate) items: Vec<Item>,
    /// Diagonal of the box of the part.
    pub(crate) size: f64,
    /// Index of the first edge that is a curve of its own.
    pub(crate) first_free: usize,
}

/// Faces that hang together.
#[derive(Clone, Debug)]
pub struct Shell {
    pub(crate) name: String,
    pub(crate) source: u64,
    pub(crate) closed: bool,
}

/// An item of the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Item {
    Face(usize),
    Edge(usize),
    /// The point of a loop that is a single vertex: face and index of the point.
    Point(usize, usize),
}

impl Part {
    /// Builds a part. The faces that cannot be used are left out, with what is wrong.
    ///
    /// # Errors
    /// [`Error::Description`] when a shell or a loop names something that does not exist.
    pub(crate) fn new(description: &PartDescription) -> Result<(Self, Vec<(u64, Error)>), Error> {
        let mut vertices: Vec<_> = description.vertices.iter().map(|v| v.point).collect();
        let mut left_out = Vec::new();
        let mut edges: Vec<Edge> = Vec::new();
        let mut places: Vec<Option<usize>> = Vec::new();
        let add = |curve: &crate::description::EdgeCurve,
                   range: [f64; 2],
                   source: u64,
                   ends: [Option<usize>; 2],
                   vertices: &mut Vec<Vector3<f64>>| {
            let closed = ends[0].is_some() && ends[0] == ends[1];
            let mut own = [0; 2];
            for i in 0..2 {
                own[i] = match ends[i] {
                    Some(index) if index < vertices.len() => index,
                    Some(_) => return Err(Error::of(format!("edge #{source}"), "its vertex does not exist")),
                    None if i == 1 && closed => own[0],
                    None => {
                        vertices.push(curve.point(range[i]));
                        vertices.len() - 1
                    }
                };
            }
            Edge::new(curve.clone(), range, source, own)
        };
        for edge in &description.edges {
            match add(&edge.curve, edge.range, edge.source, [edge.start, edge.end], &mut vertices) {
                Ok(edge) => {
                    places.push(Some(edges.len()));
                    edges.push(edge);
                }
                Err(error) => {
                    left_out.push((edge.source, error));
                    places.push(None);
                }
            }
        }
        let first_free = edges.len();
        for curve in &description.curves {
            match add(&curve.curve, curve.range, curve.source, [None, None], &mut vertices) {
                Ok(edge) => edges.push(edge),
                Err(error) => left_out.push((curve.source, error)),
            }
        }
        let corners = edges.iter().flat_map(|e| [e.bounds.min, e.bounds.max]).collect::<Vec<_>>();
        let mut size = Aabb::of_points(&corners).map_or(0.0, |b| b.diagonal());
        for face in &description.faces {
            if let crate::description::Carrier::Nurbs(surface) = &face.carrier
                && face.loops.is_empty()
            {
                size = size.max(surface.control_box().diagonal());
            }
        }
        let mut part = Self {
            name: description.name.clone(),
            source: description.source,
            faces: Vec::new(),
            stars: vec![Vec::new(); vertices.len()],
            vertices,
            edges,
            shells: Vec::new(),
            tree: Tree::default(),
            items: Vec::new(),
            size,
            first_free,
        };
        for (index, edge) in part.edges.iter().enumerate() {
            let [a, b] = edge.vertices;
            part.stars[a].push(index);
            if b != a {
                part.stars[b].push(index);
            }
        }
        part.add_faces(description, &places, &mut left_out)?;
        part.plant();
        Ok((part, left_out))
    }

    fn add_faces(
        &mut self,
        description: &PartDescription,
        places: &[Option<usize>],
        left_out: &mut Vec<(u64, Error)>,
    ) -> Result<(), Error> {
        for shell in &description.shells {
            let index = self.shells.len();
            let mut closed = shell.closed;
            let faces: Vec<_> = shell
                .faces
                .iter()
                .map(|&face| {
                    description.faces.get(face).ok_or_else(|| {
                        Error::of(
                            format!("shell #{}", shell.source),
                            format!("its face {face} does not exist"),
                        )
                    })
                })
                .collect::<Result<_, _>>()?;
            let built: Vec<_> = parallel::map(&faces, |face| self.face(face, places, index));
            for (face, built) in faces.iter().zip(built) {
                match built {
                    Ok(built) => self.adopt(built),
                    Err(error) => {
                        left_out.push((face.source, error));
                        // With a face missing it bounds nothing.
                        closed = false;
                    }
                }
            }
            self.shells.push(Shell { name: shell.name.clone(), source: shell.source, closed });
        }
        Ok(())
    }

    fn face(
        &self,
        face: &crate::description::FaceDescription,
        places: &[Option<usize>],
        shell: usize,
    ) -> Result<Face, Error> {
        let mut face = face.clone();
        for entry in &mut face.loops {
            let crate::description::LoopDescription::Edges(uses) = entry else { continue };
            for u in uses {
                u.edge = places.get(u.edge).copied().flatten().ok_or_else(|| {
                    Error::of(format!("face #{}", face.source), "an edge of its boundary cannot be used")
                })?;
            }
        }
        Face::new(&face, &self.edges, &self.vertices, self.size, shell)
    }

    fn adopt(&mut self, face: Face) {
        let index = self.faces.len();
        for (i, u) in face.boundary.uses.iter().enumerate() {
            let edge = &mut self.edges[u.edge];
            edge.uses.push([index, i]);
            edge.tolerance = edge.tolerance.max(u.tolerance);
        }
        self.faces.push(face);
    }

    fn plant(&mut self) {
        let mut boxes = Vec::new();
        for (i, face) in self.faces.iter().enumerate() {
            self.items.push(Item::Face(i));
            boxes.push(face.bounds);
            for (k, point) in face.points.iter().enumerate() {
                self.items.push(Item::Point(i, k));
                boxes.push(Aabb::of_point(*point));
            }
        }
        for (i, edge) in self.edges.iter().enumerate() {
            // Edges of faces that are left out belong to nothing.
            if edge.uses.is_empty() && i < self.first_free {
                continue;
            }
            self.items.push(Item::Edge(i));
            boxes.push(edge.bounds.inflated(1e-12 * self.size));
        }
        self.tree = Tree::new(&boxes);
        self.size = self.tree.bounds().map_or(self.size, |b| b.diagonal());
    }

    /// Name; may be empty.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of the entity in the file.
    #[must_use]
    pub fn source(&self) -> u64 {
        self.source
    }

    /// Faces.
    #[must_use]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Edges, and curves that bound no face.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Shells.
    #[must_use]
    pub fn shells(&self) -> &[Shell] {
        &self.shells
    }

    /// The box of the part.
    #[must_use]
    pub fn bounds(&self) -> Option<Aabb<3>> {
        self.tree.bounds()
    }
}

impl Shell {
    /// Name; may be empty.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of the entity in the file.
    #[must_use]
    pub fn source(&self) -> u64 {
        self.source
    }

    /// Whether the shell bounds a volume.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.closed
    }
}
