//! Faces that the part around them tells, and faces that it must not change.

use crate::shapes::{Random, run, share};
use segmentation::nalgebra::{Point3, Vector3};
use segmentation::{Segmentation, Shape};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Clouds face by face.
struct Faces {
    random: Random,
    sigma: f64,
    points: Vec<Point3<f64>>,
    ends: Vec<usize>,
}

impl Faces {
    fn new(sigma: f64) -> Self {
        Self { random: Random(11), sigma, points: Vec::new(), ends: Vec::new() }
    }

    fn add(&mut self, count: usize, at: impl Fn(f64, f64) -> Option<[f64; 3]>) {
        let mut left = count;
        while left > 0 {
            if let Some(x) = at(self.random.next(), self.random.next()) {
                self.points.push(Point3::from(x) + self.random.noise(self.sigma));
                left -= 1;
            }
        }
        self.ends.push(self.points.len());
    }

    /// The shape of most points of a face, and their share.
    fn shape<'a>(&self, found: &'a Segmentation, face: usize) -> (Option<&'a Shape>, f64) {
        let from = if face == 0 { 0 } else { self.ends[face - 1] };
        let (part, label) = share(found, from, self.ends[face]);
        (label.map(|l| &found.regions[l as usize].shape), part)
    }
}

/// A block of 60 × 40 × 20 with a draft of 3 degrees on its sides: two covers, four sides, four corners of radius 6 at the bottom, which
/// are cones or keep their radius.
fn drafted(sigma: f64, cones: bool) -> Faces {
    let slope = 3f64.to_radians().tan();
    let mut faces = Faces::new(sigma);
    faces.add(4800, |u, v| Some([60.0 * u - 30.0, 40.0 * v - 20.0, 0.0]));
    faces.add(4400, |u, v| Some([57.9 * u - 28.95, 37.9 * v - 18.95, 20.0]));
    // Next to corners of constant radius the sides are wider at the top, where they meet at less distance.
    let half = |z: f64, whole: f64| whole - 6.0 - if cones { 0.0 } else { z * slope };
    for s in [-1.0, 1.0] {
        faces.add(1900, |u, v| {
            let z = 20.0 * v;
            Some([(2.0 * u - 1.0) * half(z, 30.0), s * (20.0 - z * slope), z])
        });
        faces.add(1100, |u, v| {
            let z = 20.0 * v;
            Some([s * (30.0 - z * slope), (2.0 * u - 1.0) * half(z, 20.0), z])
        });
    }
    for (sx, sy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        faces.add(360, |u, v| {
            let (a, z) = (FRAC_PI_2 * u, 20.0 * v);
            let (cx, cy, r) =
                if cones { (24.0, 14.0, 6.0 - z * slope) } else { (24.0 - z * slope, 14.0 - z * slope, 6.0) };
            Some([sx * (cx + r * a.cos()), sy * (cy + r * a.sin()), z])
        });
    }
    faces
}

#[test]
fn corners_of_small_draft_are_cones() {
    let faces = drafted(0.06, true);
    let found = run(&faces.points);
    for corner in 6..10 {
        let (shape, part) = faces.shape(&found, corner);
        let Some(Shape::Cone { axis, half_angle, .. }) = shape else { panic!("corner {corner}: {shape:?}") };
        assert!(part > 0.8 && axis.cross(&Vector3::z()).norm() < 0.01, "{part} {axis}");
        assert!((half_angle.to_degrees() - 3.0).abs() < 1.0, "{}", half_angle.to_degrees());
    }
}

#[test]
fn corners_of_constant_radius_stay_cylinders() {
    let faces = drafted(0.06, false);
    let found = run(&faces.points);
    for corner in 6..10 {
        let (shape, _) = faces.shape(&found, corner);
        assert!(matches!(shape, Some(Shape::Cylinder { .. })), "corner {corner}: {shape:?}");
    }
}

/// A plate of 40 × 40 × 10 with a hole of radius 4 drilled at an angle of 8 degrees.
#[test]
fn a_hole_at_an_angle_stays_a_cylinder() {
    let lean = 8f64.to_radians();
    let axis = Vector3::new(lean.sin(), 0.0, lean.cos());
    let mut faces = Faces::new(0.05);
    for z in [0.0, 10.0] {
        faces.add(3000, |u, v| {
            let (x, y) = (40.0 * u - 20.0, 40.0 * v - 20.0);
            ((x - z * lean.tan()).hypot(y) > 4.1).then_some([x, y, z])
        });
    }
    for s in [-20.0, 20.0] {
        faces.add(800, |u, v| Some([s, 40.0 * u - 20.0, 10.0 * v]));
        faces.add(800, |u, v| Some([40.0 * u - 20.0, s, 10.0 * v]));
    }
    faces.add(600, |u, v| {
        let (sine, cosine) = (TAU * u).sin_cos();
        let across = Vector3::new(lean.cos(), 0.0, -lean.sin());
        // Along the axis from cover to cover.
        let ring = across * (4.0 * cosine) + Vector3::y() * (4.0 * sine);
        let x = ring + axis * ((10.0 * v - ring.z) / axis.z);
        Some([x.x, x.y, x.z])
    });
    let found = run(&faces.points);
    let (shape, part) = faces.shape(&found, 6);
    let Some(Shape::Cylinder { axis: found_axis, radius, .. }) = shape else { panic!("{shape:?}") };
    assert!(part > 0.9 && (radius - 4.0).abs() < 0.05 && found_axis.cross(&axis).norm() < 0.01);
}

