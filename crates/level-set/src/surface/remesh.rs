//! From a mesh to its signed distance on a grid, and back to a mesh.

use super::dual::{Crossing, dual_contour, zero_between};
use crate::error::check_size;
use crate::{Error, parallel};
use distance_field::Grid;
use distance_field::grid::Winding;
use mesh_core::{MeshProjector, TriangleMesh};
use nalgebra::{Point3, Vector3};

/// Cells that are left free around the mesh.
const MARGIN: f64 = 2.5;
/// Nodes along the longest side at least and at most.
const NODES: std::ops::RangeInclusive<usize> = 8..=2000;

/// A mesh by way of a grid.
#[derive(Clone, Debug)]
pub struct Remeshed {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// Nodes of the grid along each axis.
    pub counts: [usize; 3],
    /// Side of the cells.
    pub cell: f64,
    /// Largest distance of vertices and middles of triangles of the new mesh from the old one.
    pub forth: f64,
    /// Largest distance of vertices of the old mesh from the new one: what was thinner than a cell is lost.
    pub back: f64,
}

/// Samples the signed distance of a mesh with `nodes` along the longest side of its box and triangulates its zero set, with sharp edges and
/// corners where faces of the mesh meet. Holes are closed, and flips and self-intersections mended, by the generalised winding
/// number.
///
/// # Errors
/// [`Error::Option`] for less than 8 or more than 2000 nodes, [`Error::TooLarge`] for too many in all, [`Error::Mesh`] for a mesh
/// without area, and [`Error::Empty`] for one that has no inside.
pub fn remesh(mesh: &TriangleMesh, nodes: usize) -> Result<Remeshed, Error> {
    if !NODES.contains(&nodes) {
        let what = "it must be from 8 to 2000 nodes along the longest side";
        return Err(Error::Option { option: "grid", value: nodes as f64, what });
    }
    let projector = MeshProjector::new(mesh)?;
    let finite = mesh.vertices().iter().map(|p| p.coords).filter(|p| p.iter().all(|c| c.is_finite()));
    let (low, high) = finite
        .fold((Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)), |(low, high), p| {
            (low.inf(&p), high.sup(&p))
        });
    let sides = high - low;
    let cell = sides.amax() / (nodes as f64 - 1.0 - 2.0 * MARGIN);
    if !(cell.is_finite() && cell > 0.0) {
        return Err(Error::Empty { what: "the mesh has no extent".to_owned() });
    }
    let counts: [usize; 3] = std::array::from_fn(|k| to_count((sides[k] / cell + 2.0 * MARGIN).ceil() + 1.0));
    let total = check_size(&counts.map(|count| count as u64), || {
        format!("{} x {} x {} nodes", counts[0], counts[1], counts[2])
    })?;
    let corner = |k: u32| mesh.vertices()[k as usize].coords;
    let triangles = || mesh.triangles().iter().map(|triangle| triangle.map(corner)).collect();
    let winding = (!projector.is_solid()).then(|| Winding::new(triangles()));
    let value = |x: &Vector3<f64>| {
        let Ok(foot) = projector.project(&Point3::from(*x)) else { return f64::NAN };
        match (foot.signed_distance, &winding) {
            (Some(distance), _) => distance,
            (None, Some(winding)) if winding.number(x) > 0.5 => -foot.distance,
            _ => foot.distance,
        }
    };
    // Off the middle of the box by a little that no part is made with: nodes on faces of the mesh have no side.
    let origin = (low + high) * 0.5
        - Vector3::from_fn(|k, _| (0.5 * (counts[k] - 1) as f64 + 0.012_345 * (k + 1) as f64) * cell);
    let place = |node: usize| {
        let at = [node / (counts[1] * counts[2]), node / counts[2] % counts[1], node % counts[2]];
        origin + Vector3::from_fn(|k, _| at[k] as f64 * cell)
    };
    let values = parallel::map(total, |node| value(&place(node)));
    let grid = Grid::new(origin, Vector3::repeat(cell), counts, values)?;
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
    let forth = farthest(&projector, &samples)?;
    let kept: Vec<Point3<f64>> =
        mesh.vertices().iter().filter(|p| p.iter().all(|c| c.is_finite())).copied().collect();
    let back = farthest(&MeshProjector::new(&found)?, &kept)?;
    Ok(Remeshed { mesh: found, counts, cell, forth, back })
}

/// Largest distance of points from a mesh.
fn farthest(projector: &MeshProjector, points: &[Point3<f64>]) -> Result<f64, Error> {
    let mut most = 0.0f64;
    for found in projector.project_many(points) {
        most = most.max(found?.distance);
    }
    Ok(most)
}

/// A number of nodes.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most a few thousand")]
fn to_count(value: f64) -> usize {
    value as usize
}
