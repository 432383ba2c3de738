//! Each kind of entity against what it means.

use crate::iges_builder::{Iges, everything, tetrahedron};
use brep_core::description::{Carrier, FaceDescription, LoopDescription, ModelDescription, PartDescription};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface};

fn read(text: &str) -> ModelDescription {
    cad_io::read_iges(text.as_bytes()).unwrap()
}

/// Every loop is a chain: each edge begins where the one before ends.
pub(crate) fn check_loops(part: &PartDescription, tolerance: f64) {
    for face in &part.faces {
        for boundary in &face.loops {
            let LoopDescription::Edges(uses) = boundary else { continue };
            for (i, here) in uses.iter().enumerate() {
                let next = &uses[(i + 1) % uses.len()];
                let ends = |edge: usize, forward: bool| {
                    let edge = &part.edges[edge];
                    assert!(edge.range[0] < edge.range[1]);
                    let [start, end] = edge.range.map(|t| edge.curve.point(t));
                    let vertices = [edge.start.unwrap(), edge.end.unwrap()];
                    for (point, vertex) in [start, end].iter().zip(vertices) {
                        assert!((point - part.vertices[vertex].point).norm() <= tolerance);
                    }
                    if forward {
                        ([start, end], vertices)
                    } else {
                        ([end, start], [vertices[1], vertices[0]])
                    }
                };
                let (points, vertices) = ends(here.edge, here.forward);
                let (next_points, next_vertices) = ends(next.edge, next.forward);
                assert!((points[1] - next_points[0]).norm() <= tolerance, "face {} edge {i}", face.source);
                assert_eq!(vertices[1], next_vertices[0]);
            }
        }
    }
}

fn surface(face: &FaceDescription) -> &BsplineSurface {
    match &face.carrier {
        Carrier::Nurbs(surface) => surface,
        other => panic!("{other:?}"),
    }
}

fn near(a: Vector3<f64>, b: [f64; 3]) -> bool {
    (a - Vector3::from(b)).norm() < 1e-12
}

#[test]
fn faces_of_every_kind() {
    let model = read(&everything());
    let [part] = &model.parts[..] else { panic!() };
    assert_eq!(
        (model.name.as_str(), part.name.as_str(), model.unit.as_ref().unwrap().metres),
        ("part", "part", 1e-3)
    );
    assert_eq!(model.uncertainty, Some(1e-6));
    check_loops(part, 2e-8);
    // The solid first, then trimmed surfaces, then whole surfaces.
    assert_eq!(part.faces.len(), 4 + 3 + 4);
    assert_eq!(
        part.shells.iter().map(|shell| (shell.faces.len(), shell.closed)).collect::<Vec<_>>(),
        [(4, true), (7, false)]
    );
    let square = &part.faces[4];
    assert_eq!((square.name.as_str(), square.loops.len(), square.same_sense), ("square one", 2, true));
    // The hole was a circle in the parameters, which are lengths here.
    let LoopDescription::Edges(hole) = &square.loops[1] else { panic!() };
    assert!(hole[0].pcurve.is_some());
    let hole = &part.edges[hole[0].edge];
    for k in 0..=20 {
        let t = hole.range[0] + (hole.range[1] - hole.range[0]) * f64::from(k) / 20.0;
        assert!(((hole.curve.point(t) - Vector3::new(5.0, 5.0, 0.0)).norm() - 2.0).abs() < 1e-8);
    }
    // The half cylinder was turned by a quarter about z and moved; its axis was z.
    let half = &part.faces[5];
    let Carrier::Cylinder { frame, radius } = &half.carrier else { panic!("{:?}", half.carrier) };
    assert!((radius - 2.0).abs() < 1e-15 && near(frame.z(), [0.0, 0.0, 1.0]));
    assert!((frame.origin().xy() - nalgebra::Vector2::new(20.0, 0.0)).norm() < 1e-12);
    // S_t × S_θ with t along z: against the outward normal.
    assert!(!half.same_sense);
    let LoopDescription::Edges(ring) = &half.loops[0] else { panic!() };
    assert_eq!(ring.iter().map(|edge| edge.forward).collect::<Vec<_>>(), [true, true, false, true]);
    let bottom = &part.edges[ring[0].edge];
    assert!(near(bottom.curve.point(bottom.range[0]), [20.0, 2.0, 5.0]));
    let ruled = surface(&part.faces[6]);
    assert!(near(ruled.point(0.5, 1.0), [2.0, 3.0, 8.0]));
    let LoopDescription::Edges(uses) = &part.faces[6].loops[0] else { panic!() };
    assert_eq!(uses.iter().map(|edge| edge.forward).collect::<Vec<_>>(), [true, true, false, true]);
    // Whole surfaces, by their entity numbers: plane with a boundary, spline, crossed rulings, swept line.
    let plane = part.faces[7..].iter().find(|face| matches!(face.carrier, Carrier::Plane { .. })).unwrap();
    let Carrier::Plane { frame } = &plane.carrier else { panic!() };
    assert!(near(frame.origin(), [0.0, 0.0, 2.0]) && near(frame.z(), [0.0, 0.0, 1.0]));
    assert_eq!(plane.loops.len(), 1);
    let whole: Vec<&BsplineSurface> =
        part.faces[7..].iter().filter(|face| face.loops.is_empty()).map(surface).collect();
    assert_eq!(whole.len(), 3);
    assert!(near(whole[0].point(0.25, 1.0), [3.0, 3.0, 8.0]));
    assert!(near(whole[1].point(1.0, 3.0), [4.0, 0.0, 12.0]));
    assert!(near(whole[2].point(1.5, 0.5), [1.5, 0.5, 0.75]));
}

