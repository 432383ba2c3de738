//! `indgeo demo`: real data, real results.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, fixture, rows};

#[test]
fn shows_the_thread() {
    let bench = Bench::new();
    let run = bench.run("demo --json report.json");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{}", run.stdout);
    for name in ["deviations.csv", "deviations.ply", "deviations.svg"] {
        assert!(run.stdout.contains(name) && bench.path("indgeo-demo").join(name).is_file(), "{name}");
    }
    let report: serde_json::Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    assert_eq!((&report["command"], &report["status"]), (&"demo".into(), &"done".into()));
    assert_eq!(report["inputs"][1]["points_read"], 8565);
    assert_eq!(report["results"]["points"], 8565);
    // What the scan shows of the bolt: all of the thread within a few tenths of its nominal surface.
    let text = bench.text("indgeo-demo/deviations.csv");
    let inside: Vec<f64> = rows(&text)
        .iter()
        .filter(|row| row[7] == "0" && row[10] == "converged")
        .map(|row| row[6].parse().unwrap())
        .collect();
    assert!(inside.len() > 4500, "{}", inside.len());
    assert!(inside.iter().all(|distance| distance.abs() < 0.5));
    let rms = (inside.iter().map(|d| d * d).sum::<f64>() / inside.len() as f64).sqrt();
    assert!((0.02..0.12).contains(&rms), "{rms}");
}

#[test]
fn the_picture_is_whole_and_explains_itself() {
    let bench = Bench::new();
    assert_eq!(bench.run("demo --out here --quiet").code, 0);
    let svg = bench.text("here/deviations.svg");
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    for words in ["M12", "Signed distance, mm", "position along the axis, mm", "std dev", "black: nominal"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(svg.len() < 800_000, "{}", svg.len());
}

#[test]
fn says_where_it_looked_for_data() {
    let bench = Bench::new();
    let run = bench.run("demo --data nowhere");
    assert_eq!((run.code, bench.files().len()), (2, 0));
    assert!(run.stderr.contains("are not in nowhere; run this in a checkout"), "{}", run.stderr);
    assert_eq!(bench.run(&format!("demo --quiet --data {}", fixture(""))).code, 0);
}

#[test]
fn the_displaced_scan_is_registered_and_judged() {
    let bench = Bench::new();
    let run = bench.run("demo --json report.json");
    assert_eq!(run.code, 0, "{}", run.stdout);
    let json = |name: &str| -> serde_json::Value {
        serde_json::from_str(&bench.text(&format!("indgeo-demo/{name}"))).unwrap()
    };
    let (registration, inspection) = (json("registration.json"), json("inspection.json"));
    let found = &registration["results"];
    assert_eq!((&registration["command"], &found["status"]), (&"register".into(), &"converged".into()));
    // The thread and the shank let the scan slide along one helix.
    assert_eq!(found["free_motions"].as_array().unwrap().len(), 1);
    assert!(found["free_motions"][0].as_str().unwrap().contains("helical"));
    // It is not carried along it: the thread fits as well a turn further.
    let apart = run.stdout.split("It lies ").nth(1).and_then(|rest| rest.split(" mm").next()).unwrap();
    assert!(apart.parse::<f64>().unwrap() < 0.5, "{apart}");
    assert!(found["rms"].as_f64().unwrap() < 0.09 && found["points_used"].as_u64().unwrap() > 5000);
    assert_eq!(found["matrix"], json("pose.json")["matrix"]);
    assert_eq!(inspection["options"]["transform"], found["matrix"]);
    assert!(inspection["results"]["verdict"]["share"].as_f64().unwrap() > 0.7);
    let svg = bench.text("indgeo-demo/registration.svg");
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
    assert!(svg.len() < 1_000_000, "{}", svg.len());
    assert!(bench.text("indgeo-demo/report.html").contains("</html>"));
    let outputs = serde_json::from_str::<serde_json::Value>(&bench.text("report.json")).unwrap();
    assert_eq!(outputs["outputs"].as_array().unwrap().len(), 13);
}

#[test]
fn the_errors_of_the_cad_scan_are_found() {
    let bench = Bench::new();
    let run = bench.run("demo");
    assert_eq!(run.code, 0, "{}", run.stdout);
    let row = |words: &str| -> [f64; 2] {
        let line = run.stdout.lines().find(|line| line.contains(words)).unwrap();
        let numbers: Vec<f64> =
            line.rsplit_terminator(' ').filter_map(|word| word.parse().ok()).take(2).collect();
        [numbers[1], numbers[0]]
    };
    let [bump, found] = row("height of the bump");
    assert!(bump == found && (0.19..=0.2).contains(&bump), "{bump} {found}");
    assert_eq!(row("deviation of the hole"), [-0.08, -0.08]);
    let [wrong, beyond] = row("points beyond");
    assert!(wrong == beyond && wrong > 50.0, "{wrong} {beyond}");
    let report: serde_json::Value =
        serde_json::from_str(&bench.text("indgeo-demo/cad-inspection.json")).unwrap();
    let found = &report["results"];
    assert_eq!(
        (&report["status"], found["outcomes"]["measured"].as_u64()),
        (&"out_of_tolerance".into(), found["points"].as_u64())
    );
    // The others deviate by rounding only.
    let within = found["total"]["within"].as_u64().unwrap() as f64;
    assert!((found["points"].as_f64().unwrap() - within - wrong).abs() < 0.5);
}
