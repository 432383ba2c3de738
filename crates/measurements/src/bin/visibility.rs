//! Errors of hidden point removal against rays on a mesh, and the time it takes:
//! `cargo run --release -p measurements --bin visibility -- MESH.obj`.

use cloud_param::{Sharpness, View, visible_points};
use mesh_core::{MeshProjector, TriangleMesh, sample_uniform};
use nalgebra::{Point3, Vector3};
use std::error::Error;
use std::time::Instant;

fn read(path: &str) -> Result<TriangleMesh, Box<dyn Error>> {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for line in std::fs::read_to_string(path)?.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"v") => points.push(Point3::new(words[1].parse()?, words[2].parse()?, words[3].parse()?)),
            Some(&"f") => {
                let corner = |k: usize| -> Result<u32, Box<dyn Error>> {
                    Ok(words[k].split('/').next().unwrap_or("").parse::<u32>()? - 1)
                };
                triangles.push([corner(1)?, corner(2)?, corner(3)?]);
            }
            _ => {}
        }
    }
    Ok(TriangleMesh::new(points, triangles)?)
}

/// Whether nothing of the mesh lies before the point.
fn truth(
    mesh: &MeshProjector,
    point: &Point3<f64>,
    towards: &Vector3<f64>,
    size: f64,
) -> Result<bool, Box<dyn Error>> {
    // From outside: the first hit on the way is the point itself.
    let start = point + towards * (10.0 * size);
    let hit = mesh.nearest_on_line(&start, &-towards)?;
    Ok(hit.is_none_or(|hit| hit.offset.abs() > 10.0 * size * (1.0 - 1e-7)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give a mesh (OBJ)")?;
    let mesh = read(&path)?;
    let projector = MeshProjector::new(&mesh)?;
    let (low, high) = mesh
        .vertices()
        .iter()
        .fold((mesh.vertices()[0], mesh.vertices()[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let (centre, size) = (nalgebra::center(&low, &high), (high - low).norm());
    println!("  points view          sharpness   radius  false visible %  false hidden %  seconds");
    let most = std::env::args().nth(2).map_or(Ok(1_000_000), |n| n.parse())?;
    for count in [2_000, 35_000, 200_000, 1_000_000].into_iter().filter(|&n| n <= most) {
        let points: Vec<Vector3<f64>> =
            sample_uniform(&mesh, count, 1)?.iter().map(|s| s.point.coords).collect();
        for direction in
            [Vector3::new(0.3, 0.2, 1.0), Vector3::new(1.0, 0.1, 0.0), Vector3::new(-0.5, 0.7, -0.6)]
        {
            let towards = direction.normalize();
            let eye = centre.coords + towards * (2.0 * size);
            for perspective in [false, true] {
                let step = count.div_ceil(20_000);
                let sampled: Vec<usize> = (0..count).step_by(step).collect();
                let seen: Vec<bool> = sampled
                    .iter()
                    .map(|&i| {
                        let to = if perspective { (eye - points[i]).normalize() } else { towards };
                        truth(&projector, &points[i].into(), &to, size)
                    })
                    .collect::<Result<_, _>>()?;
                let view = if perspective { View::From(eye) } else { View::Along(-towards) };
                for sharpness in
                    [0.5, 0.72, 1.0].map(Sharpness::Automatic).into_iter().chain([Sharpness::Radius(316.0)])
                {
                    let began = Instant::now();
                    let found = visible_points(&points, view, sharpness)?;
                    let seconds = began.elapsed().as_secs_f64();
                    let share = |wanted: bool| {
                        let wrong = sampled
                            .iter()
                            .zip(&seen)
                            .filter(|&(&i, &s)| s != wanted && found.visible[i] == wanted)
                            .count();
                        100.0 * wrong as f64 / sampled.len() as f64
                    };
                    println!(
                        "{count:8} {} {sharpness:?} {:9.0} {:12.2} {:14.2} {seconds:12.3}",
                        if perspective { "point    " } else { "direction" },
                        found.radius,
                        share(true),
                        share(false)
                    );
                }
            }
        }
    }
    Ok(())
}
