//! Parameters of patches: linear functions come back, nothing folds, features take more room.

use crate::shapes::{cube, grid};
use feature_metric::{Error, Metric, ParameterDomain, ParameterOptions, PatchParameters, parameterize_patch};
use mesh_core::TriangleMesh;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

/// A flat piece of length 1, a fillet of a quarter turn, another flat piece of length 1; `s` is the way in space as a share.
fn fillet(radius: f64) -> impl Fn(f64, f64) -> (Vector3<f64>, Vector3<f64>) {
    move |s, t| {
        let arc = FRAC_PI_2 * radius;
        let way = s * (2.0 + arc);
        let angle = ((way - 1.0) / radius).clamp(0.0, FRAC_PI_2);
        let normal = Vector3::new(angle.sin(), 0.0, angle.cos());
        let flat = Vector3::new((way - 1.0).min(0.0), t, -(way - 1.0 - arc).max(0.0));
        (flat + normal * radius, normal)
    }
}

fn mesh_of(counts: [u32; 2], at: impl Fn(f64, f64) -> (Vector3<f64>, Vector3<f64>)) -> TriangleMesh {
    grid(counts, |s, t| at(s, t).0, Some(&|s, t| at(s, t).1))
}

fn areas(found: &PatchParameters) -> Vec<f64> {
    let at = |k: u32| found.places[k as usize].parameters;
    let area =
        |[a, b, c]: [[f64; 2]; 3]| 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    found.triangles.iter().map(|t| area(t.map(at))).collect()
}

#[test]
fn a_flat_rectangle_has_its_own_coordinates() {
    // Uneven rows and columns, so that no symmetry helps.
    let bend = |s: f64| s + 0.3 * s * (1.0 - s);
    let mesh = grid([9, 7], |s, t| Vector3::new(3.0 * bend(s), 2.0 * bend(t), 0.5), None);
    for metric in [Metric::Euclidean, Metric::Feature { width: 0.0 }, Metric::Feature { width: 2.0 }] {
        let found = parameterize_patch(&mesh, metric, &ParameterOptions::default()).unwrap();
        assert_eq!((found.corners, found.folded), (Some([0, 9, 79, 70]), 0));
        for place in &found.places {
            let x = mesh.vertices()[place.vertex];
            let [u, v] = place.parameters;
            assert!((u - x.x / 3.0).abs() < 1e-12 && (v - x.y / 2.0).abs() < 1e-12, "{place:?}");
        }
    }
}

#[test]
fn without_a_width_the_metrics_are_one() {
    let mesh = mesh_of([24, 8], fillet(0.3));
    let options = ParameterOptions::default();
    let plain = parameterize_patch(&mesh, Metric::Euclidean, &options).unwrap();
    assert_eq!(plain, parameterize_patch(&mesh, Metric::Feature { width: 0.0 }, &options).unwrap());
    let tiny = parameterize_patch(&mesh, Metric::Feature { width: 1e-7 }, &options).unwrap();
    for (a, b) in plain.places.iter().zip(&tiny.places) {
        assert!((0..2).all(|k| (a.parameters[k] - b.parameters[k]).abs() < 1e-9));
    }
}

#[test]
fn a_fillet_takes_the_share_of_its_length_in_the_metric() {
    let radius = 0.1;
    let (at, n) = (fillet(radius), 84u32);
    let mesh = mesh_of([n, 20], &at);
    let mut before = 0.0;
    for width in [0.0, 0.2, 0.5, 1.0] {
        let found =
            parameterize_patch(&mesh, Metric::Feature { width }, &ParameterOptions::default()).unwrap();
        let all = areas(&found);
        assert!(found.folded == 0 && all.iter().all(|area| *area > 0.0));
        assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Triangles between vertices of the fillet.
        let is_bent = |k: &u32| {
            let column = found.places[*k as usize].vertex % (n as usize + 1);
            let normal = at(column as f64 / f64::from(n), 0.0).1;
            normal.x > 1e-9 && normal.z > 1e-9
        };
        let share: f64 =
            found.triangles.iter().zip(&all).filter(|(t, _)| t.iter().any(is_bent)).map(|(_, a)| a).sum();
        let length = FRAC_PI_2 * f64::hypot(radius, width);
        // The rows at the ends of the fillet count as a whole.
        assert!((share - length / (2.0 + length)).abs() < 0.05, "w = {width}: {share}");
        assert!(share > before, "w = {width}: {share} after {before}");
        before = share;
    }
}

