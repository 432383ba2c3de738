//! Primitives through the public API: against minimisers computed with 50 digits, under motions and scales, with outliers.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use nalgebra::{Rotation3, SVector, Vector2, Vector3};
use nurbs_core::Frame;
use sdm_fit::Error;
use sdm_fit::primitive::{
    Elements, PrimitiveOptions, PrimitiveOutliers, PrimitiveStatus, fit_circle, fit_circle_in_space,
    fit_cone, fit_cylinder, fit_line, fit_plane, fit_sphere, fit_torus,
};

/// Numbers in [−½, ½), the same everywhere.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    }

    fn vector<const D: usize>(&mut self) -> SVector<f64, D> {
        SVector::from_fn(|_, _| self.next())
    }
}

/// What a fit is asked for: elements, status and rms.
type Answer = Result<(Elements<3>, PrimitiveStatus, f64), Error>;

fn fit(name: &str, points: &[Vector3<f64>], options: &PrimitiveOptions) -> Answer {
    macro_rules! call {
        ($f:ident) => {
            $f(points, options).map(|fit| (fit.elements, fit.status, fit.rms))
        };
    }
    match name {
        "line" => call!(fit_line),
        "plane" => call!(fit_plane),
        "circle" => call!(fit_circle_in_space),
        "sphere" => call!(fit_sphere),
        "cylinder" => call!(fit_cylinder),
        "cone" => call!(fit_cone),
        _ => call!(fit_torus),
    }
}

/// A piece of each shape, 16 × 5 points, not a full turn of any.
fn piece(name: &str, i: usize) -> Vector3<f64> {
    let (a, b) = ((i % 16) as f64 / 16.0, (i / 16) as f64 / 5.0);
    let around = |r: f64, angle: f64, h: f64| Vector3::new(r * angle.cos(), r * angle.sin(), h);
    match name {
        "line" => Vector3::new(0.0, 0.0, 8.0 * (a + b / 16.0)),
        "plane" => Vector3::new(6.0 * a, 5.0 * b, 0.0),
        "circle" => around(4.0, 0.5 * a + 0.3 * b, 0.0),
        "sphere" => around(4.0 * (0.8 * b).cos(), a, 4.0 * (0.8 * b).sin()),
        "cylinder" => around(3.0, 1.6 * a, 2.0 * b),
        "cone" => around(2.0 + 1.5 * b, 5.0 * a, 3.0 * b),
        _ => around(5.0 + 1.5 * (2.5 * b + 0.3).cos(), 3.0 * a, 1.5 * (2.5 * b + 0.3).sin()),
    }
}

const ALL: [&str; 7] = ["line", "plane", "circle", "sphere", "cylinder", "cone", "torus"];

/// The piece in a position of its own.
fn placed(name: &str) -> Vec<Vector3<f64>> {
    let frame = Frame::from_axis(Vector3::new(10.0, -4.0, 3.0), Vector3::new(1.0, 2.0, 2.0)).unwrap();
    (0..80).map(|i| frame.point(&piece(name, i))).collect()
}

/// The same with noise, rounded to six digits so that every machine has the same points.
fn noisy(name: &str) -> Vec<Vector3<f64>> {
    let mut noise = Noise(7);
    placed(name).iter().map(|p| p.map(|c| ((c + 0.05 * noise.next()) * 1e6).round() / 1e6)).collect()
}

