//! Partial results: any tiling gives the bits of the whole; with the feature `serde` after a way through files, too.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use inspection::{Deviation, Error, InspectionOptions, Nominal, Outcome, Partial, Tolerance, no_progress};
use nalgebra::{Point3, Vector3};
use nurbs_core::{Cylinder, Frame, Interval, Sphere};
use proptest::prelude::*;
use std::sync::LazyLock;

struct Case {
    options: InspectionOptions,
    points: Vec<Point3<f64>>,
    deviations: Vec<Deviation>,
    nominal: Nominal,
}

/// A shaft with a ball at its end, far from the origin, and a cloud with every kind of point.
static CASE: LazyLock<Case> = LazyLock::new(|| {
    let frame = |z: f64| Frame::new(Vector3::new(1e5, -3e4, z), Vector3::z(), Vector3::x()).unwrap();
    let shaft = Cylinder::new(frame(0.0), 1.0, Interval::new(0.0, 5.0).unwrap()).unwrap();
    let ball = Sphere::new(frame(6.0), 1.5).unwrap();
    let nominal = Nominal::from_analytic(&[shaft.into(), ball.into()]).unwrap();
    let options = InspectionOptions::new(Tolerance::new(-0.01, 0.02).unwrap())
        .with_max_distance(0.5)
        .with_exact_limit(900)
        .with_min_share(0.5)
        .with_worst(7);
    let point = |i: u32| {
        let s = f64::from(i);
        let radius = 1.0 + 0.03 * (s * 1.7).sin() * (s * 0.013).cos();
        let z = if i % 97 == 5 { f64::NAN } else { (s * 0.37).rem_euclid(8.5) - 0.5 };
        Point3::new(1e5 + radius * (s * 0.61).cos(), -3e4 + radius * (s * 0.61).sin(), z)
    };
    let points: Vec<_> = (0..3000).map(point).collect();
    let deviations = nominal.measure(&points, None, &options, &no_progress).unwrap();
    Case { options, points, deviations, nominal }
});

impl Case {
    fn part(&self, start: usize, end: usize) -> Partial {
        let mut part = Partial::new(&self.options).unwrap();
        part.extend(start as u64, &self.points[start..end], &self.deviations[start..end]);
        part
    }
}

/// What travels from one machine to another.
#[cfg(feature = "serde")]
fn sent(part: &Partial) -> Partial {
    serde_json::from_str(&serde_json::to_string(part).unwrap()).unwrap()
}

#[cfg(not(feature = "serde"))]
fn sent(part: &Partial) -> Partial {
    part.clone()
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(11), ..ProptestConfig::with_cases(24) })]
    #[test]
    fn tiles_in_any_order_give_the_same_bits(mut cuts in prop::collection::vec(0usize..3000, 0..8), reverse: bool, through_files: bool) {
        let case = &*CASE;
        cuts.extend([0, 3000]);
        cuts.sort_unstable();
        let mut parts: Vec<Partial> = cuts.windows(2).map(|pair| case.part(pair[0], pair[1])).collect();
        if reverse {
            parts.reverse();
        }
        let mut merged = Partial::new(&case.options).unwrap();
        for part in &parts {
            merged.merge(&if through_files { sent(part) } else { part.clone() }).unwrap();
        }
        let whole = case.part(0, 3000);
        prop_assert_eq!(&merged, &whole);
        // Printed numbers read back to the same bits.
        let text = |partial: &Partial| {
            format!("{:?}", partial.finish(&case.options, case.nominal.shapes()).unwrap())
        };
        prop_assert_eq!(text(&merged), text(&whole));
    }
}

#[test]
fn the_sums_are_what_they_should_be() {
    let case = &*CASE;
    let inspection = case.part(0, 3000).finish(&case.options, case.nominal.shapes()).unwrap();
    let used: Vec<f64> =
        case.deviations.iter().filter(|d| d.outcome == Outcome::Measured).map(|d| d.distance).collect();
    let total = &inspection.total;
    assert_eq!(total.count, used.len() as u64);
    assert_eq!(inspection.points, 3000);
    assert_eq!(inspection.outcomes.values().sum::<u64>(), 3000);
    assert_eq!(inspection.outcomes["invalid_point"], 31);
    assert!(inspection.outcomes["beyond_max_distance"] > 100);
    let within = used.iter().filter(|d| (-0.01..=0.02).contains(*d)).count() as u64;
    assert_eq!((total.within, total.under + total.over), (within, total.count - within));
    let distance = total.distance.as_ref().unwrap();
    let mean = used.iter().sum::<f64>() / used.len() as f64;
    assert!((distance.mean - mean).abs() < 1e-15);
    let variance = used.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / (used.len() - 1) as f64;
    assert!((distance.variance - variance).abs() < 1e-14 * variance.max(1e-3));
    let positive: Vec<f64> = used.iter().copied().filter(|d| *d > 0.0).collect();
    let mean_positive = positive.iter().sum::<f64>() / positive.len() as f64;
    assert!((distance.mean_positive.unwrap() - mean_positive).abs() < 1e-15);
    assert!(!distance.quantiles_exact);
    let mut sorted = used.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let median = 0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]);
    assert!((distance.quantile(0.5).unwrap() - median).abs() < 2e-4 * median.abs() + 1e-6);
    // Surfaces add up to the total, and the worst are the worst.
    assert_eq!(inspection.shapes.len(), 2);
    assert_eq!(inspection.shapes.iter().map(|shape| shape.deviations.count).sum::<u64>(), total.count);
    assert_eq!((inspection.shapes[0].info.kind, inspection.shapes[1].info.kind), ("cylinder", "sphere"));
    let largest = used.iter().map(|d| d.abs()).fold(0.0, f64::max);
    assert_eq!((inspection.worst.len(), inspection.worst[0].distance.abs()), (7, largest));
    assert!(inspection.worst.windows(2).all(|pair| pair[0].distance.abs() >= pair[1].distance.abs()));
    assert!(inspection.to_string().starts_with(if inspection.verdict.pass { "pass: " } else { "fail: " }));
}

#[test]
fn parts_of_different_inspections_do_not_mix() {
    let case = &*CASE;
    let mut part = case.part(0, 10);
    let other = InspectionOptions { tolerance: Tolerance::new(-0.01, 0.03).unwrap(), ..case.options };
    assert_eq!(part.merge(&Partial::new(&other).unwrap()), Err(Error::DifferentOptions));
    assert_eq!(part.finish(&other, &[]).unwrap_err(), Error::DifferentOptions);
    #[cfg(feature = "serde")]
    assert!(serde_json::from_str::<Partial>("{\"points\": 3}").is_err());
}

#[test]
fn nothing_measured_is_no_pass() {
    let case = &*CASE;
    let inspection = Partial::new(&case.options).unwrap().finish(&case.options, &[]).unwrap();
    assert!(!inspection.verdict.pass && inspection.total.distance.is_none());
    assert_eq!((inspection.total.share_within, inspection.verdict.share), (0.0, 0.0));
}
