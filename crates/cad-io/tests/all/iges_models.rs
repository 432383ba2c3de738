//! Models that are built from IGES files: areas, tolerances, closest points.

use crate::iges_builder::everything;
use crate::iges_files::fixture;
use brep_core::Model;
use nalgebra::Vector3;
use std::f64::consts::PI;

#[test]
fn areas_and_feet_of_every_kind_of_face() {
    let model = Model::new(&cad_io::read_iges(everything().as_bytes()).unwrap()).unwrap();
    let part = &model.parts()[0];
    // The square with the hole is left out: files may run round holes in either direction, which areas do not expect.
    let expected = [0.5, 0.5, 0.5, 0.75_f64.sqrt(), f64::NAN, 6.0 * PI, 4.0 * 10.0_f64.sqrt()];
    for (face, area) in expected.into_iter().enumerate().filter(|(_, area)| !area.is_nan()) {
        let found = part.area(face).abs();
        assert!((found - area).abs() < 1e-7, "face {face}: {found}, not {area}");
    }
    // Above the middle of the hole the rim is nearest, a little above the square beside it its inside.
    let foot = model.nearest(&Vector3::new(5.0, 5.0, -1.0)).unwrap();
    assert!((foot.distance - 5.0_f64.sqrt()).abs() < 1e-7, "{foot:?}");
    let foot = model.nearest(&Vector3::new(9.0, 9.0, -0.5)).unwrap();
    assert!((foot.distance - 0.5).abs() < 1e-12 && (foot.point - Vector3::new(9.0, 9.0, 0.0)).norm() < 1e-12);
    // Inside of the half cylinder, whose half without face does not count.
    let foot = model.nearest(&Vector3::new(19.5, 0.0, 6.5)).unwrap();
    assert!((foot.distance - 1.5).abs() < 1e-12, "{foot:?}");
    let foot = model.nearest(&Vector3::new(20.5, 0.0, 6.5)).unwrap();
    assert!((foot.distance - (4.0_f64 + 0.25).sqrt()).abs() < 1e-12, "{foot:?}");
}

#[test]
fn impeller_is_a_model_with_the_gaps_of_its_file() {
    let model = Model::new(&cad_io::read_iges(&fixture("impeller.igs")).unwrap()).unwrap();
    assert!(model.unread().is_empty(), "{:?}", model.unread());
    let part = &model.parts()[0];
    assert_eq!(part.faces().len(), 277);
    let largest = part.edges().iter().map(|edge| edge.tolerance()).fold(0.0, f64::max);
    assert!(largest <= 1.1 * 0.16, "{largest}");
    let total: f64 = (0..277).map(|face| part.area(face).abs()).sum();
    // As another program measures it; edges are off their surfaces by up to 0.16 mm.
    assert!((total / 28_616.0 - 1.0).abs() < 2e-4, "{total}");
    let foot = model.nearest(&Vector3::new(0.0, 100.0, 0.0)).unwrap();
    assert!(foot.distance > 0.0 && foot.gap() < 0.2, "{foot:?}");
}
