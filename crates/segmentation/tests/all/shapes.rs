//! Shapes whose parameters are known.

use segmentation::nalgebra::{Point3, Vector3};
use segmentation::{Segmentation, SegmentationOptions, Shape, segment};

/// Uniform numbers in 0..1 from a linear congruential generator (Knuth, MMIX).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Gaussian in space (Box and Muller).
    pub(crate) fn noise(&mut self, sigma: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| {
            let (u, v) = (self.next().max(1e-300), self.next());
            sigma * (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        })
    }
}

pub(crate) fn run(points: &[Point3<f64>]) -> Segmentation {
    segment(points, None, &SegmentationOptions::default()).unwrap()
}

/// Share of the points `from..to` in their most frequent region.
pub(crate) fn share(found: &Segmentation, from: usize, to: usize) -> (f64, Option<u32>) {
    let labels = &found.labels[from..to];
    let best = labels.iter().max_by_key(|l| labels.iter().filter(|m| m == l).count()).unwrap();
    (labels.iter().filter(|l| *l == best).count() as f64 / labels.len() as f64, *best)
}

/// A box of 20 × 16 × 10 with a boss (a cylinder of radius 4 and height 6, its rim a cone of 45°): points of each face.
fn part(sigma: f64) -> (Vec<Point3<f64>>, Vec<usize>) {
    let mut random = Random(7);
    let (mut points, mut ends) = (Vec::new(), Vec::new());
    let mut face = |count: usize, at: &dyn Fn(f64, f64) -> Option<Point3<f64>>| {
        let mut left = count;
        while left > 0 {
            let (u, v) = (random.next(), random.next());
            if let Some(x) = at(u, v) {
                points.push(x + random.noise(sigma));
                left -= 1;
            }
        }
        ends.push(points.len());
    };
    let turn = std::f64::consts::TAU;
    face(1100, &|u, v| {
        let x = Point3::new(20.0 * u - 10.0, 16.0 * v - 8.0, 10.0);
        (x.x.hypot(x.y) > 4.0).then_some(x)
    });
    face(1280, &|u, v| Some(Point3::new(20.0 * u - 10.0, 16.0 * v - 8.0, 0.0)));
    for y in [-8.0, 8.0] {
        face(800, &|u, v| Some(Point3::new(20.0 * u - 10.0, y, 10.0 * v)));
    }
    for x in [-10.0, 10.0] {
        face(640, &|u, v| Some(Point3::new(x, 16.0 * u - 8.0, 10.0 * v)));
    }
    face(500, &|u, v| Some(Point3::new(4.0 * (turn * u).cos(), 4.0 * (turn * u).sin(), 10.0 + 5.0 * v)));
    face(260, &|u, v| {
        let r = 4.0 - 2.0 * v;
        Some(Point3::new(r * (turn * u).cos(), r * (turn * u).sin(), 15.0 + 2.0 * v))
    });
    (points, ends)
}

#[test]
fn faces_of_a_part_with_noise() {
    for sigma in [0.0, 0.01, 0.04] {
        let (points, ends) = part(sigma);
        let found = run(&points);
        let mut labels = Vec::new();
        let mut from = 0;
        for &to in &ends {
            let (part, label) = share(&found, from, to);
            assert!(part > 0.93, "sigma {sigma}: {part} of {from}..{to}");
            labels.push(label.unwrap());
            from = to;
        }
        let mut different = labels.clone();
        different.sort_unstable();
        different.dedup();
        assert_eq!(different.len(), ends.len(), "sigma {sigma}: {labels:?}");
        if sigma > 0.0 {
            assert!((found.sigma / sigma - 1.0).abs() < 0.1, "{} for {sigma}", found.sigma);
        }
        let shape = |k: usize| &found.regions[labels[k] as usize].shape;
        let tolerance = 0.3 * sigma + 1e-6;
        assert!((0..6).all(|k| matches!(shape(k), Shape::Plane { .. })));
        let Shape::Cylinder { axis, radius, .. } = shape(6) else { panic!("{:?}", shape(6)) };
        assert!((radius - 4.0).abs() < tolerance && axis.cross(&Vector3::z()).norm() < tolerance);
        let Shape::Cone { point, half_angle, .. } = shape(7) else { panic!("{:?}", shape(7)) };
        assert!((half_angle - std::f64::consts::FRAC_PI_4).abs() < 2.0 * tolerance, "{half_angle}");
        assert!((point - Point3::new(0.0, 0.0, 19.0)).norm() < 10.0 * tolerance, "{point}");
        // The covariance tells the error that was made: within 5 standard deviations.
        let region = &found.regions[labels[6] as usize];
        if sigma > 0.0 {
            let deviation = region.covariance[4][4].sqrt();
            assert!((radius - 4.0).abs() < 5.0 * deviation && deviation < sigma, "{deviation}");
            assert!((region.chi2 - 1.0).abs() < 0.4, "{}", region.chi2);
        }
    }
}

