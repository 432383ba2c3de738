//! Figs. 3 and 6 to 11 of \[P05\]: curves fitted to points, and how they move.

use super::drawing::{BLACK, BLUE, Drawing, GREY, Panel, RED, bounds};
use crate::workspace;
use distance_field::{CurveField, DistanceField, ErrorTerm, Hint, PrincipalFrame, Search};
use nalgebra::Vector2;
use nurbs_core::{BsplineCurve, KnotVector, ParametricCurve};
use pc_io::{ReadOptions, Shape};
use sdm_fit::curve::{CurveOptions, fit_curve};
use sdm_fit::{
    ActiveCurve, ActiveShape, Constraints, FitOptions, Fitted, Smoothing, StepControl, Target, fit,
};
use std::error::Error;
use std::f64::consts::TAU;

type Outcome<T> = Result<T, Box<dyn Error>>;
/// A name, and how it fits: so many iterations.
type Method = (&'static str, ErrorTerm, StepControl, Smoothing, usize);
/// The smoothing of all methods that are compared.
const FALLING: Smoothing = Smoothing::CONTINUATION;
/// Samples of a drawn curve.
const SAMPLES: usize = 240;
/// Layers that are drawn of an evolution.
const LAYERS: usize = 24;

/// Points and a start of `fixtures/fit-cases`.
struct Case {
    points: Vec<Vector2<f64>>,
    start: BsplineCurve<2>,
}

impl Case {
    fn read(points: &str, start: &str) -> Outcome<Self> {
        let folder = workspace::root().join("fixtures/fit-cases");
        let cloud = pc_io::read_cloud(folder.join(points), &ReadOptions::default())?.content;
        let model = pc_io::read_model(folder.join(start), &ReadOptions::default())?.content;
        let curve = model.into_shapes().into_iter().find_map(|shape| match shape {
            Shape::Curve2(curve) => Some(curve),
            _ => None,
        });
        let points = cloud.positions().iter().map(|p| p.coords.xy()).collect();
        Ok(Self { points, start: curve.ok_or("the start is no plane curve")? })
    }

    /// So many iterations with a term.
    fn fitted(
        &self,
        term: ErrorTerm,
        control: StepControl,
        smoothing: Smoothing,
        iterations: usize,
    ) -> Outcome<Fitted<ActiveCurve<2>, 2>> {
        let options = FitOptions::default()
            .with_term(term)
            .with_control(control)
            .with_smoothing(smoothing)
            .with_cost_tolerance(0.0)
            .with_max_iterations(iterations)
            .with_evolution(true);
        let target = Target::Points { points: &self.points, weights: None };
        Ok(fit(ActiveCurve::new(self.start.clone())?, target, &Constraints::none(), &options)?)
    }
}

fn polygon(curve: &BsplineCurve<2>) -> Vec<Vector2<f64>> {
    (0..=SAMPLES).map(|k| curve.point(curve.domain().lerp(k as f64 / SAMPLES as f64))).collect()
}

/// A panel around some points, with room.
fn framed<'d>(drawing: &'d mut Drawing, title: &str, points: &[Vector2<f64>]) -> Panel<'d> {
    let [low, high] = bounds(points);
    let room = (high - low) * 0.12;
    drawing.panel(title, low - room, high + room)
}

/// Ellipses on which the quadratic model of a squared distance has the given values.
fn level_sets(panel: &mut Panel<'_>, frame: &PrincipalFrame<2>, place: &Vector2<f64>, colour: &str) {
    let matrix = ErrorTerm::SquaredDistance.model(frame).matrix();
    let value = (place - frame.foot).dot(&(matrix * (place - frame.foot)));
    let eigen = matrix.symmetric_eigen();
    // Where the model is a strip of two lines, a long ellipse stands for it.
    let least = 0.01 * eigen.eigenvalues.max();
    for share in [0.25, 0.6, 1.0] {
        let radii = eigen.eigenvalues.map(|w| (share * value / w.max(least)).sqrt());
        let at = |k: usize| {
            let (sine, cosine) = (TAU * k as f64 / 60.0).sin_cos();
            frame.foot + eigen.eigenvectors * Vector2::new(radii[0] * cosine, radii[1] * sine)
        };
        let ellipse: Vec<Vector2<f64>> = (0..60).map(at).collect();
        panel.clipped_line(&ellipse, true, 0.9, colour);
    }
}

