//! Distances on grids and geodesic distances on meshes: errors against closed forms, and time.

#![allow(clippy::print_stdout, reason = "a program that prints its results")]

use distance_field::Grid;
use distance_field::grid::{Element, Inside, Lattice, Medium, Scene, carry, march, redistance, seeds, sweep};
use industrial_geometry::feature_metric::{Method, Metric, MetricMesh};
use industrial_geometry::io::{self, Content, ReadOptions};
use mesh_core::{MeshProjector, TriangleMesh};
use nalgebra::{Point3, SVector, Vector2, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::Path;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    orders()?;
    times()?;
    obstacles()?;
    redistancing()?;
    signs()?;
    geodesics()?;
    closed_forms()
}

/// Mean and largest error of values against a closed form.
fn errors<const D: usize>(
    lattice: &Lattice<D>,
    values: &[f64],
    truth: impl Fn(&SVector<f64, D>) -> f64,
) -> [f64; 2] {
    let all = (0..lattice.len()).map(|node| (values[node] - truth(&lattice.point(node))).abs());
    let (sum, most) = all.fold((0.0, 0.0f64), |(sum, most), error| (sum + error, most.max(error)));
    [sum / lattice.len() as f64, most]
}

/// Distances of a point and of a circle by each method on finer and finer grids.
fn orders() -> Result<(), Failure> {
    println!("one point in the unit square: mean and largest error, order of the mean");
    let source = Vector2::new(0.37, 0.41);
    let mut before: [Option<f64>; 4] = [None; 4];
    for nodes in [65, 129, 257, 513] {
        let lattice = Lattice::new(Vector2::zeros(), Vector2::repeat(1.0), [nodes; 2])?;
        let element = [Element::Point(source)];
        // The ball around the point in which distances are exact has the same size on all grids.
        let near = seeds(&lattice, &element, 0.1);
        let next = seeds(&lattice, &element, lattice.spacing().norm());
        let medium = Medium::default();
        let all = [
            ("sweeping", sweep(&lattice, &near, &medium).0),
            ("marching", march(&lattice, &near, &medium, false)),
            ("marching, second order", march(&lattice, &near, &medium, true)),
            ("nearest points carried (Tsai)", carry(&lattice, &element, &next).0),
        ];
        for ((name, values), before) in all.iter().zip(&mut before) {
            let [mean, most] = errors(&lattice, values, |x| (x - source).norm());
            let order = before.map_or_else(String::new, |b| format!(", order {:.2}", (b / mean).log2()));
            println!(
                "  {nodes:4}^2 {name}: {mean:.2e} {most:.2e}{}",
                if mean > 0.0 { order } else { String::new() }
            );
            *before = Some(mean);
        }
    }
    Ok(())
}

/// CPU seconds of the threads of the process so far; NaN where there is no `/proc`.
fn cpu() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return f64::NAN };
    let nanoseconds = threads.flatten().filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    nanoseconds.sum::<f64>() * 1e-9
}

/// What comes out, and the CPU seconds of the faster one of two runs.
fn timed<T>(run: impl Fn() -> T) -> (T, f64) {
    let began = cpu();
    let found = run();
    let first = cpu() - began;
    let began = cpu();
    let _again = run();
    (found, first.min(cpu() - began))
}

/// Time of each method with one source.
fn times() -> Result<(), Failure> {
    fn of<const D: usize>(nodes: usize) -> Result<(), Failure> {
        let lattice = Lattice::<D>::new(SVector::zeros(), SVector::repeat(1.0), [nodes; D])?;
        let element = [Element::Point(SVector::repeat(0.37))];
        let near = seeds(&lattice, &element, lattice.spacing().norm());
        let medium = Medium::default();
        let share = 1e9 / lattice.len() as f64;
        println!(
            "one point, {nodes}^{D} nodes, ns per node: sweeping {:.0}, marching {:.0}, second order {:.0}, carrying {:.0}",
            timed(|| sweep(&lattice, &near, &medium)).1 * share,
            timed(|| march(&lattice, &near, &medium, false)).1 * share,
            timed(|| march(&lattice, &near, &medium, true)).1 * share,
            timed(|| carry(&lattice, &element, &near)).1 * share,
        );
        Ok(())
    }
    of::<2>(1025)?;
    of::<3>(129)
}

