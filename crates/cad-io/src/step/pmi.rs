//! Tolerances and dimensions that AP242 files state about faces (semantic PMI).
//!
//! The chain of entities is that of the recommended practices for the representation of PMI (Implementor Forum of the `CAx` association): a tolerance
//! or a dimension names a shape aspect, and a `GEOMETRIC_ITEM_SPECIFIC_USAGE` says which faces that is; composite and derived
//! aspects lead to theirs by relationships.

use super::records::{Record, Records, Value};
use brep_core::description::{EntityNumber, LengthUnit, PmiTolerance};
use std::collections::HashSet;

/// Aspects that lead to each other at most.
const MAX_STEPS: usize = 4096;

/// Whether records of a type tell something about tolerances, dimensions or what they are stated of.
fn matters(kind: &str) -> bool {
    kind.contains("TOLERANCE")
        || kind.contains("DATUM")
        || kind.contains("SHAPE_ASPECT")
        || kind.contains("DIMENSION")
        || kind.contains("MEASURE")
        || kind.starts_with("ANGULAR_")
        || kind.ends_with("_UNIT")
        || kind.ends_with("SHAPE_REPRESENTATION")
        || matches!(
            kind,
            "GEOMETRIC_ITEM_SPECIFIC_USAGE"
                | "ITEM_IDENTIFIED_REPRESENTATION_USAGE"
                | "PROPERTY_DEFINITION"
                | "SHAPE_DEFINITION_REPRESENTATION"
                | "PROPERTY_DEFINITION_REPRESENTATION"
                | "LIMITS_AND_FITS"
                | "CENTRE_OF_SYMMETRY"
                | "COMPONENT_FEATURE_RELATIONSHIP"
        )
}

/// Whether a type is one of geometric tolerances.
fn is_tolerance(kind: &str) -> bool {
    (kind.ends_with("_TOLERANCE") || kind == "GEOMETRIC_TOLERANCE")
        && !matches!(kind, "PLUS_MINUS_TOLERANCE" | "MODIFIED_GEOMETRIC_TOLERANCE")
}

/// Whether a type is one of dimensions.
fn is_dimension(kind: &str) -> bool {
    ["DIMENSIONAL_SIZE", "ANGULAR_SIZE"].iter().any(|start| kind.starts_with(start)) || is_location(kind)
}

/// Whether a type is one of dimensions between two aspects.
fn is_location(kind: &str) -> bool {
    kind.ends_with("DIMENSIONAL_LOCATION")
        || kind.starts_with("DIMENSIONAL_LOCATION_")
        || kind.starts_with("ANGULAR_LOCATION")
}

/// Finds the tolerances and dimensions of a file. `unit` is that of its coordinates, `faces` the numbers of its faces.
pub(super) fn read(text: &[u8], unit: Option<&LengthUnit>, faces: &HashSet<u64>) -> Vec<PmiTolerance> {
    if !has_any(text) {
        return Vec::new();
    }
    let pmi = Pmi { records: Records::read(text, matters), unit, faces };
    let stated = |(number, record): (u64, &Record)| {
        if record.is(is_tolerance) {
            Some(pmi.tolerance(number, record))
        } else if record.is(is_dimension) {
            Some(pmi.dimension(number, record))
        } else {
            None
        }
    };
    pmi.records.iter().filter_map(stated).collect()
}

/// Whether the text may hold any: most files do not, and are not looked at twice.
fn has_any(text: &[u8]) -> bool {
    let starts = |at: usize| {
        let rest = &text[at..];
        [&b"_TOLERANCE"[..], b"_SIZE", b"_LOCATION"]
            .iter()
            .any(|word| rest.len() >= word.len() && rest[..word.len()].eq_ignore_ascii_case(word))
    };
    text.iter().enumerate().any(|(at, byte)| *byte == b'_' && starts(at))
}

struct Pmi<'a> {
    records: Records,
    unit: Option<&'a LengthUnit>,
    faces: &'a HashSet<u64>,
}