/// Location, direction and sizes of the least squares shapes of [`noisy`], computed with 50 digits by Gauss-Newton
/// iteration in other unknowns (axis point, tilt and sizes) to steps of 1e-28.
const MINIMISERS: [(&str, &[f64]); 7] = [
    (
        "line",
        &[
            11.315_562_925,
            -1.368_307_862_5,
            5.633_543_937_5,
            0.333_555_587_995_115_53,
            0.665_971_718_917_239_4,
            0.667_249_832_761_050_8,
        ],
    ),
    (
        "plane",
        &[
            12.650_546_675,
            -3.250_340_162_5,
            0.923_084_362_5,
            0.332_323_707_213_162_23,
            0.666_637_333_767_485_9,
            0.667_199_834_271_171,
        ],
    ),
    (
        "circle",
        &[
            10.052_866_295_539_523,
            -3.957_321_655_714_689_5,
            3.027_241_125_813_026,
            0.349_054_671_777_234_26,
            0.664_838_959_750_949_5,
            0.660_416_530_462_224_7,
            3.964_495_763_380_539,
        ],
    ),
    (
        "sphere",
        &[9.983_671_103_415_29, -4.007_252_338_398_55, 3.012_108_546_477_844_8, 4.017_334_688_076_009],
    ),
    (
        "cylinder",
        &[
            10.287_594_394_285_346,
            -3.461_601_915_840_338,
            3.520_315_592_274_246,
            0.336_586_775_585_038_24,
            0.664_399_082_523_249_1,
            0.667_295_438_050_892_1,
            2.976_197_727_839_229,
        ],
    ),
    (
        "cone",
        &[
            10.393_124_348_278_013,
            -3.197_695_548_064_276_6,
            3.795_880_779_975_233,
            0.335_519_170_108_481_7,
            0.664_225_969_422_622_2,
            0.668_005_050_904_776_8,
            2.601_052_023_270_871,
            0.464_188_848_113_454_3,
        ],
    ),
    (
        "torus",
        &[
            9.998_844_819_264_518,
            -3.994_871_354_150_659_3,
            2.992_243_952_813_791_6,
            0.334_091_511_443_928_24,
            0.667_393_915_945_781_6,
            0.665_558_579_645_448_4,
            4.991_663_080_175_878,
            1.504_441_882_011_314_8,
        ],
    ),
];

#[test]
fn minimisers_agree_with_those_of_fifty_digits() {
    for (name, expected) in MINIMISERS {
        let (elements, status, _) = fit(name, &noisy(name), &PrimitiveOptions::default()).unwrap();
        assert_eq!(status, PrimitiveStatus::Converged, "{name}");
        for (found, expected) in elements.values().iter().zip(expected) {
            let off = (found - expected).abs();
            assert!(off <= 1e-12 * (1.0 + expected.abs()), "{name}: {found} for {expected}, off by {off:e}");
        }
    }
}

#[test]
fn exact_points_give_exact_shapes() {
    let z = Vector3::new(1.0, 2.0, 2.0) / 3.0;
    let centre = Vector3::new(10.0, -4.0, 3.0);
    for name in ALL {
        let (found, status, rms) = fit(name, &placed(name), &PrimitiveOptions::default()).unwrap();
        assert_eq!(status, PrimitiveStatus::Converged, "{name}");
        assert!(rms < 1e-14 * 20.0, "{name}: {rms:e}");
        let off = found.location - centre;
        let off = match name {
            "line" | "cylinder" | "cone" => off - z * off.dot(&z),
            "plane" => z * off.dot(&z),
            _ => off,
        };
        assert!(off.norm() < 1e-12 * 10.0, "{name}: {:e}", off.norm());
        if let Some(direction) = found.direction {
            assert!((direction - z).norm() < 1e-12, "{name}: {:e}", (direction - z).norm());
        }
        let sizes: &[f64] = match name {
            "circle" | "sphere" => &[4.0],
            "cylinder" => &[3.0],
            "cone" => &[found.radius.unwrap(), 0.5f64.atan()],
            "torus" => &[5.0, 1.5],
            _ => &[],
        };
        let values = found.values();
        for (found, expected) in values[values.len() - sizes.len()..].iter().zip(sizes) {
            assert!((found - expected).abs() < 1e-12 * 10.0, "{name}: {found} for {expected}");
        }
    }
}

