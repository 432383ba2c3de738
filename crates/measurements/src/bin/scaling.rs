//! Height fields, hidden points and the whole way of clouds from 28 thousand to a million points, with the time of each stage and how it
//! grows per point:
//! `cargo run --release -p measurements --bin scaling [-- MOST]`.

use cloud_param::{
    FitOptions, MultilevelOptions, ParameteriseOptions, Sharpness, View, fit_parameters, multilevel,
    parameterise, visible_points,
};
use nalgebra::Vector3;
use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

const COUNTS: [u32; 4] = [28_000, 64_000, 250_000, 1_000_000];

/// A vase with five lobes and some noise, its points in no order.
fn vase(count: u32) -> Vec<Vector3<f64>> {
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut point = |i: u32| {
        let (a, h) =
            (TAU * (f64::from(i) * 0.754_877_666_246).fract(), (f64::from(i) * 0.569_840_290_998).fract());
        let radius = 60.0 + 12.0 * (5.0 * h).sin() + 9.0 * (5.0 * a + 2.0 * h).cos();
        let mut noise = || 0.15 * (0..12).map(|_| random()).sum::<f64>();
        Vector3::new(radius * a.cos() + noise(), radius * a.sin() + noise(), 240.0 * h + noise())
    };
    (0..count).map(&mut point).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let most = std::env::args().nth(1).map_or(Ok(u32::MAX), |n| n.parse())?;
    let counts = || COUNTS.into_iter().filter(|&n| n <= most);
    for count in counts() {
        let points = vase(count);
        // A wavy height field, met within a thousandth.
        let place = |i: u32| [0.754_877_666_246, 0.569_840_290_998].map(|step| (f64::from(i) * step).fract());
        let field = |[x, y]: [f64; 2]| (7.0 * x).sin() * (5.0 * y).cos() + 0.1 * (40.0 * x * y).sin();
        let data: Vec<Vector3<f64>> =
            (0..count).map(place).map(|p| Vector3::new(p[0], p[1], field(p))).collect();
        let began = Instant::now();
        let (_, report) = multilevel(&data, None, &MultilevelOptions::default().with_tolerance(1e-3))?;
        let heights = began.elapsed().as_secs_f64();
        let began = Instant::now();
        let seen = visible_points(&points, View::Along(-Vector3::x()), Sharpness::default())?;
        println!(
            "{count:8} points: height field {heights:.3} s, {} levels, rms {:.1e}; hidden points {:.3} s, {} visible",
            report.history.len(),
            report.rms,
            began.elapsed().as_secs_f64(),
            seen.count()
        );
    }
    let mut first: Option<f64> = None;
    for count in counts() {
        let points = vase(count);
        let began = Instant::now();
        let found = parameterise(&points, &ParameteriseOptions::default())?;
        let parameters = began.elapsed().as_secs_f64();
        let began = Instant::now();
        let options = FitOptions { control_points: [55, 55], ..FitOptions::default() };
        let fit = fit_parameters(&points, &found.base, &found.feet, &found.counts, &options)?;
        let fitted = began.elapsed().as_secs_f64();
        let per_point = (parameters + fitted) / f64::from(count);
        let ratio = per_point / *first.get_or_insert(per_point);
        let stages: Vec<String> =
            found.report.times.iter().map(|t| format!("{} {:.2}", t.stage.name(), t.seconds)).collect();
        println!(
            "{count:8} points: {:.2} s, {:.2} us per point ({ratio:.2} of the first); {}, fit 55 x 55 {fitted:.2}; rms {:.4}, {}",
            parameters + fitted,
            1e6 * per_point,
            stages.join(", "),
            fit.rms,
            found.report
        );
    }
    Ok(())
}
