//! The registration cases: convergence to known optima.

use crate::common::case;
use distance_field::ErrorTerm;
use sdm_register::{FootpointPolicy, Method, Outliers, RegisterOptions, Source, StepControl, register};
use std::fmt::Write as _;

#[test]
fn without_noise_to_the_last_digit() {
    let case = case("cad_zero");
    for (degrees, start) in case.starts.iter().step_by(13) {
        let report =
            register(&case.field, &Source::new(&case.points), start, &RegisterOptions::default()).unwrap();
        assert!(report.is_converged() && case.error(&report.pose) <= 1e-13, "{degrees}: {report}");
        assert!(*degrees > 10.0 || report.iterations <= 8, "{degrees}: {report}");
    }
}

#[test]
fn large_residuals_converge_quadratically() {
    for name in ["cad_warp_in", "cad_offset_pos"] {
        let case = case(name);
        for (degrees, start) in case.starts.iter().step_by(17) {
            let report =
                register(&case.field, &Source::new(&case.points), start, &RegisterOptions::default())
                    .unwrap();
            assert!(report.is_converged() && case.error(&report.pose) <= 1e-12, "{name} {degrees}: {report}");
            assert!(report.iterations <= 10, "{name} {degrees}: {report}");
        }
    }
}

#[test]
fn with_noise_from_every_angle() {
    let case = case("cad_noise1e-3");
    let mut steps = Vec::new();
    for (degrees, start) in case.starts.iter().step_by(9) {
        let report =
            register(&case.field, &Source::new(&case.points), start, &RegisterOptions::default()).unwrap();
        assert!(case.error(&report.pose) <= 1e-8, "{degrees}: {report}");
        steps.push(report.iterations);
    }
    steps.sort_unstable();
    assert!(steps[steps.len() / 2] <= 7, "{steps:?}");
}

/// The error after each step, from the same start at 10 degrees: who converges linearly, and who quadratically.
#[test]
fn steps_of_the_methods() {
    let case = case("cad_warp_in");
    let start = &case.starts[16].1;
    let mut table = String::from("step       ICP       TDM       SDM    Newton  adaptive\n");
    let methods = [Method::ICP, Method::TANGENT, Method::SDM, Method::Newton, Method::Adaptive];
    let mut errors = vec![Vec::new(); methods.len()];
    for (k, method) in methods.into_iter().enumerate() {
        for steps in 0..=10 {
            let options = RegisterOptions::default()
                .with_method(method)
                .with_outliers(Outliers::None)
                .with_max_iterations(steps);
            let report = register(&case.field, &Source::new(&case.points), start, &options).unwrap();
            errors[k].push(case.error(&report.pose));
        }
    }
    for steps in 0..=10 {
        let _ = write!(table, "{steps:4}");
        for error in &errors {
            let error = error[steps];
            let _ = if error < 1e-14 { write!(table, "   < 1e-14") } else { write!(table, " {error:9.1e}") };
        }
        table.push('\n');
    }
    let last = |k: usize| errors[k][10];
    assert!(last(0) > 1e-3 && last(1) > 1e-7 && last(4) < 1e-14, "{table}");
    insta::assert_snapshot!("steps_of_the_methods", table);
}

#[test]
fn outliers_are_told_apart() {
    let case = case("cad_out20");
    for (degrees, start) in case.starts.iter().step_by(21) {
        let report =
            register(&case.field, &Source::new(&case.points), start, &RegisterOptions::default()).unwrap();
        assert!(report.is_converged(), "{degrees}: {report}");
        // The noise of the inliers alone moves the optimum by 1.59e-4.
        assert!(case.error(&report.pose) <= 1.7e-4, "{degrees}: {report}, {:e}", case.error(&report.pose));
        assert!(report.used >= 4990 && report.used <= 5060, "{report}");
    }
}

#[test]
fn footpoint_policies_and_controls_reach_the_same_minimum() {
    let case = case("cad_noise1e-3");
    let start = &case.starts[5].1;
    let options = RegisterOptions::default().with_outliers(Outliers::None);
    for policy in [FootpointPolicy::Global, FootpointPolicy::Local, FootpointPolicy::OneStep] {
        let options = options.with_footpoints(policy);
        let report = register(&case.field, &Source::new(&case.points), start, &options).unwrap();
        assert!(case.error(&report.pose) <= 1e-9, "{policy:?}: {report}, {:e}", case.error(&report.pose));
    }
    for control in [StepControl::None, StepControl::Armijo] {
        let options = options.with_control(control);
        let report = register(&case.field, &Source::new(&case.points), start, &options).unwrap();
        assert!(case.error(&report.pose) <= 1e-9, "{control:?}: {report}");
    }
    for term in [ErrorTerm::SquaredDistance, ErrorTerm::SquaredDistanceRatio, ErrorTerm::Taylor] {
        let options = options.with_method(Method::Term(term)).with_tolerance(1e-10);
        let report = register(&case.field, &Source::new(&case.points), start, &options).unwrap();
        assert!(case.error(&report.pose) <= 1e-8, "{term}: {report}");
    }
}

#[test]
fn symmetric_and_accelerated_steps() {
    let case = case("cad_zero");
    let start = &case.starts[15].1;
    let options = RegisterOptions::default().with_outliers(Outliers::None);
    let source = Source::new(&case.points).with_normals(&case.normals);
    let symmetric = register(&case.field, &source, start, &options.with_method(Method::Symmetric)).unwrap();
    assert!(case.error(&symmetric.pose) <= 1e-12 && symmetric.iterations <= 9, "{symmetric}");
    let run = |method| {
        let options = options.with_method(method).with_max_iterations(25);
        case.error(&register(&case.field, &source, start, &options).unwrap().pose)
    };
    let (plain, accelerated) = (run(Method::ICP), run(Method::AndersonPoint));
    assert!(accelerated < 0.1 * plain, "{plain:e} {accelerated:e}");
}