#[test]
fn far_origins_and_scales_do_no_harm() {
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7));
    for name in ALL {
        let points = noisy(name);
        let (plain, _, rms) = fit(name, &points, &PrimitiveOptions::default()).unwrap();
        for (scale, shift) in [(1e3, 0.0), (1e-3, 0.0), (1.0, 1e6), (1e-3, 1e3)] {
            let shift = Vector3::new(1.0, -0.5, 0.25) * shift;
            let moved: Vec<_> = points.iter().map(|p| turn * p * scale + shift).collect();
            let (found, status, moved_rms) = fit(name, &moved, &PrimitiveOptions::default()).unwrap();
            assert_eq!(status, PrimitiveStatus::Converged, "{name}");
            // What rounding of the moved coordinates does, with room for the conditioning of short arcs.
            let tolerance = 1e-11 + 3e3 * f64::EPSILON * shift.amax() / scale;
            let off = (found.location - (turn * plain.location * scale + shift)).norm() / scale;
            assert!(off < tolerance * 10.0, "{name} {scale} {shift:?}: {off:e}");
            assert!((moved_rms / scale - rms).abs() < tolerance, "{name}");
            if let (Some(a), Some(b)) = (found.direction, plain.direction) {
                assert!(a.cross(&(turn * b)).norm() < tolerance, "{name}");
            }
            let size = found.radius.zip(plain.radius).map_or(0.0, |(a, b)| (a / scale - b).abs());
            assert!(size < tolerance * 10.0, "{name}: {size:e}");
        }
    }
}

#[test]
fn short_arcs() {
    // 1° of a circle, 5° by 5° of a sphere, 10° of a cylinder; exact points.
    let arc: Vec<_> = (0..50).map(|i| i as f64 / 49.0 * 1f64.to_radians()).collect();
    let points: Vec<_> = arc.iter().map(|t| Vector2::new(100.0 * t.cos(), 100.0 * t.sin())).collect();
    let found = fit_circle(&points, &PrimitiveOptions::default()).unwrap();
    assert!(found.is_converged());
    // The sagitta is 4e-3, coordinates are rounded at 1e-14.
    assert!((found.shape.radius() - 100.0).abs() < 1e-8, "{:e}", found.shape.radius() - 100.0);

    let grid = |i: usize| ((i % 8) as f64 / 7.0 * 0.1, (i / 8) as f64 / 7.0);
    let sphere: Vec<_> = (0..64)
        .map(grid)
        .map(|(u, v)| (u, 0.1 * v))
        .map(|(u, v)| Vector3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin()) * 7.0)
        .collect();
    let found = fit_sphere(&sphere, &PrimitiveOptions::default()).unwrap();
    assert!(found.is_converged() && (found.shape.radius() - 7.0).abs() < 1e-10, "{found}");

    let cylinder: Vec<_> = (0..64)
        .map(grid)
        .map(|(u, v)| Vector3::new(v, 2.0 * (1.7 * u).cos(), 2.0 * (1.7 * u).sin()))
        .collect();
    let found = fit_cylinder(&cylinder, &PrimitiveOptions::default()).unwrap();
    assert!(found.is_converged() && (found.shape.radius() - 2.0).abs() < 1e-10, "{found}");
    assert!(found.shape.frame().z().x.abs() > 1.0 - 1e-14);
}