/// Figs. 3 and 9: one step, with the models attached to the model shape and to the active curve.
pub(super) fn step() -> Outcome<String> {
    let case = Case::read("a3_bean.xyz", "a3_init_even.json")?;
    let target =
        case.fitted(ErrorTerm::SquaredDistance, StepControl::Armijo, FALLING, 30)?.shape.into_curve();
    let options = FitOptions::default().with_smoothing(Smoothing::CONTINUATION).with_max_iterations(1);
    let field = CurveField::new(&target)?;
    let active = ActiveCurve::new(case.start.clone())?;
    let model = Target::Model { field: &field, sensors: 6, boundary: true };
    let moved = fit(active.clone(), model, &Constraints::none(), &options)?.shape.into_curve();
    let mut drawing = Drawing::new(
        340.0,
        "One iteration from a start (black) to the next position (red) with their control points. (a) The model shape is a curve (grey); at three sensor points of the active curve the quadratic models of its squared distance are shown by three level sets each. (b) The data are points; their models belong to the active curve.",
    );
    let (before, after) = (polygon(&case.start), polygon(&moved));
    let whole: Vec<Vector2<f64>> = before.iter().chain(&case.points).copied().collect();
    let mut panel = framed(&mut drawing, "(a) attached to the model shape", &whole);
    panel.line(&polygon(&target), true, 2.2, GREY);
    for share in [0.08, 0.42, 0.78] {
        let place = active.point([case.start.domain().lerp(share), 0.0]);
        let frame = field.frame(&place, Search::Global, &Hint::NONE);
        level_sets(&mut panel, &frame, &place, BLUE);
        panel.line(&[place, frame.foot], false, 0.8, BLUE);
        panel.points(&[place, frame.foot], 2.4, BLUE);
    }
    panel.line(&before, true, 1.4, BLACK);
    panel.line(&after, true, 1.6, RED);
    panel.points(&case.start.control_points()[..12], 1.8, BLACK);
    panel.points(&moved.control_points()[..12], 1.8, RED);
    let moved = case.fitted(ErrorTerm::SquaredDistance, StepControl::Armijo, FALLING, 1)?.shape.into_curve();
    let mut panel = framed(&mut drawing, "(b) attached to the active curve", &whole);
    panel.points(&case.points, 1.0, GREY);
    for place in case.points.iter().step_by(case.points.len() / 4) {
        let frames = active.frames(&[*place], Search::Global, &[])?;
        if let Some(frame) = frames.first() {
            level_sets(&mut panel, frame, place, BLUE);
            panel.points(&[*place, frame.foot], 2.4, BLUE);
        }
    }
    panel.line(&before, true, 1.4, BLACK);
    panel.line(&polygon(&moved), true, 1.6, RED);
    Ok(drawing.finish())
}

