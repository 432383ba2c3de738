//! Points that are hard to project: the cases of `fixtures/projection-cases`, with what an independent search found.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may panic")]

use footpoint::{Mode, ProjectionOptions, SurfaceFootpoint, SurfaceProjector, no_progress};
use nalgebra::Vector3;
use nurbs_core::BsplineSurface;
use std::path::Path;

fn load(name: &str) -> BsplineSurface {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/projection-cases").join(name);
    serde_json::from_slice(&std::fs::read(path.with_extension("json")).unwrap()).unwrap()
}

/// What the default options allow, and what rounding adds to it.
fn is_proven(surface: &BsplineSurface, foot: &SurfaceFootpoint) -> bool {
    let size = surface.control_points().iter().fold(0.0f64, |all, p| all.max(p.amax()));
    foot.gap() <= 2.0 * (1e-7 * foot.distance + 1e-10 * size)
}

#[test]
fn no_worse_than_what_is_known() {
    // Distances of points of the surfaces that a dense search found, rounded up.
    let cases = [
        (
            "bump100",
            [0.577_177_231_626_639_2, 0.662_000_348_716_618_6, 10.265_316_210_223_341],
            0.288_662_997_5,
        ),
        (
            "bump100",
            [0.545_334_996_536_013_1, 0.545_754_823_268_174_7, 31.018_303_446_477_92],
            0.285_657_550_8,
        ),
        (
            "w1e3_patch",
            [0.085_056_300_616_889_93, 0.391_322_393_652_312_97, -0.051_263_328_034_487_48],
            0.006_062_123_1,
        ),
        (
            "s_w1e3",
            [0.085_056_300_616_889_93, 0.391_322_393_652_312_97, -0.051_263_328_034_487_48],
            0.006_062_123_1,
        ),
        ("s_degen", [0.030_780_743_323_881_02, 0.012_463_616_996_533_09, 20.008_930_812_285_63], 1e-13),
    ];
    for (name, x, known) in cases {
        let surface = load(name);
        let projector = SurfaceProjector::new(&surface);
        let x = Vector3::from(x);
        let foot = projector.project(&x);
        assert!(foot.distance <= known, "{name}: {foot:?} instead of {known}");
        assert!(is_proven(&surface, &foot), "{name}: {foot:?}");
        let fast = projector.project_with(&x, &ProjectionOptions::default().with_mode(Mode::Fast)).unwrap();
        assert!(foot.distance <= fast.distance * (1.0 + 1e-7) + 1e-13, "{name}: {foot:?} {fast:?}");
    }
}

#[test]
fn certificates_that_take_long_are_closed() {
    let cases = [
        ("s9x5", [-0.048_071_662_481_497_02, 0.583_130_604_152_893, 0.107_285_085_211_309_28]),
        ("s_30x30_noise", [0.620_732_459_080_077_6, 0.569_323_590_266_135_4, -0.020_114_158_945_265_376]),
        ("s_C0", [1.072_405_601_613_083_2, 0.432_266_791_950_457_5, -0.119_420_886_986_523_6]),
        ("s_deg1_bilin", [-0.005_381_173_205_628_26, 1.005_359_274_591_887_8, 0.126_838_875_117_557_06]),
        ("s_floating", [0.422_520_327_988_478_33, 0.292_073_213_807_550_63, 0.259_808_968_071_170_3]),
        ("s_w1e3", [0.838_452_991_512_629_6, 0.824_253_764_617_550_2, 0.338_563_702_052_253_56]),
    ];
    for (name, x) in cases {
        let surface = load(name);
        let projector = SurfaceProjector::new(&surface);
        let foot = projector.project(&Vector3::from(x));
        assert!(foot.status.is_converged() && is_proven(&surface, &foot), "{name}: {foot:?}");
        let fast = projector
            .project_with(&Vector3::from(x), &ProjectionOptions::default().with_mode(Mode::Fast))
            .unwrap();
        assert!(foot.distance <= fast.distance * (1.0 + 1e-7), "{name}: {foot:?} {fast:?}");
    }
}

#[test]
fn a_point_on_the_surface_is_found_as_well_among_others() {
    let projector = SurfaceProjector::new(&load("s_degen"));
    let x = Vector3::new(0.030_780_743_323_881_02, 0.012_463_616_996_533_09, 20.008_930_812_285_63);
    let points: Vec<_> =
        (0..40).map(|k| x + Vector3::repeat(1e-9 * f64::from(k % 7) + 0.01 * f64::from(k / 7))).collect();
    let feet = projector.project_many(&points, &ProjectionOptions::default(), &no_progress).unwrap();
    for (x, foot) in points.iter().zip(&feet) {
        assert_eq!(foot, &projector.project(x));
    }
    assert!(feet[0].distance < 1e-13, "{:?}", feet[0]);
}
