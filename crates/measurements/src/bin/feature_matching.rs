//! Registration from far: with nearest points alone, and after matching by position and normal in R⁶.

#![allow(clippy::print_stdout, reason = "a program that prints its results")]

use distance_field::MeshField;
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use sdm_register::start::OrientedPoints;
use sdm_register::{FeatureMatching, Pose, RegisterOptions, Source, register, rotation};

type Failure = Box<dyn std::error::Error>;

/// Widths as shares of the diagonal; 0 matches positions alone.
const WIDTHS: [f64; 5] = [0.0, 0.1, 0.3, 1.0, 3.0];
/// Turns in degrees, and shifts as shares of the diagonal.
const OFFSETS: [(f64, f64); 8] =
    [(30.0, 0.1), (60.0, 0.1), (90.0, 0.1), (150.0, 0.1), (15.0, 0.6), (30.0, 0.6), (60.0, 0.6), (90.0, 0.6)];
/// Starts for each offset and shape.
const STARTS: usize = 12;
/// Points of a cloud, and their noise as a share of the diagonal.
const POINTS: usize = 600;
const NOISE: f64 = 1e-3;
/// Root mean square displacement, as a share of the diagonal, up to which a pose is the true one.
const RIGHT: f64 = 0.01;

/// Random numbers that are the same on every run.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 ^ (self.0 >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn gauss(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.gauss())
    }
}

/// The surface over a floor of given width whose height changes from step to step: `(end along x, height)`.
fn stairs(steps: &[(f64, f64)], width: f64) -> Result<TriangleMesh, Failure> {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    let mut square = |corners: [[f64; 3]; 4]| -> Result<(), Failure> {
        let first = u32::try_from(points.len())?;
        points.extend(corners.map(Point3::from));
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        Ok(())
    };
    let mut from = (0.0f64, 0.0f64);
    for &(to, height) in steps.iter().chain([&(steps.last().map_or(0.0, |step| step.0), 0.0)]) {
        let (x, before, w) = (from.0, from.1, width);
        // The riser, facing the lower side.
        let (low, high) = (before.min(height), before.max(height));
        if height > before {
            square([[x, w, low], [x, 0.0, low], [x, 0.0, high], [x, w, high]])?;
        } else {
            square([[x, 0.0, low], [x, w, low], [x, w, high], [x, 0.0, high]])?;
        }
        if to > x {
            let h = height;
            square([[x, 0.0, h], [to, 0.0, h], [to, w, h], [x, w, h]])?;
            square([[x, w, 0.0], [to, w, 0.0], [to, 0.0, 0.0], [x, 0.0, 0.0]])?;
            square([[x, 0.0, 0.0], [to, 0.0, 0.0], [to, 0.0, h], [x, 0.0, h]])?;
            square([[to, w, 0.0], [x, w, 0.0], [x, w, h], [to, w, h]])?;
        }
        from = (to, height);
    }
    Ok(TriangleMesh::new(points, triangles)?)
}

/// Shapes with edges: without a symmetry that a rotation has.
fn shapes() -> Result<Vec<(&'static str, TriangleMesh)>, Failure> {
    let bracket = stairs(&[(0.3, 2.0), (3.0, 0.3)], 1.4)?;
    let block = stairs(&[(1.0, 0.5), (1.8, 1.3), (2.2, 0.7), (3.0, 1.0)], 1.6)?;
    let channel = stairs(&[(0.08, 1.5), (2.0, 0.08), (2.08, 1.0)], 2.8)?;
    Ok(vec![("bracket", bracket), ("stepped block", block), ("thin channel", channel)])
}

fn main() -> Result<(), Failure> {
    println!(
        "share of {STARTS} random starts per column that lead to the true pose; turn in degrees, shift and w as shares of the diagonal, - without matching"
    );
    let head: String =
        OFFSETS.iter().map(|(turn, shift)| format!("{:>9}", format!("{turn}/{shift}"))).collect();
    println!("{:14} {:>4} {head}     all", "shape", "w");
    for (name, mesh) in shapes()? {
        let bounds = mesh.bounding_box().ok_or("a shape has no box")?;
        let diagonal = bounds.diagonal();
        let field = MeshField::new(&mesh)?;
        let samples = OrientedPoints::from_mesh(&mesh, 20_000);
        let mut random = Random(7);
        // Points in no order, with the normals of their faces.
        let drawn = OrientedPoints::from_mesh(&mesh, POINTS);
        let points: Vec<Vector3<f64>> =
            drawn.points().iter().map(|x| x + random.vector() * (NOISE * diagonal)).collect();
        let cloud = OrientedPoints::new(&points, drawn.normals())?;
        let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let mut starts = Vec::new();
        for (turn, shift) in OFFSETS {
            for _ in 0..STARTS {
                let axis = random.vector().normalize() * turn.to_radians();
                let shift = random.vector().normalize() * (shift * diagonal);
                starts.push(Pose {
                    scale: 1.0,
                    rotation: rotation::exponential::<3>(&axis).0,
                    source_origin: centre,
                    target_origin: centre + shift,
                });
            }
        }
        let off = |pose: &Pose<3>| {
            let sum: f64 = points.iter().map(|x| (pose.apply(x) - x).norm_squared()).sum();
            (sum / points.len() as f64).sqrt() / diagonal
        };
        let source = Source::new(&points).with_normals(drawn.normals());
        let options = RegisterOptions::default();
        for width in std::iter::once(None).chain(WIDTHS.map(Some)) {
            let matching = width.map(|w| FeatureMatching::new(&samples, w * diagonal, true)).transpose()?;
            let mut good = [0usize; OFFSETS.len()];
            for (k, start) in starts.iter().enumerate() {
                let begin = match &matching {
                    Some(matching) => matching.approach(&cloud, start)?.pose,
                    None => *start,
                };
                let found = register(&field, &source, &begin, &options)?;
                good[k / STARTS] += usize::from(off(&found.pose) < RIGHT);
            }
            let row: String =
                good.iter().map(|good| format!("{:>8.0}%", 100.0 * *good as f64 / STARTS as f64)).collect();
            let all = 100.0 * good.iter().sum::<usize>() as f64 / starts.len() as f64;
            let width = width.map_or_else(|| "-".to_owned(), |w| format!("{w}"));
            println!("{name:14} {width:>4} {row} {all:>6.0}%");
        }
    }
    Ok(())
}
