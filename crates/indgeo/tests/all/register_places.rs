//! Clouds and views that other places fit as well: what does not tell a place is no success.

use crate::common::Bench;
use crate::common::inputs::lines;
use crate::common::sheets::{Point, Random, turned};
use serde_json::Value;

fn registered(bench: &Bench, arguments: &str) -> (i32, Value, String) {
    let run = bench.run(&format!("register {arguments} --json report.json --transform pose.json"));
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    (run.code, report["results"].clone(), run.stdout + &run.stderr)
}

/// Points of the faces of a box, each in the share of its area.
fn on_box(size: Point, count: usize, seed: u64) -> Vec<Point> {
    let mut random = Random(seed);
    let areas = [size[1] * size[2], size[0] * size[2], size[0] * size[1]];
    let all: f64 = areas.iter().sum();
    let mut point = || {
        let mut pick = random.unit() * all;
        let axis = areas.iter().position(|area| {
            pick -= area;
            pick < 0.0
        });
        let mut x = size.map(|side| side * random.unit());
        let axis = axis.unwrap_or(2);
        x[axis] = if random.unit() < 0.5 { 0.0 } else { size[axis] };
        x
    };
    (0..count).map(|_| point()).collect()
}

#[test]
fn a_cloud_of_a_sheet_that_is_too_wide_shows_no_surface() {
    let bench = Bench::new();
    bench.put("wide.xyz", lines(on_box([100.0, 60.0, 2.0], 4000, 3).into_iter()));
    bench.put("scan.xyz", lines(on_box([100.0, 60.0, 2.0], 1500, 5).into_iter()));
    let (code, results, said) = registered(&bench, "wide.xyz scan.xyz --start given");
    assert_eq!((code, &results["support"]["doubt"]), (1, &"unresolved".into()), "{said}");
    assert!(said.contains("show no surface"), "{said}");
}

#[test]
fn two_scans_that_share_a_plane_leave_the_motions_in_it_open() {
    let bench = Bench::new();
    let [floor, wall] = [[100.0, 60.0, 0.0], [0.0, 60.0, 40.0]].map(|size| on_box(size, 3000, 7));
    let front = floor.iter().chain(&wall).copied();
    bench.put("one.xyz", lines(front));
    // Another wall, which the first scan did not see, on the same floor.
    let other = on_box([100.0, 60.0, 0.0], 2000, 9)
        .into_iter()
        .chain(on_box([0.0, 60.0, 40.0], 2000, 11).into_iter().map(|x| [x[0] + 55.0, x[1], x[2]]));
    bench.put("other.xyz", lines(other.map(|x| turned(x, [0.0, 0.0, 1.0], 2.0))));
    let (code, results, said) = registered(&bench, "one.xyz other.xyz --start given");
    assert!(code == 1 && results["status"] != "converged", "{said}");
}

#[test]
fn points_of_a_plane_have_no_scale() {
    let bench = Bench::new();
    bench.put("model.xyz", lines(on_box([100.0, 60.0, 40.0], 20_000, 3).into_iter()));
    let mut random = Random(4);
    let patch: Vec<Point> =
        (0..600).map(|_| [20.0 + 50.0 * random.unit(), 15.0 + 30.0 * random.unit(), 40.0]).collect();
    bench.put("patch.xyz", lines(patch.into_iter()));
    let (code, results, said) = registered(&bench, "model.xyz patch.xyz --scale --start given");
    assert_eq!((code, &results["status"]), (1, &"underdetermined".into()), "{said}");
    assert!(said.contains("at other scales"), "{said}");
}

#[test]
fn views_of_a_cube_lie_on_each_other_in_many_places() {
    let bench = Bench::new();
    // Three faces of a cube each, of which one is common to both.
    let seen = |hidden: [f64; 3], seed: u64| {
        on_box([50.0; 3], 6000, seed)
            .into_iter()
            .filter(move |x| (0..3).any(|k| x[k] == hidden[k]))
            .collect::<Vec<_>>()
    };
    bench.put("one.xyz", lines(seen([0.0, 0.0, 0.0], 3).into_iter()));
    let other = seen([50.0, 50.0, 0.0], 5).into_iter().map(|x| turned(x, [1.0, 2.0, 3.0], 70.0));
    bench.put("other.xyz", lines(other));
    let run = bench.run("register-views one.xyz other.xyz -o aligned");
    let poses: Value = serde_json::from_str(&bench.text("aligned/poses.json")).unwrap();
    assert!(run.code == 1 && poses["status"] != "converged", "{} {}", run.stdout, run.stderr);
}