/// Data, start and the results of methods side by side.
fn compared(caption: &str, case: &Case, methods: &[Method]) -> Outcome<String> {
    let mut drawing = Drawing::new(300.0, caption);
    let start = polygon(&case.start);
    let whole: Vec<Vector2<f64>> = start.iter().chain(&case.points).copied().collect();
    let mut panel = framed(&mut drawing, "data and start", &whole);
    panel.points(&case.points, 1.4, GREY);
    panel.line(&start, true, 1.6, BLUE);
    panel.points(&case.start.control_points()[..case.start.knots().distinct_count()], 2.4, BLUE);
    for &(name, term, control, smoothing, iterations) in methods {
        let found = case.fitted(term, control, smoothing, iterations)?;
        // Where the iteration left the data, its last curve is shown as far as it lies in the panel.
        let rms = found.report.history.last().map_or(found.report.rms, |step| step.rms);
        let title = format!("{name}, {iterations} iterations: rms {rms:.2e}");
        let mut shape = found.shape.clone();
        if let Some(last) = found.evolution.last() {
            shape.set_coefficients(last)?;
        }
        let mut panel = framed(&mut drawing, &title, &whole);
        panel.points(&case.points, 1.4, GREY);
        panel.clipped_line(&polygon(shape.curve()), true, 1.6, RED);
    }
    Ok(drawing.finish())
}

/// Fig. 6: tangent distance minimisation without and with Armijo's rule.
pub(super) fn armijo() -> Outcome<String> {
    let case = Case::read("a3_bean.xyz", "a3_init_uneven.json")?;
    let tangent = ErrorTerm::Tangent;
    compared(
        "Tangent distance minimisation from a start with uneven control points, with full steps and with steps that Armijo's rule shortens.",
        &case,
        &[
            ("TDM", tangent, StepControl::None, FALLING, 6),
            ("TDM with Armijo", tangent, StepControl::Armijo, FALLING, 20),
        ],
    )
}

/// Fig. 10: points on a rectangle, twelve control points.
pub(super) fn rectangle() -> Outcome<String> {
    let case = Case::read("a1_rect.xyz", "a1_init_uneven.json")?;
    let methods = [
        ("PDM", ErrorTerm::Point, StepControl::None, FALLING, 20),
        ("SDM", ErrorTerm::SquaredDistance, StepControl::Armijo, FALLING, 20),
    ];
    compared(
        "Sixty points on a rectangle, twelve control points, unevenly distributed at the start.",
        &case,
        &methods,
    )
}

/// Fig. 11: very noisy points.
pub(super) fn noisy() -> Outcome<String> {
    let case = Case::read("a2_noisy.xyz", "a2_init_uneven.json")?;
    let methods = [
        ("PDM", ErrorTerm::Point, StepControl::None, FALLING, 50),
        ("TDM", ErrorTerm::Tangent, StepControl::None, FALLING, 50),
        ("SDM", ErrorTerm::SquaredDistance, StepControl::Armijo, FALLING, 50),
        (
            "SDM, smoothing by the data",
            ErrorTerm::SquaredDistance,
            StepControl::Armijo,
            Smoothing::default(),
            50,
        ),
    ];
    compared(
        "Eight hundred points with noise, twelve control points; in the first three results the smoothing falls to nothing, and the curves follow the noise; in the last one, by default, it stops where the data ask for it.",
        &case,
        &methods,
    )
}

/// Curves as layers, the first at the bottom.
fn stack(drawing: &mut Drawing, title: &str, curves: &[BsplineCurve<2>], data: &[Vector2<f64>]) {
    let step = curves.len().div_ceil(LAYERS).max(1);
    let mut shown: Vec<&BsplineCurve<2>> = curves.iter().step_by(step).collect();
    if !(curves.len() - 1).is_multiple_of(step) {
        shown.extend(curves.last());
    }
    let [low, high] = bounds(data);
    let size = (high - low).max();
    let rise = 1.9 * size / shown.len() as f64;
    let slant = |p: &Vector2<f64>, layer: usize| {
        let (x, y) = (p.x - 0.5 * (low.x + high.x), p.y - 0.5 * (low.y + high.y));
        Vector2::new(x + 0.25 * y, 0.42 * y + rise * layer as f64)
    };
    let lines: Vec<Vec<Vector2<f64>>> = shown
        .iter()
        .enumerate()
        .map(|(layer, curve)| polygon(curve).iter().map(|p| slant(p, layer)).collect())
        .collect();
    let top: Vec<Vector2<f64>> = data.iter().map(|p| slant(p, shown.len())).collect();
    let all: Vec<Vector2<f64>> = lines.iter().flatten().chain(&top).copied().collect();
    let mut panel = framed(drawing, title, &all);
    // Lines of constant parameter show what moves along the curve.
    for k in (0..SAMPLES).step_by(SAMPLES / 24) {
        let line: Vec<Vector2<f64>> = lines.iter().map(|line| line[k]).collect();
        panel.line(&line, false, 0.5, GREY);
    }
    for (layer, line) in lines.iter().enumerate() {
        let last = layer + 1 == lines.len();
        panel.line(line, true, if last { 2.0 } else { 0.9 }, if last { RED } else { BLUE });
    }
    panel.points(&top, 0.9, BLACK);
}

