//! Speed and truth of the certified search on nine kinds of shape, singular places included.
//!
//! Prints per kind and set of queries: wrong answers, microseconds per query (mean, 99.9 %, slowest; of each query the
//! fastest of several runs, one thread), the largest excess over the true distance and the largest certified gap
//! (both as a share of the distance), and the answers without convergence. The true distance comes from closed
//! forms, or from dense samples that are refined by a pattern search. `jets` is the mean as a multiple of one evaluation of
//! point and derivatives of a bicubic surface in the same run, which is what other machines can be compared by.
//!
//! `kinds [COUNT [REPEATS [NAME [SET]]]]`: queries per set (default 500), runs per query (default 7), kinds whose name
//! contains NAME, and of these the set SET alone (`on`, `near`, …), with its slowest query.

mod samples;
mod shapes;

use footpoint::{CurveProjector, Status, SurfaceProjector};
use measurements::random::Random;
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Circle, Cylinder, Frame, Interval, ParametricCurve, ParametricSurface,
    Sphere, Torus,
};
use samples::{dense, diagonal, refined, with_ends};
use shapes::{cubic, fan, helix, paper, wavy};
use std::error::Error;
use std::time::Instant;

/// The true distance of a point, in closed form.
type Distance<'a, const D: usize> = dyn Fn(&SVector<f64, D>) -> f64 + 'a;
type Outcome<T> = Result<T, Box<dyn Error>>;

/// Shares of the diagonal by which queries are moved away from singular places.
const OFFSETS: [f64; 8] = [0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2];

/// What one answer looks like to the judge.
struct Answer {
    distance: f64,
    bound: f64,
    status: Status,
    /// Inside the domain, and as far as it says.
    consistent: bool,
    note: String,
}

