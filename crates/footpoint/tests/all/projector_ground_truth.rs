//! Distances that are known to be right: the cases of `fixtures/footpoint-cases`, described in its README.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use crate::projector_support::answer::{Answer, Judge};
use footpoint::{CurveProjector, Mode, ProjectionOptions, SurfaceProjector};
use nalgebra::{SVector, Vector3};
use nurbs_core::{BsplineCurve, BsplineSurface};
use std::path::{Path, PathBuf};

/// Fast mode follows only the best seeds: at most this share of each set may end in another local minimum.
const FAST_MISSES: f64 = 0.05;

/// Points of a set and their true distances.
struct Case<const D: usize> {
    name: String,
    points: Vec<SVector<f64, D>>,
    distances: Vec<f64>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/footpoint-cases")
}

fn json(name: &str) -> String {
    std::fs::read_to_string(folder().join(name).with_extension("json")).unwrap()
}

fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect()).collect()
}

/// All sets of a shape.
fn cases<const D: usize>(shape: &str, expected: &[&str]) -> Vec<Case<D>> {
    let case = |set: &&str| {
        let path = folder().join(format!("{shape}.{set}.q"));
        let points: Vec<_> = rows(&path).iter().map(|row| SVector::from_column_slice(row)).collect();
        let truth = rows(&path.with_extension("gt"));
        assert_eq!(points.len(), truth.len());
        assert!(truth.iter().all(|row| row[3] == 1.0), "every distance is certified");
        Case { name: format!("{shape}.{set}"), points, distances: truth.iter().map(|row| row[2]).collect() }
    };
    let sets: Vec<_> = expected.iter().map(case).collect();
    let stored = std::fs::read_dir(folder()).unwrap();
    let stored = stored.filter(|e| {
        let name = e.as_ref().unwrap().file_name().into_string().unwrap();
        name.starts_with(&format!("{shape}.")) && name.ends_with(".q")
    });
    assert_eq!(stored.count(), sets.len(), "a set of {shape} is not tested");
    sets
}

/// Judges every answer of both modes; messages name set and point.
fn run<const D: usize>(
    case: &Case<D>,
    judge: &impl Judge<D>,
    answer: impl Fn(&SVector<f64, D>, Mode) -> Answer<D>,
) {
    let size = judge.size();
    let wrong = |found: &Answer<D>, x: &SVector<f64, D>, truth: f64| -> Option<String> {
        let too_far = found.distance > truth * (1.0 + 1e-6) + 1e-9 * size;
        judge.inconsistency(x, found).or_else(|| too_far.then(|| format!("the true distance is {truth}")))
    };
    let mut fast_misses = 0;
    for (i, (x, &truth)) in case.points.iter().zip(&case.distances).enumerate() {
        let found = answer(x, Mode::Certified);
        if let Some(what) = wrong(&found, x, truth) {
            panic!("{} point {i} {x:?}: {what}; found {found:?}", case.name);
        }
        // The stored distances are those of points found: the true ones may be a little below.
        assert!(
            found.lower_bound <= truth * (1.0 + 1e-9) + 1e-12 * size,
            "{} point {i}: bound {} above the true distance {truth}",
            case.name,
            found.lower_bound
        );
        let gap = found.distance - found.lower_bound;
        assert!(
            (0.0..=1e-6 * found.distance + 1e-9 * size).contains(&gap),
            "{} point {i} {x:?}: gap {gap} at distance {}",
            case.name,
            found.distance
        );
        let fast = answer(x, Mode::Fast);
        assert_eq!(fast.lower_bound, 0.0, "fast mode proves nothing");
        assert!(judge.inconsistency(x, &fast).is_none(), "{} point {i}, fast: {fast:?}", case.name);
        fast_misses += usize::from(wrong(&fast, x, truth).is_some());
    }
    let allowed = FAST_MISSES * case.points.len() as f64;
    println!("{:18} {:4} points, {fast_misses} missed in fast mode", case.name, case.points.len());
    assert!(fast_misses as f64 <= allowed, "{}: {fast_misses} misses in fast mode", case.name);
}

fn run_surface(name: &str, sets: &[&str]) {
    let surface: BsplineSurface = serde_json::from_str(&json(name)).unwrap();
    let projector = SurfaceProjector::new(&surface);
    for case in &cases::<3>(name, sets) {
        run(case, &surface, |x: &Vector3<f64>, mode| {
            projector.project_with(x, &ProjectionOptions::default().with_mode(mode)).unwrap().into()
        });
    }
}

#[test]
fn plane_cubic() {
    let curve: BsplineCurve<2> = serde_json::from_str(&json("c_hw2")).unwrap();
    let projector = CurveProjector::new(&curve);
    for case in &cases::<2>("c_hw2", &["on", "near", "mid", "far", "beyond", "paper"]) {
        run(case, &curve, |x, mode| {
            projector.project_with(x, &ProjectionOptions::default().with_mode(mode)).unwrap().into()
        });
    }
}

#[test]
fn bicubic_surface() {
    run_surface("s_hw3", &["on", "near", "mid", "far", "beyond", "paper"]);
}

#[test]
fn torus() {
    run_surface("s_torus", &["on", "near", "mid", "far", "singular"]);
}

#[test]
fn collapsed_edge() {
    run_surface("s_degen", &["on", "near", "mid", "far", "beyond", "singular"]);
}
