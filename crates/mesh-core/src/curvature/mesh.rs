//! Curvatures of a mesh from the change of its normals (\[Ru04\]).

use nalgebra::{Cholesky, Matrix3, Point3, Vector3};

use super::tensor::{CurvatureFrame, tangents, transported};
use crate::normals::unit;
use crate::{Error, TriangleMesh};

/// Principal curvatures at the vertices of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCurvature {
    frames: Vec<Option<CurvatureFrame>>,
    /// Area of the surface that belongs to each vertex.
    areas: Vec<f64>,
    /// The first vertex at the same position, and the triangles with area in these numbers.
    first: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl MeshCurvature {
    /// Estimates the curvatures at all vertices.
    ///
    /// In every triangle the second fundamental form is fitted to the change of the vertex normals along the edges; the
    /// form of a vertex is the mean over the triangles around it, weighted by the parts of their areas that are nearest
    /// to the vertex ([Ru04, sec. 3]). Normals are weighted such that they are exact on spheres (\[Ma99\]). Vertices at
    /// exactly the same position count as one.
    #[must_use]
    pub fn new(mesh: &TriangleMesh) -> Self {
        let positions = mesh.vertices();
        let first = mesh.coincident_vertices();
        let corners = |indices: &[u32; 3]| indices.map(|index| positions[index as usize]);
        let triangles: Vec<[u32; 3]> = (mesh.triangles().iter())
            .map(|indices| indices.map(|index| first[index as usize]))
            .filter(|indices| {
                let [a, b, c] = corners(indices);
                unit(&(b - a).cross(&(c - a))).is_some()
            })
            .collect();
        let normals = sphere_exact_normals(&triangles, positions.len(), corners);
        let mut forms = vec![Matrix3::zeros(); positions.len()];
        let mut areas = vec![0.0; positions.len()];
        for indices in &triangles {
            let corners = corners(indices);
            let vertex_normals = indices.map(|index| normals[index as usize]);
            let Some((form, normal)) = form_of_face(&corners, &vertex_normals) else { continue };
            for ((&index, to), share) in indices.iter().zip(&vertex_normals).zip(voronoi_areas(&corners)) {
                forms[index as usize] += transported(&form, &normal, to) * share;
                areas[index as usize] += share;
            }
        }
        let frames = (first.iter().map(|&vertex| vertex as usize))
            .map(|vertex| {
                let tensor = forms[vertex] / areas[vertex];
                CurvatureFrame::of_tensor(&tensor, &normals[vertex]).filter(|_| areas[vertex] > 0.0)
            })
            .collect();
        Self { frames, areas, first, triangles }
    }

    /// The frames, one per vertex; `None` where no triangle with area ends or normals cancel out.
    #[must_use]
    pub fn frames(&self) -> &[Option<CurvatureFrame>] {
        &self.frames
    }

    /// Number of vertices without a frame.
    #[must_use]
    pub fn undefined(&self) -> usize {
        self.frames.iter().filter(|frame| frame.is_none()).count()
    }

    /// Curvatures averaged over the neighbours as often as asked for.
    ///
    /// A step replaces the tensor of every vertex by the mean of its own and those of its neighbours, turned into its
    /// tangent plane and weighted by their areas. Normals stay.
    #[must_use]
    pub fn smoothed(&self, steps: usize) -> Self {
        let mut smooth = self.clone();
        for _ in 0..steps {
            let tensors: Vec<_> =
                smooth.frames.iter().map(|frame| frame.map(|frame| (frame.tensor(), frame.normal))).collect();
            let mut sums: Vec<(Matrix3<f64>, f64)> = (tensors.iter().zip(&self.areas))
                .map(|(own, &area)| own.map_or((Matrix3::zeros(), 0.0), |(tensor, _)| (tensor * area, area)))
                .collect();
            for &[a, b, c] in &self.triangles {
                for (one, other) in [(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)] {
                    let (one, other) = (one as usize, other as usize);
                    if let (Some((_, to)), Some((tensor, from))) = (&tensors[one], &tensors[other]) {
                        // Interior edges come twice, from both of their triangles.
                        let share = 0.5 * self.areas[other];
                        sums[one].0 += transported(tensor, from, to) * share;
                        sums[one].1 += share;
                    }
                }
            }
            for (vertex, frame) in smooth.frames.iter_mut().enumerate() {
                let (sum, area) = &sums[self.first[vertex] as usize];
                *frame = frame.and_then(|frame| CurvatureFrame::of_tensor(&(sum / *area), &frame.normal));
            }
        }
        smooth
    }

    /// The curvatures between three vertices: the mean of their tensors by the weights, in the plane normal to the mean
    /// of their normals.
    ///
    /// Continuous over the mesh when the weights are barycentric coordinates. `None` where a vertex of positive weight
    /// has no curvature or normals cancel out.
    ///
    /// # Errors
    /// [`Error::VertexIndex`] if a vertex does not exist.
    pub fn interpolate(
        &self,
        vertices: [u32; 3],
        weights: [f64; 3],
    ) -> Result<Option<CurvatureFrame>, Error> {
        let (mut tensor, mut normal) = (Matrix3::zeros(), Vector3::zeros());
        for (corner, (index, weight)) in vertices.into_iter().zip(weights).enumerate() {
            let Some(frame) = self.frames.get(index as usize) else {
                return Err(Error::VertexIndex { triangle: 0, corner, index, vertices: self.frames.len() });
            };
            match frame {
                Some(frame) => {
                    tensor += frame.tensor() * weight;
                    normal += frame.normal * weight;
                }
                None if weight == 0.0 => {}
                None => return Ok(None),
            }
        }
        Ok(unit(&normal).and_then(|normal| CurvatureFrame::of_tensor(&tensor, &normal)))
    }
}

