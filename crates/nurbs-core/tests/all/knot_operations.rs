//! Knot vectors made from knot vectors: what may be inserted where, and what one vector lacks of another.

#![allow(clippy::unwrap_used, reason = "a failed construction is a failed test")]

use nurbs_core::{Error, KnotVector};

fn floating() -> KnotVector {
    // Degree 2: the domain is [2, 6].
    KnotVector::new(2, (0..9).map(f64::from).collect()).unwrap()
}

#[test]
fn both_ends_of_a_floating_domain_take_no_knot() {
    let knots = floating();
    for end in [2.0, 6.0] {
        for values in [vec![end], vec![3.5, end], vec![end, 4.5]] {
            let error = knots.inserted(&values).unwrap_err();
            assert!(
                matches!(error, Error::Argument { .. }) && error.to_string().contains("clamp"),
                "{error}"
            );
        }
    }
    for outside in [1.0, 6.5, 1.999, f64::NAN] {
        assert!(matches!(knots.inserted(&[outside]), Err(Error::Parameter { .. })), "{outside}");
    }
    assert_eq!(
        knots.inserted(&[5.9, 2.1]).unwrap().as_slice(),
        [0.0, 1.0, 2.0, 2.1, 3.0, 4.0, 5.0, 5.9, 6.0, 7.0, 8.0]
    );
    // Clamped at one end only: that end refuses by its multiplicity, the other one as floating.
    let half = KnotVector::new(2, vec![0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0]).unwrap();
    assert!(matches!(half.inserted(&[0.0]), Err(Error::KnotMultiplicity { .. })));
    assert!(matches!(half.inserted(&[2.0]), Err(Error::Argument { .. })));
}

#[test]
fn what_is_missing_lies_in_the_domain_and_counts_repetitions() {
    let clamped = |inner: &[f64], [start, end]: [f64; 2]| {
        let ends = |t: f64| std::iter::repeat_n(t, 3);
        KnotVector::new(2, ends(start).chain(inner.iter().copied()).chain(ends(end)).collect()).unwrap()
    };
    let one = clamped(&[0.25, 0.5], [0.0, 1.0]);
    assert_eq!(one.missing(&clamped(&[0.25, 0.25, 0.75], [0.0, 1.0])), [0.25, 0.75]);
    assert_eq!(one.missing(&one), [0.0; 0]);
    // A longer domain: of its knots only those inside count, with the ends.
    let longer = clamped(&[-0.5, 0.0, 0.1, 0.5, 0.5, 1.0, 1.5], [-1.0, 2.0]);
    assert_eq!(one.missing(&longer), [0.1, 0.5]);
    // A shorter one: its ends have the multiplicity of ends.
    let shorter = clamped(&[0.6], [0.5, 0.75]);
    assert_eq!(one.missing(&shorter), [0.5, 0.5, 0.6, 0.75, 0.75, 0.75]);
    // Apart from each other, or touching in one value that is there already.
    assert_eq!(one.missing(&clamped(&[2.5], [2.0, 3.0])), [0.0; 0]);
    assert_eq!(one.missing(&clamped(&[1.5], [1.0, 2.0])), [0.0; 0]);
    assert_eq!(longer.missing(&one), [0.0, 0.0, 0.25, 1.0, 1.0]);
    // Of a floating vector the knots of its domain count, each as often as it is there.
    assert_eq!(floating().missing(&clamped(&[2.5, 4.0, 4.0], [1.0, 7.0])), [2.5, 4.0]);
}
