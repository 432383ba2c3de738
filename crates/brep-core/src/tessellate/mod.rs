//! Triangles that follow the faces of a model within a chord tolerance, and end at their edges.
//!
//! Edges are divided once and shared by their faces, so that neighbouring faces have the same vertices along them. A face is
//! triangulated in its parameter plane, cut open along lines where it is periodic, with the divided edges as constraints;
//! which regions of the plane belong to the face is what [`inside`](crate::boundary) says. Places inside are added until the
//! triangles are as near as was asked for.

mod edge_points;
mod face_mesh;
mod outline;
mod regions;

use crate::model::Model;
use crate::part::Part;
use crate::samples::{Picture, Sample};
use crate::{Error, parallel};
use edge_points::EdgePoints;
use face_mesh::FaceMesh;
use nalgebra::Vector3;

/// Rounds at most in which edges are divided where their chords cross.
const ROUNDS: usize = 12;

/// Triangles near the faces of a model, in the coordinates of the model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tessellation {
    /// Vertices; faces that share an edge share the vertices on it.
    pub vertices: Vec<Vector3<f64>>,
    /// Corners of the triangles, counter-clockwise seen from outside of the material.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals of the surface at the corners of each triangle.
    pub normals: Vec<[Vector3<f64>; 3]>,
    /// Instance and face of each triangle.
    pub faces: Vec<[usize; 2]>,
    /// Lines along the edges.
    pub lines: Vec<Vec<Vector3<f64>>>,
    /// The largest distance between triangles and surfaces that was found at the middles of triangles and of their sides.
    pub deviation: f64,
}

/// A part in triangles, in its own coordinates.
struct PartMesh {
    points: Vec<Vector3<f64>>,
    /// Triangles, normals and deviation of each face.
    faces: Vec<FaceMesh>,
    lines: Vec<Vec<Vector3<f64>>>,
}

impl Model {
    /// Triangles that stay within `chord`, a length, of the faces; `chord` is met where the vertices it takes are not more than
    /// some hundred thousand for a face, and what was reached is in [`Tessellation::deviation`].
    ///
    /// # Errors
    /// [`Error::Description`] if `chord` is not positive and finite, or a face cannot be triangulated.
    pub fn tessellate(&self, chord: f64) -> Result<Tessellation, Error> {
        if !(chord > 0.0 && chord.is_finite()) {
            return Err(Error::of("chord tolerance", format!("it is {chord}, it must be positive")));
        }
        let mut scales = vec![0.0_f64; self.parts().len()];
        for instance in self.instances() {
            scales[instance.part] = scales[instance.part].max(instance.placement.scale.abs());
        }
        let meshes: Result<Vec<PartMesh>, Error> = self
            .parts()
            .iter()
            .zip(&scales)
            .map(|(part, scale)| PartMesh::new(part, if *scale > 0.0 { chord / scale } else { chord }))
            .collect();
        let meshes = meshes?;
        let mut out = Tessellation::default();
        for (index, instance) in self.instances().iter().enumerate() {
            let (mesh, placement) = (&meshes[instance.part], &instance.placement);
            let first = out.vertices.len();
            let too_many = || Error::of("tessellation", "it takes more than 4e9 vertices");
            let number = |id: usize| u32::try_from(first + id).map_err(|_| too_many());
            out.vertices.extend(mesh.points.iter().map(|x| placement.point(x)));
            for (face, found) in mesh.faces.iter().enumerate() {
                for (corners, normals) in found.triangles.iter().zip(&found.normals) {
                    let [a, b, c] = *corners;
                    out.triangles.push([number(a)?, number(b)?, number(c)?]);
                    out.normals.push(normals.map(|n| placement.direction(&n)));
                    out.faces.push([index, face]);
                }
                out.deviation = out.deviation.max(found.deviation * placement.scale.abs());
            }
            out.lines.extend(mesh.lines.iter().map(|line| line.iter().map(|x| placement.point(x)).collect()));
        }
        out.keep_used();
        Ok(out)
    }

