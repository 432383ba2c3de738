//! Tolerances and dimensions of AP242 files.

use crate::step::fixture;
use crate::step_damage::mutate;
use brep_core::description::{ModelDescription, PmiTolerance};
use cad_io::read_step;
use std::f64::consts::FRAC_PI_6;

/// Faces of the part, in order.
fn faces(model: &ModelDescription) -> Vec<u64> {
    model.parts[0].faces.iter().map(|face| face.source).collect()
}

/// The bracket with the records of its tolerances. `$1` to `$4` in them are faces.
fn annotated(records: &str) -> (Vec<u8>, [u64; 4]) {
    let text = std::fs::read_to_string(fixture("nema-17-bracket.step")).unwrap();
    let all = faces(&read_step(text.as_bytes()).unwrap());
    let on = [all[0], all[1], all[2], all[3]];
    let mut records = records.to_owned();
    for (k, face) in on.iter().enumerate() {
        records = records.replace(&format!("${}", k + 1), &format!("#{face}"));
    }
    let end = text.rfind("ENDSEC").unwrap();
    (format!("{}{records}\n{}", &text[..end], &text[end..]).into_bytes(), on)
}

/// Chains as the recommended practices for PMI have them: a position with two datums, a flatness of a composite aspect, a
/// profile of the whole part, a diameter with deviations, an angle with limits, a thickness with a fit.
const RECORDS: &str = "
#90001=PRODUCT_DEFINITION_SHAPE('','',#7);
#90002=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#90003=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#90004=(CONVERSION_BASED_UNIT('DEGREE',#90005)NAMED_UNIT(#90006)PLANE_ANGLE_UNIT());
#90005=PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.017453292519943295),#90003);
#90006=DIMENSIONAL_EXPONENTS(0.,0.,0.,0.,0.,0.,0.);
#90007=(CONVERSION_BASED_UNIT('INCH',#90008)LENGTH_UNIT()NAMED_UNIT(#90006));
#90008=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#90002);
#90010=SHAPE_ASPECT('hole','',#90001,.T.);
#90011=GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#90010,#8,$1);
#90012=DATUM_FEATURE('A face','',#90001,.T.);
#90013=GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#90012,#8,$2);
#90014=DATUM('','',#90001,.F.,'A');
#90015=SHAPE_ASPECT_RELATIONSHIP('','',#90012,#90014);
#90016=DATUM('','',#90001,.F.,'B');
#90017=DATUM('','',#90001,.F.,'C');
#90020=DATUM_REFERENCE_COMPARTMENT('','',#90001,.F.,#90014,$);
#90021=DATUM_REFERENCE_ELEMENT('','',#90001,.F.,#90016,$);
#90022=DATUM_REFERENCE_ELEMENT('','',#90001,.F.,#90017,$);
#90023=DATUM_REFERENCE_COMPARTMENT('','',#90001,.F.,COMMON_DATUM_LIST((#90021,#90022)),$);
#90024=DATUM_SYSTEM('','',#90001,.F.,(#90020,#90023));
#90030=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.2),#90002);
#90031=(GEOMETRIC_TOLERANCE('Position.1','',#90030,#90010)GEOMETRIC_TOLERANCE_WITH_DATUM_REFERENCE((#90024))
GEOMETRIC_TOLERANCE_WITH_MODIFIERS((.MAXIMUM_MATERIAL_REQUIREMENT.))POSITION_TOLERANCE());
#90032=COMPOSITE_GROUP_SHAPE_ASPECT('','',#90001,.T.);
#90033=SHAPE_ASPECT('','',#90001,.T.);
#90034=SHAPE_ASPECT('','',#90001,.T.);
#90035=SHAPE_ASPECT_RELATIONSHIP('','',#90032,#90033);
#90036=SHAPE_ASPECT_RELATIONSHIP('','',#90032,#90034);
#90037=GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#90033,#8,$3);
#90038=ITEM_IDENTIFIED_REPRESENTATION_USAGE('','',#90034,#8,SET_REPRESENTATION_ITEM(($4,#9)));
#90039=(LENGTH_MEASURE_WITH_UNIT()MEASURE_REPRESENTATION_ITEM()MEASURE_WITH_UNIT(LENGTH_MEASURE(0.01),#90007)REPRESENTATION_ITEM(''));
#90040=FLATNESS_TOLERANCE('Flatness.1','',#90039,#90032);
#90041=SURFACE_PROFILE_TOLERANCE('all over','',#90030,#90001);
#90050=DIMENSIONAL_SIZE(#90010,'diameter');
#90051=(LENGTH_MEASURE_WITH_UNIT()MEASURE_REPRESENTATION_ITEM()MEASURE_WITH_UNIT(POSITIVE_LENGTH_MEASURE(3.),#90002)
REPRESENTATION_ITEM('nominal value'));
#90052=SHAPE_DIMENSION_REPRESENTATION('',(#90051),#8);
#90053=DIMENSIONAL_CHARACTERISTIC_REPRESENTATION(#90050,#90052);
#90054=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(-0.05),#90002);
#90055=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.1),#90002);
#90056=TOLERANCE_VALUE(#90054,#90055);
#90057=PLUS_MINUS_TOLERANCE(#90056,#90050);
#90060=ANGULAR_LOCATION('angle','',#90012,#90033,.SMALL.);
#90061=MEASURE_REPRESENTATION_ITEM('nominal value',PLANE_ANGLE_MEASURE(30.),#90004);
#90062=MEASURE_REPRESENTATION_ITEM('upper limit',PLANE_ANGLE_MEASURE(31.),#90004);
#90063=SHAPE_DIMENSION_REPRESENTATION('',(#90061,#90062),#8);
#90064=DIMENSIONAL_CHARACTERISTIC_REPRESENTATION(#90060,#90063);
#90070=DIMENSIONAL_LOCATION('linear distance','',#90012,#90010);
#90071=LIMITS_AND_FITS('H','hole','7','');
#90072=PLUS_MINUS_TOLERANCE(#90071,#90070);
#90080=PERPENDICULARITY_TOLERANCE('of a size','',#90030,#90050,(#90081,#90082));
#90081=DATUM_REFERENCE(2,#90016);
#90082=DATUM_REFERENCE(1,#90014);
";

