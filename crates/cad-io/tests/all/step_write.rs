//! What is written as STEP comes back.

use crate::iges_builder::everything;
use crate::iges_entities::check_loops;
use crate::iges_files::fixture;
use brep_core::description::{
    Carrier, EdgeCurve, EdgeDescription, EdgeUse, FaceDescription, InstanceDescription, LengthUnit,
    LoopDescription, ModelDescription, PartDescription, Placement, ShellDescription, VertexDescription,
};
use cad_io::ModelBuilder;
use nalgebra::Vector3;
use nurbs_core::{
    AnalyticSurface, BsplineCurve, BsplineSurface, Cone, Cylinder, Direction, Frame, Interval, KnotVector,
    ParametricCurve, Plane, Sphere, Torus,
};
use std::f64::consts::PI;
use std::sync::Arc;

fn round(model: &ModelDescription) -> ModelDescription {
    let bytes = cad_io::to_step(model).unwrap();
    let model = cad_io::read_step(&bytes)
        .unwrap_or_else(|error| panic!("{error}\n{}", String::from_utf8_lossy(&bytes)));
    assert!(model.unread.is_empty(), "{:?}", model.unread);
    model
}

/// A rational surface that is no power of two anywhere, with a square cut out of its middle.
pub(crate) fn trimmed_vane() -> ModelDescription {
    let knots = || KnotVector::new(3, vec![0.1, 0.1, 0.1, 0.1, 0.37, 1.3, 1.3, 1.3, 1.3]).unwrap();
    let at = |k: usize| (k / 5, k % 5);
    let points = (0..25)
        .map(|k| {
            let (i, j) = at(k);
            let (x, y) = (i as f64 * 10.0 / 3.0 + 0.1, j as f64 * 7.0 / 3.0 - 0.2);
            Vector3::new(x, y, (0.7 * x).sin() + 0.1 * y * y)
        })
        .collect();
    let weights = (0..25).map(|k| 1.0 + 0.3 * (at(k).0 * at(k).1) as f64 / 7.0).collect();
    let surface = BsplineSurface::new(knots(), knots(), points, Some(weights)).unwrap();
    let mut model = ModelBuilder::new("Vane-1", Some(LengthUnit::millimetre()));
    model.surface("pressure side", surface.clone());
    let mut model = model.finish();
    let part = &mut model.parts[0];
    let square = |direction: Direction, at: f64| {
        surface.iso_curve(direction, at).unwrap().trimmed(Interval::new(0.4, 0.9).unwrap()).unwrap()
    };
    let outer = |direction: Direction, at: f64| surface.iso_curve(direction, at).unwrap();
    let mut add = |curves: [BsplineCurve<3>; 4]| {
        let first = part.vertices.len();
        for curve in &curves[..] {
            let point = curve.point(curve.domain().start());
            part.vertices.push(VertexDescription { source: 0, point });
        }
        // Bottom, right, top (backwards), left (backwards): vertices are the lower left corners, two of them doubled.
        let upper = curves[1].point(curves[1].domain().end());
        part.vertices.push(VertexDescription { source: 0, point: upper });
        let corners = [first, first + 1, first + 4, first + 2];
        let ends = [(0, 1), (1, 2), (3, 2), (0, 3)];
        let uses = curves.into_iter().zip(ends).enumerate().map(|(k, (curve, (start, end)))| {
            let domain = curve.domain();
            part.edges.push(EdgeDescription {
                source: 0,
                range: [domain.start(), domain.end()],
                curve: EdgeCurve::Nurbs(Arc::new(curve)),
                start: Some(corners[start]),
                end: Some(corners[end]),
            });
            EdgeUse { edge: part.edges.len() - 1, forward: k < 2, pcurve: None }
        });
        LoopDescription::Edges(uses.collect())
    };
    let loops = vec![
        add([
            outer(Direction::V, 0.1),
            outer(Direction::U, 1.3),
            outer(Direction::V, 1.3),
            outer(Direction::U, 0.1),
        ]),
        add([
            square(Direction::V, 0.4),
            square(Direction::U, 0.9),
            square(Direction::V, 0.9),
            square(Direction::U, 0.4),
        ]),
    ];
    part.faces[0].loops = loops;
    model
}