#[test]
fn noisy_arcs_are_minima() {
    // No random change of the unknowns lowers the sum: the unknowns of the oracle are the elements themselves.
    let mut noise = Noise(3);
    let points: Vec<_> = (0..60)
        .map(|i| i as f64 / 60.0 * 0.6)
        .map(|t| Vector2::new(5.0 * t.cos(), 5.0 * t.sin()) + noise.vector::<2>() * 0.08)
        .collect();
    let sum = |c: &Vector2<f64>, r: f64| points.iter().map(|p| ((p - c).norm() - r).powi(2)).sum::<f64>();
    let found = fit_circle(&points, &PrimitiveOptions::default()).unwrap();
    let (centre, radius) = (found.shape.centre(), found.shape.radius());
    let least = sum(&centre, radius);
    for k in 0..4000 {
        let size = [1.0, 1e-1, 1e-2, 1e-3][k % 4];
        let changed = sum(&(centre + noise.vector::<2>() * size), radius + noise.next() * size);
        assert!(changed >= least * (1.0 - 1e-14), "{changed} < {least}");
    }
    // The gradient vanishes in comparison with its parts.
    let (mut gradient, mut parts) = (Vector3::zeros(), 0.0);
    for p in &points {
        let n = (p - centre).normalize();
        let d = (p - centre).norm() - radius;
        gradient += Vector3::new(n.x, n.y, 1.0) * d;
        parts += d.abs();
    }
    assert!(gradient.norm() < 1e-13 * parts, "{:e}", gradient.norm() / parts);
}

#[test]
fn outliers_are_told_apart() {
    for name in ALL {
        let mut noise = Noise(11);
        let mut points = placed(name);
        let inliers = points.len();
        // One in five is elsewhere in the box.
        points.extend((0..20).map(|_| Vector3::new(10.0, -4.0, 3.0) + noise.vector::<3>() * 12.0));
        let (clean, ..) = fit(name, &placed(name), &PrimitiveOptions::default()).unwrap();
        for outliers in [
            PrimitiveOutliers::Tukey { abs_scale: None },
            PrimitiveOutliers::Trimmed { outliers: 1.0 - inliers as f64 / points.len() as f64 },
        ] {
            let options = PrimitiveOptions::default().with_outliers(outliers);
            let (found, _, rms) = fit(name, &points, &options).unwrap();
            assert!(rms < 1e-8, "{name} {outliers:?}: {rms:e}");
            let radius = found.radius.zip(clean.radius).map_or(0.0, |(a, b)| (a - b).abs());
            // The location of a cone is where the mean of the points is, and the radius goes with it.
            assert!(radius < 1e-8 || name == "cone", "{name} {outliers:?}: {radius:e}");
        }
    }
}

#[test]
fn pieces_of_any_size_are_found() {
    // The minimum cannot be worse than the shape that the points were made of.
    let mut noise = Noise(17);
    for round in 0..20 {
        for name in ["cylinder", "cone", "torus"] {
            let span = |noise: &mut Noise, low: f64, high: f64| low + (high - low) * (noise.next() + 0.5);
            let (turn, tube) = (span(&mut noise, 0.8, 6.2), span(&mut noise, 1.0, 6.2));
            let (length, slope) = (span(&mut noise, 0.5, 8.0), span(&mut noise, 0.1, 1.5));
            let minor = span(&mut noise, 0.3, 2.0);
            let frame = Frame::from_axis(noise.vector::<3>() * 40.0, noise.vector::<3>()).unwrap();
            let sigma = 0.01;
            let mut square_sum = 0.0;
            let points: Vec<_> = (0..400)
                .map(|_| {
                    let (a, b) = (turn * noise.next(), noise.next());
                    let (radius, height, tilt) = match name {
                        "cylinder" => (3.0, length * b, 0.0),
                        "cone" => (1.0 + length * slope * (b + 0.5), length * b, -slope.atan()),
                        _ => (3.0 + minor * (tube * b).cos(), minor * (tube * b).sin(), tube * b),
                    };
                    let normal = Vector3::new(tilt.cos() * a.cos(), tilt.cos() * a.sin(), tilt.sin());
                    let off = sigma * noise.next();
                    square_sum += off * off;
                    frame.point(&(Vector3::new(radius * a.cos(), radius * a.sin(), height) + normal * off))
                })
                .collect();
            let true_rms = (square_sum / 400.0).sqrt();
            let (_, status, rms) = fit(name, &points, &PrimitiveOptions::default()).unwrap();
            assert_eq!(status, PrimitiveStatus::Converged, "{name} {round}");
            assert!(
                rms <= true_rms,
                "{name} {round}: {rms} > {true_rms} (turn {turn}, tube {tube}, length {length}, slope {slope}, minor {minor})"
            );
        }
    }
}