/// Figs. 7 and 8: evolutions, time upwards.
pub(super) fn evolution() -> Outcome<String> {
    let case = Case::read("a3_bean.xyz", "a3_init_uneven.json")?;
    let mut drawing = Drawing::new(
        460.0,
        "Evolution of the active curve, time upwards, the data on top (black) and the last curve in red; thin lines join places of equal parameter. (a) Squared distance minimisation arrives within a few iterations. (b) Point distance minimisation creeps on, along the curve. (c) A start far away: a contour grows inside the outline until it meets the points, then squared distance minimisation takes over.",
    );
    for (title, term) in [
        ("(a) SDM, 20 iterations", ErrorTerm::SquaredDistance),
        ("(b) PDM, 100 iterations", ErrorTerm::Point),
    ] {
        let iterations = if term == ErrorTerm::Point { 100 } else { 20 };
        let found = case.fitted(term, StepControl::Armijo, FALLING, iterations)?;
        let mut curves = Vec::new();
        for coefficients in &found.evolution {
            let mut shape = found.shape.clone();
            shape.set_coefficients(coefficients)?;
            curves.push(shape.into_curve());
        }
        stack(&mut drawing, title, &curves, &case.points);
    }
    let data = winding(500);
    let start = circle(0.7, Vector2::new(-6.5, 2.0), 28)?;
    let options = CurveOptions::default().with_search(true);
    let options = options.with_fit(options.fit.with_evolution(true).with_max_iterations(12));
    let found = fit_curve(&data, Some(&start), &options)?;
    let title = format!("(c) from far away: rms {:.1e} of a length of 14", found.report.rms);
    let curves: Vec<BsplineCurve<2>> = found.evolution.into_iter().take(22).chain([found.curve]).collect();
    stack(&mut drawing, &title, &curves, &data);
    Ok(drawing.finish())
}

/// The outline of a band about a wave.
fn winding(count: usize) -> Vec<Vector2<f64>> {
    let spine = |t: f64| Vector2::new(6.0 * t, 1.6 * (2.6 * t).sin());
    let slope = |t: f64| Vector2::new(6.0, 1.6 * 2.6 * (2.6 * t).cos()).normalize();
    let at = |k: usize| {
        let s = 2.0 * k as f64 / count as f64;
        let (t, side) = if s < 1.0 { (2.0 * s - 1.0, 1.0) } else { (3.0 - 2.0 * s, -1.0) };
        let along = slope(t);
        // Thinner towards the ends.
        let half = 0.75 * (1.0 - t.powi(8)).max(0.0).sqrt();
        spine(t) + Vector2::new(-along.y, along.x) * (side * half)
    };
    (0..count).map(at).collect()
}

fn circle(radius: f64, centre: Vector2<f64>, controls: usize) -> Outcome<BsplineCurve<2>> {
    let at = |i: usize| {
        let (sine, cosine) = (TAU * (i % controls) as f64 / controls as f64).sin_cos();
        centre + Vector2::new(cosine, sine) * radius
    };
    let knots = KnotVector::uniform_periodic(3, controls)?;
    Ok(BsplineCurve::new(knots, (0..controls + 3).map(at).collect(), None)?)
}