fn edges_of<'p>(part: &'p PartDescription, boundary: &LoopDescription) -> Vec<(&'p EdgeDescription, bool)> {
    let LoopDescription::Edges(uses) = boundary else { panic!() };
    uses.iter().map(|edge| (&part.edges[edge.edge], edge.forward)).collect()
}

#[test]
fn rational_trimmed_named_surface_comes_back_to_the_bit() {
    let mut first = trimmed_vane();
    check_loops(&first.parts[0], 1e-12);
    let units = [
        LengthUnit::millimetre(),
        LengthUnit::metre(),
        LengthUnit::inch(),
        LengthUnit { name: "ft".to_owned(), metres: 0.3048 },
        LengthUnit { name: "cubit".to_owned(), metres: 0.4572 },
    ];
    for unit in units {
        first.unit = Some(unit.clone());
        let second = round(&first);
        let found = second.unit.as_ref().unwrap();
        assert!((found.metres / unit.metres - 1.0).abs() < 1e-15, "{found:?} {unit:?}");
        let (a, b) = (&first.parts[0], &second.parts[0]);
        assert_eq!((b.name.as_str(), b.faces.len(), b.shells.len()), ("Vane-1", 1, 1));
        assert_eq!((&a.faces[0].name, &a.faces[0].carrier), (&b.faces[0].name, &b.faces[0].carrier));
        assert!(b.faces[0].same_sense && b.faces[0].loops.len() == 2);
        for (k, l) in a.faces[0].loops.iter().zip(&b.faces[0].loops) {
            let (k, l) = (edges_of(a, k), edges_of(b, l));
            assert_eq!(k.len(), l.len());
            for ((c, c_forward), (d, d_forward)) in k.into_iter().zip(l) {
                assert_eq!((&c.curve, c_forward), (&d.curve, d_forward));
                assert!(c.range.iter().zip(d.range).all(|(s, t)| (s - t).abs() < 1e-9));
            }
        }
        assert_eq!((b.edges.len(), b.vertices.len()), (8, 8));
    }
    // The same model, the same bytes; without a unit millimetres.
    first.unit = None;
    let bytes = cad_io::to_step(&first).unwrap();
    assert_eq!(bytes, cad_io::to_step(&first).unwrap());
    assert_eq!(cad_io::read_step(&bytes).unwrap().unit.unwrap().metres, 1e-3);
}

#[test]
fn whole_surfaces_get_the_boundary_that_they_have() {
    let turned = Frame::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(1.0, 1.0, 0.5), Vector3::x()).unwrap();
    let interval = |a, b| Interval::new(a, b).unwrap();
    let sphere = Sphere::new(turned, 2.0).unwrap();
    let cases: Vec<(AnalyticSurface, [usize; 3])> = vec![
        // Edges, vertices, and edges of the loop.
        (Plane::new(turned, interval(-1.0, 2.0), interval(0.5, 3.0)).into(), [4, 4, 4]),
        (Cylinder::new(turned, 1.5, interval(-1.0, 4.0)).unwrap().into(), [3, 2, 4]),
        (
            Cylinder::new(turned, 1.5, interval(-1.0, 4.0))
                .unwrap()
                .with_angles(interval(0.5, 2.0))
                .unwrap()
                .into(),
            [4, 4, 4],
        ),
        (Cone::new(turned, 2.0, 1.0, 3.0).unwrap().into(), [3, 2, 4]),
        (Cone::new(turned, 2.0, 0.0, 3.0).unwrap().into(), [2, 2, 3]),
        (sphere.into(), [1, 2, 2]),
        (sphere.with_domain(interval(0.0, 1.0), interval(0.2, 1.0)).unwrap().into(), [4, 4, 4]),
        (sphere.with_domain(interval(0.0, 1.0), interval(0.2, PI / 2.0)).unwrap().into(), [3, 3, 3]),
        (Torus::new(turned, 5.0, 1.0).unwrap().into(), [2, 1, 4]),
    ];
    for (surface, counts) in cases {
        let mut model = ModelBuilder::new("one", Some(LengthUnit::metre()));
        model.analytic("exact", &surface).unwrap();
        let first = model.finish();
        check_loops(&first.parts[0], 1e-14);
        let back = round(&first);
        let part = &back.parts[0];
        let LoopDescription::Edges(uses) = &part.faces[0].loops[0] else { panic!() };
        assert_eq!([part.edges.len(), part.vertices.len(), uses.len()], counts, "{surface:?}");
        check_loops(part, 1e-14);
        assert_eq!(part.faces[0].name, "exact");
        same_kind(&first.parts[0].faces[0].carrier, &part.faces[0].carrier);
        // The same as a B-spline without loops: seams and poles are found.
        let mut model = ModelBuilder::new("two", None);
        model.surface("spline", surface.to_nurbs().unwrap());
        let back = round(&model.finish());
        let part = &back.parts[0];
        check_loops(part, 1e-9);
        let LoopDescription::Edges(uses) = &part.faces[0].loops[0] else { panic!() };
        assert_eq!([part.edges.len(), part.vertices.len(), uses.len()], counts, "{surface:?}");
        let Carrier::Nurbs(found) = &part.faces[0].carrier else { panic!() };
        assert_eq!(**found, surface.to_nurbs().unwrap());
    }
}

