//! Files of other programs; the numbers are compared with the text, which is taken apart here by other means.

use crate::iges_entities::check_loops;
use brep_core::description::{Carrier, EdgeCurve, LoopDescription};
use nurbs_core::{BsplineCurve, BsplineSurface};
use std::collections::HashMap;
use std::path::PathBuf;

pub(crate) fn fixture(name: &str) -> Vec<u8> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/cad");
    std::fs::read(root.join(name)).unwrap()
}

/// The values of every entity as text, by directory number: columns 1 to 64 of the lines that point back to it.
fn values_of(data: &[u8]) -> HashMap<u64, Vec<String>> {
    let text = String::from_utf8_lossy(data);
    let mut records: HashMap<u64, String> = HashMap::new();
    for line in text.lines().filter(|line| line.as_bytes().get(72) == Some(&b'P')) {
        *records.entry(line[64..72].trim().parse().unwrap()).or_default() += &line[..64];
    }
    let split = |record: String| {
        let own = record.split(';').next().unwrap().to_owned();
        own.split(',').map(|value| value.trim().to_owned()).collect()
    };
    records.into_iter().map(|(number, record)| (number, split(record))).collect()
}

fn bits(values: &[String]) -> Vec<u64> {
    values.iter().map(|value| value.replace('D', "E").parse::<f64>().unwrap().to_bits()).collect()
}

fn same_curve(curve: &BsplineCurve<3>, values: &[String]) {
    let [upper, degree] = [&values[1], &values[2]].map(|value| value.parse::<usize>().unwrap());
    let (knots, rest) = values[7..].split_at(upper + degree + 2);
    let (weights, rest) = rest.split_at(upper + 1);
    let ours = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(ours(curve.knots().as_slice()), bits(knots));
    assert_eq!((0..=upper).map(|i| curve.weight(i).to_bits()).collect::<Vec<_>>(), bits(weights));
    let points: Vec<f64> = curve.control_points().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    assert_eq!(ours(&points), bits(&rest[..3 * (upper + 1)]));
}

fn same_surface(surface: &BsplineSurface, values: &[String]) {
    let number = |i: usize| values[i].parse::<usize>().unwrap();
    let (n_u, n_v) = (number(1) + 1, number(2) + 1);
    assert_eq!((surface.degree_u(), surface.degree_v()), (number(3), number(4)));
    let (knots_u, rest) = values[10..].split_at(n_u + number(3) + 1);
    let (knots_v, rest) = rest.split_at(n_v + number(4) + 1);
    let (weights, rest) = rest.split_at(n_u * n_v);
    let ours = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    assert_eq!(ours(surface.knots_u().as_slice()), bits(knots_u));
    assert_eq!(ours(surface.knots_v().as_slice()), bits(knots_v));
    let (weights, points) = (bits(weights), bits(&rest[..3 * n_u * n_v]));
    for j in 0..n_v {
        for i in 0..n_u {
            let place = j * n_u + i;
            assert_eq!(surface.weight(i, j).to_bits(), weights[place]);
            let point = surface.control_point(i, j);
            assert_eq!([point.x, point.y, point.z].map(f64::to_bits), points[3 * place..3 * place + 3]);
        }
    }
}

