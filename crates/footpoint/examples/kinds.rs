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

use footpoint::{CurveProjector, Status, SurfaceProjector};
use nalgebra::{SVector, Vector2, Vector3};
use nurbs_core::{
    BsplineCurve, BsplineSurface, Circle, Cylinder, Frame, Interval, KnotVector, ParametricCurve,
    ParametricSurface, Sphere, Torus,
};
use std::error::Error;
use std::time::Instant;

/// The true distance of a point, in closed form.
type Distance<'a, const D: usize> = dyn Fn(&SVector<f64, D>) -> f64 + 'a;
type Outcome<T> = Result<T, Box<dyn Error>>;

/// Shares of the diagonal by which queries are moved away from singular places.
const OFFSETS: [f64; 8] = [0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2];

/// A small generator of pseudo-random numbers (a linear congruence, high bits).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn direction<const D: usize>(&mut self) -> SVector<f64, D> {
        loop {
            let v = SVector::<f64, D>::from_fn(|_, _| self.between(-1.0, 1.0));
            if (0.1..1.0).contains(&v.norm()) {
                return v.normalize();
            }
        }
    }

    fn pick<T: Clone>(&mut self, items: &[T]) -> T {
        let index = usize::try_from(self.next() >> 33).unwrap_or(0) % items.len();
        items[index].clone()
    }
}

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

/// Example 2 of [HW05].
fn cubic() -> Outcome<BsplineCurve<2>> {
    let points = [[100., 100.], [140., 196.], [200., 240.], [260., 164.], [340., 164.], [400., 240.]];
    let points = points.into_iter().chain([[460., 196.], [500., 100.]]).map(Vector2::from).collect();
    Ok(BsplineCurve::new(KnotVector::uniform_clamped(3, 8)?, points, None)?)
}

fn helix() -> Outcome<BsplineCurve<3>> {
    let point = |k: i32| {
        let angle = 0.6 * f64::from(k);
        Vector3::new(2.0 * angle.cos(), 2.0 * angle.sin(), 0.15 * f64::from(k))
    };
    Ok(BsplineCurve::new(KnotVector::uniform_clamped(3, 40)?, (0..40).map(point).collect(), None)?)
}

/// A bicubic surface over a grid of control points.
fn grid(n: [i32; 2], point: impl Fn(i32, i32) -> Vector3<f64>) -> Outcome<BsplineSurface> {
    let points = (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| (i, j))).map(|(i, j)| point(i, j)).collect();
    let knots = |n: i32| KnotVector::uniform_clamped(3, usize::try_from(n).unwrap_or(4));
    Ok(BsplineSurface::new(knots(n[0])?, knots(n[1])?, points, None)?)
}

/// A bicubic surface of the size and liveliness of Example 3 of [HW05].
fn paper() -> Outcome<BsplineSurface> {
    let heights = [
        [-22., -22., 8., -22.],
        [8., 38., 126., 8.],
        [8., -146., -60., 8.],
        [-22., -33., 95., 8.],
        [8., 147., 105., 8.],
        [8., 63., 154., 8.],
        [-22., 8., 8., -22.],
    ];
    grid([7, 4], |i, j| {
        let height = heights[usize::try_from(i).unwrap_or(0)][usize::try_from(j).unwrap_or(0)];
        Vector3::new(-240.0 + 80.0 * f64::from(i), -190.0 + 95.0 * f64::from(j), height)
    })
}

fn wavy() -> Outcome<BsplineSurface> {
    grid([50, 50], |i, j| {
        let (x, y) = (f64::from(i), f64::from(j));
        Vector3::new(x, y, 2.0 * (0.5 * x).sin() * (0.4 * y).cos() + 0.7 * (1.1 * x + 0.3 * y).sin())
    })
}

/// A fan over a full turn less a bit, whose edge `v = 0` is one point.
fn fan() -> Outcome<BsplineSurface> {
    grid([8, 8], |i, j| {
        let (angle, radius) = (0.75 * f64::from(i), f64::from(j));
        let height = if j == 0 { 2.0 } else { 2.0 + 0.9 * (1.3 * radius + 0.8 * f64::from(i)).sin() };
        Vector3::new(1.5 * radius * angle.cos(), 1.5 * radius * angle.sin(), height)
    })
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

fn diagonal<const D: usize>(points: &[SVector<f64, D>]) -> f64 {
    let low = points.iter().fold(points[0], |a, p| a.inf(p));
    let high = points.iter().fold(points[0], |a, p| a.sup(p));
    (high - low).norm()
}

/// Break points and the ends of the domain.
fn with_ends(mut breaks: Vec<f64>, domain: &Interval) -> Vec<f64> {
    breaks.insert(0, domain.start());
    breaks.push(domain.end());
    breaks
}

/// Parameters that divide every span into `n` parts.
fn dense(breaks: &[f64], n: usize) -> Vec<f64> {
    let part =
        |w: &[f64]| -> Vec<f64> { (0..n).map(|k| w[0] + (w[1] - w[0]) * k as f64 / n as f64).collect() };
    breaks.windows(2).flat_map(part).chain(breaks.last().copied()).collect()
}

/// Distance from the best of a pattern search that begins at each of the nearest samples.
fn refined<const D: usize>(
    points: &[SVector<f64, D>],
    samples: &[Vec<f64>; 2],
    x: &SVector<f64, D>,
    point: &dyn Fn([f64; 2]) -> SVector<f64, D>,
) -> f64 {
    let columns = samples[1].len();
    let mut order: Vec<(f64, usize)> = points.iter().map(|p| (p - x).norm_squared()).zip(0..).collect();
    let kept = 60.min(order.len());
    order.select_nth_unstable_by(kept - 1, |a, b| a.0.total_cmp(&b.0));
    order.truncate(kept);
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut seeds: Vec<[usize; 2]> = Vec::new();
    for (_, k) in order {
        let at = [k / columns, k % columns];
        if !seeds.iter().any(|s| (0..2).all(|d| s[d].abs_diff(at[d]) <= 2)) {
            seeds.push(at);
        }
    }
    let domain = [0, 1].map(|d| [samples[d][0], samples[d][samples[d].len() - 1]]);
    let mut least = f64::INFINITY;
    for seed in seeds.into_iter().take(5) {
        let mut centre = [0, 1].map(|d| samples[d][seed[d]]);
        let mut best = (point(centre) - x).norm();
        let mut step = [0, 1].map(|d| (domain[d][1] - domain[d][0]) / samples[d].len() as f64);
        for _ in 0..44 {
            for _ in 0..20 {
                let mut moved = None;
                for (i, j) in [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1)] {
                    let to = [centre[0] + f64::from(i) * step[0], centre[1] + f64::from(j) * step[1]];
                    let to = [0, 1].map(|d| to[d].clamp(domain[d][0], domain[d][1]));
                    let found = (point(to) - x).norm();
                    if found < best {
                        (best, moved) = (found, Some(to));
                    }
                }
                let Some(to) = moved else { break };
                centre = to;
            }
            step = step.map(|s| 0.5 * s);
        }
        least = least.min(best);
    }
    least
}