fn same_kind(a: &Carrier, b: &Carrier) {
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    match (a, b) {
        (Carrier::Plane { frame: a }, Carrier::Plane { frame: b }) => assert_eq!(a, b),
        (Carrier::Cylinder { radius: a, .. }, Carrier::Cylinder { radius: b, .. })
        | (Carrier::Sphere { radius: a, .. }, Carrier::Sphere { radius: b, .. }) => near(*a, *b),
        (
            Carrier::Cone { frame: f, radius: a, half_angle: c },
            Carrier::Cone { frame: g, radius: b, half_angle: d },
        ) => {
            near(*a, *b);
            near(c.tan() * f.z().dot(&g.z()), d.tan());
        }
        (
            Carrier::Torus { major_radius: a, minor_radius: c, .. },
            Carrier::Torus { major_radius: b, minor_radius: d, .. },
        ) => {
            near(*a, *b);
            near(*c, *d);
        }
        _ => panic!("{a:?} became {b:?}"),
    }
}

#[test]
fn periodic_surfaces_are_cut_open() {
    let knots = KnotVector::uniform_periodic(3, 6).unwrap();
    let ring = |k: usize, z: f64| {
        let angle = (k % 6) as f64 * PI / 3.0;
        Vector3::new(5.0 * angle.cos(), 5.0 * angle.sin(), z)
    };
    let points = (0..9).flat_map(|k| [ring(k, 0.0), ring(k, 4.0)]).collect();
    let knots_v = KnotVector::bezier(1, Interval::UNIT).unwrap();
    let surface = BsplineSurface::new(knots, knots_v, points, None).unwrap();
    let mut model = ModelBuilder::new("tube", None);
    model.surface("", surface.clone());
    let first = model.finish();
    let from_step = round(&first);
    let from_iges = cad_io::read_iges(&cad_io::to_iges(&first).unwrap()).unwrap();
    assert_eq!((from_step.parts[0].edges.len(), from_step.parts[0].vertices.len()), (3, 2));
    for model in [from_step, from_iges] {
        let Carrier::Nurbs(found) = &model.parts[0].faces[0].carrier else { panic!() };
        for k in 0..=50 {
            let u = f64::from(k) / 50.0;
            let [a, b] = [found, &Arc::new(surface.clone())]
                .map(|s| nurbs_core::ParametricSurface::point(&**s, u, 0.3));
            assert!((a - b).norm() < 1e-14, "{u}");
        }
    }
}