#[test]
fn a_helical_surface_tells_axis_and_pitch() {
    // A strip between two radii with an advance of 10 per turn: no primitive within the noise. Where it is steep, some pieces stay apart.
    let mut random = Random(3);
    let points: Vec<Point3<f64>> = (0..4000)
        .map(|_| {
            let (a, r) = (2.0 * random.next(), 4.0 + 6.0 * random.next());
            Point3::new(r * a.cos(), r * a.sin(), 10.0 / std::f64::consts::TAU * a) + random.noise(0.002)
        })
        .collect();
    let found = run(&points);
    let Shape::Helix { point, axis, pitch } = found.regions[0].shape else {
        panic!("{:?}", found.regions[0])
    };
    assert!((pitch - 10.0).abs() < 0.05 && axis.cross(&Vector3::z()).norm() < 0.005, "{pitch} {axis}");
    assert!(point.x.hypot(point.y) < 0.05, "{point}");
    assert!(found.regions[0].support > 2400, "{found}");
    // Tilts, shifts and the pitch with their covariance: within 5 standard deviations.
    let covariance = &found.regions[0].covariance;
    let deviation = |k: usize| covariance[k][k].sqrt();
    assert_eq!(covariance.len(), 5);
    assert!((pitch - 10.0).abs() < 5.0 * deviation(4) && deviation(4) < 0.02, "{pitch} {}", deviation(4));
    assert!(axis.x.abs() < 5.0 * deviation(0).max(deviation(1)), "{axis} {}", deviation(0));
}

#[test]
fn flanks_of_a_thread_share_one_motion() {
    // Six short flanks of a screw with six starts, each of which a torus explains as well within this noise.
    let (mut random, mut points) = (Random(5), Vec::new());
    for start in 0..6 {
        for _ in 0..500 {
            let (a, v) = (0.5 * random.next(), random.next());
            let (r, h) = (8.0 + 3.0 * v, 1.5 * (1.0 - v) * v);
            let turn = a + std::f64::consts::TAU * f64::from(start) / 6.0 + 0.25 * h;
            let z = 60.0 / std::f64::consts::TAU * a;
            points.push(Point3::new(r * turn.cos(), r * turn.sin(), z) + random.noise(0.02));
        }
    }
    let found = run(&points);
    for start in 0..6 {
        let (part, label) = share(&found, 500 * start, 500 * start + 500);
        assert!(part > 0.8, "{part} of flank {start}: {found}");
        let shape = &found.regions[label.unwrap() as usize].shape;
        let Shape::Helix { axis, pitch, .. } = shape else { panic!("flank {start}: {shape:?}") };
        assert!((pitch.abs() - 60.0).abs() < 3.0 && axis.cross(&Vector3::z()).norm() < 0.03, "{shape:?}");
    }
}

#[test]
fn results_do_not_depend_on_the_threads() {
    let (points, _) = part(0.02);
    let threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| run(&points))
    };
    assert_eq!(threads(1), threads(3));
}

#[test]
fn a_free_form_sheet_within_the_noise_of_a_torus_is_none() {
    // A sheet that deviates from its torus by less than the noise of a point everywhere, and a piece of a torus for comparison.
    let mut random = Random(3);
    let sigma = 0.05;
    let sheet = |bump: f64, random: &mut Random| -> Vec<Point3<f64>> {
        (0..6000)
            .map(|_| {
                let (u, v) = (20.0 * random.next() - 10.0, 14.0 * random.next() - 7.0);
                // A tube of radius 25 about a circle of radius 15.
                let r = 15.0 + (25.0f64.powi(2) - v * v).sqrt();
                let (s, c) = (u / 40.0).sin_cos();
                let lift = bump * (0.25 * u).sin() * (0.3 * v).cos();
                Point3::new((r + lift) * s, v, (r + lift) * c) + random.noise(sigma)
            })
            .collect()
    };
    let torus = run(&sheet(0.0, &mut random));
    assert!(matches!(torus.regions[0].shape, Shape::Torus { .. }), "{:?}", torus.regions[0]);
    let bumpy = run(&sheet(0.5 * sigma, &mut random));
    assert!(matches!(bumpy.regions[0].shape, Shape::Freeform), "{:?}", bumpy.regions[0]);
    assert!(bumpy.regions[0].support > 5500, "{bumpy}");
}