/// Vertex normals that are exact on spheres: sum of `e × f / (|e|² |f|²)` over the edges `e`, `f` of the corners (\[Ma99\]).
fn sphere_exact_normals(
    triangles: &[[u32; 3]],
    count: usize,
    corners: impl Fn(&[u32; 3]) -> [Point3<f64>; 3],
) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); count];
    for indices in triangles {
        let corners = corners(indices);
        for corner in 0..3 {
            let e = corners[(corner + 1) % 3] - corners[corner];
            let f = corners[(corner + 2) % 3] - corners[corner];
            sums[indices[corner] as usize] += e.cross(&f) / (e.norm_squared() * f.norm_squared());
        }
    }
    sums.iter().map(|sum| unit(sum).unwrap_or_else(Vector3::zeros)).collect()
}

/// The second fundamental form of a triangle, and its normal ([Ru04, eq. (5)], with the opposite sign).
fn form_of_face(
    corners: &[Point3<f64>; 3],
    normals: &[Vector3<f64>; 3],
) -> Option<(Matrix3<f64>, Vector3<f64>)> {
    let normal = unit(&(corners[1] - corners[0]).cross(&(corners[2] - corners[0])))?;
    if normals.contains(&Vector3::zeros()) {
        return None;
    }
    let [x, y] = tangents(&normal)?;
    // Least squares for (a, b, c) in  a e_x + b e_y = −Δn_x,  b e_x + c e_y = −Δn_y  over the three edges.
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let size = (corners[1] - corners[0]).norm().max((corners[2] - corners[0]).norm());
    for edge in 0..3 {
        let (from, to) = (edge, (edge + 1) % 3);
        let along = (corners[to] - corners[from]) / size;
        let change = (normals[from] - normals[to]) / size;
        let (ex, ey) = (along.dot(&x), along.dot(&y));
        let (nx, ny) = (change.dot(&x), change.dot(&y));
        matrix +=
            Matrix3::new(ex * ex, ex * ey, 0.0, ex * ey, ex * ex + ey * ey, ex * ey, 0.0, ex * ey, ey * ey);
        right += Vector3::new(ex * nx, ex * ny + ey * nx, ey * ny);
    }
    let form = Cholesky::new(matrix)?.solve(&right);
    let tensor = x * x.transpose() * form.x
        + (x * y.transpose() + y * x.transpose()) * form.y
        + y * y.transpose() * form.z;
    form.iter().all(|value| value.is_finite()).then_some((tensor, normal))
}

/// The parts of a triangle that are nearest to each corner; in obtuse triangles half the area for the obtuse corner
/// ([MDSB03, sec. 3.3]).
fn voronoi_areas(corners: &[Point3<f64>; 3]) -> [f64; 3] {
    let edge = |corner: usize| corners[(corner + 2) % 3] - corners[(corner + 1) % 3];
    let edges = [edge(0), edge(1), edge(2)];
    let area = 0.5 * edges[0].cross(&edges[1]).norm();
    let cosines = [0, 1, 2].map(|corner| -edges[(corner + 1) % 3].dot(&edges[(corner + 2) % 3]));
    if let Some(obtuse) = cosines.iter().position(|&cosine| cosine < 0.0) {
        return [0, 1, 2].map(|corner| if corner == obtuse { 0.5 * area } else { 0.25 * area });
    }
    let part = |opposite: usize| edges[opposite].norm_squared() * cosines[opposite] / (16.0 * area);
    [0, 1, 2].map(|corner| part((corner + 1) % 3) + part((corner + 2) % 3))
}
