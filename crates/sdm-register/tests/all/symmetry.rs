//! Motions that carry shapes into themselves.

use distance_field::{MeshField, MeshGeometry, MeshOptions};
use mesh_core::TriangleMesh;
use nalgebra::{Point3, Vector3};
use sdm_register::start::OrientedPoints;
use sdm_register::{Pose, rotation, symmetries, symmetries_and_near};

/// A prism over a polygon with given corners, as triangles.
pub(crate) fn prism(corners: &[[f64; 2]], height: f64, place: &Pose<3>) -> TriangleMesh {
    let n = u32::try_from(corners.len()).unwrap();
    let at = |z: f64| corners.iter().map(move |[x, y]| Vector3::new(*x, *y, z));
    let points = at(0.0).chain(at(height)).map(|x| Point3::from(place.apply(&x))).collect();
    let mut triangles = Vec::new();
    for i in 1..n - 1 {
        triangles.push([0, i + 1, i]);
        triangles.push([n, n + i, n + i + 1]);
    }
    for i in 0..n {
        let next = (i + 1) % n;
        triangles.extend([[i, next, n + next], [i, n + next, n + i]]);
    }
    TriangleMesh::new(points, triangles).unwrap()
}

pub(crate) fn regular(n: u32, radius: f64) -> Vec<[f64; 2]> {
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n) + 0.3;
    (0..n).map(|i| [radius * angle(i).cos(), radius * angle(i).sin()]).collect()
}

fn rectangle(a: f64, b: f64) -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]]
}

#[test]
fn solids_have_the_symmetries_of_their_groups() {
    let turn = rotation::exponential::<3>(&Vector3::new(0.4, -1.1, 0.6)).0;
    let place = Pose::new(turn, Vector3::new(30.0, -12.0, 5.0));
    let house = |roof: f64| {
        let mut corners = rectangle(3.0, 2.0);
        corners.insert(2, [3.3, roof]);
        corners
    };
    for (name, corners, height, expected) in [
        ("cube", rectangle(2.0, 2.0), 2.0, 24),
        ("box", rectangle(3.0, 2.0), 1.0, 4),
        ("nearly cubic box", rectangle(2.0, 2.1), 1.9, 4),
        ("square plate", rectangle(3.0, 3.0), 0.4, 8),
        ("triangular prism", regular(3, 1.0), 1.0, 6),
        ("pentagonal prism", regular(5, 1.0), 2.5, 10),
        ("hexagonal prism", regular(6, 1.0), 1.5, 12),
        ("octagonal prism", regular(8, 1.0), 0.5, 16),
        ("house", house(1.0), 1.0, 2),
        ("lopsided house", house(1.2), 1.0, 1),
    ] {
        let mesh = prism(&corners, height, &place);
        let options = MeshOptions::default().with_geometry(MeshGeometry::Exact);
        let field = MeshField::with_options(&mesh, &options).unwrap();
        let samples = OrientedPoints::from_mesh(&mesh, 12_000);
        let found = symmetries(&field, &samples, 0.0);
        assert_eq!(found.len(), expected, "{name}");
        assert_eq!(found[0], Pose::identity());
        // A group: with every two motions their product.
        let same = |a: &Pose<3>, b: &Pose<3>| {
            (a.rotation - b.rotation).norm() < 1e-6
                && mesh.vertices().iter().all(|x| (a.apply(&x.coords) - b.apply(&x.coords)).norm() < 1e-5)
        };
        for a in &found {
            for b in found.iter().take(5) {
                assert!(found.iter().any(|c| same(c, &a.followed_by(b))), "{name}");
            }
        }
    }
}

#[test]
fn a_plate_with_one_cut_corner_nearly_has_the_symmetries_of_the_whole() {
    let mut corners = rectangle(4.0, 2.0);
    corners.splice(2..3, [[4.0, 1.6], [3.6, 2.0]]);
    let mesh = prism(&corners, 0.3, &Pose::identity());
    let field = MeshField::new(&mesh).unwrap();
    let samples = OrientedPoints::from_mesh(&mesh, 12_000);
    let (group, near) = symmetries_and_near(&field, &samples, 0.0);
    assert_eq!((group.len(), near.len()), (1, 3));
    let whole = prism(&rectangle(4.0, 2.0), 0.3, &Pose::identity());
    let samples = OrientedPoints::from_mesh(&whole, 12_000);
    let (group, near) = symmetries_and_near(&MeshField::new(&whole).unwrap(), &samples, 0.0);
    assert_eq!((group.len(), near.len()), (4, 0));
}
