//! `indgeo align` as a user runs it.

use crate::common::{Bench, SQUARE, fixture};
use serde_json::{Value, json};

/// A turn about z by the angle with cosine .8 and sine .6, and a translation: takes the nominal frame to that of the measurement.
fn measured([x, y, z]: [f64; 3]) -> [f64; 3] {
    [0.8 * x - 0.6 * y + 100.0, 0.6 * x + 0.8 * y - 20.0, z + 7.0]
}

/// The motion back, by rows.
const BACK: [[f64; 4]; 4] =
    [[0.8, 0.6, 0.0, -68.0], [-0.6, 0.8, 0.0, 76.0], [0.0, 0.0, 1.0, -7.0], [0.0, 0.0, 0.0, 1.0]];

fn assert_back(matrix: &Value, tolerance: f64) {
    for (i, row) in BACK.iter().enumerate() {
        for (j, right) in row.iter().enumerate() {
            let found = matrix[i][j].as_f64().unwrap();
            assert!((found - right).abs() < tolerance, "{matrix}");
        }
    }
}

/// Nominal points and directions of a 3-2-1 alignment.
const THREE_TWO_ONE: [([f64; 3], [f64; 3]); 6] = [
    ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
    ([50.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
    ([0.0, 30.0, 0.0], [0.0, 0.0, 1.0]),
    ([10.0, 0.0, 10.0], [0.0, 1.0, 0.0]),
    ([40.0, 0.0, 10.0], [0.0, 1.0, 0.0]),
    ([0.0, 15.0, 10.0], [1.0, 0.0, 0.0]),
];

fn datums() -> Vec<Value> {
    let one = |(k, (nominal, direction)): (usize, &([f64; 3], [f64; 3]))| json!({"name": format!("A{k}"), "measured": measured(*nominal), "nominal": nominal, "direction": direction});
    THREE_TWO_ONE.iter().enumerate().map(one).collect()
}

#[test]
fn three_two_one_is_exact_and_starts_a_registration() {
    let bench = Bench::new();
    bench.put("datums.json", json!({"targets": datums()}).to_string());
    let run = bench.run("align datums.json --transform pose.json --json report.json --tolerance 1e-9");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("6 directions at 6 points, exactly determined"), "{}", run.stdout);
    let pose: Value = serde_json::from_str(&bench.text("pose.json")).unwrap();
    assert_back(&pose["matrix"], 1e-12);
    assert!(pose["max"].as_f64().unwrap() < 1e-12);

    // The motion is understood by the other commands.
    bench.put("model.json", SQUARE);
    bench.put("points.xyz", "100.5 -19.5 7.25\n100.2 -19.7 7.5\n100.1 -19.4 7.125\n100 -19.2 7.25\n");
    let run = bench.run("project model.json points.xyz -o d.csv");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = bench.run("inspect model.json points.xyz --transform pose.json --tolerance 100");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let run = bench.run("register model.json points.xyz --init pose.json --max-iterations 1 --json r.json");
    assert!(run.code <= 1, "{}", run.stderr);
}

#[test]
fn more_pairs_than_needed_leave_residuals_that_a_tolerance_judges() {
    let bench = Bench::new();
    // Four corners, one of them measured .3 too high: the least squares plane leaves residuals of .075 of alternating sign.
    let corners = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 10.0, 0.0], [0.0, 10.0, 0.0]];
    let mut table = "name;x;y;z;nominal_x;nominal_y;nominal_z\n".to_owned();
    for (k, corner) in corners.iter().enumerate() {
        let [x, y, z] = measured([corner[0], corner[1], if k == 2 { 0.3 } else { 0.0 }]);
        let [a, b, c] = corner;
        let row = format!("corner {k};{x};{y};{z};{a};{b};{c}\n");
        table += &row.replace('.', ",");
    }
    bench.put("pairs.csv", table);
    bench.put("scan.xyz", "100 -20 7\n108 -14 7\n");
    let run = bench.run("align pairs.csv scan.xyz -o moved.csv --json -");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report = run.report();
    let residuals: Vec<f64> =
        (0..4).map(|k| report["results"]["targets"][k]["residuals"][2].as_f64().unwrap()).collect();
    for (residual, sign) in residuals.iter().zip([1.0, -1.0, 1.0, -1.0]) {
        assert!((residual - sign * 0.075).abs() < 1e-3, "{residuals:?}");
    }
    assert_eq!(report["results"]["targets"][2]["name"], "corner 2");
    assert!(bench.text("moved.csv").lines().count() == 3);

    let run = bench.run("align pairs.csv --transform t.json --tolerance 0.05 --json r.json");
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert!(run.stdout.contains("not within 0.05"), "{}", run.stdout);
    assert!(bench.files().contains(&"t.json".to_owned()));
}

