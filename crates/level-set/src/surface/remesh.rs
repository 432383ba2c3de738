//! From a mesh to its signed distance on a grid, and back to a mesh.

use super::dual::{Crossing, dual_contour, zero_between};
use super::lattice::Lattice;
use crate::{Error, parallel};
use distance_field::Grid;
use distance_field::grid::Inside;
use mesh_core::{MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// A mesh by way of a grid.
#[derive(Clone, Debug)]
pub struct Remeshed {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// Nodes of the grid along each axis.
    pub counts: [usize; 3],
    /// Side of the cells.
    pub cell: f64,
    /// Largest distance of vertices and middles of triangles of the mesh from the old one; of a cloud, of vertices from their nearest
    /// points.
    pub forth: f64,
    /// Largest distance of vertices of the old mesh, or of the points, from the new one: what was thinner than a cell is lost.
    pub back: f64,
}

/// Samples the signed distance of a mesh with `nodes` along the longest side of its box and triangulates its zero set, with sharp edges and
/// corners where faces of the mesh meet. Holes, flipped triangles and self-intersections are mended as [`Inside`] says.
///
/// # Errors
/// [`Error::Option`] for less than 8 or more than 2000 nodes, [`Error::TooLarge`] for too many in all, [`Error::Field`] for a mesh
/// that surrounds nothing ([`Inside`]), [`Error::Mesh`] and [`Error::Empty`] for one without area.
pub fn remesh(mesh: &TriangleMesh, nodes: usize) -> Result<Remeshed, Error> {
    let inside = Inside::new(mesh)?;
    let projector = inside.projector();
    let lattice = Lattice::around(mesh.vertices().iter().map(|p| &p.coords), nodes)?;
    let value = |x: &Vector3<f64>| {
        projector.project(&Point3::from(*x)).map_or(f64::NAN, |foot| inside.signed(x, &foot))
    };
    let values = parallel::map(lattice.total, |node| value(&lattice.position(node)));
    let grid = Grid::new(lattice.origin, Vector3::repeat(lattice.cell), lattice.counts, values)?;
    let crossing = |a: &Vector3<f64>, b: &Vector3<f64>| {
        let point = zero_between(a, b, value);
        let outwards = if value(a) < 0.0 { b - a } else { a - b };
        // The normal of the face, not that of an edge between two.
        let foot = projector.project(&Point3::from(point)).ok();
        let face = foot.and_then(|foot| mesh.corners(foot.triangle));
        let normal = face.map_or(outwards, |[a, b, c]| (b - a).cross(&(c - a))).normalize();
        Crossing { point, normal: if normal.dot(&outwards) < 0.0 { -normal } else { normal } }
    };
    let found = dual_contour(&grid, crossing)?;
    let middles = found.triangles().iter().map(|triangle| {
        let [a, b, c] = triangle.map(|k| found.vertices()[k as usize].coords);
        Point3::from((a + b + c) / 3.0)
    });
    let samples: Vec<Point3<f64>> = found.vertices().iter().copied().chain(middles).collect();
    let forth = farthest(projector, &samples)?;
    let kept: Vec<Point3<f64>> =
        mesh.vertices().iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
    let back = farthest(&MeshProjector::new(&found)?, &kept)?;
    Ok(Remeshed { mesh: found, counts: lattice.counts, cell: lattice.cell, forth, back })
}

/// Largest distance of points from a mesh.
pub(super) fn farthest(projector: &MeshProjector, points: &[Point3<f64>]) -> Result<f64, Error> {
    let mut most = 0.0f64;
    for found in projector.project_many(points) {
        most = most.max(found?.distance);
    }
    Ok(most)
}