#[test]
fn sharp_edges_become_strips() {
    // Three sides of a cube around a corner.
    let cube = cube(6);
    let is_near = |t: &&[u32; 3]| {
        let middle = t.iter().map(|&k| cube.vertices()[k as usize].coords).sum::<Vector3<f64>>() / 3.0;
        middle.iter().any(|c| *c > 1.0 - 1e-9)
    };
    let triangles = cube.triangles().iter().filter(is_near).copied().collect();
    let corner = TriangleMesh::new(cube.vertices().to_vec(), triangles).unwrap();
    for domain in [ParameterDomain::Square, ParameterDomain::Disc] {
        let options = ParameterOptions::default().with_domain(domain);
        let plain = parameterize_patch(&corner, Metric::Euclidean, &options).unwrap();
        let bent = parameterize_patch(&corner, Metric::Feature { width: 0.5 }, &options).unwrap();
        assert_eq!((plain.folded, bent.folded, plain.triangles.len()), (0, 0, bent.triangles.len()));
        let [all, less] = [&plain, &bent].map(|found| areas(found).iter().sum::<f64>());
        // The strips take what the faces lose.
        assert!(less < 0.8 * all, "{less} of {all}");
        let own = |found: &PatchParameters| {
            found.places.iter().all(|p| p.parameters.iter().all(|c| (0.0..=1.0).contains(c)))
        };
        assert!(own(&plain) && own(&bent));
    }
}

#[test]
fn triangles_with_three_vertices_on_a_side_stay_in_the_square() {
    // A corner of this grid is cut by its diagonal, and given corners put ears on sides.
    let mesh = grid([4, 4], |s, t| Vector3::new(s, t, 0.2 * (3.0 * s).sin() * t), None);
    let options = ParameterOptions::default().with_corners(Some([2, 14, 22, 10]));
    let found = parameterize_patch(&mesh, Metric::Euclidean, &options).unwrap();
    assert_eq!(found.corners, Some([2, 14, 22, 10]));
    let all = areas(&found);
    assert!(all.iter().all(|area| *area > -1e-15));
    assert_eq!(found.folded, all.iter().filter(|area| **area <= 0.0).count());
    assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let disc = ParameterOptions::default().with_domain(ParameterDomain::Disc);
    assert_eq!(parameterize_patch(&mesh, Metric::Euclidean, &disc).unwrap().folded, 0);
}

#[test]
fn what_is_no_disc_is_refused() {
    let closed = cube(3);
    let options = ParameterOptions::default();
    let error = parameterize_patch(&closed, Metric::Euclidean, &options).unwrap_err();
    assert!(matches!(error, Error::NotADisc { parts: 1, boundaries: 0, euler: 2, .. }), "{error}");
    let flat = grid([6, 6], |s, t| Vector3::new(s, t, 0.0), None);
    let hole = flat.triangles().iter().filter(|t| !t.contains(&24)).copied().collect();
    let ring = TriangleMesh::new(flat.vertices().to_vec(), hole).unwrap();
    let error = parameterize_patch(&ring, Metric::Feature { width: 1.0 }, &options).unwrap_err();
    assert!(matches!(error, Error::NotADisc { boundaries: 2, euler: 0, .. }), "{error}");
    let inner = parameterize_patch(&flat, Metric::Euclidean, &options.with_corners(Some([0, 6, 48, 24])));
    assert!(matches!(inner.unwrap_err(), Error::Corners { boundary: 24, vertex: Some(24) }));
    let twice = parameterize_patch(&flat, Metric::Euclidean, &options.with_corners(Some([0, 6, 48, 6])));
    assert!(matches!(twice.unwrap_err(), Error::Corners { vertex: Some(6), .. }));
    let wrong = parameterize_patch(&flat, Metric::Feature { width: -1.0 }, &options);
    assert!(matches!(wrong.unwrap_err(), Error::Option { .. }));
    let one = TriangleMesh::new(flat.vertices()[..8].to_vec(), vec![[0, 1, 7]]).unwrap();
    assert!(matches!(
        parameterize_patch(&one, Metric::Euclidean, &options).unwrap_err(),
        Error::Corners { .. }
    ));
    let disc = options.with_domain(ParameterDomain::Disc);
    assert_eq!(parameterize_patch(&one, Metric::Euclidean, &disc).unwrap().places.len(), 3);
}