#[test]
fn solids_share_edges_and_point_outwards() {
    let mut f = Iges::default();
    let solid = tetrahedron(&mut f);
    let model = read(&f.text());
    let part = &model.parts[0];
    check_loops(part, 1e-15);
    assert_eq!((part.faces.len(), part.edges.len(), part.vertices.len()), (4, 6, 4));
    assert!(solid > 0 && part.shells[0].closed);
    let centre = Vector3::new(30.25, 0.25, 0.25);
    let mut uses = vec![Vec::new(); 6];
    for face in &part.faces {
        let Carrier::Plane { frame } = &face.carrier else { panic!() };
        let normal = if face.same_sense { frame.z() } else { -frame.z() };
        assert!((centre - frame.origin()).dot(&normal) < 0.0, "{face:?}");
        let LoopDescription::Edges(edges) = &face.loops[0] else { panic!() };
        edges.iter().for_each(|edge| uses[edge.edge].push(edge.forward));
    }
    // Each edge in both directions.
    assert!(uses.iter().all(|uses| uses.len() == 2 && uses[0] != uses[1]));
}

#[test]
fn free_curves_and_what_is_left_out() {
    let model = read(&everything());
    let curves = &model.parts[0].curves;
    assert_eq!(curves.len(), 7);
    let ends = |i: usize| curves[i].range.map(|t| curves[i].curve.point(t));
    let expected = [
        ([3.0, 0.0, 1.0], [0.0, 3.0, 1.0]),
        ([2.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([1.25, -0.75, 0.0], [1.25, 0.75, 0.0]),
        ([-1.0, 1.0, 2.0], [2.0, 4.0, 2.0]),
        ([0.0, 0.0, 0.0], [2.0, 0.0, 1.0]),
        ([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
        ([0.0, 0.0, 0.0], [2.0, 0.0, 0.0]),
    ];
    for (i, (start, end)) in expected.into_iter().enumerate() {
        assert!(near(ends(i)[0], start) && near(ends(i)[1], end), "curve {i}: {:?}", ends(i));
    }
    // The implicit equations hold along the conics.
    let conics: [(usize, fn(Vector3<f64>) -> f64); 3] = [
        (1, |p| 0.25 * p.x * p.x + p.y * p.y - 1.0),
        (2, |p| p.x * p.x - p.y * p.y - 1.0),
        (3, |p| p.x * p.x - p.y),
    ];
    for (i, equation) in conics {
        for k in 0..=16 {
            let [start, end] = curves[i].range;
            let p = curves[i].curve.point(start + (end - start) * f64::from(k) / 16.0);
            assert!(equation(p).abs() < 1e-13, "conic {i} at {p}");
        }
    }
    let spline = |t: f64| curves[5].curve.point(t);
    assert!(near(spline(0.5), [0.5, 0.25, 0.125]));
    let left_out: Vec<(&str, &str)> =
        model.unread.iter().map(|unread| (unread.kind.as_str(), unread.why.as_str())).collect();
    assert_eq!(
        left_out,
        [("type 110", "the file hides it"), ("type 116", "a free point"), ("type 212", "an annotation")]
    );
}

#[test]
fn surfaces_of_revolution_become_what_they_are() {
    // Meridians in the plane y = 0, bounded by some loop; the kind of carrier, and the sense against its own normal.
    let cases = [
        ("110,1.,0.,0.,3.,0.,0.", "plane", true),
        ("110,2.,0.,0.,2.,0.,5.", "cylinder", false),
        ("110,2.,0.,5.,2.,0.,0.", "cylinder", true),
        ("110,1.,0.,0.,2.,0.,5.", "cone", false),
        ("110,2.,0.,0.,1.,1.,5.", "B-spline", true),
    ];
    for (meridian, kind, same_sense) in cases {
        let mut f = Iges::default();
        let dependent = "00010000";
        let axis = f.add_with(110, 0, dependent, 0, "0.,0.,0.,0.,0.,1.");
        let meridian = f.add_with(110, 0, dependent, 0, meridian.strip_prefix("110,").unwrap());
        let turned = f.add_with(120, 0, dependent, 0, &format!("{axis},{meridian},0.,6.283185307179586"));
        let ring = f.add_with(100, 0, dependent, 0, "1.,0.,0.,2.,0.,2.,0.");
        let ring = f.add_with(142, 0, dependent, 0, &format!("1,{turned},0,{ring},2"));
        f.add(144, &format!("{turned},1,0,{ring}"));
        let model = read(&f.text());
        let face = &model.parts[0].faces[0];
        let found = match &face.carrier {
            Carrier::Plane { .. } => "plane",
            Carrier::Cylinder { .. } => "cylinder",
            Carrier::Cone { half_angle, radius, frame } => {
                assert!((half_angle.tan() - 0.2).abs() < 1e-15);
                assert!((radius - 0.2 * frame.origin().z - 1.0).abs() < 1e-14);
                "cone"
            }
            Carrier::Nurbs(surface) => {
                assert!((surface.point(0.0, 0.0).xy().norm() - 2.0).abs() < 1e-15);
                "B-spline"
            }
            other => panic!("{other:?}"),
        };
        assert_eq!((found, face.same_sense), (kind, same_sense));
    }
    // Arcs, drawn in the x, y plane and turned into x, z.
    for (arc, kind) in [("0.,0.,0.,0.,-2.,0.,2.", "sphere"), ("0.,5.,0.,6.,0.,4.,0.", "torus")] {
        let mut f = Iges::default();
        let dependent = "00010000";
        let upright = f.add(124, "1.,0.,0.,0.,0.,0.,-1.,0.,0.,1.,0.,0.");
        let axis = f.add_with(110, 0, dependent, 0, "0.,0.,0.,0.,0.,1.");
        let meridian = f.add_with(100, 0, dependent, upright, arc);
        let turned = f.add_with(120, 0, dependent, 0, &format!("{axis},{meridian},0.,6.283185307179586"));
        let ring = f.add_with(100, 0, dependent, 0, "0.,0.,0.,2.,0.,2.,0.");
        let ring = f.add_with(142, 0, dependent, 0, &format!("1,{turned},0,{ring},2"));
        f.add(144, &format!("{turned},1,0,{ring}"));
        let model = read(&f.text());
        let face = &model.parts[0].faces[0];
        match &face.carrier {
            Carrier::Sphere { frame, radius } if kind == "sphere" => {
                assert!(frame.origin().norm() < 1e-15 && (radius - 2.0).abs() < 1e-15);
            }
            Carrier::Torus { major_radius, minor_radius, .. } if kind == "torus" => {
                assert!((major_radius - 5.0).abs() < 1e-15 && (minor_radius - 1.0).abs() < 1e-15);
            }
            other => panic!("{kind}: {other:?}"),
        }
        // Both arcs run counter-clockwise, upwards on the outside: S_t × S_θ points inwards.
        assert!(!face.same_sense, "{kind}");
    }
}

#[test]
fn boundaries_in_angles_are_lifted() {
    // A quarter of a cylinder whose boundary is given in (height, angle) only.
    let mut f = Iges::default();
    let dependent = "00010000";
    let axis = f.add_with(110, 0, dependent, 0, "0.,0.,0.,0.,0.,1.");
    let side = f.add_with(110, 0, dependent, 0, "2.,0.,0.,2.,0.,3.");
    let turned = f.add_with(120, 0, dependent, 0, &format!("{axis},{side},0.,3."));
    let corners = ["0.,0.,0.", "1.,0.,0.", "1.,1.5,0.", "0.,1.5,0."];
    let lines: Vec<String> = (0..4)
        .map(|i| {
            f.add_with(110, 0, "00010500", 0, &format!("{},{}", corners[i], corners[(i + 1) % 4])).to_string()
        })
        .collect();
    let flat = f.add_with(102, 0, "00010500", 0, &format!("4,{}", lines.join(",")));
    let ring = f.add_with(142, 0, dependent, 0, &format!("1,{turned},{flat},0,1"));
    f.add(144, &format!("{turned},1,0,{ring}"));
    let model = read(&f.text());
    let part = &model.parts[0];
    check_loops(part, 1e-8);
    assert_eq!((part.edges.len(), part.faces[0].loops.len()), (4, 1));
    for edge in &part.edges {
        for k in 0..=40 {
            let p = edge.curve.point(edge.range[0] + (edge.range[1] - edge.range[0]) * f64::from(k) / 40.0);
            assert!((p.xy().norm() - 2.0).abs() < 1e-8 && p.z > -1e-12 && p.z < 3.0 + 1e-12);
        }
    }
    let far = &part.vertices[2].point;
    assert!((far - Vector3::new(2.0 * 1.5_f64.cos(), 2.0 * 1.5_f64.sin(), 3.0)).norm() < 1e-12);
}
