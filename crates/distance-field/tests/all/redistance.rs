//! Level functions made into distances, against closed forms.

use distance_field::grid::redistance;
use distance_field::{DistanceField, Error, ErrorTerm, Grid, Hint, LevelSetField, Saddles, Search};
use nalgebra::{Vector2, Vector3};
use nurbs_core::{BsplineCurve, KnotVector};

/// On `[−2, 2]²`, or what is in it.
fn plane(nodes: usize, f: impl Fn(&Vector2<f64>) -> f64) -> Grid<2> {
    let h = 4.0 / (nodes - 1) as f64;
    Grid::sample(Vector2::repeat(-2.0), Vector2::repeat(h), [nodes, nodes], f).unwrap()
}

/// Mean and largest error of the distances in a band where the distance is smooth.
fn errors(
    nodes: usize,
    f: impl Fn(&Vector2<f64>) -> f64,
    right: impl Fn(&Vector2<f64>) -> Option<f64>,
) -> [f64; 2] {
    let found = redistance(&plane(nodes, f), Some(0.3)).unwrap();
    // At centres of curvature only, where all points of an arc are as near.
    assert!(found.unresolved <= 10, "{}", found.unresolved);
    let (mut sum, mut most, mut count) = (0.0, 0.0f64, 0);
    for (node, value) in found.grid.values().iter().enumerate() {
        if value.abs() > 0.26 {
            continue;
        }
        if let Some(right) = right(&found.grid.position(node)).filter(|right| right.abs() < 0.25) {
            let error = (value - right).abs();
            (sum, most, count) = (sum + error, most.max(error), count + 1);
        }
    }
    [sum / f64::from(count), most]
}

/// The distance of a point from a closed curve given by an angle, by Newton's method from the best of many samples.
fn from_curve(x: &Vector2<f64>, point: impl Fn(f64) -> Vector2<f64>) -> f64 {
    let far = |a: f64| (point(a) - x).norm_squared();
    let best =
        (0..720).map(|k| f64::from(k).to_radians() / 2.0).min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap();
    let (mut low, mut high) = (best - 0.01, best + 0.01);
    // The golden section leaves half of the digits of the parameter, which are all digits of the distance.
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..60 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if far(a) < far(b) { high = b } else { low = a }
    }
    far(0.5 * (low + high)).sqrt()
}

fn order(
    name: &str,
    f: impl Fn(&Vector2<f64>) -> f64 + Copy,
    right: impl Fn(&Vector2<f64>) -> Option<f64> + Copy,
    nodes: usize,
) {
    let (coarse, fine) = (errors(nodes, f, right), errors(2 * nodes - 1, f, right));
    let orders = [0, 1].map(|k| (coarse[k] / fine[k]).log2());
    assert!(orders[0] > 3.5 && orders[1] > 3.3, "{name}: orders {orders:?}, errors {coarse:?} {fine:?}");
}

#[test]
fn redistancing_is_of_fourth_order() {
    // None is a distance: gradients are neither of length 1 nor constant along the zero set.
    let circle = |p: &Vector2<f64>| (p.norm_squared() - 1.0) * (2.0 + (1.3 * p.x).sin());
    order("circle", circle, |p| Some(p.norm() - 1.0), 41);
    let ellipse =
        |p: &Vector2<f64>| ((p.x / 1.5).powi(2) + p.y.powi(2) - 1.0) * (2.0 + (1.7 * p.x + 0.4).sin());
    let on_ellipse = |p: &Vector2<f64>| {
        // The cut locus lies on the long axis between the centres of curvature.
        (p.x.abs() > 0.9 || p.y.abs() > 0.3).then(|| {
            let far = from_curve(p, |a| Vector2::new(1.5 * a.cos(), a.sin()));
            if ellipse(p) < 0.0 { -far } else { far }
        })
    };
    order("ellipse", ellipse, on_ellipse, 41);
    let star = |p: &Vector2<f64>| (p.norm() - 1.0 - 0.2 * (5.0 * p.y.atan2(p.x)).cos()) * (1.0 + 0.2 * p.y);
    let on_star = |p: &Vector2<f64>| {
        let radius = |a: f64| 1.0 + 0.2 * (5.0 * a).cos();
        let far = from_curve(p, |a| Vector2::new(a.cos(), a.sin()) * radius(a));
        // Curvatures are below 5: no cut locus there.
        (far < 0.12).then_some(if star(p) < 0.0 { -far } else { far })
    };
    order("star", star, on_star, 81);
}