#[test]
fn free_curves_and_names_in_any_script() {
    let line = |z: f64| {
        BsplineCurve::bezier(vec![Vector3::new(0.1, 0.2, z), Vector3::new(1.0 / 3.0, 2.0, z)], None).unwrap()
    };
    let mut model = ModelBuilder::new("Profil Nr. 7 – 'Flügel'", Some(LengthUnit::millimetre()));
    model.curve("first", line(0.7));
    model.curve("zweite", line(0.9));
    let arc = (line(0.3).into_parts().1).into_iter().chain([Vector3::new(0.7, 0.1, 0.3)]).collect();
    model.curve("rational", BsplineCurve::bezier(arc, Some(vec![1.0, 1.0 / 3.0, 0.7])).unwrap());
    let first = model.finish();
    let second = round(&first);
    let (a, b) = (&first.parts[0], &second.parts[0]);
    assert_eq!((a.curves.len(), b.curves.len(), &b.name), (3, 3, &a.name));
    for (c, d) in a.curves.iter().zip(&b.curves) {
        assert_eq!((c.range, &c.name), (d.range, &d.name));
        let (EdgeCurve::Nurbs(c), EdgeCurve::Nurbs(d)) = (&c.curve, &d.curve) else { panic!() };
        if c.weights().is_none() {
            assert_eq!(c, d);
        } else {
            // The library that reads it divides by the weights once.
            assert_eq!((c.knots(), c.weights()), (d.knots(), d.weights()));
            let off = c.control_points().iter().zip(d.control_points()).map(|(p, q)| (p - q).amax());
            assert!(off.fold(0.0, f64::max) < 1e-15);
        }
    }
    assert!(cad_io::to_step(&ModelDescription::default()).is_err());
}

#[test]
fn iges_becomes_step() {
    for data in [fixture("impeller.igs"), everything().into_bytes()] {
        let first = cad_io::read_iges(&data).unwrap();
        let second = round(&first);
        let a = &first.parts[0];
        let count = |model: &ModelDescription, kind: fn(&Carrier) -> bool| {
            model.parts.iter().flat_map(|part| &part.faces).filter(|face| kind(&face.carrier)).count()
        };
        let kinds: [fn(&Carrier) -> bool; 4] = [
            |carrier| matches!(carrier, Carrier::Nurbs(_)),
            |carrier| matches!(carrier, Carrier::Plane { .. }),
            |carrier| matches!(carrier, Carrier::Cylinder { .. }),
            |carrier| {
                matches!(carrier, Carrier::Cone { .. } | Carrier::Sphere { .. } | Carrier::Torus { .. })
            },
        ];
        assert!(kinds.iter().all(|&kind| count(&first, kind) == count(&second, kind)));
        let splines = |model: &ModelDescription| -> Vec<BsplineSurface> {
            let faces = model.parts.iter().flat_map(|part| &part.faces);
            faces
                .filter_map(|face| match &face.carrier {
                    Carrier::Nurbs(surface) => Some(surface.as_ref().clone()),
                    _ => None,
                })
                .collect()
        };
        let (ours, theirs) = (splines(&first), splines(&second));
        assert!(ours.iter().all(|surface| theirs.contains(surface)));
        assert_eq!(a.curves.len(), second.parts.iter().map(|part| part.curves.len()).sum::<usize>());
        assert_eq!(first.unit.as_ref().unwrap().metres, second.unit.as_ref().unwrap().metres);
    }
}

/// A part of whole spheres: radius, centre, and whether the normal points outwards.
fn balls(spheres: &[(f64, f64, bool)]) -> ModelDescription {
    let mut part = PartDescription { name: "balls".to_owned(), ..PartDescription::default() };
    for (k, (radius, x, same_sense)) in spheres.iter().enumerate() {
        let frame = Frame::new(Vector3::new(*x, 0.0, 0.0), Vector3::z(), Vector3::x()).unwrap();
        part.faces.push(FaceDescription {
            name: format!("ball {k}"),
            source: 0,
            carrier: Carrier::Sphere { frame, radius: *radius },
            same_sense: *same_sense,
            loops: Vec::new(),
        });
        part.shells.push(ShellDescription { faces: vec![k], closed: true, ..ShellDescription::default() });
    }
    let instance = InstanceDescription { part: 0, name: String::new(), placement: Placement::IDENTITY };
    ModelDescription {
        unit: Some(LengthUnit::millimetre()),
        parts: vec![part],
        instances: vec![instance],
        ..ModelDescription::default()
    }
}

