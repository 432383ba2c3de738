//! Which poses are called converged: right ones on ordinary data, and no others.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small counts")]

use crate::bodies::Bumpy;
use crate::common::{Random, distance, model};
use distance_field::{CloudField, DistanceField, MeshField, SurfaceField};
use mesh_core::TriangleMesh;
use nalgebra::{Matrix3, Point3, Vector3};
use nurbs_core::ParametricSurface;
use sdm_register::{
    Doubt, Locks, Outliers, Pose, RegisterOptions, RegisterReport, Source, Status, register, rotation,
};

type Points = Vec<Vector3<f64>>;

/// Points of a part of the surface of the cases (2.0 × 0.8 × 0.4), `u` and `v` from, to.
fn part(u: [f64; 2], v: [f64; 2], count: usize, noise: f64, random: &mut Random) -> Points {
    let surface = model();
    let place = |[low, high]: [f64; 2], random: &mut Random| low + (high - low) * random.uniform();
    (0..count)
        .map(|_| {
            let (u, v) = (place(u, random), place(v, random));
            surface.point(u, v) + random.vector() * noise
        })
        .collect()
}

fn inside(low: Vector3<f64>, high: Vector3<f64>, count: usize, random: &mut Random) -> Points {
    let mut unit = || Vector3::new(random.uniform(), random.uniform(), random.uniform());
    (0..count).map(|_| low + unit().component_mul(&(high - low))).collect()
}

fn sphere(radius: f64, count: usize, random: &mut Random) -> Points {
    (0..count).map(|_| random.vector().normalize() * radius).collect()
}

fn bumpy(count: usize, towards: Option<(Vector3<f64>, f64)>, seed: u64) -> Points {
    Bumpy::new().view(towards, count, &mut crate::bodies::Random(seed)).0
}

fn cuboid(sides: [f64; 3]) -> TriangleMesh {
    let corner = |i: u8| {
        let side = |k: usize| sides[k] * (f64::from(i >> k & 1) - 0.5);
        Point3::new(side(0), side(1), side(2))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap()
}

/// A turn about the centre of the points, and a shift.
fn away(points: &[Vector3<f64>], degrees: f64, shift: f64, random: &mut Random) -> Pose<3> {
    let centre = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let turn: Matrix3<f64> =
        rotation::exponential::<3>(&(random.vector().normalize() * degrees.to_radians())).0;
    Pose {
        scale: 1.0,
        rotation: turn,
        source_origin: centre,
        target_origin: centre + random.vector().normalize() * shift,
    }
}

fn size(points: &[Vector3<f64>]) -> f64 {
    let low = points.iter().fold(Vector3::repeat(f64::INFINITY), |low, x| low.inf(x));
    let high = points.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |high, x| high.sup(x));
    (high - low).norm()
}

fn run(
    field: &dyn DistanceField<3>,
    points: &[Vector3<f64>],
    start: &Pose<3>,
    options: &RegisterOptions<3>,
) -> RegisterReport<3> {
    register(field, &Source::new(points), start, options).unwrap()
}

/// What is wrong with the verdicts of runs from several starts, of points whose right pose is the identity, or that have none.
struct Tally {
    wrong: Vec<String>,
}

impl Tally {
    fn add(&mut self, what: String) {
        self.wrong.push(what);
    }

    fn converges(&mut self, name: &str, report: &RegisterReport<3>, inliers: &[Vector3<f64>], limit: f64) {
        let error = distance(inliers, &report.pose, &Pose::identity()) / size(inliers);
        if error > limit || !report.is_converged() {
            self.add(format!("{name}: error {error:.1e} {report} | {}", report.support));
        }
    }

    /// Either right, or not converged.
    fn knows(
        &mut self,
        name: &str,
        report: &RegisterReport<3>,
        inliers: &[Vector3<f64>],
        limit: f64,
    ) -> bool {
        let error = distance(inliers, &report.pose, &Pose::identity()) / size(inliers);
        if error > limit && report.is_converged() {
            self.add(format!("{name}: error {error:.1e} {report} | {}", report.support));
        }
        error <= limit && report.is_converged()
    }

    fn never(&mut self, name: &str, report: &RegisterReport<3>) {
        if report.is_converged() {
            self.add(format!("{name}: {report} | {}", report.support));
        }
    }

    fn check(self) {
        assert!(self.wrong.is_empty(), "{} wrong:\n{}", self.wrong.len(), self.wrong.join("\n"));
    }
}

