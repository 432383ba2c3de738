//! Clouds without parameters on the whole way to fitted surfaces, with nets of the sizes of [MPK, Figs. 7-9].
//!
//! ```sh
//! cargo run --release -p measurements --bin scans [-- FILE SAMPLES LAYERS N_U N_V]
//! ```
//! Without arguments the shipped scans and a vase of two sizes are taken; with them one more file. A base surface through SAMPLES
//! points of each of LAYERS curves around the axis is made from the cloud alone, then a least squares surface with `N_U × N_V`
//! control points, and then squared distances are minimised. Printed are root mean square distances: of the samples of the base curves from
//! the points nearest to them (`nearest`), and orthogonal ones of the points from the base surface, the least squares surface, and the
//! finished one, whose largest distance follows; loops and crossovers of the base surface before they were smoothed away and after,
//! folds of the finished surface; and seconds for the base surface with its parameters, the least squares surface and the finish.

use industrial_geometry::cloud_param::{
    FitOptions, ParameteriseOptions, Shape, finish_fit, finish_options, fit_parameters, parameterise,
};
use industrial_geometry::io::{self, Content, ReadOptions};
use industrial_geometry::mesh::nalgebra::Vector3;
use industrial_geometry::mesh::sample_wide_triangles;
use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::Instant;

/// A cloud and the sizes of its nets.
struct Scan {
    name: String,
    points: Vec<Vector3<f64>>,
    /// Samples of each base curve, and their number; `None` for as many as the cloud asks for.
    base: Option<[usize; 2]>,
    controls: [usize; 2],
}

impl Scan {
    /// The points of a cloud, or the vertices of a mesh and points on triangles that are much larger than others.
    fn read(path: &Path, base: Option<[usize; 2]>, controls: [usize; 2]) -> Result<Self, Box<dyn Error>> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let points = match io::read(path, &ReadOptions::default())?.content {
            Content::Cloud(cloud) => cloud.positions().iter().map(|p| p.coords).collect(),
            Content::Mesh(mesh) => {
                let between = sample_wide_triangles(&mesh, 1)?;
                let between = between.iter().map(|sample| sample.point.coords);
                mesh.vertices().iter().map(|p| p.coords).chain(between).collect()
            }
            Content::Nurbs(_) => return Err(format!("{}: a model, not points", path.display()).into()),
        };
        Ok(Self { name, points, base, controls })
    }

    /// A vase with five lobes and noise, its points in no order.
    fn vase(count: u32, base: [usize; 2], controls: [usize; 2]) -> Self {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut point = |i: u32| {
            let a = TAU * (f64::from(i) * 0.754_877_666_246).fract();
            let h = (f64::from(i) * 0.569_840_290_998).fract();
            let radius = 60.0 + 12.0 * (5.0 * h).sin() + 9.0 * (5.0 * a + 2.0 * h).cos();
            // The sum of twelve has the variance 1.
            let mut noise = || 0.15 * (0..12).map(|_| random()).sum::<f64>();
            Vector3::new(radius * a.cos() + noise(), radius * a.sin() + noise(), 240.0 * h + noise())
        };
        let points = (0..count).map(&mut point).collect();
        Self { name: format!("vase, noise .15, {count}"), points, base: Some(base), controls }
    }

    fn run(&self) -> Result<(), Box<dyn Error>> {
        let clock = Instant::now();
        let options = ParameteriseOptions::default().with_shape(Shape::Cylinder);
        let options = match self.base {
            Some([samples, layers]) => options.with_grid(samples, layers),
            None => options,
        };
        let found = parameterise(&self.points, &options)?;
        let base = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let options = FitOptions { control_points: self.controls, ..FitOptions::default() };
        let fitted = fit_parameters(&self.points, &found.base, &found.feet, &found.counts, &options)?;
        let fit = clock.elapsed().as_secs_f64();
        let least_squares = fitted.rms;
        let clock = Instant::now();
        let (done, finish) =
            finish_fit(&self.points, &found.counts, fitted, &finish_options(self.points.len()))?;
        let report = &found.report;
        let before = report.refine_history.last().map_or(report.defects, |step| step.defects);
        println!(
            "{:22} {:6} {:>7} {:>6} {:7.3} {:7.4} {:7.4} {:7.4} {:7.3} {:>8} {:>8} {:>5} {:5.1} {:4.1} {:5.1}  {}, {}",
            self.name,
            self.points.len(),
            format!("{}x{}", report.grid[1], report.grid[0]),
            format!("{}x{}", self.controls[0], self.controls[1]),
            report.curve_history.last().map_or(f64::NAN, |step| step.rms),
            report.rms,
            least_squares,
            done.rms,
            done.max,
            format!("{}/{}", before.self_loops, before.crossovers),
            format!("{}/{}", report.defects.self_loops, report.defects.crossovers),
            finish.defects[1].crossovers,
            base,
            fit,
            clock.elapsed().as_secs_f64(),
            report.status.name(),
            finish.outcome.name(),
        );
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let scans = if let [path, sizes @ ..] = &arguments[..] {
        let sizes = sizes.iter().map(|size| size.parse()).collect::<Result<Vec<usize>, _>>()?;
        let &[samples, layers, n_u, n_v] = &sizes[..] else {
            return Err("give a file and four numbers: samples, layers, control points in u and in v".into());
        };
        vec![Scan::read(Path::new(path), Some([samples, layers]), [n_u, n_v])?]
    } else {
        vec![
            Scan::read(&fixtures.join("fit-cases/c_bunny_trunk.xyz"), Some([110, 24]), [30, 30])?,
            Scan::read(&fixtures.join("scans/stud-bolt.ply"), Some([35, 43]), [30, 60])?,
            Scan::read(&fixtures.join("scans/engine-blade.ply"), None, [39, 39])?,
            Scan::vase(28_000, [120, 37], [39, 39]),
            Scan::vase(64_000, [101, 51], [55, 55]),
        ]
    };
    println!(
        "{:22} {:>6} {:>7} {:>6} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8} {:>8} {:>5} {:>5} {:>4} {:>5}  base, finish",
        "cloud",
        "points",
        "base",
        "net",
        "nearest",
        "surface",
        "fit",
        "finish",
        "max",
        "before",
        "after",
        "folds",
        "s",
        "s",
        "s"
    );
    scans.iter().try_for_each(Scan::run)
}