#[test]
fn closed_shells_become_solids_and_voids() {
    // Two solids, one of them with a hole inside.
    let model = balls(&[(2.0, 0.0, true), (1.0, 9.0, true), (0.5, 0.3, false)]);
    let text = String::from_utf8(cad_io::to_step(&model).unwrap()).unwrap();
    assert_eq!(text.matches("MANIFOLD_SOLID_BREP").count(), 1, "{text}");
    assert_eq!(text.matches("BREP_WITH_VOIDS").count(), 1, "{text}");
    assert!(!text.contains("SHELL_BASED_SURFACE_MODEL"), "{text}");
    let read = brep_core::Model::new(&round(&model)).unwrap();
    let side = |x: f64| read.nearest(&Vector3::new(x, 0.0, 0.0)).unwrap().signed_distance().unwrap();
    assert!((side(0.3) - 0.5).abs() < 1e-12, "in the hole: {}", side(0.3));
    assert!((side(1.5) + 0.5).abs() < 1e-12, "in the material: {}", side(1.5));
    assert!((side(9.5) + 0.5).abs() < 1e-12 && (side(4.0) - 2.0).abs() < 1e-12);
    // A void without anything around it bounds nothing.
    let text =
        String::from_utf8(cad_io::to_step(&balls(&[(2.0, 0.0, true), (1.0, 9.0, false)])).unwrap()).unwrap();
    assert!(text.contains("SHELL_BASED_SURFACE_MODEL") && !text.contains("SOLID_BREP("), "{text}");
}

#[test]
fn offsets_of_free_form_surfaces_become_splines() {
    // Two quarters of cylinders as B-splines; the outer one is then said to be an offset of the inner one.
    let quarter = |radius: f64| {
        let piece = Cylinder::new(Frame::WORLD, radius, Interval::new(0.0, 3.0).unwrap()).unwrap();
        AnalyticSurface::from(piece.with_angles(Interval::new(0.2, 1.7).unwrap()).unwrap())
            .to_nurbs()
            .unwrap()
    };
    let mut model = ModelBuilder::new("offset", Some(LengthUnit::millimetre()));
    model.surface("inner", quarter(2.0));
    model.surface("outer", quarter(2.5));
    let text = String::from_utf8(cad_io::to_step(&model.finish()).unwrap()).unwrap();
    let surface_of = |name: &str| {
        let face =
            text.split(';').find(|record| record.contains(&format!("ADVANCED_FACE('{name}'"))).unwrap();
        let words: Vec<&str> = face.split(',').collect();
        words[words.len() - 2].to_owned()
    };
    let (inner, outer) = (surface_of("inner"), surface_of("outer"));
    let end = text.rfind("ENDSEC").unwrap();
    let changed = text[..end].replace(&format!(",{outer},"), ",#900000,");
    let changed = format!("{changed}#900000=OFFSET_SURFACE('',{inner},0.5,.F.);\n{}", &text[end..]);
    let read = cad_io::read_step(changed.as_bytes()).unwrap();
    assert!(read.unread.is_empty(), "{:?}", read.unread);
    assert_eq!(read.converted.iter().map(|c| c.kind).collect::<Vec<_>>(), ["offset"]);
    let model = brep_core::Model::new(&read).unwrap();
    assert!(model.unread().is_empty(), "{:?}", model.unread());
    for k in 0..40 {
        let angle = 0.25 + 1.4 * f64::from(k) / 39.0;
        let x = Vector3::new(2.7 * angle.cos(), 2.7 * angle.sin(), 0.3 + 0.06 * f64::from(k));
        let foot = model.nearest(&x).unwrap();
        assert!((foot.distance - 0.2).abs() < 1e-7, "{foot:?}");
    }
}