#[test]
fn right_poses_on_ordinary_data_are_converged() {
    let field = SurfaceField::new(&model()).unwrap();
    let mut tally = Tally { wrong: Vec::new() };
    let all = [0.02, 0.98];
    for seed in 1..=3 {
        let mut random = Random::new(seed);
        let options = RegisterOptions::default();
        for noise in [0.0, 1e-4, 2e-3, 1e-2] {
            for (u, v) in [(all, all), ([0.1, 0.6], all), ([0.3, 0.95], [0.1, 0.8]), ([0.2, 0.6], [0.2, 0.9])]
            {
                for count in [150, 2000, 12_000] {
                    let points = part(u, v, count, noise, &mut random);
                    let start = away(&points, 6.0, 0.04, &mut random);
                    let report = run(&field, &points, &start, &options);
                    let limit = 1e-9 + 60.0 * noise / (count as f64).sqrt();
                    tally.converges(
                        &format!("part {u:?} {v:?} {count} noise {noise}"),
                        &report,
                        &points,
                        limit,
                    );
                }
            }
        }
        for (share, noise) in [(0.1, 1e-3), (0.4, 1e-3), (0.6, 1e-3), (0.3, 0.0)] {
            let mut points = part(all, all, 2000, noise, &mut random);
            let inliers = points.clone();
            let others = (2000.0 * share / (1.0 - share)) as usize;
            points.extend(inside(Vector3::repeat(-0.3), Vector3::new(2.3, 1.2, 0.9), others, &mut random));
            let start = away(&points, 5.0, 0.03, &mut random);
            let report = run(&field, &points, &start, &options);
            tally.converges(&format!("outliers {share} noise {noise}"), &report, &inliers, 3e-3);
        }
        for (overlap, noise) in [(0.3, 1e-3), (0.5, 1e-3), (0.9, 1e-3), (0.6, 0.0), (0.7, 5e-3)] {
            let points = part(all, all, 2000, noise, &mut random);
            let start = away(&points, 3.0, 0.02, &mut random);
            let report = run(
                &field,
                &points,
                &start,
                &options.with_outliers(Outliers::Trimmed { outliers: 1.0 - overlap }),
            );
            tally.converges(&format!("trimmed {overlap} noise {noise}"), &report, &points, 1e-9 + noise);
        }
    }
    tally.check();
}

#[test]
fn clouds_on_clouds_are_converged() {
    let mut tally = Tally { wrong: Vec::new() };
    for seed in 1..=3 {
        let mut random = Random::new(seed);
        for (noise, count) in [(0.0, 4000), (1e-3, 4000), (3e-3, 9000)] {
            let noisy = |points: Points, random: &mut Random| -> Points {
                points.into_iter().map(|x| x + random.vector() * noise).collect()
            };
            let whole = noisy(bumpy(count, None, seed), &mut random);
            let whole: Vec<_> = whole.into_iter().map(Point3::from).collect();
            let field = CloudField::new(&whole, None).unwrap();
            let scan = noisy(bumpy(count / 2, Some((Vector3::y(), 1.3)), seed + 50), &mut random);
            let start = away(&scan, 5.0, 0.03, &mut random);
            let report = run(&field, &scan, &start, &RegisterOptions::default());
            tally.converges(&format!("view on body, noise {noise}"), &report, &scan, 2e-3 + noise);
            // Two views with about two thirds in common.
            let one = noisy(bumpy(count, Some((Vector3::y(), 1.4)), seed + 60), &mut random);
            let one: Vec<_> = one.into_iter().map(Point3::from).collect();
            let field = CloudField::new(&one, None).unwrap();
            let towards = Vector3::new(0.6, 0.8, 0.0);
            let other = noisy(bumpy(count, Some((towards, 1.4)), seed + 70), &mut random);
            let start = away(&other, 3.0, 0.02, &mut random);
            let report = run(&field, &other, &start, &RegisterOptions::default());
            tally.converges(&format!("view on view, noise {noise}"), &report, &other, 4e-3 + noise);
        }
    }
    tally.check();
}

