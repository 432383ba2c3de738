//! The trunk and the vase.

use crate::{METHODS, courses, header, verdict};
use measurements::cases::{Outcome, cpu, fixture, points};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface};
use sdm_fit::{BaseShape, NetSize, Smoothing, SurfaceOptions, fit_cloud, fit_surface, initial_surface};
use std::f64::consts::TAU;
use std::time::Instant;

const SHOWN: [usize; 5] = [1, 2, 5, 10, 20];
/// Noise of the vase, as of a scanner.
const NOISE: f64 = 0.15;

pub(crate) fn all() -> Outcome<()> {
    let trunk = points::<3>(&fixture("fit-cases/c_bunny_trunk.xyz"))?;
    let size = NetSize { controls: [30, 30], ..NetSize::default() };
    let clock = Instant::now();
    let start = initial_surface(&trunk, BaseShape::Auto, size)?;
    println!(
        "c trunk, {} points, 30 x 30 control points over a {} ({:.2} s): rms after iterations",
        trunk.len(),
        start.base,
        clock.elapsed().as_secs_f64()
    );
    println!("{}", header(&SHOWN));
    for (name, smoothing) in
        [("smoothing to 0", Smoothing::CONTINUATION), ("by the data", Smoothing::default())]
    {
        println!("  {name}");
        for (method, term, control) in METHODS {
            let mut options = SurfaceOptions::default();
            options.fit = options
                .fit
                .with_term(term)
                .with_control(control)
                .with_smoothing(smoothing)
                .with_max_iterations(20);
            let before = cpu();
            let found = fit_surface(&trunk, start.surface.clone(), &options)?;
            let seconds = (cpu() - before) / found.report.fit.history.len().max(1) as f64;
            println!(
                "{}, folds {}, seam {:.0e} {:.0e} {:.0e}, {seconds:.3} s of CPU per iteration",
                courses(method, &found.report.fit, &SHOWN),
                found.report.folds.count(),
                seam(&found.surface, 0),
                seam(&found.surface, 1),
                seam(&found.surface, 2)
            );
            if method == "SDM" {
                verdict("rms", found.report.fit.rms, 0.11);
                verdict("folded cells", found.report.folds.count() as f64, 0.0);
                verdict("gap at the seam", seam(&found.surface, 0), 1e-9);
                verdict("seconds of CPU per iteration", seconds, 0.25);
            }
            if method == "PDM" {
                verdict("seconds of CPU per iteration", seconds, 0.07);
            }
        }
    }
    let mut random = Random::new(7);
    let scan: Vec<Vector3<f64>> = (0..28_384)
        .map(|_| {
            let place = vase(TAU * random.uniform(), random.uniform());
            place + Vector3::new(random.normal(), random.normal(), random.normal()) * NOISE
        })
        .collect();
    for controls in [[20, 20], [30, 30], [40, 40]] {
        let size = NetSize { controls, ..NetSize::default() };
        let found = fit_cloud(&scan, &SurfaceOptions::default().with_size(size))?;
        println!("d vase, {} points, noise {NOISE}, smoothing by the data: {}", scan.len(), found.report);
        let (rms, max, [u, v]) = deviation(&found.surface);
        println!("  furthest from the truth at {u:.2} of u, {v:.2} of v");
        verdict("distance to the truth, rms", rms, 0.045);
        verdict("distance to the truth, largest", max, 0.3);
        verdict("folded cells", found.report.folds.count() as f64, 0.0);
    }
    Ok(())
}

/// Largest jump of a derivative across the seam, relative to its size.
fn seam(surface: &BsplineSurface, order: usize) -> f64 {
    let [u, v] = surface.domain();
    let jump = |k: i32| {
        let v = v.lerp(f64::from(k) / 40.0);
        let a = surface.derivatives(u.start(), v, order)[order][0];
        let b = surface.derivatives(u.end() - 1e-14 * u.length(), v, order)[order][0];
        (a - b).norm() / (1.0 + a.norm())
    };
    (0..=40).map(jump).fold(0.0, f64::max)
}

/// A lobed vase, 247 high.
fn vase(angle: f64, height: f64) -> Vector3<f64> {
    let r = radius(angle, height);
    Vector3::new(r * angle.cos(), r * angle.sin(), 247.0 * height)
}

fn radius(angle: f64, height: f64) -> f64 {
    60.0 * (1.0
        + 0.25 * (3.0 * height + 0.4).sin()
        + 0.12 * (5.0 * angle + 2.0 * height).cos() * (0.3 + height))
}

/// Distance of a surface from the vase, rms and largest, and where: the difference in radius times the cosine of the slope.
fn deviation(surface: &BsplineSurface) -> (f64, f64, [f64; 2]) {
    let [u, v] = surface.domain();
    let (mut sum, mut max, mut at) = (0.0, 0.0, [0.0; 2]);
    let n = 150;
    for k in 0..n * n {
        let place = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
        let p = surface.point(u.lerp(place(k / n)), v.lerp(place(k % n)));
        let (angle, height) = (p.y.atan2(p.x), p.z / 247.0);
        let (rho, r, e) = (p.x.hypot(p.y), radius(angle, height), 1e-5);
        let by_angle = (radius(angle + e, height) - radius(angle - e, height)) / (2.0 * e * rho);
        let by_height = (radius(angle, height + e) - radius(angle, height - e)) / (2.0 * e * 247.0);
        // Beyond the ends the vase goes on as its formula does.
        let distance = (rho - r) / (1.0 + by_angle * by_angle + by_height * by_height).sqrt();
        sum += distance * distance;
        if distance.abs() > max {
            (max, at) = (distance.abs(), [place(k / n), place(k % n)]);
        }
    }
    ((sum / f64::from(n * n)).sqrt(), max, at)
}

/// A sequence without a pattern.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}
