//! What the figures in space have in common: meshes of surfaces and of level sets, colours, views.

use distance_field::{Grid, LevelSetField};
use industrial_geometry::level_set::surface::{dual_contour, of_field};
use industrial_geometry::mesh::TriangleMesh;
use industrial_geometry::picture::{Curve, View};
use nalgebra::{Point3, Vector3};
use nurbs_core::{BsplineSurface, ParametricSurface};
use std::error::Error;

pub(super) const GREY: [f32; 3] = [0.74, 0.77, 0.80];
pub(super) const SAND: [f32; 3] = [0.93, 0.76, 0.50];
pub(super) const RED: [f32; 3] = [0.82, 0.13, 0.20];
pub(super) const BLUE: [f32; 3] = [0.12, 0.37, 0.66];
pub(super) const DARK: [f32; 3] = [0.13, 0.14, 0.17];
/// Pixels of the longer side of a picture.
pub(super) const SIZE: usize = 520;

/// The mesh of a surface over an even grid of parameters, with its normals.
pub(super) fn mesh_of(
    surface: &BsplineSurface,
    [m, n]: [usize; 2],
) -> Result<(TriangleMesh, Vec<Vector3<f64>>), Box<dyn Error>> {
    let [u, v] = surface.domain();
    let (mut points, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..=m {
        for j in 0..=n {
            let jet = surface.jet(u.lerp(i as f64 / m as f64), v.lerp(j as f64 / n as f64));
            points.push(Point3::from(jet.point));
            normals.push(jet.du.cross(&jet.dv).try_normalize(0.0).unwrap_or_else(Vector3::z));
        }
    }
    for i in 0..m {
        for j in 0..n {
            let corner = u32::try_from(i * (n + 1) + j)?;
            let next = corner + u32::try_from(n + 1)?;
            triangles.extend([[corner, next, next + 1], [corner, next + 1, corner + 1]]);
        }
    }
    Ok((TriangleMesh::new(points, triangles)?, normals))
}

/// Parameter lines of a surface: `along` of them in the direction of u at even v, `across` in that of v at even u.
pub(super) fn lines_of(
    surface: &BsplineSurface,
    [along, across]: [usize; 2],
    colour: [f32; 3],
) -> Vec<Curve> {
    let [u, v] = surface.domain();
    let share = |k: usize, count: usize| k as f64 / count.max(1) as f64;
    let line = |points: Vec<Point3<f64>>| Curve { points, colour, width: 1.4 };
    let first = (0..along).map(|k| {
        let at = v.lerp(share(k, along - 1));
        line((0..=160).map(|i| Point3::from(surface.point(u.lerp(share(i, 160)), at))).collect())
    });
    let second = (0..across).map(|k| {
        let at = u.lerp(share(k, across));
        line((0..=80).map(|i| Point3::from(surface.point(at, v.lerp(share(i, 80))))).collect())
    });
    first.chain(second).collect()
}

/// A block with a boss, a step and a hole, its inner edges filleted, its outer ones rounded, as a level set of distances.
pub(super) fn part(cells: usize) -> Result<(TriangleMesh, Vec<Vector3<f64>>), Box<dyn Error>> {
    let smooth = |a: f64, b: f64, r: f64| {
        // The union of two shapes with a fillet of radius r.
        let (u, v) = ((r - a).max(0.0), (r - b).max(0.0));
        a.min(b).max(r) - u.hypot(v)
    };
    let block = |p: &Vector3<f64>, centre: [f64; 3], half: [f64; 3], r: f64| {
        let q = Vector3::from_fn(|d, _| (p[d] - centre[d]).abs() - half[d] + r);
        q.map(|c| c.max(0.0)).norm() + q.max().min(0.0) - r
    };
    let shape = |p: &Vector3<f64>| {
        let base = block(p, [0.0, 0.0, -0.25], [1.0, 0.7, 0.22], 0.07);
        let step = block(p, [-0.56, 0.0, 0.1], [0.30, 0.54, 0.35], 0.07);
        let boss = {
            let q = [((p.x - 0.4).powi(2) + p.y * p.y).sqrt() - 0.36 + 0.07, (p.z - 0.05).abs() - 0.3 + 0.07];
            q[0].max(0.0).hypot(q[1].max(0.0)) + q[0].max(q[1]).min(0.0) - 0.07
        };
        let solid = smooth(smooth(base, step, 0.12), boss, 0.10);
        let hole = ((p.x - 0.4).powi(2) + p.y * p.y).sqrt() - 0.17;
        -smooth(-solid, hole, 0.06)
    };
    let cell = 2.3 / cells as f64;
    let counts = [cells + 1, cells * 17 / 23 + 1, cells * 12 / 23 + 1];
    let grid = Grid::sample(Vector3::new(-1.15, -0.85, -0.6), Vector3::repeat(cell), counts, shape)?;
    let field = LevelSetField::<3>::new(&grid)?;
    let mesh = dual_contour(&grid, of_field(&field))?;
    let normal = |p: &Point3<f64>| field.taylor(&p.coords).1.try_normalize(0.0).unwrap_or_else(Vector3::z);
    let normals = mesh.vertices().iter().map(normal).collect();
    Ok((mesh, normals))
}

/// From where the part is seen.
pub(super) const PART_VIEW: View = View { turn: -0.45, height: 0.75 };