#[test]
fn spheres_in_space_and_bands() {
    let f = |p: &Vector3<f64>| (p - Vector3::new(0.1, -0.2, 0.05)).norm_squared() - 1.0;
    let spacing = Vector3::new(0.1, 0.11, 0.12);
    let grid = Grid::sample(Vector3::repeat(-1.6), spacing, [33, 30, 28], f).unwrap();
    let found = redistance(&grid, Some(0.25)).unwrap();
    let mut beyond = 0;
    for (node, value) in found.grid.values().iter().enumerate() {
        let right = (grid.position(node) - Vector3::new(0.1, -0.2, 0.05)).norm() - 1.0;
        if value.abs() == 0.25 {
            beyond += 1;
            assert!(right.abs() > 0.2499 && right.signum() == value.signum());
        } else {
            assert!((value - right).abs() < 1e-10, "{value} {right}");
        }
    }
    assert_eq!(beyond, found.beyond);
}

#[test]
fn two_parts_share_the_nodes() {
    // Two circles: each node has the nearer one, also where a front comes from both.
    let centres = [Vector2::new(-0.9, 0.1), Vector2::new(0.8, -0.2)];
    let radii = [0.5, 0.7];
    let right =
        |p: &Vector2<f64>| (0..2).map(|k| (p - centres[k]).norm() - radii[k]).fold(f64::INFINITY, f64::min);
    let grid = plane(101, |p| {
        (0..2).map(|k| (p - centres[k]).norm_squared() - radii[k] * radii[k]).product::<f64>()
    });
    let found = redistance(&grid, None).unwrap();
    assert!(found.beyond == 0 && found.unresolved <= 2);
    let off =
        (0..grid.values().len()).map(|node| (found.grid.values()[node] - right(&grid.position(node))).abs());
    assert!(off.fold(0.0, f64::max) < 1e-5);
}

#[test]
fn bad_bands_and_grids_without_a_zero_are_refused() {
    let grid = plane(9, |p| p.norm_squared() - 1.0);
    for band in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(redistance(&grid, Some(band)), Err(Error::Option { option: "band", .. })));
    }
    assert!(matches!(redistance(&plane(9, |_| 1.0), None), Err(Error::NoPoints { .. })));
    // A zero set on which the gradient vanishes: values stay finite.
    let flat = redistance(&plane(21, |p| if p.x > 0.05 { 1.0 } else { 0.0 }), None);
    assert!(flat.is_err() || flat.unwrap().grid.values().iter().all(|value| value.is_finite()));
}

/// The models that value, gradient and Hessian of a signed distance give, against those at certified feet of the curve itself.
#[test]
fn models_from_the_grid_agree_with_exact_ones() {
    let net: Vec<_> = (0..11)
        .map(|k| {
            let a = std::f64::consts::TAU * f64::from(k % 8) / 8.0;
            Vector2::new(1.3 * a.cos(), 0.9 * a.sin())
        })
        .collect();
    let curve = BsplineCurve::new(KnotVector::uniform_periodic(3, 8).unwrap(), net, None).unwrap();
    let exact = distance_field::CurveField::new(&curve).unwrap();
    let signed = |p: &Vector2<f64>| {
        let frame = exact.frame(p, Search::Global, &Hint::NONE);
        // Outside of this oval the foot is nearer to the centre than the point.
        let far = (p - frame.foot).norm();
        if (p - frame.foot).dot(&frame.foot) > 0.0 { far } else { -far }
    };
    let field = LevelSetField::<2>::new(&plane(161, signed)).unwrap();
    for k in 0..60 {
        let a = f64::from(k) * 0.37;
        let x = Vector2::new(1.3 * a.cos(), 0.95 * a.sin()) * (1.0 + 0.2 * (f64::from(k) * 0.61).fract());
        for term in [ErrorTerm::SquaredDistance, ErrorTerm::Taylor, ErrorTerm::Tangent] {
            let (found, right) = (term.model(&field.frame_from_values(&x)), exact.quadratic(&x, term));
            assert!((found.foot - right.foot).norm() < 1e-5, "{k}: {found:?} {right:?}");
            assert!((found.matrix() - right.matrix()).norm() < 5e-3, "{k} {term:?}: {found:?} {right:?}");
        }
    }
    assert!(!field.frame_from_values(&Vector2::new(f64::NAN, 0.0)).is_finite());
}

/// Where two negative nodes touch at a corner only, they are apart.
#[test]
fn saddles_can_be_kept_apart() {
    let grid = plane(40, |p| p.x * p.y - 0.002);
    let joined = LevelSetField::<2>::new(&grid).unwrap();
    let apart = LevelSetField::<2>::with_saddles(&grid, Saddles::Separate).unwrap();
    let quadrant = |field: &LevelSetField<2>| {
        let contour = &field.contours()[0];
        let first = contour.vertices()[0].x.signum();
        contour.vertices().iter().all(|v| v.x.signum() == first)
    };
    // f < 0 around the second and the fourth quadrant; the middle of the saddle is negative.
    assert!(quadrant(&joined) && !quadrant(&apart));
}
