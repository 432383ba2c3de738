//! Figs. 1 and 2 of \[P05\]: distances around obstacles, and the quadratic approximant of the squared distance.

use super::shading::{BLUE, RED};
use distance_field::grid::{Element, Lattice, Medium, Scene, Seed, carry, march, seeds, sweep};
use distance_field::{CurveField, DistanceField, Hint, Search};
use industrial_geometry::picture::{FieldScene, Line, Sheet};
use nalgebra::Vector2;
use nurbs_core::{BsplineCurve, KnotVector, ParametricCurve};
use std::error::Error;

/// Nodes along each side.
const NODES: usize = 129;
/// Pixels along each side.
const SIZE: usize = 360;
const WHITE: [f32; 3] = [1.0, 1.0, 1.0];
const BLACK: [f32; 3] = [0.05, 0.06, 0.08];

/// Level sets of the distance of a point among obstacles by sweeping, by marching and exactly, with shortest ways; Tsai's sweeping knows no
/// obstacles.
pub(super) fn obstacles() -> Result<String, Box<dyn Error>> {
    let path = crate::workspace::root().join("fixtures/field-cases/scene_aligned.json");
    let text: serde_json::Value = serde_json::from_slice(&std::fs::read(path)?)?;
    let point = |value: &serde_json::Value| {
        let number = |k: usize| value.get(k).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
        Vector2::new(number(0), number(1))
    };
    let list = |name: &str| text[name].as_array().cloned().unwrap_or_default();
    let source = point(&text["source"]);
    let polygons: Vec<Vec<Vector2<f64>>> =
        list("polys").iter().map(|p| p.as_array().into_iter().flatten().map(point).collect()).collect();
    let scene = Scene::new(Vector2::zeros(), Vector2::repeat(1.0), source, &polygons)?;
    let lattice = Lattice::new(Vector2::zeros(), Vector2::repeat(1.0), [NODES; 2])?;
    let exact = scene.distances(&lattice);
    let element = [Element::Point(source)];
    let straight: Vec<f64> = (0..lattice.len()).map(|k| (lattice.point(k) - source).norm()).collect();
    let blocked: Vec<bool> = (0..lattice.len()).map(|k| scene.is_blocked(&lattice.point(k))).collect();
    let medium = Medium { blocked, ..Medium::default() };
    let near = |cells: f64| -> Vec<Seed> {
        let mut near = seeds(&lattice, &element, cells * lattice.spacing().max());
        near.retain(|seed| exact[seed.node] <= seed.distance * (1.0 + 1e-9));
        near
    };
    let first = sweep(&lattice, &near(1.5), &medium).0;
    let second = march(&lattice, &near(4.0), &medium, true);
    let carried = carry(&lattice, &element, &near(1.5)).0;
    let max = exact.iter().copied().fold(0.0, f64::max);
    let filled: Vec<Vec<[f64; 2]>> =
        polygons.iter().map(|p| p.iter().map(|q| (*q).into()).collect()).collect();
    let ways: Vec<Line> = list("targets")
        .iter()
        .filter_map(|target| scene.path(&point(target)))
        .map(|way| Line { points: way.points.iter().map(|p| (*p).into()).collect(), colour: RED, width: 2.5 })
        .collect();
    let error = |values: &[f64], truth: &[f64]| {
        let free = (0..truth.len()).filter(|k| !medium.blocked[*k]);
        free.map(|k| (values[k] - truth[k]).abs()).fold(0.0, f64::max)
    };
    let draw = |values: &[f64], filled: &[Vec<[f64; 2]>], ways: &[Line]| {
        // Under the obstacles nothing is seen: zeros there would bend isolines next to them.
        let shown: Vec<f64> =
            (0..values.len())
                .map(|k| {
                    if filled.is_empty() || !medium.blocked[k] {
                        values[k]
                    } else {
                        around(values, &medium, k)
                    }
                })
                .collect();
        let ends = ways.iter().filter_map(|way| way.points.last()).map(|end| (*end, RED, 4.0));
        FieldScene {
            counts: [NODES; 2],
            bounds: [[0.0; 2], [1.0; 2]],
            values: &shown,
            range: [0.0, max],
            lines: 24,
            filled,
            curves: ways.to_vec(),
            points: ends.chain([(source.into(), BLACK, 4.5)]).collect(),
        }
        .draw(SIZE)
    };
    let told = |error: f64| if error > 0.0 { format!("{error:.1e}") } else { "0".to_owned() };
    let sheet = Sheet::new()
        .with(&format!("fast sweeping (Zhao): {}", told(error(&first, &exact))), draw(&first, &filled, &[]))
        .with(&format!("fast marching, order 2: {}", told(error(&second, &exact))), draw(&second, &filled, &[]))
        .with(&format!("Tsai, no obstacles: {}", told(error(&carried, &straight))), draw(&carried, &[], &[]))
        .with("exact, with shortest ways", draw(&exact, &filled, &ways))
        .with_bar([0.0, max])
        .with_caption(&format!(
            "Distance from a point among obstacles on {NODES} × {NODES} nodes, with the largest error of each method. Level sets of \
             sweeping are no circles near the point."
        ));
    Ok(sheet.to_svg()?)
}