#[test]
fn tolerances_name_the_faces_that_they_are_stated_of() {
    let (bytes, [a, b, c, d]) = annotated(RECORDS);
    let model = read_step(&bytes).unwrap();
    let found: Vec<&PmiTolerance> = model.tolerances.iter().collect();
    let by = |source: u64| *found.iter().find(|tolerance| tolerance.source == source).unwrap();
    assert_eq!(found.len(), 7, "{found:?}");

    let position = by(90031);
    assert_eq!((position.kind.as_str(), position.name.as_str()), ("position", "Position.1"));
    assert_eq!((position.value, &position.faces), (Some(0.2), &vec![a]));
    assert_eq!(position.datums, ["A", "B-C"]);
    assert_eq!(position.modifiers, ["maximum material requirement"]);

    // A hundredth of an inch in a file of millimetres, of two aspects together.
    let flatness = by(90040);
    assert!((flatness.value.unwrap() - 0.254).abs() < 1e-15);
    assert_eq!((&flatness.faces, &flatness.others), (&vec![c, d], &vec![9]));

    let whole = by(90041);
    assert_eq!(whole.kind, "surface profile");
    assert!(whole.faces.is_empty() && whole.others.is_empty());

    let diameter = by(90050);
    assert_eq!((diameter.kind.as_str(), diameter.name.as_str()), ("dimensional size", "diameter"));
    assert_eq!((diameter.value, diameter.limits), (Some(3.0), Some([-0.05, 0.1])));

    let angle = by(90060);
    assert!((angle.value.unwrap() - FRAC_PI_6).abs() < 1e-15);
    let [low, high] = angle.limits.unwrap();
    assert!(low == f64::NEG_INFINITY && (high - 1_f64.to_radians()).abs() < 1e-15);
    assert_eq!(angle.faces, [b, c]);

    let distance = by(90070);
    assert_eq!((distance.fit.as_str(), &distance.faces), ("H7", &vec![b, a]));

    // A tolerance of a dimension is one of the faces that have it; references are ordered by their precedence.
    let upright = by(90080);
    assert_eq!((&upright.faces, &upright.datums), (&vec![a], &vec!["A".to_owned(), "B".to_owned()]));
}

#[test]
fn circles_of_aspects_and_files_without_tolerances_end() {
    let (bytes, [a, ..]) = annotated(
        "#90001=FLATNESS_TOLERANCE('','',#90009,#90002);#90002=SHAPE_ASPECT('','',#7,.T.);
         #90003=SHAPE_ASPECT('','',#7,.T.);#90004=SHAPE_ASPECT_RELATIONSHIP('','',#90002,#90003);
         #90005=SHAPE_ASPECT_RELATIONSHIP('','',#90003,#90002);
         #90006=GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#90003,#8,$1);
         #90009=LENGTH_MEASURE_WITH_UNIT($,#90009);",
    );
    let model = read_step(&bytes).unwrap();
    assert_eq!(model.tolerances.len(), 1);
    assert_eq!((&model.tolerances[0].faces, model.tolerances[0].value), (&vec![a], None));
    let plain = std::fs::read(fixture("nema-17-bracket.step")).unwrap();
    assert!(read_step(&plain).unwrap().tolerances.is_empty());
}

#[test]
fn damaged_chains_end() {
    for seed in 0..200 {
        let records = mutate(RECORDS.as_bytes(), seed);
        let (bytes, _) = annotated(&String::from_utf8_lossy(&records));
        if let Ok(model) = read_step(&bytes) {
            assert!(model.tolerances.iter().all(|t| t.value.is_none_or(f64::is_finite)), "seed {seed}");
        }
    }
}
