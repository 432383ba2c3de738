//! What the fast mode promises: a true point of the shape, and hardly ever another than the nearest.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use footpoint::{Mode, ProjectionOptions, SurfaceProjector};
use nalgebra::Vector3;
use nurbs_core::{BsplineSurface, ParametricSurface};
use std::path::Path;

fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect()
}

#[test]
fn hardly_any_point_of_the_known_cases_is_missed() {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/footpoint-cases");
    let options = ProjectionOptions::default().with_mode(Mode::Fast);
    for shape in ["s_hw3", "s_torus", "s_degen"] {
        let json = std::fs::read(dir.join(format!("{shape}.json"))).unwrap();
        let surface: BsplineSurface = serde_json::from_slice(&json).unwrap();
        let projector = SurfaceProjector::new(&surface);
        let (mut count, mut missed) = (0, Vec::new());
        for set in ["on", "near", "mid", "far", "beyond", "singular"] {
            let queries = dir.join(format!("{shape}.{set}.q"));
            if !queries.exists() {
                continue;
            }
            for (i, (x, truth)) in rows(&queries).iter().zip(rows(&queries.with_extension("gt"))).enumerate()
            {
                let x = Vector3::new(x[0], x[1], x[2]);
                let foot = projector.project_with(&x, &options).unwrap();
                let [u, v] = foot.parameter;
                assert!((surface.point(u, v) - foot.point).norm() < 1e-9, "{shape}.{set} {i}: {foot}");
                assert!(((foot.point - x).norm() - foot.distance).abs() < 1e-9, "{shape}.{set} {i}: {foot}");
                if foot.distance > truth[2] * (1.0 + 1e-6) + 1e-7 {
                    missed.push(format!("{set} {i}: {foot}, true {} at {} {}", truth[2], truth[0], truth[1]));
                }
                count += 1;
            }
        }
        assert!(count > 400);
        assert!(missed.len() <= 2, "{shape}: {} of {count}: {missed:#?}", missed.len());
    }
}
