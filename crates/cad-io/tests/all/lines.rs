//! Where lines meet the faces of files, against their triangles.

use crate::iges_files;
use brep_core::{Model, Tessellation};
use nalgebra::Vector3;

/// Numbers that are the same everywhere, from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| 2.0 * self.next() - 1.0)
    }
}

/// Offsets at which a line meets triangles, with the cosine of the angle to their normals and how near to a side that is.
fn hits(mesh: &Tessellation, x: &Vector3<f64>, d: &Vector3<f64>) -> Vec<(f64, f64)> {
    let meets = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|k| mesh.vertices[k as usize]);
        let normal = (b - a).cross(&(c - a));
        let t = normal.dot(&(a - x)) / normal.dot(d);
        let p = x + d * t;
        let inside =
            [(a, b), (b, c), (c, a)].iter().all(|(p0, p1)| (p1 - p0).cross(&(p - p0)).dot(&normal) >= 0.0);
        (inside && t.is_finite()).then(|| (t, (normal.dot(d) / normal.norm()).abs()))
    };
    mesh.triangles.iter().filter_map(meets).collect()
}

/// Lines through a model; returns how many of them meet it.
fn check(model: &Model, count: usize) -> usize {
    let (size, centre) = (model.bounds().diagonal(), model.bounds().centre());
    let chord = 2e-5 * size;
    let mesh = model.tessellate(chord).unwrap();
    let slack = mesh.deviation.max(chord);
    let mut random = Random(7);
    let (mut met, mut grazing) = (0, 0);
    for _ in 0..count {
        let x = centre + random.vector() * (0.6 * size);
        let aim = centre + random.vector() * (0.2 * size);
        let d = (aim - x).normalize();
        let found = model.nearest_on_line(&x, &((aim - x) * 7.0), f64::INFINITY, None).unwrap();
        let told = hits(&mesh, &x, &d);
        let nearest = told.iter().map(|hit| hit.0.abs()).fold(f64::INFINITY, f64::min);
        // Where a line meets triangles at a flat angle, the faces may be elsewhere.
        let room = told.iter().map(|hit| slack / hit.1.max(0.02)).fold(slack, f64::max);
        match found.nearest {
            Some(hit) => {
                met += 1;
                assert!((found.free - hit.offset.abs()).abs() <= 1e-9 * size, "{found:?}");
                assert!((hit.point - (x + d * hit.offset)).norm() <= 1e-8 * size, "{hit:?}");
                let foot = model.nearest(&hit.point).unwrap();
                assert!(foot.distance <= 1e-8 * size, "{hit:?} {foot:?}");
                assert!(hit.normal.dot(&d).abs() <= 1.0 + 1e-12);
                grazing += usize::from((hit.offset.abs() - nearest).abs() > 2.0 * room);
            }
            None => grazing += usize::from(nearest.is_finite()),
        }
        // No triangle that is met well away from flat angles is nearer.
        let missed = told.iter().filter(|hit| {
            hit.1 > 0.2
                && hit.0.abs() < found.nearest.map_or(f64::INFINITY, |n| n.offset.abs()) - 20.0 * slack
        });
        grazing += usize::from(missed.count() > 0);
    }
    assert!(100 * grazing <= 2 * count, "{grazing} of {count} differ");
    met
}

#[cfg(feature = "step")]
#[test]
fn lines_meet_the_faces_of_solids() {
    for name in ["nema-17-bracket.step", "M6-1x12-countersunk-screw.step"] {
        let model = Model::new(&cad_io::read_step_file(&crate::step::fixture(name)).unwrap()).unwrap();
        assert!(check(&model, 300) > 50, "{name}");
    }
}

#[test]
fn lines_meet_free_form_faces() {
    let model = Model::new(&cad_io::read_iges(&iges_files::fixture("impeller.igs")).unwrap()).unwrap();
    assert!(check(&model, 60) > 20);
}