/// The exact distance among obstacles against the visibility graph, and its time beside that of sweeping.
fn obstacles() -> Result<(), Failure> {
    let text: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string("fixtures/field-cases/scene_aligned.json")?)?;
    let point = |value: &serde_json::Value| {
        let number = |k: usize| value.get(k).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
        Vector2::new(number(0), number(1))
    };
    let list = |value: &serde_json::Value| value.as_array().cloned().unwrap_or_default();
    let polygons: Vec<Vec<Vector2<f64>>> =
        list(&text["polys"]).iter().map(|p| list(p).iter().map(point).collect()).collect();
    let source = point(&text["source"]);
    let scene = Scene::new(Vector2::zeros(), Vector2::repeat(1.0), source, &polygons)?;
    let known: Vec<f64> = std::fs::read_to_string("fixtures/field-cases/scene_aligned.exact129.txt")?
        .lines()
        .map(str::parse)
        .collect::<Result<_, _>>()?;
    let lattice = Lattice::new(Vector2::zeros(), Vector2::repeat(1.0), [129; 2])?;
    let values = scene.distances(&lattice);
    let wrong = values.iter().zip(&known).filter(|(a, b)| (*a - *b).abs() > 1e-12).count();
    println!("obstacles, 129^2 nodes against a visibility graph: {wrong} wrong nodes of {}", known.len());
    let fine = Lattice::new(Vector2::zeros(), Vector2::repeat(1.0), [257; 2])?;
    let blocked: Vec<bool> = (0..fine.len()).map(|node| scene.is_blocked(&fine.point(node))).collect();
    let medium = Medium { blocked, ..Medium::default() };
    let near = seeds(&fine, &[Element::Point(source)], fine.spacing().norm());
    let exact = timed(|| scene.distances(&fine)).1;
    let swept = timed(|| sweep(&fine, &near, &medium)).1;
    println!("obstacles, 257^2 nodes: exact in {:.1} times the time of sweeping", exact / swept);
    Ok(())
}

/// Redistancing of a function that is no distance.
fn redistancing() -> Result<(), Failure> {
    let level = |p: &Vector2<f64>| ((1.4 * (p.norm_squared() - 1.0)).exp() - 1.0) * (1.5 + p.x);
    let mut before: Option<f64> = None;
    for nodes in [65usize, 129, 257, 513] {
        let spacing = 2.8 / (nodes - 1) as f64;
        let grid = Grid::sample(Vector2::repeat(-1.4), Vector2::repeat(spacing), [nodes; 2], level)?;
        let (found, seconds) = timed(|| redistance(&grid, None));
        let found = found?;
        let away = (0..nodes * nodes).map(|node| grid.position(node)).collect::<Vec<_>>();
        let kept: Vec<f64> = away
            .iter()
            .zip(found.grid.values())
            // The centre of curvature is no smooth point of the distance.
            .filter(|(p, _)| p.norm() > 0.2)
            .map(|(p, value)| (value - (p.norm() - 1.0)).abs())
            .collect();
        let mean = kept.iter().sum::<f64>() / kept.len() as f64;
        let order = before.map_or_else(String::new, |b: f64| format!(", order {:.2}", (b / mean).log2()));
        let share = 1e6 * seconds / (nodes * nodes) as f64;
        println!("redistancing, {nodes}^2 nodes: mean error {mean:.2e}{order}, {share:.2} us per node");
        before = Some(mean);
    }
    Ok(())
}

