//! A folder with an input of every kind.

use super::{Bench, CUBE, SQUARE};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Points that look random, always the same, in the unit cube.
fn random(count: usize) -> impl Iterator<Item = [f64; 3]> {
    let share = |i: usize, step: f64| (i as f64 * step).fract();
    (0..count).map(move |i| [share(i, 0.819_172_513), share(i, 0.671_043_607), share(i, 0.549_700_478)])
}

pub(crate) fn lines(points: impl Iterator<Item = [f64; 3]>) -> String {
    points.fold(String::new(), |mut text, [x, y, z]| {
        writeln!(text, "{x} {y} {z}").unwrap();
        text
    })
}

/// A wavy sheet over [0, 3] × [0, 2], from `from` to `to` in x.
fn sheet(from: f64, to: f64, count: usize) -> impl Iterator<Item = [f64; 3]> {
    let at = move |[x, y, _]: [f64; 3]| {
        let (x, y) = (from + (to - from) * x, 2.0 * y);
        [x, y, 0.3 * (2.0 * x).sin() * (1.5 * y + 0.3 * x).cos() + 0.1 * x * x]
    };
    random(count).map(at)
}

/// A vase that is closed around its axis.
fn vase(count: usize) -> impl Iterator<Item = [f64; 3]> {
    random(count).map(|[a, h, _]| {
        let (a, h) = (TAU * a, h);
        let r = 3.0 + 0.6 * (4.0 * h).sin() + 0.4 * (3.0 * a).cos();
        [r * a.cos(), r * a.sin(), 10.0 * h]
    })
}

/// A folder with an input of every kind.
pub(crate) fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("model.json", SQUARE);
    bench.put("cube.off", CUBE);
    bench.put("points.xyz", "0.5 1 0.03\n1 0.25 -0.0625\n1 1 0.2\n");
    let circle = (0..60).map(|i| f64::from(i) * TAU / 60.0).map(|a| [2.0 * a.cos(), a.sin(), 0.0]);
    bench.put("ring.xyz", lines(circle));
    bench.put("sheet.xyz", lines(sheet(0.0, 3.0, 900)));
    bench.put("vase.xyz", lines(vase(3000)));
    bench.put("left.xyz", lines(sheet(0.0, 2.0, 2500)));
    bench.put("right.xyz", lines(sheet(1.0, 3.0, 2500)));
    bench.put("far.xyz", lines(sheet(0.0, 2.0, 2500).map(|[x, y, z]| [x + 50.0, y, z])));
    let (sin, cos) = 0.2f64.sin_cos();
    let turned =
        sheet(0.5, 2.5, 800).map(|[x, y, z]| [cos * x - sin * z + 0.05, y + 0.03, sin * x + cos * z - 0.1]);
    bench.put("turned.xyz", lines(turned));
    bench.put("strip.xyz", lines(random(300).map(|[x, y, _]| [3.0 * x, 2.0 * y, 0.4 * x * (1.0 - y)])));
    bench.put("ball.off", ball());
    // Off the cube, all around it.
    bench.put("around.xyz", lines(cube_points().map(|p| p.map(|c| c + 0.02))));
    bench
}

/// Points on the six sides of the unit cube.
pub(crate) fn cube_points() -> impl Iterator<Item = [f64; 3]> {
    random(600).enumerate().map(|(i, mut p)| {
        p[i % 3] = f64::from(u8::from(i % 2 == 0));
        p
    })
}

/// A sphere of triangles: an octahedron, its sides divided into 6 × 6.
fn ball() -> String {
    const SIDE: usize = 6;
    let (mut corners, mut faces) = (Vec::<[f64; 3]>::new(), Vec::new());
    let index = |corners: &mut Vec<[f64; 3]>, p: [f64; 3]| {
        let norm = p.iter().map(|c| c * c).sum::<f64>().sqrt();
        let p = p.map(|c| c / norm);
        let near = |q: &[f64; 3]| q.iter().zip(&p).all(|(a, b)| (a - b).abs() < 1e-9);
        corners.iter().position(near).unwrap_or_else(|| {
            corners.push(p);
            corners.len() - 1
        })
    };
    for octant in 0..8u8 {
        let sign = [0, 1, 2].map(|axis| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 });
        let odd = octant.count_ones() % 2 == 1;
        for i in 0..SIDE {
            for j in 0..SIDE - i {
                let mut corner = |i: usize, j: usize| {
                    let p = [i as f64, j as f64, (SIDE - i - j) as f64];
                    index(&mut corners, [p[0] * sign[0], p[1] * sign[1], p[2] * sign[2]])
                };
                let mut add =
                    |a: usize, b: usize, c: usize| faces.push(if odd { [a, c, b] } else { [a, b, c] });
                let [a, b, c] = [corner(i, j), corner(i + 1, j), corner(i, j + 1)];
                add(a, b, c);
                if i + j + 2 <= SIDE {
                    let d = corner(i + 1, j + 1);
                    add(b, d, c);
                }
            }
        }
    }
    let mut text = format!("OFF\n{} {} 0\n", corners.len(), faces.len());
    text.push_str(&lines(corners.into_iter()));
    for [a, b, c] in faces {
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text
}