    /// Triangles and lines that show the model, with the normals of the surfaces at their vertices. Faces that cannot be
    /// triangulated are not shown.
    #[must_use]
    pub fn picture(&self, chord: f64) -> Picture {
        let Ok(found) = self.tessellate(chord) else { return Picture::default() };
        let mut out = Picture { lines: found.lines, ..Picture::default() };
        let mut known = std::collections::BTreeMap::new();
        for ((corners, normals), face) in found.triangles.iter().zip(&found.normals).zip(&found.faces) {
            let mut vertex = |corner: u32, normal: &Vector3<f64>| {
                // A vertex on an edge has a normal for each of its faces.
                *known.entry((*face, corner)).or_insert_with(|| {
                    out.vertices.push(Sample { point: found.vertices[corner as usize], normal: *normal });
                    u32::try_from(out.vertices.len() - 1).unwrap_or(u32::MAX)
                })
            };
            let triangle = [0, 1, 2].map(|k| vertex(corners[k], &normals[k]));
            out.triangles.push(triangle);
        }
        out
    }
}

impl Tessellation {
    /// Leaves out vertices that no triangle has: points of free curves, and places of the plane outside of the faces.
    fn keep_used(&mut self) {
        let mut numbers = vec![u32::MAX; self.vertices.len()];
        let mut kept = Vec::with_capacity(self.vertices.len());
        for corner in self.triangles.iter_mut().flatten() {
            let number = &mut numbers[*corner as usize];
            if *number == u32::MAX {
                // There are no more vertices than before.
                *number = u32::try_from(kept.len()).unwrap_or(u32::MAX);
                kept.push(self.vertices[*corner as usize]);
            }
            *corner = *number;
        }
        self.vertices = kept;
    }
}

impl PartMesh {
    fn new(part: &Part, chord: f64) -> Result<Self, Error> {
        let mut points = EdgePoints::new(part, chord);
        // Where a face is cut open, its edges get a point on the cut, for both of their faces.
        let cuts: Vec<outline::Cuts> = parallel::map(&part.faces, |face| outline::cuts(part, face, &points));
        for (face, cuts) in part.faces.iter().zip(&cuts) {
            outline::divide(part, face, cuts, &mut points);
        }
        let mut open: Vec<usize> = (0..part.faces.len()).collect();
        let mut found: Vec<Option<FaceMesh>> = open.iter().map(|_| None).collect();
        for round in 0..=ROUNDS {
            let meshes =
                parallel::map(&open, |&face| face_mesh::mesh(part, face, &cuts[face], &points, chord));
            let mut crossed = Vec::new();
            for (face, mesh) in open.iter().zip(meshes) {
                let mesh = mesh?;
                crossed.extend_from_slice(&mesh.crossed);
                found[*face] = Some(mesh);
            }
            // Where chords of edges cross, though the edges do not, both of their faces get more points on them.
            let mut touched = vec![false; part.faces.len()];
            if round < ROUNDS {
                for (edge, t) in crossed {
                    if points.divide(&part.edges, edge, t) {
                        part.edges[edge].faces().for_each(|face| touched[face] = true);
                    }
                }
            }
            open = (0..part.faces.len()).filter(|face| touched[*face]).collect();
            if open.is_empty() {
                break;
            }
        }
        let lines = (0..part.edges.len()).map(|edge| points.line(edge)).collect();
        let mut this = Self { points: points.into_points(), faces: Vec::new(), lines };
        for mut mesh in found.into_iter().flatten() {
            // The vertices inside of a face come after those of the edges.
            let first = this.points.len();
            let shared = mesh.shared;
            let number = |id: usize| if id < shared { id } else { id - shared + first };
            for corners in &mut mesh.triangles {
                *corners = corners.map(number);
            }
            this.points.append(&mut mesh.own);
            this.faces.push(mesh);
        }
        Ok(this)
    }
}