#[test]
fn impeller_is_read_to_the_bit() {
    let data = fixture("impeller.igs");
    let model = cad_io::read_iges(&data).unwrap();
    let values = values_of(&data);
    let part = &model.parts[0];
    assert_eq!((model.name.as_str(), model.unit.as_ref().unwrap().name.as_str()), ("impeller", "mm"));
    assert_eq!((part.faces.len(), model.unread.len(), part.curves.len()), (277, 0, 0));
    let (mut splines, mut rational, mut others) = (0, 0, 0);
    for face in &part.faces {
        let own = &values[&face.source];
        assert_eq!(own[0], "144");
        let holes: usize = own[3].parse().unwrap();
        assert_eq!((own[2].as_str(), face.loops.len()), ("1", 1 + holes));
        let surface = &values[&own[1].parse().unwrap()];
        match &face.carrier {
            Carrier::Nurbs(carrier) if surface[0] == "128" => {
                same_surface(carrier, surface);
                assert!(face.same_sense);
                splines += 1;
                rational += usize::from(carrier.weights().is_some());
            }
            _ => {
                assert_eq!(surface[0], "120");
                others += 1;
            }
        }
        for (boundary, number) in face.loops.iter().zip(&own[4..]) {
            let LoopDescription::Edges(uses) = boundary else { panic!() };
            let on_surface = &values[&number.parse().unwrap()];
            assert_eq!((on_surface[0].as_str(), &on_surface[2]), ("142", &own[1]));
            // Curves in space, and those in parameters where the carrier has those of the file.
            for (place, flat) in [(4, false), (3, true)] {
                let composite = &values[&on_surface[place].parse().unwrap()];
                assert_eq!((composite[0].as_str(), composite[1].parse().unwrap()), ("102", uses.len()));
                for (edge_use, number) in uses.iter().zip(&composite[2..]) {
                    let number: u64 = number.parse().unwrap();
                    let text = &values[&number];
                    let edge = &part.edges[edge_use.edge];
                    assert!(edge_use.forward);
                    if flat {
                        if let Some(curve) = &edge_use.pcurve {
                            let [upper, degree] = [&text[1], &text[2]].map(|v| v.parse::<usize>().unwrap());
                            let start = 7 + upper + degree + 2 + upper + 1;
                            let points: Vec<f64> =
                                curve.control_points().iter().flat_map(|p| [p.x, p.y, 0.0]).collect();
                            let ours: Vec<u64> = points.iter().map(|value| value.to_bits()).collect();
                            assert_eq!(ours, bits(&text[start..start + 3 * (upper + 1)]));
                        } else {
                            assert_ne!(surface[0], "128");
                        }
                        continue;
                    }
                    assert_eq!(edge.source, number);
                    match &edge.curve {
                        EdgeCurve::Nurbs(curve) => same_curve(curve, text),
                        EdgeCurve::Line { origin, .. } => {
                            assert_eq!(bits(&text[1..4]), [origin.x, origin.y, origin.z].map(f64::to_bits));
                            let end = edge.curve.point(edge.range[1]);
                            let told = bits(&text[4..7]);
                            let gap =
                                (0..3).map(|c| (f64::from_bits(told[c]) - end[c]).abs()).fold(0.0, f64::max);
                            assert!(gap < 1e-13);
                        }
                        _ => assert_eq!(text[0], "100"),
                    }
                }
            }
        }
    }
    assert_eq!((splines, rational, others), (247, 212, 30));
    // Curves of one loop are up to 6 µm apart in the file.
    check_loops(part, 7e-3);
}

#[test]
fn arcs_of_another_program() {
    let model = cad_io::read_iges(&fixture("example-arcs.iges")).unwrap();
    let curves = &model.parts[0].curves;
    assert_eq!(curves.len(), 3);
    let values = values_of(&fixture("example-arcs.iges"));
    let EdgeCurve::Circle { frame, radius } = &curves[0].curve else { panic!() };
    let text: Vec<f64> = values[&3][1..8].iter().map(|value| value.parse().unwrap()).collect();
    // The matrix of the file only moves.
    assert!((frame.origin().x + 63.253315).abs() < 1e-12);
    assert!((radius - text[3].hypot(text[4])).abs() < 1e-12);
    let end = curves[0].curve.point(curves[0].range[1]);
    assert!((end.x - (text[5] - 63.253315)).abs() < 1e-7 && (end.y - (text[6] + 36.654861)).abs() < 1e-7);
    let EdgeCurve::Nurbs(spline) = &curves[1].curve else { panic!() };
    same_curve(spline, &values[&7]);
    let EdgeCurve::Ellipse { semi_axes, .. } = &curves[2].curve else { panic!() };
    let [a, c, f] = [1, 3, 6].map(|i| values[&9][i].parse::<f64>().unwrap());
    assert!((semi_axes[0] - (-f / a).sqrt()).abs() < 1e-12 && (semi_axes[1] - (-f / c).sqrt()).abs() < 1e-12);
}

#[test]
fn a_file_without_shapes_says_what_it_holds() {
    let error = cad_io::read_iges(&fixture("sample.igs")).unwrap_err().to_string();
    assert!(error.contains("no faces and no curves") && error.contains("type 116"), "{error}");
}
