//! Adaptively sampled distance fields against the functions that they sample.

use distance_field::adaptive::{AdaptiveField, AdaptiveOptions, AdaptiveReport};
use distance_field::{DistanceField, Error, Hint, Search};
use footpoint::Status;
use nalgebra::{Vector2, Vector3};

fn torus(p: &Vector3<f64>) -> f64 {
    (p.xy().norm() - 1.0).hypot(p.z) - 0.4
}

fn place(index: u32) -> Vector3<f64> {
    let share = |step: f64| 2.0 * (f64::from(index) * step + 0.1).fract() - 1.0;
    Vector3::new(share(0.819_172_513_396_164), share(0.671_043_606_703_789), share(0.549_700_477_901_970))
}

fn build(degree: usize, abs_tolerance: f64) -> (AdaptiveField<3>, AdaptiveReport) {
    let options =
        AdaptiveOptions::default().with_abs_tolerance(abs_tolerance).with_band(Some(0.1)).with_degree(degree);
    AdaptiveField::build(Vector3::repeat(-1.7), Vector3::repeat(1.7), &options, torus).unwrap()
}

#[test]
fn cubics_need_a_tenth_of_the_leaves() {
    let (cubic, three) = build(3, 5e-4);
    let (_, one) = build(1, 5e-4);
    assert!(three.leaves * 10 <= one.leaves, "{} against {}", three.leaves, one.leaves);
    assert_eq!((three.open_leaves, one.open_leaves), (0, 0));
    assert!(three.largest_error <= 5e-4 && one.largest_error <= 5e-4);
    // Between the test points, too.
    let mut worst = 0.0f64;
    for k in 0..20_000 {
        let p = place(k) * 1.7;
        if torus(&p).abs() < 0.1 {
            worst = worst.max((cubic.value(&p).unwrap() - torus(&p)).abs());
        }
    }
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn frames_are_those_of_the_shape() {
    let (field, _) = build(3, 1e-5);
    for k in 0..400 {
        let p = place(k) * 1.6;
        let right = torus(&p);
        if right.abs() > 0.09 {
            continue;
        }
        let frame = field.frame(&p, Search::Global, &Hint::NONE);
        assert_eq!(frame.status, Status::Converged, "{p}");
        assert!((frame.distance - right).abs() < 5e-5, "{p}: {} {right}", frame.distance);
        assert!(torus(&frame.foot).abs() < 3e-5);
        let meridian = frame.curvatures.iter().take(2).fold(0.0f64, |most, c| most.max(c.abs()));
        assert!((meridian - 2.5).abs() < 0.1, "{:?}", frame.curvatures);
    }
    // From outside of the box as well.
    let far = field.frame(&Vector3::new(4.0, 0.0, 0.0), Search::Global, &Hint::NONE);
    assert!((far.distance - 2.6).abs() < 1e-4, "{far:?}");
    let bounds = field.bounding_box();
    assert!(
        bounds.max.x > 1.3 && bounds.max.x < 1.42 && bounds.min.z < -0.38 && bounds.min.z > -0.42,
        "{bounds:?}"
    );
}

#[test]
fn bytes_come_back_and_broken_ones_are_refused() {
    let circle = |p: &Vector2<f64>| p.norm() - 1.0;
    let options = AdaptiveOptions::default().with_abs_tolerance(1e-4).with_band(Some(0.2));
    let (field, _) =
        AdaptiveField::build(Vector2::repeat(-2.0), Vector2::new(2.0, 3.0), &options, circle).unwrap();
    let bytes = field.to_bytes();
    assert_eq!(AdaptiveField::<2>::from_bytes(&bytes).unwrap(), field);
    assert!(AdaptiveField::<3>::from_bytes(&bytes).unwrap_err().to_string().contains("dimension 2"));
    for length in (0..bytes.len()).step_by(7) {
        assert!(AdaptiveField::<2>::from_bytes(&bytes[..length]).is_err(), "{length}");
    }
    // Whatever one byte is turned into: an error, or a field that answers.
    for at in (0..bytes.len()).step_by(3) {
        let mut changed = bytes.clone();
        changed[at] ^= 0xff;
        if let Ok(field) = AdaptiveField::<2>::from_bytes(&changed) {
            let frame = field.frame(&Vector2::new(0.7, 0.9), Search::Global, &Hint::NONE);
            assert!(frame.is_finite() || !frame.status.is_converged());
        }
    }
}

#[test]
fn bad_input_is_refused() {
    let (low, high) = (Vector2::repeat(-1.0), Vector2::repeat(1.0));
    let build = |options: AdaptiveOptions, low, high| {
        AdaptiveField::build(low, high, &options, |p: &Vector2<f64>| p.norm() - 0.5).map(|_| ())
    };
    let options = AdaptiveOptions::default();
    for bad in [options.with_abs_tolerance(0.0), options.with_band(Some(f64::NAN)), options.with_degree(4)] {
        assert!(matches!(build(bad, low, high), Err(Error::Option { .. })));
    }
    assert!(matches!(build(options, high, low), Err(Error::Grid { .. })));
    let nan = AdaptiveField::build(low, high, &options, |p: &Vector2<f64>| p.x.sqrt());
    assert!(matches!(nan, Err(Error::Grid { .. })));
    let none = AdaptiveField::build(low, high, &options, |p: &Vector2<f64>| p.norm() + 9.0);
    assert!(matches!(none, Err(Error::NoPoints { .. })));
    // No tolerance is reached on a kink; the tree ends nevertheless, and says so.
    let options = options.with_abs_tolerance(1e-9).with_max_depth(6);
    let (_, report) =
        AdaptiveField::build(low, high, &options, |p: &Vector2<f64>| (p.x - 0.1).abs() - 0.3).unwrap();
    assert!(report.open_leaves > 0 && report.depth == 6);
}