#[test]
fn covariance_tells_how_far_noise_carries() {
    // Many times the same circle with other noise: the spread of the radii is what the covariance says.
    let mut noise = Noise(5);
    let options = PrimitiveOptions::default().with_covariance(true);
    let (mut spread, mut claimed, rounds) = (0.0, 0.0, 300);
    for _ in 0..rounds {
        let points: Vec<_> = (0..40)
            .map(|i| i as f64 / 40.0 * 2.0)
            .map(|t| Vector2::new(3.0 * t.cos(), 3.0 * t.sin()) + noise.vector::<2>() * 0.02)
            .collect();
        let found = fit_circle(&points, &options).unwrap();
        spread += (found.shape.radius() - 3.0).powi(2) / f64::from(rounds);
        claimed += found.covariance[2][2] / f64::from(rounds);
    }
    assert!((spread / claimed - 1.0).abs() < 0.25, "{spread:e} {claimed:e}");
}

#[test]
fn duplicates_count_twice_and_do_no_harm() {
    for name in ALL {
        let points = noisy(name);
        let doubled: Vec<_> = points.iter().chain(&points).copied().collect();
        let (once, ..) = fit(name, &points, &PrimitiveOptions::default()).unwrap();
        let (twice, ..) = fit(name, &doubled, &PrimitiveOptions::default()).unwrap();
        assert!((once.location - twice.location).norm() < 1e-11, "{name}");
    }
}

#[test]
fn bad_input_is_an_error_or_a_status() {
    let options = PrimitiveOptions::default();
    let on_line: Vec<_> = (0..20).map(|i| Vector3::new(1.0, 2.0, 3.0) * f64::from(i)).collect();
    let on_plane: Vec<_> =
        (0..36).map(|i| Vector3::new(f64::from(i % 6), f64::from(i / 6), f64::from(i % 6))).collect();
    let in_place = vec![Vector3::new(1.0, 2.0, 3.0); 20];
    let mut broken = placed("sphere");
    broken[3].x = f64::NAN;
    broken[5].y = f64::INFINITY;
    for name in ALL {
        assert!(matches!(fit(name, &[], &options), Err(Error::TooFewPoints { .. })), "{name}");
        assert!(matches!(fit(name, &in_place, &options), Err(Error::Degenerate { .. })), "{name}");
        let nothing = vec![Vector3::repeat(f64::NAN); 50];
        assert!(matches!(fit(name, &nothing, &options), Err(Error::TooFewPoints { .. })), "{name}");
        let degenerate = |points| matches!(fit(name, points, &options), Err(Error::Degenerate { .. }));
        assert!(name == "line" || degenerate(&on_line), "{name}");
        assert!(["line", "plane", "circle"].contains(&name) || degenerate(&on_plane), "{name}");
    }
    let found = fit_sphere(&broken, &options).unwrap();
    assert_eq!((found.dropped, found.points, found.used), (2, 80, 78));
    // A circle leaves the sphere open.
    let ring: Vec<_> = (0..30).map(f64::from).map(|t| Vector3::new(t.cos(), t.sin(), 0.0)).collect();
    assert!(matches!(fit_sphere(&ring, &options), Err(Error::Degenerate { .. })));
    let all = options.with_outliers(PrimitiveOutliers::Trimmed { outliers: 1.0 });
    assert!(matches!(fit_sphere(&broken, &all), Err(Error::Option { name: "outliers", .. })));
}

#[test]
fn the_same_bits_again() {
    let points = noisy("torus");
    let options = PrimitiveOptions::default();
    assert_eq!(fit("torus", &points, &options).unwrap().0, fit("torus", &points, &options).unwrap().0);
}
