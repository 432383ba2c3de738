//! The picture of the registration: where the scan was, where it came to lie, and the steps in between.

use super::bolt::Bolt;
use super::scale::Scale;
use super::svg::{Anchor, Svg};
use crate::error::Error;
use crate::input::cad::Choice;
use crate::input::model::{Loaded, Model};
use industrial_geometry::mesh::nalgebra::{Point3, Vector3};
use industrial_geometry::nurbs::ParametricSurface;
use industrial_geometry::register::{Pose, RegisterStep};
use std::path::Path;

const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 640.0;
const MODEL: [u8; 3] = [176, 182, 188];
const BEFORE: [u8; 3] = [222, 78, 52];
const AFTER: [u8; 3] = [58, 118, 196];
const INK: &str = "fill=\"#222\"";
const BOLD: &str = "fill=\"#111\" font-weight=\"bold\"";
/// Samples of the model around and along its axis.
const SAMPLES: [usize; 2] = [120, 60];

/// Draws a displaced scan and the pose that takes it back, as SVG.
pub(crate) fn draw(
    bolt: &Bolt,
    model: &Path,
    scan: &[Vector3<f64>],
    pose: &Pose<3>,
    history: &[RegisterStep],
) -> Result<String, Error> {
    let title = "Registration of the displaced scan to its nominal thread and shank";
    let mut svg = Svg::new(WIDTH, HEIGHT, title);
    svg.text([40.0, 40.0], 25.0, Anchor::Start, BOLD, title);
    let nominal = samples(model)?;
    let places =
        [(60.0, BEFORE, "a  Before: the scan (red) and the model (grey)"), (640.0, AFTER, "b  After")];
    for (left, colour, text) in places {
        let along = Scale { values: [-30.0, 14.0], pixels: [left, left + 520.0] };
        let scale = 520.0 / 44.0;
        let across = Scale { values: [-9.0, 9.0], pixels: [90.0 + 18.0 * scale, 90.0] };
        svg.rectangle([left, 90.0], [520.0, 18.0 * scale], "#f4f5f7");
        svg.text([left, 78.0], 15.0, Anchor::Start, BOLD, text);
        let at = |x: &Vector3<f64>| {
            let [height, side, _] = bolt.local(&Point3::from(*x));
            [along.at(height), across.at(side)]
        };
        let inside =
            |p: &[f64; 2]| p[0] > left && p[0] < left + 520.0 && p[1] > 90.0 && p[1] < 90.0 + 18.0 * scale;
        let model: Vec<_> = nominal.iter().map(at).filter(inside).collect();
        svg.dots(&model, 1.6, MODEL);
        let moved = |x: &Vector3<f64>| if colour == AFTER { pose.apply(x) } else { *x };
        let points: Vec<_> = scan.iter().step_by(2).map(|x| at(&moved(x))).filter(inside).collect();
        svg.dots(&points, 1.8, colour);
    }
    steps(&mut svg, history, [100.0, 1160.0], [360.0, 580.0]);
    Ok(svg.finish())
}

/// Points spread over the surfaces of the model.
fn samples(model: &Path) -> Result<Vec<Vector3<f64>>, Error> {
    let Model::Space { surfaces, .. } = Loaded::read(model, &Choice::default())?.model else {
        return Ok(Vec::new());
    };
    let [around, along] = SAMPLES;
    let mut points = Vec::new();
    for surface in &surfaces.shapes {
        let [u, v] = surface.domain();
        for k in 0..around * along {
            let (i, j) = ((k / along) as f64 / around as f64, (k % along) as f64 / along as f64);
            points.push(surface.point(u.start() + u.length() * i, v.start() + v.length() * j));
        }
    }
    Ok(points)
}

/// The motion of each step on a logarithmic scale.
fn steps(svg: &mut Svg, history: &[RegisterStep], x: [f64; 2], y: [f64; 2]) {
    let text =
        "c  Motion of each step as a share of the size of the scan; colours: stages, filled: Newton's method";
    svg.text([x[0] - 40.0, y[0] - 12.0], 15.0, Anchor::Start, BOLD, text);
    svg.rectangle([x[0], y[0]], [x[1] - x[0], y[1] - y[0]], "#f4f5f7");
    let down = Scale { values: [0.0, -16.0], pixels: y };
    let right = Scale { values: [0.0, history.len() as f64 + 1.0], pixels: x };
    for power in down.ticks(4.0) {
        let at = down.at(power);
        svg.polyline(&[[x[0], at], [x[1], at]], "#d5d8dc", 1.0);
        svg.text([x[0] - 9.0, at + 4.0], 12.5, Anchor::End, INK, &format!("1e{power:.0}"));
    }
    let count = history.len().to_string();
    svg.text([right.at(1.0), y[1] + 20.0], 12.5, Anchor::Middle, INK, "1");
    svg.text([right.at(history.len() as f64), y[1] + 20.0], 12.5, Anchor::Middle, INK, &count);
    svg.text([0.5 * (x[0] + x[1]), y[1] + 36.0], 13.0, Anchor::Middle, INK, "step");
    let place = |(index, step): (usize, &RegisterStep)| {
        let power = step.motion.max(1e-16).log10();
        [right.at(index as f64 + 1.0), down.at(power)]
    };
    let line: Vec<_> = history.iter().enumerate().map(place).collect();
    svg.polyline(&line, "#888", 1.2);
    for (stage, colour) in [
        ("fit", [90, 98, 104]),
        ("narrow", [222, 120, 30]),
        ("inliers", [30, 130, 76]),
        ("coarse", [120, 80, 160]),
    ] {
        let of = |newton: bool| -> Vec<[f64; 2]> {
            let steps = history.iter().enumerate();
            steps.filter(|(_, s)| s.stage == stage && (s.step == "newton") == newton).map(place).collect()
        };
        svg.dots(&of(false), 9.0, colour);
        svg.dots(&of(false), 5.0, [244, 245, 247]);
        svg.dots(&of(true), 9.0, colour);
    }
    let legend =
        [("all points, least squares", "#5a6268"), ("limit narrowed", "#de781e"), ("inliers", "#1e824c")];
    for (k, (name, colour)) in legend.into_iter().enumerate() {
        let left = x[1] - 470.0 + 180.0 * k as f64;
        svg.rectangle([left, y[1] + 26.0], [11.0, 11.0], colour);
        svg.text([left + 17.0, y[1] + 36.0], 13.0, Anchor::Start, INK, name);
    }
}
