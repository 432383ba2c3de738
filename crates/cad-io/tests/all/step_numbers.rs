//! Numbers of B-splines of STEP files against the text of the file, which is scanned here by other means.

use crate::step::fixture;
use crate::step_write::trimmed_vane;
use brep_core::description::{Carrier, EdgeCurve, ModelDescription};
use cad_io::{read_step, to_step};
use std::collections::HashMap;

/// The text of each record by its number, without blanks and line ends.
struct Text(HashMap<u64, String>);

impl Text {
    fn of(bytes: &[u8]) -> Self {
        let text = String::from_utf8_lossy(bytes);
        let records = text.split(';').map(|record| record.split_whitespace().collect::<String>());
        let numbered = records.filter_map(|record| {
            let (number, rest) = record.strip_prefix('#')?.split_once('=')?;
            Some((number.parse().ok()?, rest.to_owned()))
        });
        Self(numbered.collect())
    }

    /// The values of a type, split at the commas between them.
    fn values(&self, number: u64, kind: &str) -> Option<Vec<String>> {
        let record = self.0.get(&number)?;
        // The whole word: `CURVE(` ends other words too.
        let is_word = |at: &usize| !record[..*at].ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
        let at = record.match_indices(&format!("{kind}(")).map(|found| found.0).find(is_word)?;
        let mut out = vec![String::new()];
        let mut depth = 0;
        for c in record[at + kind.len()..].chars() {
            match c {
                '(' => depth += 1,
                ')' => depth -= 1,
                _ => {}
            }
            match (c, depth) {
                ('(', 1) => {}
                (',', 1) => out.push(String::new()),
                (_, 0) => return Some(out),
                _ => out.last_mut().unwrap().push(c),
            }
        }
        None
    }

    fn bits(list: &str) -> Vec<u64> {
        let plain = list.replace(['(', ')'], "");
        plain.split(',').map(|word| word.parse::<f64>().unwrap().to_bits()).collect()
    }

    /// Knots, each as often as its multiplicity says.
    fn knots(multiplicities: &str, knots: &str) -> Vec<u64> {
        let counts = multiplicities.replace(['(', ')'], "");
        let counts = counts.split(',').map(|word| word.parse::<usize>().unwrap());
        Self::bits(knots).into_iter().zip(counts).flat_map(|(knot, count)| vec![knot; count]).collect()
    }

    /// Coordinates of points that a list names.
    fn points(&self, list: &str) -> Vec<u64> {
        let plain = list.replace(['(', ')', '#'], "");
        let numbers = plain.split(',').map(|word| word.parse::<u64>().unwrap());
        numbers.flat_map(|n| Self::bits(&self.values(n, "CARTESIAN_POINT").unwrap()[1])).collect()
    }

    fn reference(word: &str) -> u64 {
        word.trim_start_matches('#').parse().unwrap()
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Compares all B-splines; returns how many surfaces, rational ones among them, and curves there are.
fn compare(model: &ModelDescription, text: &Text) -> [usize; 3] {
    let mut counts = [0; 3];
    let part_values = |number: u64, simple: &str, kinds: [&str; 2]| match text.values(number, simple) {
        // Name, then what the two parts of a complex entity hold.
        Some(values) if values.len() > 5 => Some((values[1..].to_vec(), None)),
        _ => {
            let mut values = text.values(number, kinds[0])?;
            values.extend(text.values(number, simple)?);
            Some((values, text.values(number, kinds[1])))
        }
    };
    for part in &model.parts {
        for face in &part.faces {
            let Carrier::Nurbs(surface) = &face.carrier else { continue };
            let own = text.values(face.source, "ADVANCED_FACE").unwrap();
            let number = Text::reference(&own[2]);
            let kinds = ["B_SPLINE_SURFACE", "RATIONAL_B_SPLINE_SURFACE"];
            let Some((values, weights)) = part_values(number, "B_SPLINE_SURFACE_WITH_KNOTS", kinds) else {
                continue;
            };
            let points: Vec<f64> = surface.control_points().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
            assert_eq!(bits(&points), text.points(&values[2]), "#{number}");
            assert_eq!(bits(surface.knots_u().as_slice()), Text::knots(&values[7], &values[9]), "#{number}");
            assert_eq!(bits(surface.knots_v().as_slice()), Text::knots(&values[8], &values[10]), "#{number}");
            assert_eq!(surface.weights().map(bits), weights.as_ref().map(|w| Text::bits(&w[0])), "#{number}");
            counts[0] += 1;
            counts[1] += usize::from(weights.is_some());
        }
        for edge in &part.edges {
            let EdgeCurve::Nurbs(curve) = &edge.curve else { continue };
            let own = text.values(edge.source, "EDGE_CURVE").unwrap();
            let mut number = Text::reference(&own[3]);
            for wrapper in ["SURFACE_CURVE", "SEAM_CURVE", "INTERSECTION_CURVE"] {
                if let Some(values) = text.values(number, wrapper) {
                    number = Text::reference(&values[1]);
                }
            }
            let kinds = ["B_SPLINE_CURVE", "RATIONAL_B_SPLINE_CURVE"];
            let Some((values, weights)) = part_values(number, "B_SPLINE_CURVE_WITH_KNOTS", kinds) else {
                continue;
            };
            // Edges against their curve are turned round.
            let same = own[4] == ".T.";
            let points: Vec<f64> = curve.control_points().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
            let mut told = text.points(&values[1]);
            if !same {
                told = told.chunks(3).rev().flatten().copied().collect();
            }
            assert_eq!(bits(&points), told, "#{number}");
            if same {
                assert_eq!(bits(curve.knots().as_slice()), Text::knots(&values[5], &values[6]), "#{number}");
                assert_eq!(curve.weights().map(bits), weights.map(|w| Text::bits(&w[0])), "#{number}");
            }
            counts[2] += 1;
        }
    }
    counts
}

#[test]
fn splines_have_the_numbers_of_the_text() {
    for (name, surfaces) in [("M6-1x12-countersunk-screw.step", 6), ("nema-17-bracket.step", 0)] {
        let bytes = std::fs::read(fixture(name)).unwrap();
        let [found, _, curves] = compare(&read_step(&bytes).unwrap(), &Text::of(&bytes));
        assert_eq!(found, surfaces, "{name}");
        assert!(surfaces == 0 || curves > 20, "{name}: {curves}");
    }
    let bytes = to_step(&trimmed_vane()).unwrap();
    assert_eq!(compare(&read_step(&bytes).unwrap(), &Text::of(&bytes)), [1, 1, 8]);
}
