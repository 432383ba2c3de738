//! Thin parts made of one sheet, and scans of them: plates, shells, brackets and blades, all with an outline that no motion carries into itself.

#![allow(dead_code, reason = "every user needs another part")]

use std::fmt::Write as _;

pub(crate) type Point = [f64; 3];

/// Diagonal of all parts, about.
pub(crate) const SIZE: f64 = 117.0;

/// Names of the parts.
pub(crate) const KINDS: [&str; 5] = ["plate", "curved plate", "shell", "bracket", "blade"];

/// Random numbers that are the same in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (mixed >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn gauss(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }
}

pub(crate) fn sum(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn times(a: Point, factor: f64) -> Point {
    a.map(|c| c * factor)
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Point) -> Point {
    times(a, 1.0 / dot(a, a).sqrt())
}

fn difference(a: Point, b: Point) -> Point {
    sum(a, times(b, -1.0))
}

/// A turn by an angle in degrees about an axis.
pub(crate) fn turned(x: Point, axis: Point, degrees: f64) -> Point {
    let (axis, (sine, cosine)) = (unit(axis), degrees.to_radians().sin_cos());
    let along = times(axis, dot(axis, x) * (1.0 - cosine));
    sum(sum(times(x, cosine), times(cross(axis, x), sine)), along)
}

/// The middle of the sheet of a part over the unit square.
fn middle(kind: &str, u: f64, v: f64) -> Point {
    match kind {
        "plate" => [100.0 * u, 60.0 * v, 0.0],
        "curved plate" => [100.0 * u, 60.0 * v, 3.0 * (2.5 * u).sin() + 1.5 * u * v],
        "shell" => {
            let (sine, cosine) = ((u - 0.5) * 1.6).sin_cos();
            [60.0 * sine, 60.0 * v, 60.0 * cosine + 6.0 * (3.0 * v + 1.0).sin()]
        }
        "bracket" => {
            let (one, radius, other) = (60.0, 5.0, 35.0);
            let arc = radius * std::f64::consts::FRAC_PI_2;
            let s = u * (one + arc + other);
            let [x, z] = if s < one {
                [s, 0.0]
            } else if s < one + arc {
                let (sine, cosine) = ((s - one) / radius).sin_cos();
                [one + radius * sine, radius * (1.0 - cosine)]
            } else {
                [one + radius, radius + s - one - arc]
            };
            [x, 50.0 * v, z]
        }
        _ => {
            let (sine, cosine) = (0.6 * v).sin_cos();
            let (x, y) = ((u - 0.4) * 40.0 * (1.0 - 0.4 * v), 2.5 * (std::f64::consts::PI * u).sin());
            [x * cosine - y * sine, x * sine + y * cosine, 100.0 * v]
        }
    }
}

/// Whether a cell of the unit square belongs to a part: a corner and a hole do not.
fn is_inside(kind: &str, u: f64, v: f64) -> bool {
    kind == "blade" || !(u > 0.74 && v > 0.74 || (0.14..0.3).contains(&u) && (0.17..0.34).contains(&v))
}

/// A part as a closed mesh: vertices and triangles, those of the upper side first.
pub(crate) struct Part {
    pub(crate) vertices: Vec<Point>,
    pub(crate) triangles: Vec<[usize; 3]>,
    /// Number of triangles of the upper side.
    pub(crate) upper: usize,
}

impl Part {
    /// `thickness` is a share of the size.
    pub(crate) fn new(kind: &str, thickness: f64) -> Self {
        let [columns, rows]: [i32; 2] = if kind == "bracket" { [36, 12] } else { [24, 18] };
        let half = 0.5 * SIZE * thickness;
        let (mut upper, mut lower) = (Vec::new(), Vec::new());
        for i in 0..=columns {
            for j in 0..=rows {
                let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
                let at = |du: f64, dv: f64| middle(kind, u + du, v + dv);
                let h = 1e-5;
                let along_u = difference(at(h, 0.0), at(-h, 0.0));
                let normal = unit(cross(along_u, difference(at(0.0, h), at(0.0, -h))));
                let half = if kind == "blade" { half * (0.15 + 1.6 * u.sqrt() * (1.0 - u)) } else { half };
                upper.push(sum(at(0.0, 0.0), times(normal, half)));
                lower.push(sum(at(0.0, 0.0), times(normal, -half)));
            }
        }
        let cell = |i: i32, j: i32| {
            let (u, v) = ((f64::from(i) + 0.5) / f64::from(columns), (f64::from(j) + 0.5) / f64::from(rows));
            (0..columns).contains(&i) && (0..rows).contains(&j) && is_inside(kind, u, v)
        };
        let vertex = |i: i32, j: i32| usize::try_from(i * (rows + 1) + j).unwrap_or(0);
        let (mut triangles, mut others, below) = (Vec::new(), Vec::new(), upper.len());
        for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))).filter(|&(i, j)| cell(i, j)) {
            let corners = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            let [a, b, c, d] = corners;
            triangles.extend([[a, b, c], [a, c, d]]);
            others.extend([[below + a, below + c, below + b], [below + a, below + d, below + c]]);
            for (side, (di, dj)) in [(0, -1), (1, 0), (0, 1), (-1, 0)].into_iter().enumerate() {
                let (p, q) = (corners[side], corners[(side + 1) % 4]);
                if !cell(i + di, j + dj) {
                    others.extend([[p, below + q, q], [p, below + p, below + q]]);
                }
            }
        }
        let count = triangles.len();
        triangles.extend(others);
        upper.extend(lower);
        Self { vertices: upper, triangles, upper: count }
    }

    /// As an OFF file.
    pub(crate) fn to_off(&self) -> String {
        let mut text = format!("OFF\n{} {} 0\n", self.vertices.len(), self.triangles.len());
        for [x, y, z] in &self.vertices {
            let _ = writeln!(text, "{x} {y} {z}");
        }
        for [a, b, c] in &self.triangles {
            let _ = writeln!(text, "3 {a} {b} {c}");
        }
        text
    }

    /// Random points of the upper side, with its normals.
    pub(crate) fn scan(&self, count: usize, random: &mut Random) -> (Vec<Point>, Vec<Point>) {
        let corners = |k: usize| self.triangles[k].map(|i| self.vertices[i]);
        let across = |k: usize| {
            let [a, b, c] = corners(k);
            cross(difference(b, a), difference(c, a))
        };
        let mut areas = vec![0.0];
        for k in 0..self.upper {
            areas.push(areas[k] + dot(across(k), across(k)).sqrt());
        }
        let total = areas[self.upper];
        (0..count)
            .map(|_| {
                let at = random.unit() * total;
                let k = areas.partition_point(|area| *area <= at).clamp(1, self.upper) - 1;
                let [a, b, c] = corners(k);
                let (s, t) = (random.unit(), random.unit());
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                let x = sum(a, sum(times(difference(b, a), s), times(difference(c, a), t)));
                (x, unit(across(k)))
            })
            .unzip()
    }
}

/// A bend and a twist of a part that was made badly: how far a point is off along its normal, at most about the share `warp` of the size.
pub(crate) fn warped(x: Point, normal: Point, centre: Point, warp: f64) -> Point {
    let from = difference(x, centre);
    let (s, t) = ((from[0] + from[2]) / SIZE, from[1] / SIZE);
    sum(x, times(normal, warp * SIZE * (4.0 * s * s - 3.0 * t * t + 3.0 * s * t)))
}

pub(crate) fn centre(points: &[Point]) -> Point {
    times(points.iter().fold([0.0; 3], |all, x| sum(all, *x)), 1.0 / points.len() as f64)
}
