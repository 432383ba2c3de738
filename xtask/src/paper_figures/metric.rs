//! Figs. 15 to 17 of \[P05\]: geodesic circles, geodesic curves and dilation in the Euclidean and in the feature sensitive metric.

use super::shading::{BLUE, DARK, GREY, PART_VIEW, RED, SIZE, mesh_of, part};
use industrial_geometry::feature_metric::{
    GeodesicOptions, Method, Metric, MetricMesh, ParameterOptions, parameterize_patch, surface_geodesic,
};
use industrial_geometry::mesh::{Attributes, TriangleMesh};
use industrial_geometry::picture::{Curve, MeshScene, Paint, Sheet, View};
use nalgebra::{Point3, Vector3};
use nurbs_core::{BsplineSurface, KnotVector, ParametricSurface};
use std::error::Error;

/// Cells along the part.
const CELLS: usize = 110;
const FINE_CELLS: usize = 170;

/// The mesh with its normals, which the metric takes.
fn with_normals(mesh: &TriangleMesh, normals: &[Vector3<f64>]) -> Result<TriangleMesh, Box<dyn Error>> {
    let mut attributes = Attributes::default();
    attributes.set_normals(Some(normals.to_vec()));
    Ok(mesh.clone().with_attributes(attributes)?)
}