#[test]
fn axes_to_fix_and_empty_cells_in_a_table() {
    let bench = Bench::new();
    let mut table = "name,x,y,z,nominal_x,nominal_y,nominal_z,fix\n".to_owned();
    for (k, (nominal, fix)) in
        [([0.0, 0.0, 0.0], "xyz"), ([50.0, 0.0, 0.0], "yz"), ([0.0, 30.0, 0.0], "z")].iter().enumerate()
    {
        let ([x, y, z], [a, b, c]) = (measured(*nominal), nominal);
        table += &format!("R{k},{x},{y},{z},{a},{b},{c},{fix}\n");
    }
    bench.put("rps.csv", table);
    let run = bench.run("align rps.csv --transform pose.json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let pose: Value = serde_json::from_str(&bench.text("pose.json")).unwrap();
    assert_back(&pose["matrix"], 1e-12);
}

#[test]
fn what_does_not_serve_is_refused_with_the_reason() {
    let bench = Bench::new();
    let refused = |name: &str, text: String, part: &str| {
        bench.put(name, text);
        let run = bench.run(&format!("align {name} --transform t.json --json r.json"));
        assert!(run.code == 2 && run.stderr.contains(part), "{name}: {} {}", run.code, run.stderr);
        assert!(!bench.files().contains(&"t.json".to_owned()));
    };
    refused(
        "open.json",
        json!(datums()[..5]).to_string(),
        "leave 1 of 6 degrees of freedom open (5 directions at 5 points)",
    );
    let line = "x,y,z,nominal_x,nominal_y,nominal_z\n0,0,0,0,0,0\n1,0,0,1,0,0\n2,0,0,2,0,0\n";
    refused("line.csv", line.to_owned(), "degrees of freedom open");
    refused("plain.csv", "x,y,z\n1,2,3\n".to_owned(), "no columns nominal_x");
    refused("part.csv", "x,y,z,nominal_x,nominal_y\n1,2,3,1,2\n".to_owned(), "nominal_z is missing");
    refused(
        "huge.json",
        "[{\"measured\": [1e400, 0, 0], \"nominal\": [0, 0, 0]}]".to_owned(),
        "number out of range",
    );
    refused("empty.json", "{\"targets\": []}".to_owned(), "no targets");
    refused(
        "fix.json",
        "[{\"measured\":[0,0,0],\"nominal\":[0,0,0],\"fix\":\"q\"}]".to_owned(),
        "letters of xyz",
    );
    let run = bench.run("align open.json");
    assert!(run.code == 2 && run.stderr.contains("nothing would be written"), "{}", run.stderr);
    let model = fixture("register-cases/cad.json");
    let run = bench.run(&format!("align open.json {model} -o moved.ply"));
    assert!(run.code == 2 && run.stderr.contains("NURBS"), "{}", run.stderr);
}

#[test]
fn points_of_another_shape_are_no_alignment() {
    let bench = Bench::new();
    let nominal = [[0, 0, 0], [10, 0, 0], [0, 20, 0], [3, 4, 5], [7, 2, 1]];
    let targets = |of: fn([i32; 3]) -> [i32; 3]| {
        let one = |x: [i32; 3]| format!("{{\"measured\": {:?}, \"nominal\": {x:?}}}", of(x));
        format!("{{\"targets\": [{}]}}", nominal.map(one).join(", "))
    };
    for (of, what) in [(|[x, y, z]| [-x, y, z], "mirrored"), (|x: [i32; 3]| x.map(|c| 2 * c), "doubled")]
        as [(fn([i32; 3]) -> [i32; 3], &str); 2]
    {
        bench.put("targets.json", targets(of));
        let run = bench.run("align targets.json --transform t.json");
        assert_eq!(run.code, 1, "{what}: {}", run.stdout + &run.stderr);
        assert!(run.stderr.contains("the measured points have another shape"), "{what}: {}", run.stderr);
        // Whoever states what is allowed is believed.
        assert_eq!(bench.run("align targets.json --transform t.json -t 100").code, 0, "{what}");
    }
    bench.put("targets.json", targets(|x| x));
    assert_eq!(bench.run("align targets.json --transform t.json").code, 0);
    bench.put("targets.json", "{\"targets\": [{\"measured\": [1e200, 0, 0], \"nominal\": [0, 0, 0]}]}");
    let run = bench.run("align targets.json --transform t.json");
    assert!(run.code == 2 && run.stderr.contains("has the coordinate 1e200"), "{}", run.stderr);
    bench.put("targets.json", "[1, 2]");
    let run = bench.run("align targets.json --transform t.json");
    assert!(
        run.code == 2 && run.stderr.contains("an object with `measured` and `nominal`"),
        "{}",
        run.stderr
    );
}
