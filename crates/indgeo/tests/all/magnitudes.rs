//! Models whose numbers are too large, or too unlike, to compute with: every command ends, with an answer or with the number.

use crate::common::Bench;

/// The cases of the fuzz targets that once ran for ever or ended in a panic.
const MODELS: [&str; 5] = ["c_huge.json", "c_whuge.json", "c_wtinymix.json", "s_huge.json", "s_whuge.json"];

fn put(bench: &Bench, name: &str) {
    let seeds = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/json/");
    bench.put(name, std::fs::read(format!("{seeds}{name}")).unwrap());
}

#[test]
fn every_command_ends_with_an_answer_or_names_the_number() {
    let bench = Bench::new();
    let rows: Vec<String> =
        (0..30).map(|k| format!("{} {} {}\n", k % 6, k / 6, (f64::from(k) * 0.7).sin())).collect();
    bench.put("points.xyz", rows.concat());
    for name in MODELS {
        put(&bench, name);
        let commands = [
            format!("project {name} points.xyz -o d.csv"),
            format!("inspect {name} points.xyz -t 1"),
            format!("register {name} points.xyz --transform t.json --start given"),
            format!("convert {name} out.obj"),
            format!("fit-surface points.xyz --init {name} -o s.json"),
            format!("fit-curve points.xyz --init {name} -o c.json"),
        ];
        for command in commands {
            let run = bench.run(&command);
            assert!((0..=2).contains(&run.code), "{command}: {} {}", run.code, run.stderr);
            if run.code == 2 {
                assert!(
                    run.stderr.starts_with("error: ") && run.stderr.len() > 20,
                    "{command}: {}",
                    run.stderr
                );
            }
        }
    }
    // What cannot be represented is refused with the number.
    let run = bench.run("project c_huge.json points.xyz -o d.csv");
    assert!(run.code == 2 && run.stderr.contains("1e300"), "{} {}", run.code, run.stderr);
}