fn nearest(mesh: &TriangleMesh, place: [f64; 3]) -> usize {
    let far = |k: &usize| (mesh.vertices()[*k] - Point3::from(place)).norm();
    (0..mesh.vertices().len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
}

/// Distances from a point next to a fillet in both metrics.
pub(super) fn circles() -> Result<String, Box<dyn Error>> {
    let (mesh, normals) = part(CELLS)?;
    let mesh = with_normals(&mesh, &normals)?;
    let source = nearest(&mesh, [-0.02, -0.38, -0.03]);
    let mut sheet = Sheet::new();
    for (title, metric) in [
        ("Euclidean metric", Metric::Euclidean),
        ("feature sensitive metric, w = 0.3", Metric::Feature { width: 0.3 }),
    ] {
        let found = MetricMesh::new(&mesh, metric)?.distances(&[source], Method::Exact)?;
        let paint = Paint::Values { values: &found.values, range: [0.0, 1.6], lines: 16 };
        let mut scene =
            MeshScene { normals: Some(&normals), view: PART_VIEW, ..MeshScene::new(&mesh, paint) };
        scene.points = vec![(mesh.vertices()[source], RED, 6.0)];
        sheet = sheet.with(title, scene.draw(SIZE + 120));
    }
    let caption = "Geodesic circles around a point (red) on a part with fillets. In the feature sensitive metric they stop at the fillets.";
    Ok(sheet.with_bar([0.0, 1.6]).with_caption(caption).to_svg()?)
}

/// A sheet with a smooth bent step.
fn stepped() -> Result<BsplineSurface, Box<dyn Error>> {
    let (m, n) = (30, 26);
    let height = |x: f64, y: f64| {
        let middle = 0.45 * (1.6 * x).sin();
        let rise = |offset: f64, sharp: f64| 1.0 / (1.0 + (-(y - middle - offset) * sharp).exp());
        0.55 * (rise(-0.35, 22.0) - rise(0.35, 22.0))
    };
    let mut net = Vec::new();
    for i in 0..m {
        for j in 0..n {
            let (x, y) = (4.0 * i as f64 / (m - 1) as f64 - 2.0, 2.6 * j as f64 / (n - 1) as f64 - 1.3);
            net.push(Vector3::new(x, y, height(x, y)));
        }
    }
    let knots = |count: usize| KnotVector::uniform_clamped(3, count);
    Ok(BsplineSurface::new(knots(m)?, knots(n)?, net, None)?)
}

/// Parameter lines of a patch with a smooth bent step in both metrics.
pub(super) fn parameters() -> Result<String, Box<dyn Error>> {
    let (mesh, normals) = mesh_of(&stepped()?, [160, 120])?;
    let mesh = with_normals(&mesh, &normals)?;
    let mut sheet = Sheet::new();
    for (title, metric) in [
        ("Euclidean metric", Metric::Euclidean),
        ("feature sensitive metric, w = 0.6", Metric::Feature { width: 0.6 }),
    ] {
        let found = parameterize_patch(&mesh, metric, &ParameterOptions::default())?;
        if found.folded > 0 {
            return Err(format!("{} triangles fold", found.folded).into());
        }
        let view = View { turn: -0.35, height: 0.85 };
        let mut scene =
            MeshScene { normals: Some(&normals), view, ..MeshScene::new(&mesh, Paint::Plain(GREY)) };
        for (direction, colour) in [BLUE, RED].into_iter().enumerate() {
            let lines = found.lines(&mesh, direction, 24);
            scene.curves.extend(lines.into_iter().map(|ends| Curve {
                points: ends.to_vec(),
                colour,
                width: 1.6,
            }));
        }
        sheet = sheet.with(title, scene.draw(SIZE + 120));
    }
    let caption = "Parameter lines of a patch over the unit square. In the feature sensitive metric they crowd where the normal turns.";
    Ok(sheet.with_caption(caption).to_svg()?)
}

/// Geodesics between two pairs of points of a parametric surface in both metrics.
pub(super) fn curves() -> Result<String, Box<dyn Error>> {
    let surface = stepped()?;
    let (mesh, normals) = mesh_of(&surface, [220, 160])?;
    let view = View { turn: -0.35, height: 0.85 };
    let mut scene = MeshScene { normals: Some(&normals), view, ..MeshScene::new(&mesh, Paint::Plain(GREY)) };
    let mut lengths = Vec::new();
    for (from, to) in [([0.08, 0.42], [0.93, 0.56]), ([0.08, 0.22], [0.93, 0.36])] {
        for (metric, colour) in [(Metric::Euclidean, BLUE), (Metric::Feature { width: 2.0 }, RED)] {
            let found = surface_geodesic(&surface, from, to, metric, &GeodesicOptions::default())?;
            if !found.is_geodesic {
                return Err(format!("no geodesic from {from:?} to {to:?}").into());
            }
            let points = found.points.iter().map(|p| Point3::from(*p)).collect();
            scene.curves.push(Curve { points, colour, width: 3.5 });
            lengths.push(found.length);
        }
        for [u, v] in [from, to] {
            scene.points.push((Point3::from(surface.point(u, v)), DARK, 6.0));
        }
    }
    let caption = "Geodesics between two pairs of points on a B-spline surface: Euclidean (blue), and feature sensitive with w = 2 (red), which follow the features.";
    Ok(Sheet::new().with("", scene.draw(900)).with_caption(caption).to_svg()?)
}

/// Largest curvature of a region, times the radius of the fillets.
const FLAT: f64 = 0.42;
/// Radius of the smallest fillets of the part.
const FILLET: f64 = 0.06;
/// Fewest vertices of a region, and how far regions grow.
const FEWEST: usize = 60;
const GROWTH: f64 = 0.14;

/// Regions between features as edge detection finds them, and the same after growth in the feature sensitive metric.
pub(super) fn dilation() -> Result<String, Box<dyn Error>> {
    let (mesh, normals) = part(FINE_CELLS)?;
    let mesh = with_normals(&mesh, &normals)?;
    let count = mesh.vertices().len();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); count];
    for t in mesh.triangles() {
        for k in 0..3 {
            around[t[k] as usize].extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
        }
    }
    let flat: Vec<bool> = (0..count)
        .map(|k| {
            let bend = |other: &u32| {
                let other = *other as usize;
                (normals[k] - normals[other]).norm() / (mesh.vertices()[k] - mesh.vertices()[other]).norm()
            };
            around[k].iter().map(bend).fold(0.0, f64::max) * FILLET < FLAT
        })
        .collect();
    let mut labels = vec![-1i64; count];
    let mut regions: Vec<Vec<usize>> = Vec::new();
    for start in 0..count {
        if labels[start] >= 0 || !flat[start] {
            continue;
        }
        let label = i64::try_from(regions.len())?;
        let mut members = vec![start];
        labels[start] = label;
        let mut next = 0;
        while next < members.len() {
            for &other in &around[members[next]] {
                let other = other as usize;
                if flat[other] && labels[other] < 0 {
                    labels[other] = label;
                    members.push(other);
                }
            }
            next += 1;
        }
        regions.push(members);
    }
    for region in regions.iter().filter(|region| region.len() < FEWEST) {
        for &k in region {
            labels[k] = -1;
        }
    }
    let metric = MetricMesh::new(&mesh, Metric::Feature { width: 0.3 })?;
    let mut grown = labels.clone();
    let mut best = vec![GROWTH; count];
    for (label, region) in regions.iter().enumerate().filter(|(_, region)| region.len() >= FEWEST) {
        let found = metric.distances_from_region(region)?;
        for k in 0..count {
            if labels[k] < 0 && found.values[k] < best[k] {
                (best[k], grown[k]) = (found.values[k], i64::try_from(label)?);
            }
        }
    }
    let draw = |labels: &[i64]| {
        let scene = MeshScene::new(&mesh, Paint::Labels(labels));
        MeshScene { normals: Some(&normals), view: PART_VIEW, ..scene }.draw(SIZE + 120)
    };
    let sheet = Sheet::new()
        .with("between edges that were found", draw(&labels))
        .with(&format!("grown by {GROWTH} with w = 0.3"), draw(&grown))
        .with_caption(
            "Dilation in the feature sensitive metric: regions grow up to the fillets, and not across them.",
        );
    Ok(sheet.to_svg()?)
}
