//! From a cloud to the mesh of its moving least squares surface.

use super::dual::{Crossing, dual_contour, zero_between};
use super::lattice::Lattice;
use super::remesh::{Remeshed, farthest};
use crate::{Error, parallel};
use distance_field::{DistanceField, Grid, Hint, MlsField, Search};
use mesh_core::{CloudIndex, MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// Triangulates the moving least squares surface of a cloud on a grid with `nodes` along the longest side of the box of the points.
///
/// Closed where the cloud is, with a boundary where the cloud ends. The outside is where the normals point to.
///
/// # Errors
/// [`Error::Option`] for less than 8 or more than 2000 nodes, [`Error::TooLarge`] for too many in all, and [`Error::Empty`] for a cloud
/// without extent or whose surface does not pass between nodes.
pub fn mesh_of_cloud(points: &[Point3<f64>], field: &MlsField, nodes: usize) -> Result<Remeshed, Error> {
    let lattice = Lattice::around(points.iter().map(|p| &p.coords), nodes)?;
    let value = |x: &Vector3<f64>| field.side(x).unwrap_or(f64::NAN);
    let values = parallel::map(lattice.total, |node| value(&lattice.position(node)));
    let grid = Grid::new(lattice.origin, Vector3::repeat(lattice.cell), lattice.counts, values)?;
    let found = dual_contour(&grid, |a, b| {
        let point = zero_between(a, b, value);
        let outwards = if value(a) < 0.0 { b - a } else { a - b };
        let gradient = field.value(&point).map_or(outwards, |(_, gradient)| gradient);
        Crossing { point, normal: gradient.try_normalize(0.0).unwrap_or_else(|| outwards.normalize()) }
    })?;
    // What lies beyond the edge of the cloud only parts the sides that were made up there.
    let covered = parallel::map(found.vertices().len(), |i| field.covers(&found.vertices()[i].coords));
    let rough = kept(&found, &covered)?;
    // Vertices where tangent planes meet lie off a curved surface by the square of the cell.
    let on_surface = parallel::map(rough.vertices().len(), |i| {
        let vertex = rough.vertices()[i];
        let frame = field.frame(&vertex.coords, Search::Global, &Hint::NONE);
        let is_near = (frame.foot - vertex.coords).norm() < 0.5 * lattice.cell;
        if frame.status.is_converged() && is_near { Point3::from(frame.foot) } else { vertex }
    });
    let mesh = TriangleMesh::new(on_surface, rough.triangles().to_vec())?;
    let finite: Vec<Point3<f64>> =
        points.iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
    let back = farthest(&MeshProjector::new(&mesh)?, &finite)?;
    let near = CloudIndex::new(&finite)?.nearest_many(mesh.vertices());
    let forth = near.iter().flatten().map(mesh_core::Neighbour::distance).fold(0.0, f64::max);
    Ok(Remeshed { mesh, counts: lattice.counts, cell: lattice.cell, forth, back })
}

/// The triangles all of whose vertices are kept.
fn kept(mesh: &TriangleMesh, keep: &[bool]) -> Result<TriangleMesh, Error> {
    let inside = |triangle: &&[u32; 3]| triangle.iter().all(|&k| keep[k as usize]);
    let triangles: Vec<[u32; 3]> = mesh.triangles().iter().filter(inside).copied().collect();
    if triangles.is_empty() {
        let what = "no part of the surface of the cloud passes between nodes; take more nodes".to_owned();
        return Err(Error::Empty { what });
    }
    let mut renumbered = vec![u32::MAX; mesh.vertices().len()];
    let mut vertices = Vec::new();
    let mut triangles = triangles;
    for k in triangles.iter_mut().flatten() {
        let old = *k as usize;
        if renumbered[old] == u32::MAX {
            let next = u32::try_from(vertices.len());
            renumbered[old] =
                next.map_err(|_| mesh_core::Error::TooMany { what: "vertices", count: vertices.len() })?;
            vertices.push(mesh.vertices()[old]);
        }
        *k = renumbered[old];
    }
    Ok(TriangleMesh::new(vertices, triangles)?)
}