/// Signed distances of a mesh, of the mesh with a hole, and of the mesh with triangles turned.
fn signs() -> Result<(), Failure> {
    let Content::Mesh(mesh) =
        io::read(Path::new("fixtures/mesh/bunny.obj"), &ReadOptions::default())?.content
    else {
        return Err("the bunny is no mesh".into());
    };
    let bounds = mesh.bounding_box().ok_or("the bunny has no box")?;
    let margin = (bounds.max - bounds.min) * 0.1;
    let lattice = Lattice::new(bounds.min.coords - margin, bounds.max.coords + margin, [129; 3])?;
    let projector = MeshProjector::new(&mesh)?;
    let nodes: Vec<Point3<f64>> = (0..lattice.len()).map(|node| Point3::from(lattice.point(node))).collect();
    let began = cpu();
    let values = projector
        .map_feet(&nodes, |_, foot| foot.ok().and_then(|foot| foot.signed_distance).unwrap_or(f64::NAN));
    let exact = (cpu() - began) / lattice.len() as f64;
    let corner = |k: u32| mesh.vertices()[k as usize].coords;
    let triangles: Vec<[Vector3<f64>; 3]> = mesh.triangles().iter().map(|t| t.map(corner)).collect();
    // The sum of solid angles, triangle by triangle.
    let turns = |x: &Vector3<f64>| triangles.iter().map(|t| solid_angle(x, t)).sum::<f64>() / (2.0 * TAU);
    let tested: Vec<usize> = (0..lattice.len()).step_by(997).collect();
    let wrong = tested.iter().filter(|n| (turns(&lattice.point(**n)) > 0.5) != (values[**n] < 0.0)).count();
    println!(
        "signed distance of the bunny ({} triangles), 129^3 nodes: {:.2} us per node, {wrong} wrong signs of {}",
        mesh.triangles().len(),
        1e6 * exact,
        tested.len()
    );
    let middle = triangles[0][0];
    let size = 0.06 * (bounds.max - bounds.min).norm();
    let is_far = |t: &[Vector3<f64>; 3]| t.iter().all(|p| (p - middle).norm() > size);
    let given = mesh.triangles();
    let open: Vec<_> = (0..given.len()).filter(|&k| is_far(&triangles[k])).map(|k| given[k]).collect();
    let turned = given.iter().enumerate();
    let turned: Vec<_> =
        turned.map(|(k, &[a, b, c])| if k % 23 == 0 { [a, c, b] } else { [a, b, c] }).collect();
    for (name, some, reach) in
        [("with a hole", open, 2.0 * size), ("with 1 of 23 triangles turned", turned, 0.0)]
    {
        let removed = triangles.len() - some.len();
        let began = cpu();
        let inside = Inside::new(&TriangleMesh::new(mesh.vertices().to_vec(), some)?)?;
        let found = inside.projector().map_feet(&nodes, |node, foot| {
            foot.map_or(f64::NAN, |foot| inside.signed(&nodes[node].coords, &foot))
        });
        let seconds = 1e6 * (cpu() - began) / lattice.len() as f64;
        let counted = |node: &usize| (nodes[*node].coords - middle).norm() >= reach;
        let all = (0..nodes.len()).filter(counted).count();
        let good = (0..nodes.len())
            .filter(counted)
            .filter(|&node| (found[node] < 0.0) == (values[node] < 0.0))
            .count();
        println!(
            "{name} ({removed} triangles less): sign right on {:.3} % of nodes, {seconds:.2} us per node",
            100.0 * good as f64 / all as f64
        );
    }
    Ok(())
}

/// The signed solid angle of a triangle (Van Oosterom and Strackee).
fn solid_angle(x: &Vector3<f64>, t: &[Vector3<f64>; 3]) -> f64 {
    let [a, b, c] = t.map(|p| p - x);
    let [l, m, n] = [a.norm(), b.norm(), c.norm()];
    let below = l * m * n + a.dot(&b) * n + b.dot(&c) * l + c.dot(&a) * m;
    2.0 * a.dot(&b.cross(&c)).atan2(below)
}