/// Pairs of views of a body that have less and less in common: placed well, or not called converged.
#[test]
fn views_with_little_in_common_are_placed_or_doubted() {
    let mut tally = Tally { wrong: Vec::new() };
    let mut placed = [0; 3];
    for seed in 1..=4 {
        let mut random = Random::new(seed);
        let first = random.vector().normalize();
        let one = bumpy(5000, Some((first, 1.25)), seed);
        let one: Vec<_> = one.into_iter().map(Point3::from).collect();
        let field = CloudField::new(&one, None).unwrap();
        let across = first.cross(&random.vector()).normalize();
        for (k, degrees) in [50.0, 70.0, 90.0].into_iter().enumerate() {
            let angle = f64::to_radians(degrees);
            let towards = first * angle.cos() + across * angle.sin();
            let other = bumpy(5000, Some((towards, 1.25)), seed + 10);
            let start = away(&other, 3.0, 0.03, &mut random);
            let report = run(&field, &other, &start, &RegisterOptions::default());
            let good = tally.knows(&format!("{degrees} degrees apart"), &report, &other, 5e-3);
            placed[k] += usize::from(good);
        }
    }
    assert!(placed[0] == 4 && placed[1] >= 3, "{placed:?}");
    tally.check();
}

#[test]
fn what_does_not_belong_together_is_never_converged() {
    let field = SurfaceField::new(&model()).unwrap();
    let body: Vec<_> = bumpy(4000, None, 9).into_iter().map(Point3::from).collect();
    let body = CloudField::new(&body, None).unwrap();
    let cube = MeshField::new(&cuboid([1.0, 0.7, 0.5])).unwrap();
    let fields: [(&str, &dyn DistanceField<3>); 3] = [("surface", &field), ("body", &body), ("box", &cube)];
    let mut tally = Tally { wrong: Vec::new() };

    let (seed, mut random) = (1, Random::new(1));
    for (name, field) in fields {
        let bounds = field.bounding_box();
        let (low, high) = (bounds.min, bounds.max);
        for count in [150, 1200] {
            for (kind, points) in [
                ("points in the box", inside(low, high, count, &mut random)),
                ("points around", inside(low * 2.0 - high, high * 2.0 - low, count, &mut random)),
                (
                    "points nearby",
                    inside(low, high, count, &mut random).iter().map(|x| x + (high - low) * 0.7).collect(),
                ),
                ("cloud of points", (0..count).map(|_| bounds.centre() + random.vector() * 0.3).collect()),
                ("sphere", sphere(0.6, count, &mut random).iter().map(|x| x + bounds.centre()).collect()),
                ("large sphere", sphere(8.0, count, &mut random)),
                (
                    "small sphere",
                    sphere(0.2, count, &mut random).iter().map(|x| x + bounds.centre()).collect(),
                ),
            ] {
                // Spheres fit into nothing here, and a body is no surface patch.
                let report = run(field, &points, &Pose::identity(), &RegisterOptions::default());
                tally.never(&format!("{kind} ({count}) on the {name}"), &report);
            }
        }
    }
    let cloud = bumpy(2000, None, seed);
    for name in ["surface", "box"] {
        let field: &dyn DistanceField<3> = if name == "surface" { &field } else { &cube };
        let start = away(&cloud, 60.0 * random.uniform(), 0.2, &mut random);
        tally.never(
            &format!("another body on the {name}"),
            &run(field, &cloud, &start, &RegisterOptions::default()),
        );
    }
    let cloud = part([0.0, 1.0], [0.0, 1.0], 2000, 1e-3, &mut random);
    let start = away(&cloud, 60.0 * random.uniform(), 0.2, &mut random);
    tally.never("the surface on another body", &run(&body, &cloud, &start, &RegisterOptions::default()));

    tally.check();
}

#[test]
fn wrong_minima_are_not_called_converged() {
    let field = SurfaceField::new(&model()).unwrap();
    let body: Vec<_> = bumpy(4000, None, 9).into_iter().map(Point3::from).collect();
    let body = CloudField::new(&body, None).unwrap();
    let mut tally = Tally { wrong: Vec::new() };
    let mut right = 0;
    for seed in 1..=4 {
        let mut random = Random::new(seed);
        for degrees in [40.0, 90.0, 180.0] {
            for noise in [0.0, 2e-3] {
                let points = part([0.05, 0.95], [0.05, 0.95], 700, noise, &mut random);
                let start = away(&points, degrees, 0.3, &mut random);
                let report = run(&field, &points, &start, &RegisterOptions::default());
                right +=
                    usize::from(tally.knows(&format!("surface {degrees} {noise}"), &report, &points, 5e-3));
                let points = part([0.2, 0.6], [0.1, 0.9], 700, noise, &mut random);
                let start = away(&points, degrees, 0.3, &mut random);
                let report = run(&field, &points, &start, &RegisterOptions::default());
                right += usize::from(tally.knows(&format!("part {degrees} {noise}"), &report, &points, 5e-3));
            }
            let points = bumpy(700, None, seed);
            let start = away(&points, degrees, 0.3, &mut random);
            let report = run(&body, &points, &start, &RegisterOptions::default());
            right += usize::from(tally.knows(&format!("body {degrees}"), &report, &points, 5e-3));
            let points = bumpy(700, Some((Vector3::x(), 1.2)), seed);
            let start = away(&points, degrees, 0.3, &mut random);
            let report = run(&body, &points, &start, &RegisterOptions::default());
            right += usize::from(tally.knows(&format!("view of the body {degrees}"), &report, &points, 5e-3));
        }
    }
    assert!(right > 15, "{right}");
    tally.check();
}

