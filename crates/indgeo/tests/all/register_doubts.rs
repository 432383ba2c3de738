//! Scans that do not tell one place of the part: of its mirror image, of a corner alone, of two copies; views that lie on each other wrongly.

use crate::common::Bench;
use crate::common::inputs::lines;
use crate::common::sheets::{Part, Point, Random, SIZE, centre, sum, times, turned};
use serde_json::Value;

/// A bracket with a corner cut off and a hole, and points of both of its sides.
fn bracket(bench: &Bench, count: usize) -> Vec<Point> {
    let part = Part::new("bracket", 0.05);
    bench.put("part.off", part.to_off());
    let everywhere = Part { upper: part.triangles.len(), ..part };
    everywhere.scan(count, &mut Random(3)).0
}

fn noisy(points: Vec<Point>, noise: f64, seed: u64) -> Vec<Point> {
    let mut random = Random(seed);
    let mut off = || [random.gauss(), random.gauss(), random.gauss()];
    points.into_iter().map(|x| sum(x, times(off(), noise * SIZE))).collect()
}

fn registered(bench: &Bench, arguments: &str) -> (i32, Value, String) {
    let run = bench.run(&format!("register {arguments} --json report.json --transform pose.json"));
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    (run.code, report["results"].clone(), run.stdout + &run.stderr)
}

#[test]
fn a_part_of_the_other_hand_is_doubted() {
    let bench = Bench::new();
    let points = bracket(&bench, 1500);
    for noise in [0.0, 5e-4] {
        let points = noisy(points.clone(), noise, 8);
        bench.put("hand.xyz", lines(points.iter().copied()));
        bench.put("other.xyz", lines(points.iter().map(|[x, y, z]| [-x, *y, *z])));
        let (code, results, said) = registered(&bench, "part.off other.xyz");
        assert_eq!((code, &results["support"]["doubt"]), (1, &"mirrored".into()), "{noise}: {said}");
        assert!(said.contains("mirror image"), "{said}");
        let (code, _, said) = registered(&bench, "part.off hand.xyz");
        assert!(code == 0 && !said.contains("mirror"), "{noise}: {said}");
    }
}

#[test]
fn points_of_one_corner_alone_leave_the_pose_open() {
    let bench = Bench::new();
    let points = bracket(&bench, 40_000);
    let near = |x: &&Point| sum(**x, [0.0, 0.0, 2.5]).iter().all(|c| c.abs() < 4.0);
    let corner: Vec<Point> = points.iter().filter(near).copied().collect();
    assert!(corner.len() > 20, "{}", corner.len());
    bench.put("corner.xyz", lines(noisy(corner, 3e-3, 4).into_iter()));
    let (code, results, said) = registered(&bench, "part.off corner.xyz --start given");
    assert_eq!((code, &results["status"]), (1, &"underdetermined".into()), "{said}");
    assert!(said.contains("covers so little of"), "{said}");
    bench.put("whole.xyz", lines(noisy(bracket(&bench, 1500), 3e-3, 4).into_iter()));
    let (code, _, said) = registered(&bench, "part.off whole.xyz --start given");
    assert!(code == 0 && !said.contains("covers so little of"), "{said}");
}

#[test]
fn a_cloud_with_two_copies_of_the_part_is_told() {
    let bench = Bench::new();
    let points = bracket(&bench, 1200);
    let middle = centre(&points);
    let other =
        |x: &Point| sum(turned(sum(*x, times(middle, -1.0)), [0.0, 0.0, 1.0], 40.0), [220.0, 30.0, 5.0]);
    bench.put("two.xyz", lines(points.iter().copied().chain(points.iter().map(other))));
    let (code, results, said) = registered(&bench, "part.off two.xyz");
    assert_eq!(code, 0, "{said}");
    assert!((results["support"]["share"].as_f64().unwrap() - 0.5).abs() < 0.02, "{results}");
    assert!(said.contains("more than once"), "{said}");
}

#[test]
fn coordinates_without_squares_are_refused() {
    let bench = Bench::new();
    let mut points = bracket(&bench, 100);
    bench.put("good.xyz", lines(points.iter().copied()));
    points[7] = [1e300, 0.0, 0.0];
    bench.put("scan.xyz", lines(points.into_iter()));
    for arguments in
        ["register part.off scan.xyz --transform t.json", "register-views good.xyz scan.xyz -o moved"]
    {
        let run = bench.run(arguments);
        assert_eq!(run.code, 2, "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains("point 7 has the coordinate 1e300"), "{}", run.stderr);
    }
}

#[test]
fn views_that_lie_on_each_other_wrongly_are_doubted() {
    let bench = Bench::new();
    // Two scans of a wave, of which the other one was made of another part: nothing but a mean plane is common.
    let wave = |k: usize, phase: f64, height: f64| {
        let (x, y) = ((k % 60) as f64 / 3.0, (k / 60) as f64 / 3.0);
        [x, y, height * ((0.5 * x + phase).sin() + (0.4 * y).cos() + 0.02 * x * y)]
    };
    bench.put("one.xyz", lines((0..3600).map(|k| wave(k, 0.0, 0.6))));
    bench.put("same.xyz", lines((0..3600).map(|k| sum(wave(k, 0.0, 0.6), [0.1, 0.05, 0.02]))));
    bench.put("other.xyz", lines((0..3600).map(|k| wave(k, 0.0, 0.8))));
    let run = bench.run("register-views one.xyz same.xyz -o moved");
    assert_eq!(run.code, 0, "{}", run.stdout + &run.stderr);
    let run = bench.run("register-views one.xyz other.xyz -o moved --start given --json report.json");
    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    assert_eq!(run.code, 1, "{}", run.stdout + &run.stderr);
    assert_eq!(report["results"]["status"], "doubtful", "{report}");
    assert!(run.stderr.contains("much more than the noise of either"), "{}", run.stderr);
}
