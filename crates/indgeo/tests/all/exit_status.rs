//! One rule for every command: what its exit status means, and that its report says the same.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::Bench;
use crate::common::inputs::bench;
use serde_json::Value;

/// A command with arguments for which it is done (0), with others for which the answer is no (1) and the status of the report then,
/// with a missing file (2), and with an option that makes no sense (2) and what the message says about it.
type Case =
    (&'static str, &'static str, &'static [(&'static str, &'static str)], &'static str, [&'static str; 2]);

const CASES: [Case; 9] = [
    (
        "project",
        "model.json points.xyz -o out.csv",
        &[],
        "model.json none.xyz -o out.csv",
        ["model.json points.xyz -o out.csv --relative-gap -1", "--relative-gap is -1"],
    ),
    (
        "inspect",
        "model.json points.xyz -t 1",
        &[("model.json points.xyz -t 0.1", "out_of_tolerance")],
        "model.json none.xyz -t 1",
        [
            "model.json points.xyz -t -0.1",
            "invalid value '-0.1' for '--tolerance <T>': it must be a positive length",
        ],
    ),
    (
        "register",
        "cube.off around.xyz -o out.xyz --start given",
        &[("left.xyz turned.xyz -o out.xyz --start given --max-iterations 1", "not_converged")],
        "cube.off none.xyz -o out.xyz",
        ["cube.off around.xyz -o out.xyz --max-iterations -3", "'--max-iterations <N>'"],
    ),
    (
        "register-views",
        "left.xyz right.xyz -o moved",
        &[
            ("left.xyz far.xyz -o moved --start given", "not_converged"),
            ("left.xyz right.xyz -o moved --start given --max-iterations 1", "not_converged"),
        ],
        "left.xyz none.xyz -o moved",
        [
            "left.xyz right.xyz -o moved --min-overlap -0.5",
            "for '--min-overlap <SHARE>': it must be a share from 0 to 1",
        ],
    ),
    (
        "fit-curve",
        "ring.xyz -o out.json",
        &[
            ("ring.xyz -o out.json --tolerance 1e-9 --max-control-points 6", "out_of_tolerance"),
            ("ring.xyz -o out.json --control-points 12 --max-iterations 1", "not_converged"),
        ],
        "none.xyz -o out.json",
        ["ring.xyz -o out.json --control-points 2", "--control-points is 2, it must be more than the degree"],
    ),
    (
        "fit-surface",
        "sheet.xyz -o out.json --control-points 8x8",
        &[
            (
                "sheet.xyz -o out.json --control-points 5x5 --max-control-points 25 --tolerance 1e-6",
                "out_of_tolerance",
            ),
            ("sheet.xyz -o out.json --control-points 8x8 --shape plane --max-iterations 1", "not_converged"),
        ],
        "none.xyz -o out.json",
        ["sheet.xyz -o out.json --tolerance -0.05", "'--tolerance <T>': it must be a positive length"],
    ),
    (
        "fit-ruled",
        "strip.xyz -o out.json --control-points 6x2",
        &[
            (
                "sheet.xyz -o out.json --control-points 6x2 --max-control-points 12 --tolerance 1e-6",
                "out_of_tolerance",
            ),
            ("sheet.xyz -o out.json --control-points 6x2 --max-iterations 1", "not_converged"),
        ],
        "none.xyz -o out.json",
        ["strip.xyz -o out.json --share 1.5 --tolerance 1", "'--share <SHARE>': it must be a share above 0"],
    ),
    (
        "fit-subdivision",
        "ball.off -o out.off --vertices 40",
        &[
            ("ball.off -o out.off --vertices 40 --tolerance 1e-9", "out_of_tolerance"),
            ("ball.off -o out.off --vertices 40 --max-iterations 1", "not_converged"),
        ],
        "none.off -o out.off",
        ["ball.off -o out.off --tolerance nan", "'--tolerance <T>': it must be a positive length"],
    ),
    (
        "parameterize",
        "vase.xyz -o out.json",
        &[],
        "none.xyz -o out.json",
        ["vase.xyz -o out.json --grid -3", "'--grid <NxM>'"],
    ),
];

#[test]
fn every_command_means_the_same_by_the_same_status() {
    let bench = bench();
    for (command, good, no, missing, [senseless, message]) in CASES {
        let run = |arguments: &str| {
            let run = bench.run(&format!("{command} {arguments} --json report.json --quiet"));
            let report = std::fs::read_to_string(bench.path("report.json")).unwrap_or_default();
            let _ = std::fs::remove_file(bench.path("report.json"));
            (run.code, run.stderr, serde_json::from_str::<Value>(&report).unwrap_or(Value::Null))
        };
        let (code, stderr, report) = run(good);
        assert_eq!((code, report["status"].as_str()), (0, Some("done")), "{command} {good}: {stderr}");
        for (arguments, status) in no {
            let (code, stderr, report) = run(arguments);
            assert_eq!(
                (code, report["status"].as_str()),
                (1, Some(*status)),
                "{command} {arguments}: {stderr}"
            );
            if arguments.contains("--max-iterations") {
                assert_eq!(report["results"]["status"], "max_iterations", "{command} {arguments}");
            }
        }
        let (code, stderr, report) = run(missing);
        assert_eq!((code, report["status"].as_str()), (2, Some("error")), "{command} {missing}");
        assert!(stderr.contains("none.") && stderr.contains("check the path"), "{command}: {stderr}");
        let (code, stderr, _) = run(senseless);
        assert!(code == 2 && stderr.contains(message), "{command} {senseless}: {code} {stderr}");
    }
}

#[test]
fn commands_that_have_no_answer_to_give_are_done_or_fail() {
    let bench = bench();
    for (arguments, code, status) in [
        ("convert points.xyz out.ply", 0, "done"),
        ("convert none.xyz out.ply", 2, "error"),
        ("convert points.xyz out.stl", 2, "error"),
        ("info points.xyz model.json cube.off", 0, "done"),
        ("info none.xyz", 2, "error"),
        ("merge none.json", 2, "error"),
        ("demo --data none", 2, "error"),
        ("selftest", 0, "done"),
    ] {
        let run = bench.run(&format!("{arguments} --json -"));
        assert_eq!(
            (run.code, run.report()["status"].as_str()),
            (code, Some(status)),
            "{arguments}: {}",
            run.stderr
        );
    }
    for arguments in ["convert points.xyz out.ply --no-such-option", "info", "demo --mode best", "selftest x"]
    {
        assert_eq!(bench.run(arguments).code, 2, "{arguments}");
    }
}

#[test]
fn schemas_share_one_form() {
    let schemas: Vec<(String, Value)> = std::fs::read_dir(crate::common::schema::folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter_map(|name| Some(name.strip_suffix(".schema.json")?.to_owned()))
        // That of the shapes in files is not one of a report.
        .filter(|name| name != "nurbs")
        .map(|command| (command.clone(), crate::common::schema::of(&command)))
        .collect();
    let help = Bench::new().run("--help").stdout;
    let listed = |command: &str| help.lines().any(|line| line.split_whitespace().next() == Some(command));
    assert_eq!(schemas.len(), 20);
    for (command, schema) in &schemas {
        assert!(listed(command), "{command}");
        assert_eq!(schema["properties"]["command"]["const"], command.as_str());
        for field in [
            "command",
            "version",
            "status",
            "exit_code",
            "inputs",
            "outputs",
            "timings",
            "results",
            "warnings",
        ] {
            assert!(schema["required"].as_array().unwrap().contains(&field.into()), "{command}: {field}");
        }
        for (other, same) in &schemas {
            for (name, form) in schema["$defs"].as_object().unwrap() {
                let there = &same["$defs"][name];
                assert!(
                    there.is_null() || there == form,
                    "`{name}` is another thing in {command} and {other}"
                );
            }
        }
    }
}