#[test]
fn locked_tilts_are_said() {
    let field = SurfaceField::new(&model()).unwrap();
    let mut random = Random::new(3);
    for degrees in [2.0, 5.0, 10.0, 20.0] {
        let points = part([0.02, 0.98], [0.02, 0.98], 2000, 1e-4, &mut random);
        let tilt = Pose::new(
            rotation::exponential::<3>(
                &Vector3::new(0.3, 0.9, 0.2).normalize().scale(f64::to_radians(degrees)),
            )
            .0,
            Vector3::zeros(),
        );
        let locks = Locks::default().with_rotations([true; 3]);
        for outliers in [Outliers::Automatic, Outliers::None] {
            let options = RegisterOptions::default().with_locks(locks).with_outliers(outliers);
            let report = run(&field, &points, &tilt, &options);
            // Little is said, much is doubted.
            let expected = if degrees > 6.0 { Status::Doubtful } else { Status::Converged };
            assert_eq!(report.status, expected, "{degrees}: {report} | {}", report.support);
            assert!(report.support.exceeds_noise(), "{degrees}: {report} | {}", report.support);
            let released = report.support.unlocked_rms.unwrap() < 0.7 * report.support.relative_rms;
            assert!(released || degrees > 6.0, "{degrees}: {report} | {}", report.support);
            let straight = run(
                &field,
                &points,
                &Pose::new(Matrix3::identity(), Vector3::new(0.02, 0.01, 0.03)),
                &options,
            );
            assert!(
                straight.is_converged() && !straight.support.exceeds_noise(),
                "{degrees}: {straight} | {}",
                straight.support
            );
        }
    }
}

#[test]
fn few_points_of_many_do_not_count() {
    // Five points of a sphere near a plane, as of two shapes that only cross.
    let plane = TriangleMesh::new(
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]].map(Point3::from).to_vec(),
        vec![[0, 1, 2], [0, 2, 3]],
    )
    .unwrap();
    let field = MeshField::new(&plane).unwrap();
    for seed in 1..=10 {
        let points = sphere(10.0, 200, &mut Random::new(seed));
        let report = run(&field, &points, &Pose::identity(), &RegisterOptions::default());
        assert!(!report.is_converged(), "{report}");
        if report.used < 20 {
            assert_eq!(report.support.doubt, Some(Doubt::FewPoints), "{report}");
        }
    }
}

#[test]
fn rms_at_the_start_is_that_of_the_same_points() {
    let field = SurfaceField::new(&model()).unwrap();
    let mut random = Random::new(8);
    let mut points = part([0.05, 0.95], [0.05, 0.95], 4000, 1e-3, &mut random);
    let shift = Vector3::new(0.0, 0.0, 0.02);
    let start = Pose::new(Matrix3::identity(), shift);
    let inliers = points.clone();
    points.extend(inside(Vector3::repeat(-3.0), Vector3::repeat(3.0), 1500, &mut random));
    let report = run(&field, &points, &start, &RegisterOptions::default());
    assert!(report.is_converged() && report.used > 3900 && report.used < 4100, "{report}");
    let moved: Vec<_> = inliers.iter().map(|x| x + shift).collect();
    let squares: f64 = moved.iter().map(|x| field.distance(x).powi(2)).sum();
    let expected = (squares / moved.len() as f64).sqrt();
    // Some outliers lie on the surface by chance, some inliers are left out.
    assert!((report.initial_rms / expected - 1.0).abs() < 0.05, "{} {expected}", report.initial_rms);
    assert!(report.rms < report.initial_rms * 0.2);
}
