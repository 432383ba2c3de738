use super::*;
use digits::Relation;

/// The parameters of the footpoints, computed with 40 digits.
const SOLUTIONS: [(usize, usize, &[f64]); 7] = [
    (1, 0, &[0.982_347_293_153_578]),
    (1, 1, &[1.783_812_656_106_892]),
    (2, 0, &[0.769_514_010_309_026]),
    (2, 1, &[0.622_341_923_826_841]),
    (3, 0, &[0.622_341_923_826_841]),
    (4, 0, &[0.861_446_923_730_362, 0.558_521_787_429_644]),
    (5, 0, &[0.128_847_832_731_207, 0.674_180_665_992_584]),
];

#[test]
fn every_number_relates_to_the_printed_one_as_listed() {
    let tables = compute::tables().unwrap();
    assert_eq!(disagreements(&tables), Vec::<String>::new());
    let printed = || tables.iter().flat_map(|t| &t.blocks).flat_map(|b| &b.rows).flat_map(|r| r.printed);
    let count = |relation| printed().filter(|p| p.relation == relation).count();
    let relations = [Relation::Equal, Relation::CutOff, Relation::Misprint];
    assert_eq!(relations.map(count), [107, 3, 8]);
    // Rounded once; rounding to 10 decimals first would give 2.4e-08.
    let row = &tables[0].blocks[0].rows[0];
    assert_eq!((row.printed[4].text, row.printed[4].relation), ("2.3e-08", Relation::Equal));
    assert!((row.computed[4] - 2.3493e-8).abs() < 1e-12);
}

#[test]
fn solutions_are_exact() {
    let tables = compute::tables().unwrap();
    for (number, block, expected) in SOLUTIONS {
        let found = &tables[number - 1].blocks[block].solutions;
        assert_eq!(found.len(), expected.len());
        for (solution, expected) in found.iter().zip(expected) {
            assert!((solution.computed - expected).abs() < 2e-12, "Table {number}: {solution:?}");
        }
    }
}

#[test]
fn snapshots_of_the_tables() {
    let tables = compute::tables().unwrap();
    let names = ["table_1", "table_2", "table_3", "table_4", "table_5"];
    assert_eq!(tables.len(), names.len());
    for (name, table) in names.iter().zip(&tables) {
        insta::assert_snapshot!(*name, render::table(table));
    }
}

#[test]
fn a_changed_number_is_noticed() {
    let mut tables = compute::tables().unwrap();
    tables[0].blocks[0].rows[1].computed[0] *= 1.1;
    tables[3].blocks[0].rows[0].computed[1] /= 10.0;
    assert_eq!(disagreements(&tables).len(), 2);
    assert!(render::document(&tables).contains("not listed"));
}

#[test]
fn registrations_of_table_6_are_exact() {
    let registrations = table_6::compute().unwrap();
    assert_eq!(table_6::disagreements(&registrations), Vec::<String>::new());
    insta::assert_snapshot!("table_6", table_6::render(&registrations));
}

#[test]
fn a_changed_registration_is_noticed() {
    let mut registrations = table_6::compute().unwrap();
    registrations[1].rows[0].errors[4] *= 1.0 + 1e-5;
    assert_eq!(table_6::disagreements(&registrations).len(), 1);
}

#[test]
fn directed_projections_compare_as_said() {
    let comparisons = directed::compute().unwrap();
    assert_eq!(directed::disagreements(&comparisons), Vec::<String>::new());
    insta::assert_snapshot!("directed", directed::render(&comparisons));
}