/// A rod of radius 6 whose end is a chamfer of 45 degrees, or the zone of a sphere of radius 7.
fn rod(sigma: f64, ball: bool) -> Faces {
    let mut faces = Faces::new(sigma);
    let (inner, height) = if ball { (4.0, 33f64.sqrt() - 13f64.sqrt()) } else { (4.6, 1.4) };
    faces.add(3000, |u, v| Some([6.0 * (TAU * u).cos(), 6.0 * (TAU * u).sin(), -30.0 * v]));
    faces.add(if ball { 500 } else { 180 }, |u, v| {
        let z = height * v;
        let r = if ball { (49.0 - (z + 13f64.sqrt()).powi(2)).sqrt() } else { 6.0 - z };
        Some([r * (TAU * u).cos(), r * (TAU * u).sin(), z])
    });
    faces.add(180, |u, v| {
        let r = inner * v.sqrt();
        Some([r * (TAU * u).cos(), r * (TAU * u).sin(), height])
    });
    faces
}

#[test]
fn a_chamfer_is_a_cone_and_a_ball_a_sphere() {
    for sigma in [0.01, 0.04] {
        let chamfer = rod(sigma, false);
        let found = run(&chamfer.points);
        let (shape, part) = chamfer.shape(&found, 1);
        let Some(Shape::Cone { half_angle, .. }) = shape else { panic!("{sigma}: {shape:?}") };
        assert!(part > 0.8 && (half_angle - FRAC_PI_4).abs() < 0.1, "{sigma}: {part} {half_angle}");
    }
    let ball = rod(0.02, true);
    let found = run(&ball.points);
    let (shape, part) = ball.shape(&found, 1);
    let Some(Shape::Sphere { radius, .. }) = shape else { panic!("{shape:?}") };
    assert!(part > 0.9 && (radius - 7.0).abs() < 0.1, "{part} {radius}");
}

#[test]
fn sides_of_a_slot_stay_four_faces() {
    let mut faces = Faces::new(0.03);
    for s in [-1.0, 1.0] {
        faces.add(1000, |u, v| Some([20.0 * u - 10.0, 5.0 * s, 12.0 * v]));
        faces.add(900, |u, v| {
            let (sine, cosine) = (PI * (u - 0.5)).sin_cos();
            Some([s * (10.0 + 5.0 * cosine), 5.0 * sine, 12.0 * v])
        });
    }
    let found = run(&faces.points);
    for face in 0..4 {
        let (shape, part) = faces.shape(&found, face);
        let right = match shape {
            Some(Shape::Plane { .. }) => face % 2 == 0,
            Some(Shape::Cylinder { radius, .. }) => face % 2 == 1 && (radius - 5.0).abs() < 0.05,
            _ => false,
        };
        assert!(right && part > 0.9, "face {face}: {part} {shape:?}");
    }
}

/// An elliptic boss of semi-axes 20 and 12 whose upper edge is rounded with radius 2: the wall, the blend, the cover.
fn boss(sigma: f64) -> Faces {
    let mut faces = Faces::new(sigma);
    // The offset of the ellipse by d at an angle, inwards.
    let at = |a: f64, d: f64| {
        let n = Vector3::new(12.0 * a.cos(), 20.0 * a.sin(), 0.0).normalize();
        Vector3::new(20.0 * a.cos(), 12.0 * a.sin(), 0.0) - n * d
    };
    // Angles by length, for an even density: the share of the longest.
    let even = |a: f64, d: f64, v: f64| {
        let speed = |a: f64| (20.0 * a.sin()).hypot(12.0 * a.cos());
        let radius = 240.0 / speed(a).powi(3);
        speed(a) * (1.0 - d * radius) > 20.0 * v
    };
    faces.add(4200, |u, v| {
        let (a, z) = (TAU * u, 15.0 * (v * 7.0).fract());
        let x = at(a, 0.0);
        even(a, 0.0, (v * 7.0).floor() / 7.0).then_some([x.x, x.y, z])
    });
    faces.add(880, |u, v| {
        let (a, t) = (TAU * u, FRAC_PI_2 * (v * 7.0).fract());
        let d = 2.0 * (1.0 - t.cos());
        let x = at(a, d);
        even(a, d, (v * 7.0).floor() / 7.0).then_some([x.x, x.y, 15.0 + 2.0 * t.sin()])
    });
    faces.add(1600, |u, v| {
        let (x, y) = (36.0 * u - 18.0, 20.0 * v - 10.0);
        ((x / 18.0).hypot(y / 10.0) < 1.0).then_some([x, y, 17.0])
    });
    faces
}

#[test]
fn an_extrusion_ends_at_its_blend() {
    for sigma in [0.0, 0.01] {
        let faces = boss(sigma);
        let found = run(&faces.points);
        let (wall, part) = faces.shape(&found, 0);
        let Some(Shape::Extrusion { axis }) = wall else { panic!("{sigma}: {wall:?} {part}") };
        assert!(part > 0.85 && axis.cross(&Vector3::z()).norm() < 0.01, "{sigma}: {part} {axis}");
        let (cover, part) = faces.shape(&found, 2);
        assert!(matches!(cover, Some(Shape::Plane { .. })) && part > 0.9, "{sigma}: {part} {cover:?}");
        // The blend, in pieces perhaps, is not the wall's.
        let wall_label = share(&found, 0, faces.ends[0]).1;
        let lost = found.labels[faces.ends[0]..faces.ends[1]].iter().filter(|l| **l == wall_label).count();
        assert!(lost < 300, "{sigma}: {lost} of the blend on the wall");
    }
}
