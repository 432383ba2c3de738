//! Truth, certificates and cost of the certified search on shapes that are hard for it.
//!
//! Prints per shape: queries, answers that are wrong (farther than a point that an independent search finds: dense samples,
//! refined; or with a bound above it), certificates that stay open (a gap beyond what the options allow), answers that have
//! not converged, microseconds per query (mean, 99.9 %, slowest; of each query the fastest of several runs, one thread). `jets`
//! is the mean as a multiple of one evaluation of point and derivatives of a bicubic surface in the same run.
//!
//! `constructed [COUNT [REPEATS [NAME]]]`: queries per shape (default 400), runs per query (default 3), shapes whose name
//! contains NAME, then with their slowest query and the means of the eight kinds of query (see [`queries`]).

mod oracle;
mod queries;
mod shapes;

use footpoint::{Mode, ProjectionOptions, SurfaceProjector};
use measurements::random::Random;
use nurbs_core::{BsplineSurface, ParametricSurface};
use oracle::Oracle;
use std::error::Error;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Samples of the independent search in each direction.
const SAMPLES: usize = 120;

fn main() -> Outcome<()> {
    let argument = |i: usize| std::env::args().nth(i);
    let count = argument(1).map_or(Ok(400), |a| a.parse())?;
    let repeats: usize = argument(2).map_or(Ok(3), |a| a.parse())?;
    let only = argument(3);
    let all = shapes::all()?;
    let jet = jet_seconds(&all[0].1);
    println!("one jet of a bicubic surface: {:.0} ns", jet * 1e9);
    println!(
        "{:28} {:>6} {:>5} {:>5} {:>7} {:>8} {:>7} {:>8} {:>8} {:>9}",
        "shape", "points", "wrong", "open", "stalled", "mean", "jets", "99.9 %", "slowest", "build"
    );
    let mut total = Total::default();
    for (name, surface) in &all {
        if only.as_deref().is_none_or(|only| name.contains(only)) {
            run(name, surface, count, repeats, jet, only.is_some(), &mut total);
        }
    }
    let Total { queries, wrong, open, slow } = total;
    println!("{queries} queries: {wrong} wrong, {open} open, {slow} over 1 ms");
    Ok(())
}

#[derive(Default)]
struct Total {
    queries: usize,
    wrong: usize,
    open: usize,
    slow: usize,
}

fn run(
    name: &str,
    surface: &BsplineSurface,
    count: usize,
    repeats: usize,
    jet: f64,
    details: bool,
    total: &mut Total,
) {
    let points = surface.control_points();
    let low = points.iter().fold(points[0], |a, p| a.inf(p));
    let high = points.iter().fold(points[0], |a, p| a.sup(p));
    let size = (high - low).max();
    let queries = queries::queries(surface, size, count);
    let start = Instant::now();
    let projector = SurfaceProjector::new(surface);
    let build = start.elapsed().as_secs_f64();
    let mut seconds = vec![f64::INFINITY; queries.len()];
    for _ in 0..repeats {
        for (x, best) in queries.iter().zip(&mut seconds) {
            let start = Instant::now();
            std::hint::black_box(projector.project(x));
            *best = best.min(start.elapsed().as_secs_f64());
        }
    }
    let options = ProjectionOptions::default();
    let fast = options.with_mode(Mode::Fast);
    let oracle = Oracle::new(surface, SAMPLES);
    // What the coordinates themselves are known to.
    let rounding = 1e-15 * (low.amax().max(high.amax()) + size);
    let (mut wrong, mut open, mut stalled) = (0, 0, 0);
    for (i, x) in queries.iter().enumerate() {
        let found = projector.project(x);
        let truth = oracle
            .distance(x)
            .min(projector.project_with(x, &fast).map_or(f64::INFINITY, |foot| foot.distance));
        let allowed = options.relative_gap * found.distance + options.size_gap * size;
        let far =
            found.distance.is_nan() || found.distance > truth + 1e-7 * truth + 1e-10 * size + 8.0 * rounding;
        let broken = found.lower_bound > truth * (1.0 + 1e-12) + 16.0 * rounding;
        let unproven = found.gap().is_nan() || found.gap() > 2.0 * allowed + 8.0 * rounding;
        wrong += usize::from(far || broken);
        open += usize::from(unproven);
        stalled += usize::from(!found.status.is_converged());
        if far || broken || (details && unproven) {
            println!("  {name} {i}: {:?} is {truth} away: {found:?}", x.as_slice());
        }
    }
    if details {
        print!("  mean by kind of query:");
        for kind in 0..8 {
            let of_kind: Vec<f64> = seconds.iter().copied().skip(kind).step_by(8).collect();
            print!(" {:.1}", of_kind.iter().sum::<f64>() / of_kind.len() as f64 * 1e6);
        }
        println!();
    }
    let mean = seconds.iter().sum::<f64>() / seconds.len() as f64;
    let slowest = (0..seconds.len()).max_by(|&a, &b| seconds[a].total_cmp(&seconds[b])).unwrap_or(0);
    let most = seconds[slowest];
    total.queries += queries.len();
    total.wrong += wrong;
    total.open += open;
    total.slow += seconds.iter().filter(|&&s| s > 1e-3).count();
    seconds.sort_by(f64::total_cmp);
    let high = seconds[(seconds.len() - 1) * 999 / 1000];
    println!(
        "{name:28} {:6} {wrong:5} {open:5} {stalled:7} {:8.2} {:7.1} {:8.1} {:8.1} {:9.1}",
        queries.len(),
        mean * 1e6,
        mean / jet,
        high * 1e6,
        most * 1e6,
        build * 1e6,
    );
    if details {
        println!(
            "  slowest {slowest}: {:?} {:?}",
            queries[slowest].as_slice(),
            projector.project(&queries[slowest])
        );
    }
}

/// Seconds for one jet, the fastest of many runs over places all over the domain.
fn jet_seconds(surface: &BsplineSurface) -> f64 {
    let [u, v] = surface.domain();
    let mut random = Random(1);
    let places: Vec<_> = (0..1000).map(|_| [u.lerp(random.unit()), v.lerp(random.unit())]).collect();
    let mut best = f64::INFINITY;
    for _ in 0..100 {
        let start = Instant::now();
        for &[u, v] in &places {
            std::hint::black_box(surface.jet(u, v));
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    best / places.len() as f64
}
