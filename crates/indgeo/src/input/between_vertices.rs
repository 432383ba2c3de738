//! Points on the triangles of meshes that were thinned out.

use crate::report::Report;
use crate::report::wording::counted;
use industrial_geometry::mesh::{TriangleMesh, sample_wide_triangles};
use industrial_geometry::nurbs::nalgebra::Vector3;
use std::path::Path;

/// Share of the number of vertices below which such points are not worth it.
const FEW: f64 = 0.05;
const SEED: u64 = 1;

/// Points to be added to the vertices of a mesh, on triangles much wider than others: a mesh that was thinned out has hardly a vertex
/// where it is nearly flat. None for a cloud and for a mesh of even triangles. The report says so.
pub(crate) fn between_vertices(mesh: &TriangleMesh, path: &Path, report: &mut Report) -> Vec<Vector3<f64>> {
    let vertices = mesh.vertices();
    // A mesh without area is a cloud.
    let samples = sample_wide_triangles(mesh, SEED).unwrap_or_default();
    if samples.len() as f64 <= FEW * vertices.len() as f64 {
        return Vec::new();
    }
    report.warnings.push(format!(
        "{}: its triangles are of very different sizes; {} on the wide ones are taken besides the {}",
        path.display(),
        counted(samples.len(), "point"),
        counted(vertices.len(), "vertex")
    ));
    samples.into_iter().map(|sample| sample.point.coords).collect()
}
