//! Point, tangent and squared distance minimisation, and a joint minimisation by L-BFGS, side by side on the curve cases.
//!
//! `cargo run --release -p measurements --bin rivals`. From the same start and with the same control points: root mean square of
//! the orthogonal distances after 5, 10, 20, 45 and 200 iterations; iterations and milliseconds until it is within five per cent of
//! the best that any method reached. Ours share the loop, with smoothing that falls from 0.01 to 0 by halves; L-BFGS has a
//! fixed smoothing of 1e-8, since all of its memory belongs to one cost.

mod lbfgs;

use distance_field::{ErrorTerm, Search};
use lbfgs::Joint;
use measurements::cases::{Outcome, fixture, points, start};
use nalgebra::SVector;
use nurbs_core::BsplineCurve;
use sdm_fit::curve::{ActiveCurve, CurveOptions, fit_curve};
use sdm_fit::{
    ActiveShape, Constraints, FitOptions, FitStep, FootpointPolicy, Smoothing, StepControl, Target,
    fit_with_progress,
};
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::Instant;

const METHODS: [(&str, ErrorTerm, StepControl); 4] = [
    ("PDM", ErrorTerm::Point, StepControl::None),
    ("TDM", ErrorTerm::Tangent, StepControl::None),
    ("TDM + Armijo", ErrorTerm::Tangent, StepControl::Armijo),
    ("SDM", ErrorTerm::SquaredDistance, StepControl::Armijo),
];
const SHOWN: [usize; 5] = [5, 10, 20, 45, 200];
/// A part of the best within which a method has arrived.
const ARRIVED: f64 = 1.05;

/// Root mean square distance and seconds after each iteration.
type Course = Vec<(f64, f64)>;

fn main() -> Outcome<()> {
    let case = |name: &str| fixture(&format!("fit-cases/{name}"));
    let (a1, a3) = (points::<2>(&case("a1_rect.xyz"))?, points::<2>(&case("a3_bean.xyz"))?);
    for (name, data, file) in [
        ("rectangle, 12 control points, even start", &a1, "a1_init_even.json"),
        ("rectangle, 12 control points, uneven start", &a1, "a1_init_uneven.json"),
        ("bean, 12 control points, even start", &a3, "a3_init_even.json"),
        ("bean, 12 control points, uneven start", &a3, "a3_init_uneven.json"),
    ] {
        compare(name, data, &start(&case(file))?)?;
    }
    let b = points::<3>(&case("b_open3d_ordered.xyz"))?;
    let options = CurveOptions::default()
        .with_controls(Some(24))
        .with_fit(FitOptions::default().with_max_iterations(2));
    compare("open curve in space, 24 control points", &b, &fit_curve::<3>(&b, None, &options)?.curve)
}

fn compare<const D: usize>(name: &str, points: &[SVector<f64, D>], start: &BsplineCurve<D>) -> Outcome<()> {
    let mut courses: Vec<(&str, Course)> = Vec::new();
    for (name, term, control) in METHODS {
        courses.push((name, ours(points, start, term, control)?));
    }
    courses.push(("L-BFGS", joint(points, start)?));
    let best =
        courses.iter().flat_map(|(_, course)| course).map(|(rms, _)| *rms).fold(f64::INFINITY, f64::min);
    // Below rounding all are equal.
    let goal = (ARRIVED * best).max(1e-9);
    println!("{name} ({} points)", points.len());
    println!(
        "  {:13}{}  to {goal:.2e}: iterations, ms",
        "method",
        SHOWN.map(|k| format!("{k:>10}")).concat()
    );
    for (name, course) in &courses {
        let cells = SHOWN
            .map(|k| course.get(k - 1).or(course.last()).map_or("-".into(), |(rms, _)| format!("{rms:.2e}")));
        let arrived = course.iter().position(|(rms, _)| *rms <= goal);
        let arrived = arrived.map_or("never".to_owned(), |k| format!("{} {:.2}", k + 1, 1e3 * course[k].1));
        println!("  {name:13}{}  {arrived}", cells.map(|cell| format!("{cell:>10}")).concat());
    }
    Ok(())
}

fn ours<const D: usize>(
    points: &[SVector<f64, D>],
    start: &BsplineCurve<D>,
    term: ErrorTerm,
    control: StepControl,
) -> Outcome<Course> {
    let options = FitOptions::default()
        .with_term(term)
        .with_control(control)
        .with_smoothing(Smoothing::CONTINUATION)
        .with_footpoints(FootpointPolicy::Global)
        .with_max_iterations(SHOWN[4]);
    let (course, clock) = (Mutex::new(Course::new()), Instant::now());
    let watch = |step: &FitStep| {
        if let Ok(mut course) = course.lock() {
            course.push((step.rms, clock.elapsed().as_secs_f64()));
        }
        ControlFlow::Continue(())
    };
    let target = Target::Points { points, weights: None };
    fit_with_progress(ActiveCurve::new(start.clone())?, target, &Constraints::none(), &options, &watch)?;
    Ok(course.into_inner()?)
}

fn joint<const D: usize>(points: &[SVector<f64, D>], start: &BsplineCurve<D>) -> Outcome<Course> {
    let clock = Instant::now();
    let mut joint = Joint::new(start.clone(), points, 1e-8, FitOptions::default().energy)?;
    let (mut course, mut measuring) = (Course::new(), 0.0);
    while course.len() < 5 * SHOWN[4] && joint.step()? > 0 {
        let seconds = clock.elapsed().as_secs_f64() - measuring;
        // Its own cost knows no orthogonal distances; to measure them is not its work.
        let shape = joint.shape()?;
        let squares = shape.frames(points, Search::Global, &[])?;
        let rms = (squares.iter().map(|frame| frame.distance * frame.distance).sum::<f64>()
            / points.len() as f64)
            .sqrt();
        course.push((rms, seconds));
        measuring = clock.elapsed().as_secs_f64() - seconds;
    }
    Ok(course)
}
