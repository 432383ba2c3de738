//! Convex hulls: laws, degenerate input, agreement with brute force.

use cloud_param::ConvexHull;
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use robust::{Coord3D, orient3d};

fn beyond(points: &[Vector3<f64>], face: [u32; 3], p: &Vector3<f64>) -> bool {
    let at = |v: &Vector3<f64>| Coord3D { x: v.x, y: v.y, z: v.z };
    let [a, b, c] = face.map(|i| at(&points[i as usize]));
    orient3d(a, b, c, at(p)) < 0.0
}

/// No point lies beyond a face, exactly, and every edge has a face on both sides.
fn check(points: &[Vector3<f64>], hull: &ConvexHull) {
    assert_eq!(hull.dimension(), 3);
    for &face in hull.faces() {
        assert!(points.iter().all(|p| !beyond(points, face, p)));
    }
    let mut edges: Vec<(u32, u32)> =
        hull.faces().iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    edges.sort_unstable();
    assert!(edges.windows(2).all(|w| w[0] != w[1]));
    assert!(edges.iter().all(|&(a, b)| edges.binary_search(&(b, a)).is_ok()));
    assert_eq!(hull.vertices().len() + hull.faces().len(), edges.len() / 2 + 2);
}

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

#[test]
fn spheres_balls_and_grids() {
    let mut seed = 1;
    let mut cloud = |n: usize| (0..n).map(|_| Vector3::from_fn(|_, _| random(&mut seed))).collect::<Vec<_>>();
    let ball = cloud(3000);
    check(&ball, &ConvexHull::new(&ball).unwrap());
    let sphere: Vec<_> = cloud(2000).iter().map(|p| p.normalize()).collect();
    let hull = ConvexHull::new(&sphere).unwrap();
    check(&sphere, &hull);
    assert_eq!(hull.vertices().len(), 2000);
    // Hundreds of points in each face and edge of a cube, each twice.
    let grid: Vec<_> = (0..2 * 1000)
        .map(|i| i / 2)
        .map(|i| Vector3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100)) * 0.1)
        .collect();
    let hull = ConvexHull::new(&grid).unwrap();
    check(&grid, &hull);
    assert!((hull.volume(&grid) - 0.729).abs() < 1e-12);
}

#[test]
fn flat_and_thin_input() {
    let point = Vector3::new(0.1, 0.2, 0.3);
    assert_eq!(ConvexHull::new(&[point; 7]).unwrap().dimension(), 0);
    let line: Vec<_> = (0..50).map(|i| Vector3::new(1.0, -2.0, 0.5) * f64::from((i * 17) % 50)).collect();
    let hull = ConvexHull::new(&line).unwrap();
    assert_eq!(hull.dimension(), 1);
    let mut ends: Vec<f64> = hull.vertices().iter().map(|&i| line[i as usize].x).collect();
    ends.sort_by(f64::total_cmp);
    assert_eq!(ends, [0.0, 49.0]);
    let square: Vec<_> = (0..400).map(|i| Vector3::new(f64::from(i % 20), 3.0, f64::from(i / 20))).collect();
    let hull = ConvexHull::new(&square).unwrap();
    assert_eq!((hull.dimension(), hull.vertices().len()), (2, 4));
    // A plane that is flat up to rounding only.
    let turn = Rotation3::from_euler_angles(0.3, 0.5, 0.7);
    let tilted: Vec<_> = square.iter().map(|p| turn * p).collect();
    let hull = ConvexHull::new(&tilted).unwrap();
    if hull.dimension() == 3 {
        check(&tilted, &hull);
    }
    assert!(ConvexHull::new(&[]).is_err());
    assert!(ConvexHull::new(&[Vector3::new(f64::NAN, 0.0, 0.0)]).is_err());
}

#[test]
fn size_and_place_do_not_matter() {
    let mut seed = 5;
    let cloud: Vec<_> = (0..300).map(|_| Vector3::from_fn(|_, _| random(&mut seed))).collect();
    let hull = ConvexHull::new(&cloud).unwrap();
    for scale in [1e-200, 1e200, 2f64.powi(-1000)] {
        let scaled: Vec<_> = cloud.iter().map(|p| p * scale).collect();
        assert_eq!(ConvexHull::new(&scaled).unwrap().vertices(), hull.vertices(), "{scale}");
    }
    let far: Vec<_> = cloud.iter().map(|p| p + Vector3::repeat(1e9)).collect();
    check(&far, &ConvexHull::new(&far).unwrap());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    /// Small integer coordinates make every kind of degeneracy likely.
    #[test]
    fn agrees_with_brute_force(cells in proptest::collection::vec(0..125i32, 1..30)) {
        let points: Vec<_> = cells.iter().map(|c| Vector3::new(f64::from(c % 5), f64::from(c / 5 % 5), f64::from(c / 25))).collect();
        let hull = ConvexHull::new(&points).unwrap();
        if hull.dimension() == 3 {
            check(&points, &hull);
        }
        // A corner is a point that is on no segment or triangle or tetrahedron of others; its plane test: extreme in some
        // direction. Directions between integer points of this size are covered by these.
        for (i, p) in points.iter().enumerate() {
            let mut seed = 11;
            let extreme = (0..400).any(|_| {
                let d = Vector3::from_fn(|_, _| random(&mut seed));
                points.iter().all(|q| q == p || d.dot(&(q - p)) < -1e-9)
            });
            if extreme {
                prop_assert!(hull.vertices().iter().any(|&v| points[v as usize] == *p), "point {i}");
            }
        }
    }
}