/// The mean of the nodes around one inside of an obstacle that have a value.
fn around(values: &[f64], medium: &Medium, node: usize) -> f64 {
    let (i, j) = (node / NODES, node % NODES);
    let mut known = Vec::new();
    for k in i.saturating_sub(2)..(i + 3).min(NODES) {
        for l in j.saturating_sub(2)..(j + 3).min(NODES) {
            let other = k * NODES + l;
            if !medium.blocked[other] {
                known.push(values[other]);
            }
        }
    }
    known.iter().sum::<f64>() / known.len().max(1) as f64
}

/// A curve with the level sets of its squared distance, and those of the quadratic approximant at a point.
pub(super) fn approximant() -> Result<String, Box<dyn Error>> {
    let net =
        [[-0.2, 0.45], [0.25, 1.25], [1.0, 0.2], [1.55, 0.1], [2.0, 0.95], [2.4, 0.7]].map(Vector2::from);
    let curve = BsplineCurve::new(KnotVector::uniform_clamped(3, net.len())?, net.to_vec(), None)?;
    let field = CurveField::new(&curve)?;
    let (low, high) = (Vector2::new(0.0, 0.0), Vector2::new(2.1, 1.35));
    let counts = [400, 258];
    let at = |i: usize, j: usize| {
        let share = Vector2::new(i as f64 / (counts[0] - 1) as f64, j as f64 / (counts[1] - 1) as f64);
        low + (high - low).component_mul(&share)
    };
    let nodes: Vec<Vector2<f64>> =
        (0..counts[0] * counts[1]).map(|k| at(k / counts[1], k % counts[1])).collect();
    let squares: Vec<f64> =
        field.frames(&nodes, Search::Global, &[]).iter().map(|frame| frame.distance.powi(2)).collect();
    let p = Vector2::new(1.22, 0.62);
    let frame = field.frame(&p, Search::Global, &Hint::NONE);
    let (tangent, normal) = (frame.axes.column(0).into_owned(), frame.axes.column(1).into_owned());
    let d = (p - frame.foot).dot(&normal);
    // In the frame of the foot: d/(d − ρ) x₁² + x₂², whose level through p is d².
    let factor = d * frame.curvatures[0] / (d * frame.curvatures[0] - 1.0);
    let value = |x: &Vector2<f64>| {
        let local = x - frame.foot;
        factor * local.dot(&tangent).powi(2) + local.dot(&normal).powi(2)
    };
    let ellipses = [0.4, 0.7, 1.0, 1.3].map(|share: f64| {
        let half = [share * d.abs() / factor.abs().sqrt(), share * d.abs()];
        let turn = |k: u32| std::f64::consts::TAU * f64::from(k) / 160.0;
        let at =
            |k: u32| frame.foot + tangent * (half[0] * turn(k).cos()) + normal * (half[1] * turn(k).sin());
        let width = if (share - 1.0).abs() < 1e-9 { 3.0 } else { 1.6 };
        Line { points: (0..=160).map(|k| at(k).into()).collect(), colour: RED, width }
    });
    let [start, end] = [curve.domain().start(), curve.domain().end()];
    let shape = (0..=400).map(|k| curve.point(start + (end - start) * f64::from(k) / 400.0).into()).collect();
    let arrow = |direction: &Vector2<f64>| Line {
        points: vec![frame.foot.into(), (frame.foot + direction * 0.28).into()],
        colour: WHITE,
        width: 3.0,
    };
    let mut curves = vec![Line { points: shape, colour: BLACK, width: 4.0 }];
    curves.extend(ellipses);
    curves.extend([arrow(&tangent), arrow(&normal)]);
    let max = squares.iter().copied().fold(0.0, f64::max).min(0.6);
    let scene = FieldScene {
        counts,
        bounds: [low.into(), high.into()],
        values: &squares,
        range: [0.0, max],
        lines: 30,
        filled: &[],
        curves,
        points: vec![(p.into(), BLUE, 6.0), (frame.foot.into(), WHITE, 5.0)],
    };
    let gap = (value(&p) - d * d).abs();
    if gap > 1e-12 {
        return Err(format!("the approximant misses the squared distance by {gap:.1e}").into());
    }
    let sheet = Sheet::new().with("", scene.draw(900)).with_bar([0.0, max]).with_caption(
        "Level sets of the squared distance of a curve (black), and of its quadratic approximant at a point (red, the thick one through it), in the frame of the foot.",
    );
    Ok(sheet.to_svg()?)
}
