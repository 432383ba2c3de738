//! STEP files against tables made with other programs: counts, distances, areas.

use brep_core::description::Carrier;
use brep_core::{Model, Side};
use cad_io::read_step_file;
use nalgebra::Vector3;
use std::path::PathBuf;

pub(crate) fn fixture(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/cad")).join(name)
}

/// Rows of numbers of a table; words become NaN.
fn table(name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(fixture(name)).unwrap();
    text.lines().skip(1).map(|l| l.split(',').map(|w| w.parse().unwrap_or(f64::NAN)).collect()).collect()
}

const SCREW: &str = "M6-1x12-countersunk-screw";
const BRACKET: &str = "nema-17-bracket";
const PLATE: &str = "00000050_80d90bfdd2e74e709956122a_step_000";

fn model(name: &str) -> Model {
    let description = read_step_file(&fixture(&format!("{name}.step"))).unwrap();
    assert!(description.unread.is_empty(), "{:?}", description.unread);
    let model = Model::new(&description).unwrap();
    assert!(model.unread().is_empty(), "{:?}", model.unread());
    model
}

#[test]
fn faces_units_and_numbers() {
    // Two of the faces of the screw lie on swept surfaces, which become B-splines.
    for (name, placed, splines, tolerance) in
        [(SCREW, 28, 8, 2.2e-7), (BRACKET, 42, 0, 1e-7), (PLATE, 43, 0, 1e-5)]
    {
        let description = read_step_file(&fixture(&format!("{name}.step"))).unwrap();
        let unit = description.unit.as_ref().unwrap();
        let faces: Vec<_> =
            description.instances.iter().flat_map(|i| &description.parts[i.part].faces).collect();
        assert_eq!(faces.len(), placed, "{name}");
        let found = faces.iter().filter(|f| matches!(f.carrier, Carrier::Nurbs(_))).count();
        assert_eq!(found, splines, "{name}");
        assert!(faces.iter().all(|f| f.source > 0), "every face knows its number");
        let model = Model::new(&description).unwrap();
        let largest = model.parts().iter().flat_map(|p| p.edges()).map(|e| e.tolerance()).fold(0.0, f64::max);
        let millimetres = largest * unit.metres * 1e3;
        assert!(millimetres <= 1.1 * tolerance + 1e-6, "{name}: {millimetres}");
    }
}

/// The text of the entity with a number.
fn entity(text: &str, number: u64) -> String {
    let start = text.find(&format!("#{number}=")).or_else(|| text.find(&format!("#{number} ="))).unwrap();
    text[start..].split(';').next().unwrap().to_owned()
}

#[test]
fn numbers_name_the_entities_of_the_file() {
    for name in [SCREW, BRACKET, PLATE] {
        let path = fixture(&format!("{name}.step"));
        let text = std::fs::read_to_string(&path).unwrap();
        let description = read_step_file(&path).unwrap();
        for part in &description.parts {
            for face in &part.faces {
                assert!(entity(&text, face.source).contains("ADVANCED_FACE"), "#{}", face.source);
            }
            for edge in &part.edges {
                assert!(entity(&text, edge.source).contains("EDGE_CURVE"), "#{}", edge.source);
            }
            for vertex in &part.vertices {
                let own = entity(&text, vertex.source);
                assert!(own.contains("VERTEX_POINT"), "{own}");
                // The point behind it has the coordinates that were read.
                let point = own
                    .rsplit('#')
                    .next()
                    .unwrap()
                    .trim_matches(|c: char| !c.is_ascii_digit())
                    .parse()
                    .unwrap();
                let coordinates = entity(&text, point);
                let list = coordinates.rsplit('(').next().unwrap().trim_end_matches([')', ' ', '\n', '\r']);
                let numbers: Vec<f64> = list.split(',').map(|w| w.trim().parse().unwrap()).collect();
                assert_eq!(vertex.point, Vector3::from_column_slice(&numbers));
            }
        }
    }
}

#[test]
fn areas_of_faces() {
    for name in [SCREW, BRACKET, PLATE] {
        let model = model(name);
        let scale = model.unit().unwrap().metres * 1e3;
        let mut areas: Vec<f64> = Vec::new();
        for instance in model.instances() {
            let part = &model.parts()[instance.part];
            areas.extend((0..part.faces().len()).map(|face| part.area(face) * scale * scale));
        }
        areas.sort_by(|a, b| b.total_cmp(a));
        let rows = table(&format!("areas/{name}.csv"));
        assert_eq!(areas.len(), rows.len());
        for (row, area) in rows.iter().zip(areas) {
            // Area, edge length and edge tolerance.
            let allowed = 1e-6 * row[0] + row[3] * row[4];
            assert!((area - row[0]).abs() <= allowed, "{name}: {} expected, {area} found", row[0]);
        }
    }
}

#[test]
fn distances_and_sides() {
    for name in [SCREW, BRACKET] {
        let model = model(name);
        let scale = model.unit().unwrap().metres * 1e3;
        let diagonal = model.bounds().diagonal() * scale;
        let rows = table(&format!("{name}.csv"));
        let points: Vec<_> = rows.iter().map(|r| Vector3::new(r[0], r[1], r[2]) / scale).collect();
        for (row, foot) in rows.iter().zip(model.nearest_many(&points)) {
            let foot = foot.unwrap();
            let allowed = (2.0 * row[4]).max(1e-7 * diagonal);
            assert!((foot.distance * scale - row[3]).abs() <= allowed, "{name} {row:?}: {foot:?}");
            assert!(foot.gap() * scale <= 1e-7 * diagonal, "{name} {row:?}: {foot:?}");
            if row[10] != 0.0 && row[3] > allowed {
                let side = if row[10] > 0.0 { Side::Positive } else { Side::Negative };
                assert_eq!(foot.side, side, "{name} {row:?}: {foot:?}");
            }
        }
    }
}
