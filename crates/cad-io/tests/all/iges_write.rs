//! What is written as IGES comes back.

use crate::iges_builder::everything;
use crate::iges_entities::check_loops;
use crate::iges_files::fixture;
use brep_core::description::{Carrier, EdgeCurve, LengthUnit, LoopDescription, ModelDescription};

fn round(model: &ModelDescription) -> ModelDescription {
    cad_io::read_iges(&cad_io::to_iges(model).unwrap()).unwrap()
}

/// Everything but entity numbers, and arrangement in shells.
fn compare(a: &ModelDescription, b: &ModelDescription) -> [usize; 2] {
    assert_eq!((&a.name, &a.unit, a.uncertainty), (&b.name, &b.unit, b.uncertainty));
    let (a, b) = (&a.parts[0], &b.parts[0]);
    assert_eq!((a.faces.len(), a.curves.len()), (b.faces.len(), b.curves.len()));
    let mut counts = [0; 2];
    for (f, g) in a.faces.iter().zip(&b.faces) {
        assert_eq!((&f.name, f.loops.len()), (&g.name, g.loops.len()));
        assert!(g.same_sense);
        if matches!(f.carrier, Carrier::Nurbs(_)) && f.same_sense {
            assert_eq!(f.carrier, g.carrier);
            counts[0] += 1;
        }
        for (k, l) in f.loops.iter().zip(&g.loops) {
            let (LoopDescription::Edges(k), LoopDescription::Edges(l)) = (k, l) else { panic!() };
            assert_eq!(k.len(), l.len());
            for (k, l) in k.iter().zip(l) {
                assert!(l.forward);
                let (c, d) = (&a.edges[k.edge], &b.edges[l.edge]);
                if matches!(c.curve, EdgeCurve::Nurbs(_)) && k.forward {
                    assert_eq!((&c.curve, c.range, &k.pcurve), (&d.curve, d.range, &l.pcurve));
                    counts[1] += 1;
                }
            }
        }
    }
    for (c, d) in a.curves.iter().zip(&b.curves).filter(|(c, _)| matches!(c.curve, EdgeCurve::Nurbs(_))) {
        assert_eq!((&c.curve, c.range, &c.name), (&d.curve, d.range, &d.name));
    }
    counts
}

#[test]
fn impeller_comes_back_to_the_bit() {
    let first = cad_io::read_iges(&fixture("impeller.igs")).unwrap();
    let second = round(&first);
    let [faces, edges] = compare(&first, &second);
    assert_eq!(faces, 247);
    assert!(edges > 900, "{edges}");
    check_loops(&second.parts[0], 7e-3);
    // Everything is a B-spline now, so that the next file is the same to the byte.
    let written = cad_io::to_iges(&second).unwrap();
    let third = cad_io::read_iges(&written).unwrap();
    assert_eq!(written, cad_io::to_iges(&third).unwrap());
    assert_eq!(compare(&second, &third)[0], 277);
}

#[test]
fn every_kind_of_face_comes_back() {
    let mut first = cad_io::read_iges(everything().as_bytes()).unwrap();
    first.name =
        "Flügelrad; 3 × 2, \"a name that is longer than one line of the section it stands in\"".to_owned();
    first.parts[0].faces[4].name =
        "Fläche, mit Komma; und mehr als vierundsechzig Zeichen in ihrem Namen".to_owned();
    for unit in
        [LengthUnit::inch(), LengthUnit::metre(), LengthUnit { name: "ft".to_owned(), metres: 0.3048 }]
    {
        first.unit = Some(unit);
        let second = round(&first);
        compare(&first, &second);
        check_loops(&second.parts[0], 2e-8);
        let third = round(&second);
        let all = compare(&second, &third);
        assert_eq!(all[0], second.parts[0].faces.len());
    }
    first.unit = Some(LengthUnit { name: "cubit".to_owned(), metres: 0.4572 });
    let error = cad_io::to_iges(&first).unwrap_err().to_string();
    assert!(error.contains("cubit") && error.contains("convert"), "{error}");
}
