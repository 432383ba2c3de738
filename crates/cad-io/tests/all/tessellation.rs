//! Models of files as triangles.

use brep_core::{Model, Tessellation};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::PathBuf;

fn fixture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/cad").join(name)
}

/// Area of the triangles of each face.
fn areas(found: &Tessellation) -> BTreeMap<[usize; 2], f64> {
    let mut out = BTreeMap::new();
    for (corners, face) in found.triangles.iter().zip(&found.faces) {
        let [a, b, c] = corners.map(|k| found.vertices[k as usize]);
        *out.entry(*face).or_insert(0.0) += 0.5 * (b - a).cross(&(c - a)).norm();
    }
    out
}

/// Six times the volume under the triangles: positive where they are seen counter-clockwise from outside.
fn volume(found: &Tessellation) -> f64 {
    let corner = |k: u32| found.vertices[k as usize];
    found.triangles.iter().map(|t| corner(t[0]).dot(&corner(t[1]).cross(&corner(t[2])))).sum::<f64>() / 6.0
}

/// Sides of triangles that have no partner in the other direction: face and ends.
fn open_sides(found: &Tessellation) -> Vec<(usize, [Vector3<f64>; 2])> {
    let mut sides: BTreeMap<[u32; 2], (i32, usize)> = BTreeMap::new();
    for (t, face) in found.triangles.iter().zip(&found.faces) {
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            let side = sides.entry([a.min(b), a.max(b)]).or_insert((0, face[1]));
            side.0 += if a < b { 1 } else { -1 };
        }
    }
    let open = sides.into_iter().filter(|(_, (count, _))| *count != 0);
    open.map(|(ends, (_, face))| (face, ends.map(|k| found.vertices[k as usize]))).collect()
}

fn check(model: &Model, chord: f64, share: f64) -> Tessellation {
    let found = model.tessellate(chord).unwrap();
    assert!(found.deviation <= 2.0 * chord, "{} of {chord}", found.deviation);
    let areas = areas(&found);
    for (index, instance) in model.instances().iter().enumerate() {
        let part = &model.parts()[instance.part];
        for face in 0..part.faces().len() {
            let exact = part.area(face) * instance.placement.scale.powi(2);
            let flat = areas.get(&[index, face]).copied().unwrap_or(0.0);
            let source = part.faces()[face].source();
            assert!((flat - exact).abs() <= share * exact, "face #{source}: {flat} of {exact}");
        }
    }
    // Next to edges that lie beside their surfaces, slivers may be turned over.
    let (mut turned, mut whole) = (0.0, 0.0);
    for (corners, normals) in found.triangles.iter().zip(&found.normals) {
        let [a, b, c] = corners.map(|k| found.vertices[k as usize]);
        let flat = (b - a).cross(&(c - a));
        whole += flat.norm();
        if flat.dot(&normals.iter().sum()) < 0.0 {
            turned += flat.norm();
        }
    }
    assert!(turned <= 1e-4 * whole, "{turned} of {whole} are turned over");
    found
}

#[cfg(feature = "step")]
#[test]
fn solids_of_files_are_closed_and_have_the_areas_of_their_faces() {
    for name in [
        "nema-17-bracket.step",
        "M6-1x12-countersunk-screw.step",
        "00000050_80d90bfdd2e74e709956122a_step_000.step",
    ] {
        let model = Model::new(&cad_io::read_step_file(&fixture(name)).unwrap()).unwrap();
        let size = model.bounds().diagonal();
        let found = check(&model, 1e-4 * size, 0.02);
        assert!(open_sides(&found).is_empty(), "{name}: {:?}", open_sides(&found));
        assert!(volume(&found) > 0.0, "{name}");
        // Coarse chords may pass beside thin faces, fine ones meet the tolerances of edges: solids stay closed.
        for chord in [1e-2, 3e-3, 3e-5] {
            let other = model.tessellate(chord * size).unwrap();
            assert!(open_sides(&other).is_empty(), "{name} {chord}: {:?}", open_sides(&other));
        }
        let finer = check(&model, 1e-5 * size, 0.004);
        assert!((volume(&finer) - volume(&found)).abs() < 2e-3 * volume(&finer), "{name}");
    }
}

#[test]
fn faces_of_an_impeller_end_at_their_edges() {
    let bytes = std::fs::read(fixture("impeller.igs")).unwrap();
    let model = Model::new(&cad_io::read_iges(&bytes).unwrap()).unwrap();
    let found = check(&model, 2e-4 * model.bounds().diagonal(), 0.1);
    assert!(found.triangles.len() > 10_000 && !found.lines.is_empty());
}

#[test]
fn a_tolerance_that_is_none_is_refused() {
    let bytes = std::fs::read(fixture("impeller.igs")).unwrap();
    let model = Model::new(&cad_io::read_iges(&bytes).unwrap()).unwrap();
    for chord in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(model.tessellate(chord).unwrap_err().to_string().contains("it must be positive"));
    }
}