/// A closed grid over a torus, or an open one over another surface.
fn mesh_of(
    [m, n]: [u32; 2],
    is_closed: bool,
    at: impl Fn(f64, f64) -> (Vector3<f64>, Vector3<f64>),
) -> Result<TriangleMesh, Failure> {
    let (rows, columns) = if is_closed { (m, n) } else { (m + 1, n + 1) };
    let (mut points, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..rows {
        for j in 0..columns {
            let (point, normal) = at(f64::from(i) / f64::from(m), f64::from(j) / f64::from(n));
            points.push(Point3::from(point));
            normals.push(normal);
        }
    }
    for i in 0..m {
        for j in 0..n {
            let vertex = |i: u32, j: u32| (i % rows) * columns + j % columns;
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    let mesh = TriangleMesh::new(points, triangles)?;
    let (cloud, triangles) = mesh.into_parts();
    Ok(TriangleMesh::from_cloud(cloud.with_normals(normals)?, triangles)?)
}

fn torus([m, n]: [u32; 2]) -> Result<TriangleMesh, Failure> {
    mesh_of([m, n], true, |u, v| {
        let ((a, b), (c, d)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
        let normal = Vector3::new(b * d, a * d, c);
        (Vector3::new(b, a, 0.0) + normal * 0.4, normal)
    })
}

/// Time of distances on a mesh, and the error of the fast ones.
fn geodesics() -> Result<(), Failure> {
    for metric in [Metric::Euclidean, Metric::Feature { width: 0.4 }] {
        let mesh = torus([256, 160])?;
        let prepared = MetricMesh::new(&mesh, metric)?;
        let (exact, slow) = timed(|| prepared.distances(&[0], Method::Exact));
        let (fast, quick) = timed(|| prepared.distances(&[0], Method::Fast));
        let (exact, fast) = (exact?, fast?);
        let share = 1e6 / mesh.vertices().len() as f64;
        let apart = exact.values.iter().zip(&fast.values).filter(|(a, _)| **a > 0.0);
        let (sum, count) =
            apart.fold((0.0, 0.0), |(sum, count), (a, b)| (sum + (a - b).abs() / a, count + 1.0));
        println!(
            "torus of {} vertices, w = {}: exact {:.1} us per vertex, fast {:.2} with a mean relative error of {:.1e}",
            mesh.vertices().len(),
            metric.width(),
            slow * share,
            quick * share,
            sum / count
        );
    }
    Ok(())
}

/// Closed forms in the feature sensitive metric.
fn closed_forms() -> Result<(), Failure> {
    let w = 0.7;
    let mut before: [Option<f64>; 3] = [None; 3];
    for n in [16u32, 32, 64, 128] {
        // Half a sphere from the pole to the equator, a quarter of a cylinder, a fillet of radius 0.2 between two planes.
        let sphere = mesh_of([n, 2 * n], false, |u, v| {
            let ((a, b), (c, d)) = ((FRAC_PI_2 * (0.1 + 0.8 * u)).sin_cos(), (FRAC_PI_2 * v).sin_cos());
            let normal = Vector3::new(a * d, a * c, b);
            (normal, normal)
        })?;
        let cylinder = mesh_of([n, n], false, |u, v| {
            let (s, c) = (FRAC_PI_2 * u).sin_cos();
            (Vector3::new(c, s, v), Vector3::new(c, s, 0.0))
        })?;
        let fillet = mesh_of([3 * n, n], false, |u, v| {
            let (rho, s) = (0.2, 3.0 * u);
            let (sine, cosine) = (FRAC_PI_2 * (s - 1.0).clamp(0.0, 1.0)).sin_cos();
            let normal = Vector3::new(sine, 0.0, cosine);
            let flat = Vector3::new((s - 1.0).min(0.0), v, -(s - 2.0).max(0.0));
            (flat + normal * rho, normal)
        })?;
        let metric = Metric::Feature { width: w };
        let far = |mesh: &TriangleMesh, from: u32, to: u32| -> Result<f64, Failure> {
            let found = MetricMesh::new(mesh, metric)?.distances(&[from as usize], Method::Exact)?;
            Ok(found.values[to as usize])
        };
        let cases = [
            ("sphere", far(&sphere, n, n * (2 * n + 1) + n)?, (1.0 + w * w).sqrt() * 0.8 * FRAC_PI_2),
            (
                "cylinder",
                far(&cylinder, 0, (n + 1) * (n + 1) - 1)?,
                ((1.0 + w * w) * FRAC_PI_2.powi(2) + 1.0).sqrt(),
            ),
            (
                "fillet",
                far(&fillet, n / 2, 3 * n * (n + 1) + n / 2)?,
                2.0 + FRAC_PI_2 * (0.04 + w * w).sqrt(),
            ),
        ];
        for ((name, found, truth), before) in cases.into_iter().zip(&mut before) {
            let error = ((found - truth) / truth).abs();
            let order = before.map_or_else(String::new, |b| format!(", order {:.2}", (b / error).log2()));
            println!("{name}, w = {w}, {n} triangles along: relative error {error:.2e}{order}");
            *before = Some(error);
        }
    }
    Ok(())
}