fn main() -> Outcome<()> {
    let argument = |i: usize| std::env::args().nth(i);
    let count = argument(1).map_or(Ok(500), |a| a.parse())?;
    let repeats = argument(2).map_or(Ok(7), |a| a.parse())?;
    let only = argument(3).unwrap_or_default();
    let run = Run { count, repeats, set: argument(4), jet: jet_seconds(&wavy()?) };
    println!("one jet of a bicubic surface: {:.0} ns", run.jet * 1e9);
    println!(
        "{:20} {:>6} {:>5} {:>8} {:>6} {:>8} {:>8} {:>9} {:>9} {:>7}",
        "set", "points", "wrong", "mean", "jets", "99.9 %", "slowest", "excess", "gap", "stalled"
    );
    let circle = Circle::new(Vector2::new(1.0, 2.0), 3.0)?;
    let sphere = Sphere::new(Frame::WORLD, 2.0)?;
    let torus = Torus::new(Frame::WORLD, 3.0, 1.0)?;
    let cylinder = Cylinder::new(Frame::WORLD, 1.5, Interval::new(-1.0, 3.0)?)?;
    let axis = |v: f64| Vector3::new(0.0, 0.0, v);
    let heights = || (-20..=20).map(move |k| axis(0.25 * f64::from(k)));
    let wanted = |name: &str| name.contains(&only);
    if wanted("c_cubic") {
        run.curve("c_cubic", &cubic()?, None, &[])?;
    }
    if wanted("c_helix") {
        run.curve(
            "c_helix",
            &helix()?,
            None,
            &(0..20).map(|k| axis(0.3 * f64::from(k))).collect::<Vec<_>>(),
        )?;
    }
    if wanted("c_circle") {
        let truth = |x: &Vector2<f64>| circle.footpoint(x).distance;
        run.curve("c_circle", &circle.to_nurbs()?, Some(&truth), &[circle.centre()])?;
    }
    if wanted("s_paper") {
        run.surface("s_paper", &paper()?, None, &[])?;
    }
    if wanted("s_wavy") {
        run.surface("s_wavy", &wavy()?, None, &[])?;
    }
    if wanted("s_torus") {
        let ring = (0..40).map(|k| 3.0 * Vector3::new(f64::from(k).cos(), f64::from(k).sin(), 0.0));
        let places: Vec<_> = heights().chain(ring).collect();
        run.surface("s_torus", &torus.to_nurbs()?, Some(&|x| torus.footpoint(x).distance), &places)?;
    }
    if wanted("s_sphere") {
        let places: Vec<_> = heights().chain([axis(2.0), axis(-2.0), axis(0.0), axis(0.0)]).collect();
        run.surface("s_sphere", &sphere.to_nurbs()?, Some(&|x| sphere.footpoint(x).distance), &places)?;
    }
    if wanted("s_cylinder") {
        let truth = |x: &Vector3<f64>| cylinder.footpoint(x).distance;
        run.surface("s_cylinder", &cylinder.to_nurbs()?, Some(&truth), &heights().collect::<Vec<_>>())?;
    }
    if wanted("s_fan") {
        let places: Vec<_> = heights().chain([axis(2.0); 40]).collect();
        run.surface("s_fan", &fan()?, None, &places)?;
    }
    Ok(())
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

struct Run {
    count: usize,
    repeats: usize,
    /// The set that is run, all if none.
    set: Option<String>,
    /// Seconds for one jet.
    jet: f64,
}

impl Run {
    fn curve<const D: usize>(
        &self,
        name: &str,
        curve: &BsplineCurve<D>,
        truth: Option<&Distance<'_, D>>,
        places: &[SVector<f64, D>],
    ) -> Outcome<()> {
        let start = Instant::now();
        let projector = CurveProjector::new(curve);
        let build = start.elapsed().as_secs_f64() * 1e6;
        let pieces = projector.piece_count();
        println!(
            "{name}: {pieces} pieces, {:.1} µs, {} bytes each",
            build / pieces as f64,
            projector.memory() / pieces
        );
        let size = diagonal(curve.control_points());
        let domain = curve.domain();
        let breaks = with_ends(curve.breaks(), &domain);
        let samples = dense(&breaks, 40);
        let points: Vec<_> = samples.iter().map(|&t| curve.point(t)).collect();
        let oracle = |x: &SVector<f64, D>| match truth {
            Some(truth) => truth(x),
            None => refined(&points, &[samples.clone(), vec![0.0]], x, &|at| curve.point(at[0])),
        };
        let mut random = Random(2005);
        for set in SETS.into_iter().filter(|set| self.set.as_deref().is_none_or(|only| only == *set)) {
            let queries: Vec<_> = (0..self.count)
                .map(|i| {
                    let t = domain.lerp(random.unit());
                    let jet = curve.jet(t);
                    let side: SVector<f64, D> = random.direction();
                    let normal = (side - jet.d1 * (side.dot(&jet.d1) / jet.d1.norm_squared())).normalize();
                    match set {
                        "on" => jet.point,
                        "near" => jet.point + normal * random.between(-0.01, 0.01) * size,
                        "mid" => jet.point + normal * random.between(0.05, 0.25) * size,
                        "far" => jet.point + side * random.between(1.5, 4.0) * size,
                        "beyond" => {
                            let end = curve.jet(random.pick(&[domain.start(), domain.end()]));
                            end.point + side * random.between(0.0, 0.25) * size
                        }
                        _ => {
                            // Centres of curvature, the places of the kind, break points.
                            let bend = jet.d2 - jet.d1 * (jet.d2.dot(&jet.d1) / jet.d1.norm_squared());
                            let centre = jet.point + bend * (jet.d1.norm_squared() / bend.norm_squared());
                            let place = match i % 3 {
                                0 if !places.is_empty() => random.pick(places),
                                2 => curve.point(random.pick(&breaks)),
                                _ => centre,
                            };
                            place + side * random.pick(&OFFSETS) * size
                        }
                    }
                })
                .collect();
            let answer = |x: &SVector<f64, D>| {
                let foot = projector.project(x);
                let gap = ((curve.point(foot.parameter) - x).norm() - foot.distance).abs();
                Answer {
                    distance: foot.distance,
                    bound: foot.lower_bound,
                    status: foot.status,
                    consistent: domain.contains(foot.parameter) && gap <= 1e-12 * (size + foot.distance),
                    note: format!("{foot:?}"),
                }
            };
            self.judge(
                &format!("{name}.{set}"),
                size,
                &queries,
                &|x| projector.project(x).distance,
                &answer,
                &oracle,
            );
        }
        Ok(())
    }

    fn surface(
        &self,
        name: &str,
        surface: &BsplineSurface,
        truth: Option<&Distance<'_, 3>>,
        places: &[Vector3<f64>],
    ) -> Outcome<()> {
        let mut build = f64::INFINITY;
        for _ in 0..self.repeats {
            let start = Instant::now();
            std::hint::black_box(SurfaceProjector::new(surface));
            build = build.min(start.elapsed().as_secs_f64() * 1e6);
        }
        let projector = SurfaceProjector::new(surface);
        let n = projector.patch_count();
        println!("{name}: {n} patches, {:.1} µs, {} bytes each", build / n as f64, projector.memory() / n);
        let size = diagonal(surface.control_points());
        let domain = surface.domain();
        let [u, v] = surface.breaks();
        let breaks = [with_ends(u, &domain[0]), with_ends(v, &domain[1])];
        let samples = [dense(&breaks[0], 6), dense(&breaks[1], 6)];
        let points: Vec<_> = (samples[0].iter())
            .flat_map(|&u| samples[1].iter().map(move |&v| [u, v]))
            .map(|[u, v]| surface.point(u, v))
            .collect();
        let oracle = |x: &Vector3<f64>| match truth {
            Some(truth) => truth(x),
            None => refined(&points, &samples, x, &|at| surface.point(at[0], at[1])),
        };
        let mut random = Random(2005);
        for set in SETS.into_iter().filter(|set| self.set.as_deref().is_none_or(|only| only == *set)) {
            let queries: Vec<_> = (0..self.count)
                .map(|i| {
                    let mut at = [0, 1].map(|d| domain[d].lerp(random.unit()));
                    if set == "beyond" {
                        let d = random.pick(&[0, 1]);
                        at[d] = random.pick(&[domain[d].start(), domain[d].end()]);
                        if random.unit() < 0.25 {
                            at[1 - d] = domain[1 - d].start();
                        }
                    }
                    let jet = surface.jet(at[0], at[1]);
                    let side: Vector3<f64> = random.direction();
                    let normal = jet.du.cross(&jet.dv).normalize();
                    match set {
                        "on" => jet.point,
                        "near" => jet.point + normal * random.between(-0.01, 0.01) * size,
                        "mid" => {
                            jet.point + normal * random.between(0.05, 0.25) * random.pick(&[-1.0, 1.0]) * size
                        }
                        "far" => jet.point + side * random.between(1.5, 4.0) * size,
                        "beyond" => jet.point + side * random.between(0.0, 0.25) * size,
                        _ => {
                            // Centres of curvature, the places of the kind, knots and corners.
                            let (e, second) = (jet.du.norm_squared(), jet.duu.dot(&normal));
                            let centre = jet.point + normal * (e / second);
                            let place = match i % 3 {
                                0 | 1 if !places.is_empty() => random.pick(places),
                                2 => surface.point(random.pick(&breaks[0]), random.pick(&breaks[1])),
                                _ if (e / second).abs() < size => centre,
                                _ => jet.point,
                            };
                            place + side * random.pick(&OFFSETS) * size
                        }
                    }
                })
                .collect();
            let answer = |x: &Vector3<f64>| {
                let foot = projector.project(x);
                let [u, v] = foot.parameter;
                let gap = ((surface.point(u, v) - x).norm() - foot.distance).abs();
                let inside = domain[0].contains(u) && domain[1].contains(v);
                Answer {
                    distance: foot.distance,
                    bound: foot.lower_bound,
                    status: foot.status,
                    consistent: inside && gap <= 1e-12 * (size + foot.distance),
                    note: format!("{foot:?}"),
                }
            };
            self.judge(
                &format!("{name}.{set}"),
                size,
                &queries,
                &|x| projector.project(x).distance,
                &answer,
                &oracle,
            );
        }
        Ok(())
    }

    fn judge<const D: usize>(
        &self,
        name: &str,
        size: f64,
        queries: &[SVector<f64, D>],
        project: &dyn Fn(&SVector<f64, D>) -> f64,
        answer: &dyn Fn(&SVector<f64, D>) -> Answer,
        oracle: &dyn Fn(&SVector<f64, D>) -> f64,
    ) {
        let mut seconds = vec![f64::INFINITY; queries.len()];
        for _ in 0..self.repeats {
            for (x, best) in queries.iter().zip(&mut seconds) {
                let start = Instant::now();
                std::hint::black_box(project(x));
                *best = best.min(start.elapsed().as_secs_f64());
            }
        }
        let (mut wrong, mut stalled, mut excess, mut gap) = (0, 0, 0.0f64, 0.0f64);
        for (i, x) in queries.iter().enumerate() {
            let (found, truth) = (answer(x), oracle(x));
            let far = found.distance.is_nan() || found.distance > truth * (1.0 + 1e-6) + 1e-9 * size;
            let broken = found.bound > truth * (1.0 + 1e-12) + 1e-12 * size;
            if far || broken || !found.consistent {
                wrong += 1;
                println!("  {name} {i}: {x:?} is {truth} away, not {}", found.note);
            }
            if !found.status.is_converged() {
                stalled += 1;
                println!("  {name} {i}: {x:?}: {}", found.note);
            }
            let unit = found.distance.max(1e-3 * size);
            excess = excess.max((found.distance - truth) / unit);
            gap = gap.max((found.distance - found.bound) / unit);
        }
        let mean = seconds.iter().sum::<f64>() / seconds.len() as f64;
        let slowest = (0..seconds.len()).max_by(|&a, &b| seconds[a].total_cmp(&seconds[b])).unwrap_or(0);
        let at = seconds[slowest];
        seconds.sort_by(f64::total_cmp);
        let high = seconds[(seconds.len() - 1) * 999 / 1000];
        println!(
            "{name:20} {:6} {wrong:5} {:8.2} {:6.1} {:8.1} {:8.1} {excess:9.1e} {gap:9.1e} {stalled:7}",
            queries.len(),
            mean * 1e6,
            mean / self.jet,
            high * 1e6,
            at * 1e6,
        );
        if self.set.is_some() {
            println!(
                "  slowest {slowest}: {:?} {}",
                queries[slowest].as_slice(),
                answer(&queries[slowest]).note
            );
        }
    }
}

const SETS: [&str; 6] = ["on", "near", "mid", "far", "beyond", "singular"];