impl Pmi<'_> {
    /// `GEOMETRIC_TOLERANCE(name, description, magnitude, aspect)` and its subtypes, which some files write as one complex
    /// entity.
    fn tolerance(&self, number: u64, record: &Record) -> PmiTolerance {
        let own = record.values(|kind| kind == "GEOMETRIC_TOLERANCE").or_else(|| record.values(is_tolerance));
        let own = own.unwrap_or_default();
        let mut kinds = record.parts.iter().map(|(kind, _)| kind.as_str());
        let leaf = kinds.find(|kind| is_tolerance(kind) && *kind != "GEOMETRIC_TOLERANCE");
        let kind = leaf.unwrap_or("GEOMETRIC_TOLERANCE").trim_end_matches("_TOLERANCE");
        let mut modifiers = Vec::new();
        for (part, values) in &record.parts {
            if part.contains("MODIFIE") {
                words(values, &mut modifiers);
            }
        }
        let [on, others] = self.places(own.get(3).into_iter().flat_map(Value::references).collect());
        PmiTolerance {
            source: number,
            kind: readable(kind),
            name: text_at(own, 0),
            value: own.get(2).and_then(Value::reference).and_then(|measure| self.measure(measure)),
            limits: None,
            fit: String::new(),
            datums: self.datums(number, record),
            modifiers,
            faces: on,
            others,
        }
    }

    /// Letters of the datums that a tolerance names, in the order of their precedence; common ones are joined by a hyphen.
    fn datums(&self, number: u64, record: &Record) -> Vec<String> {
        let target = record
            .values(|kind| kind == "GEOMETRIC_TOLERANCE")
            .or_else(|| record.values(is_tolerance))
            .and_then(|values| values.get(3))
            .map_or_else(Vec::new, Value::references);
        let mut found: Vec<(f64, String)> = Vec::new();
        for named in record.references().into_iter().filter(|named| !target.contains(named)) {
            let Some(reference) = self.records.get(named).filter(|_| named != number) else { continue };
            if let Some(system) = reference.values(|kind| kind == "DATUM_SYSTEM") {
                let compartments = system.last().map_or_else(Vec::new, Value::references);
                for compartment in compartments {
                    found.push((found.len() as f64, self.letters(compartment, 0).join("-")));
                }
            } else if reference.is(|kind| kind.contains("DATUM") && !kind.contains("FEATURE")) {
                let precedence = reference.parts.first().and_then(|(_, values)| values.first());
                let place = precedence.and_then(Value::number).unwrap_or(found.len() as f64);
                found.push((place, self.letters(named, 0).join("-")));
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().map(|(_, letters)| letters).filter(|letters| !letters.is_empty()).collect()
    }

    /// Letters of the datums behind a reference.
    fn letters(&self, number: u64, depth: usize) -> Vec<String> {
        let Some(record) = self.records.get(number).filter(|_| depth < 8) else { return Vec::new() };
        if let Some(values) = record.values(|kind| matches!(kind, "DATUM" | "COMMON_DATUM")) {
            let letter = values.iter().rev().find_map(Value::text).unwrap_or_default();
            return vec![letter.to_owned()];
        }
        if !record.is(|kind| kind.contains("DATUM") && !kind.contains("FEATURE")) {
            return Vec::new();
        }
        record.references().into_iter().flat_map(|named| self.letters(named, depth + 1)).collect()
    }

    /// Sizes (`DIMENSIONAL_SIZE(aspect, name)`) and locations (`DIMENSIONAL_LOCATION(name, description, aspect, aspect)`).
    fn dimension(&self, number: u64, record: &Record) -> PmiTolerance {
        let own = record.parts.iter().find(|(kind, _)| is_dimension(kind));
        let (kind, own) = own.map_or(("", &[][..]), |(kind, values)| (kind.as_str(), values.as_slice()));
        let aspects: Vec<u64> = if is_location(kind) {
            // A complex entity has its names and aspects in the part of its supertype.
            let relation = record.values(|kind| kind == "SHAPE_ASPECT_RELATIONSHIP").unwrap_or(own);
            relation.iter().filter_map(Value::reference).take(2).collect()
        } else {
            own.iter().filter_map(Value::reference).take(1).collect()
        };
        let name = own.iter().find_map(Value::text).unwrap_or_default().to_owned();
        let (value, bounds) = self.sizes(number);
        let (plus_minus, fit) = self.plus_minus(number);
        let limits = plus_minus.or_else(|| {
            let [low, high] = bounds;
            let nominal = value?;
            (low.is_some() || high.is_some()).then(|| {
                [low.map_or(f64::NEG_INFINITY, |l| l - nominal), high.map_or(f64::INFINITY, |h| h - nominal)]
            })
        });
        let value = value.or(bounds[1]).or(bounds[0]);
        let [on, others] = self.places(aspects);
        PmiTolerance {
            source: number,
            kind: readable(kind),
            name,
            value,
            limits,
            fit,
            datums: Vec::new(),
            modifiers: Vec::new(),
            faces: on,
            others,
        }
    }

    /// The nominal value of a dimension, and its least and largest where the file states them as values of their own.
    fn sizes(&self, dimension: u64) -> (Option<f64>, [Option<f64>; 2]) {
        let (mut nominal, mut bounds) = (None, [None; 2]);
        for (_, user) in self.records.users(dimension) {
            let Some(values) = user.values(|kind| kind == "DIMENSIONAL_CHARACTERISTIC_REPRESENTATION") else {
                continue;
            };
            if values.first().and_then(Value::reference) != Some(dimension) {
                continue;
            }
            let representation = values.get(1).and_then(Value::reference).and_then(|n| self.records.get(n));
            let items = representation.and_then(|r| r.parts.iter().find_map(|(_, values)| values.get(1)));
            for item in items.map_or_else(Vec::new, Value::references) {
                let Some(value) = self.measure(item) else { continue };
                let name = self.records.get(item).map(measure_name).unwrap_or_default();
                match name.as_str() {
                    "lower limit" => bounds[0] = Some(value),
                    "upper limit" => bounds[1] = Some(value),
                    _ => nominal = nominal.or(Some(value)),
                }
            }
        }
        (nominal, bounds)
    }

    /// Deviations from the nominal value that are allowed, or the class of a fit.
    fn plus_minus(&self, dimension: u64) -> (Option<[f64; 2]>, String) {
        for (_, user) in self.records.users(dimension) {
            let Some(values) = user.values(|kind| kind == "PLUS_MINUS_TOLERANCE") else { continue };
            let range = values.first().and_then(Value::reference).and_then(|number| self.records.get(number));
            let Some(range) = range else { continue };
            if let Some(values) = range.values(|kind| kind == "TOLERANCE_VALUE") {
                let bound = |k: usize| values.get(k).and_then(Value::reference).and_then(|m| self.measure(m));
                if let (Some(low), Some(high)) = (bound(0), bound(1)) {
                    return (Some([low, high]), String::new());
                }
            }
            if let Some(values) = range.values(|kind| kind == "LIMITS_AND_FITS") {
                let fit: Vec<&str> = [0, 2].into_iter().filter_map(|k| values.get(k)?.text()).collect();
                return (None, fit.concat());
            }
        }
        (None, String::new())
    }

    /// The value of a measure: lengths in the unit of the file, angles in radians.
    fn measure(&self, number: u64) -> Option<f64> {
        let record = self.records.get(number)?;
        for (_, values) in &record.parts {
            let Some(place) = values
                .iter()
                .position(|value| matches!(value, Value::List(kind, _) if kind.contains("MEASURE")))
            else {
                continue;
            };
            let value = values[place].number().filter(|value| value.is_finite())?;
            let factor =
                values.get(place + 1).and_then(Value::reference).and_then(|unit| self.unit_factor(unit, 0));
            return Some(match factor {
                Some((true, metres)) => match self.unit {
                    Some(own) if (metres / own.metres - 1.0).abs() > 1e-12 => value * metres / own.metres,
                    _ => value,
                },
                Some((false, radians)) => value * radians,
                None => value,
            });
        }
        None
    }

    /// Whether a unit is one of length, and how many metres or radians it has.
    fn unit_factor(&self, number: u64, depth: usize) -> Option<(bool, f64)> {
        let record = self.records.get(number).filter(|_| depth < 4)?;
        let is_length = record.is(|kind| kind == "LENGTH_UNIT");
        if !is_length && !record.is(|kind| kind == "PLANE_ANGLE_UNIT") {
            return None;
        }
        if let Some(values) = record.values(|kind| kind == "SI_UNIT") {
            let prefix = values.iter().rev().nth(1);
            let exponent = match prefix {
                Some(Value::Word(word)) => match word.as_str() {
                    "KILO" => 3,
                    "DECI" => -1,
                    "CENTI" => -2,
                    "MILLI" => -3,
                    "MICRO" => -6,
                    "NANO" => -9,
                    _ => 0,
                },
                _ => 0,
            };
            return Some((is_length, 10_f64.powi(exponent)));
        }
        let values = record.values(|kind| kind == "CONVERSION_BASED_UNIT")?;
        let measure = self.records.get(values.get(1).and_then(Value::reference)?)?;
        let (_, values) = measure.parts.iter().find(|(_, values)| values.len() >= 2)?;
        let value = values[0].number().filter(|value| *value > 0.0 && value.is_finite())?;
        let (_, base) = self.unit_factor(values[1].reference()?, depth + 1)?;
        Some((is_length, value * base))
    }

    /// The faces that aspects stand for, and what else they name.
    fn places(&self, aspects: Vec<u64>) -> [Vec<EntityNumber>; 2] {
        let mut out = [Vec::new(), Vec::new()];
        let mut seen: HashSet<u64> = aspects.iter().copied().collect();
        let mut open: Vec<u64> = aspects.into_iter().rev().collect();
        let mut steps = 0;
        while let Some(aspect) = open.pop() {
            steps += 1;
            if steps > MAX_STEPS {
                break;
            }
            let mut next = Vec::new();
            let own = self.records.get(aspect);
            if own.is_some_and(|record| record.is(is_dimension)) {
                // A tolerance of a dimension is one of what has it.
                next.extend(own.map_or_else(Vec::new, Record::references));
            }
            let is_datum = own.is_some_and(|record| record.is(|kind| kind == "DATUM"));
            for (number, user) in self.records.users(aspect) {
                self.follow(aspect, is_datum, number, user, &mut next, &mut out);
            }
            open.extend(next.into_iter().rev().filter(|number| seen.insert(*number)));
        }
        out
    }

    /// What a record that names an aspect says about its faces: items, or other aspects to look at.
    fn follow(
        &self,
        aspect: u64,
        is_datum: bool,
        number: u64,
        user: &Record,
        next: &mut Vec<u64>,
        out: &mut [Vec<EntityNumber>; 2],
    ) {
        let at = |values: &[Value], k: usize| values.get(k).and_then(Value::reference);
        if let Some(values) = user.values(|kind| {
            matches!(kind, "GEOMETRIC_ITEM_SPECIFIC_USAGE" | "ITEM_IDENTIFIED_REPRESENTATION_USAGE")
        }) {
            if at(values, 2) == Some(aspect) {
                self.add_items(&values.get(4).map_or_else(Vec::new, Value::references), out);
            }
        } else if let Some(values) = user.values(|kind| kind == "PROPERTY_DEFINITION") {
            if at(values, 2) == Some(aspect) {
                for (_, representation) in self.records.users(number) {
                    let values = representation.values(|kind| kind.ends_with("DEFINITION_REPRESENTATION"));
                    let shape = values.and_then(|values| at(values, 1)).and_then(|n| self.records.get(n));
                    let items = shape.and_then(|s| s.values(|kind| kind.ends_with("SHAPE_REPRESENTATION")));
                    let items = items.and_then(|values| values.get(1));
                    self.add_items(&items.map_or_else(Vec::new, Value::references), out);
                }
            }
        } else if let Some(values) = user
            .values(|kind| kind.contains("SHAPE_ASPECT") && kind.contains("RELATIONSHIP"))
            .or_else(|| user.values(|kind| kind == "COMPONENT_FEATURE_RELATIONSHIP"))
            && !user.is(is_dimension)
        {
            let (relating, related) = (at(values, 2), at(values, 3));
            let is_target = |n: u64| {
                self.records
                    .get(n)
                    .is_some_and(|r| r.is(|kind| kind.contains("DATUM_TARGET") || kind == "DATUM"))
            };
            if is_datum && related == Some(aspect) {
                next.extend(relating);
            } else if relating == Some(aspect) {
                next.extend(related.filter(|n| !is_target(*n)));
            }
        }
    }

    fn add_items(&self, items: &[u64], out: &mut [Vec<EntityNumber>; 2]) {
        for item in items {
            let list = &mut out[usize::from(!self.faces.contains(item))];
            if !list.contains(item) {
                list.push(*item);
            }
        }
    }
}

/// The name of a measure that is an item of a representation.
fn measure_name(record: &Record) -> String {
    let own = record.values(|kind| kind == "REPRESENTATION_ITEM").or_else(|| record.values(|_| true));
    text_at(own.unwrap_or_default(), 0).to_ascii_lowercase()
}

fn text_at(values: &[Value], k: usize) -> String {
    values.get(k).and_then(Value::text).unwrap_or_default().to_owned()
}

/// The type in words: `surface profile` of `SURFACE_PROFILE`.
fn readable(kind: &str) -> String {
    kind.to_ascii_lowercase().replace('_', " ")
}

fn words(values: &[Value], out: &mut Vec<String>) {
    for value in values {
        match value {
            Value::Word(word) if word != "$" && word != "*" => out.push(readable(word)),
            Value::List(_, inner) => words(inner, out),
            _ => {}
        }
    }
}
