//! Curves and surfaces of other programs: free-form shapes of OBJ, and the JSON of geomdl.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use pc_io::nurbs_core::{ParametricCurve, ParametricSurface};
use pc_io::{Content, Format, Model, ReadOptions, Shape, read_bytes};

fn load(name: &str, text: &str) -> Result<(Model, Vec<String>), String> {
    let loaded = read_bytes(text.as_bytes(), Format::from_path(name.as_ref()), &ReadOptions::default());
    let loaded = loaded.map_err(|error| error.to_string())?;
    match loaded.content {
        Content::Nurbs(model) => Ok((model, loaded.report.warnings)),
        other => panic!("{}: {}", other.describe(), loaded.report),
    }
}

fn point(shape: &Shape, [u, v]: [f64; 2]) -> Vec<f64> {
    match shape {
        Shape::Curve2(curve) => curve.jet(u).point.iter().copied().collect(),
        Shape::Curve3(curve) => curve.jet(u).point.iter().copied().collect(),
        Shape::Surface(surface) => surface.jet(u, v).point.iter().copied().collect(),
    }
}

fn assert_near(found: &[f64], right: &[f64]) {
    let gap = found.iter().zip(right).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(found.len() == right.len() && gap < 1e-14, "{found:?} {right:?}");
}

const PATCH: &str = "\
v 0 0 0\nv 0 2 1\nv 0 4 1\nv 0 6 0\nv 2 0 1\nv 2 2 2\nv 2 4 2\nv 2 6 1
v 4 0 1\nv 4 2 2\nv 4 4 2\nv 4 6 1\nv 6 0 0\nv 6 2 1\nv 6 4 1\nv 6 6 0
g sheet metal\ncstype bspline\ndeg 3 3\nsurf 0 1 0 1 1 5 9 13 2 6 10 14 \\\n3 7 11 15 4 8 12 16
parm u 0 0 0 0 1 1 1 1\nparm v 0 0 0 0 1 1 1 1\nend\n";

#[test]
fn free_form_surfaces_of_obj_are_models() {
    let (model, warnings) = load("patch.obj", PATCH).unwrap();
    assert_eq!((model.shapes().len(), model.name(0), warnings.len()), (1, Some("sheet metal"), 0));
    // x = 6 u and y = 6 v since the points are evenly spaced; u runs in the first direction of the file.
    for [u, v] in [[0.0, 0.0], [0.25, 0.75], [0.5, 0.5], [1.0, 0.25]] {
        let found = point(&model.shapes()[0], [u, v]);
        // z is the sum of 3 t (1 − t) of both directions.
        assert_near(&found, &[6.0 * u, 6.0 * v, 3.0 * u * (1.0 - u) + 3.0 * v * (1.0 - v)]);
    }
    // A part of it, with vertices counted backwards, texture beside them, keywords in capitals, and no `end`.
    let part = PATCH
        .replace("surf 0 1 0 1", "SURF 0.25 0.5 0 1")
        .replace(" 1 5 9 13 2", " -16/1 -12 -8 -4 2//3")
        .replace("end\n", "");
    let (model, _) = load("part.obj", &part).unwrap();
    let Shape::Surface(surface) = &model.shapes()[0] else { panic!() };
    assert_eq!((surface.knots_u().domain().start(), surface.knots_u().domain().end()), (0.25, 0.5));
    assert_near(&point(&model.shapes()[0], [0.25, 0.75]), &[1.5, 4.5, 1.125]);
    // The corners of the net differ in the two directions, so that a wrong order would show.
    let wide = "v 0 0 0\nv 1 0 0\nv 2 0 5\nv 0 1 0\nv 1 1 0\nv 2 1 0\ncstype bezier\ndeg 2 1\nsurf 0 2 0 1 1 2 3 4 5 6\nparm u 0 2\nparm v 0 1\nend\n";
    let (model, _) = load("bezier.obj", wide).unwrap();
    assert_near(&point(&model.shapes()[0], [2.0, 0.0]), &[2.0, 0.0, 5.0]);
    assert_near(&point(&model.shapes()[0], [1.0, 0.5]), &[1.0, 0.5, 0.625]);
}

#[test]
fn rational_curves_of_obj_keep_their_weights() {
    let arc = format!(
        "v 1 0 0\nv 1 1 0 {}\nv 0 1 0\ncstype rat bspline\ndeg 2\ncurv 0 1 1 2 3\nparm u 0 0 0 1 1 1\nend\n",
        0.5f64.sqrt()
    );
    let (model, warnings) = load("arc.obj", &arc).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    for t in [0.0, 0.3, 0.5, 1.0] {
        let p = point(&model.shapes()[0], [t, 0.0]);
        assert!((p[0].hypot(p[1]) - 1.0).abs() < 1e-15, "{p:?}");
    }
    // Without `rat` weights mean nothing.
    let (model, _) = load("plain.obj", &arc.replace("rat ", "")).unwrap();
    assert_near(&point(&model.shapes()[0], [0.5, 0.0]), &[0.75, 0.75, 0.0]);
    // Bézier pieces joined at the numbers of `parm`.
    let two = "v 0 0 0\nv 1 1 0\nv 2 0 0\nv 3 -1 0\nv 4 0 0\ncstype bezier\ndeg 2\ncurv 0 3 1 2 3 4 5\nparm u 0 1 3\nend\n";
    let (model, _) = load("two.obj", two).unwrap();
    assert_near(&point(&model.shapes()[0], [1.0, 0.0]), &[2.0, 0.0, 0.0]);
    assert_near(&point(&model.shapes()[0], [2.0, 0.0]), &[3.0, -0.5, 0.0]);
}

#[test]
fn what_is_left_out_of_free_form_obj_is_told() {
    let trimmed =
        PATCH.replace("end\n", "trim 0 1 1\nhole 0 1 2\nend\nvp 0 0\nvp 1 1\ncurv2 1 2\nparm u 0 1\nend\n");
    let (_, warnings) = load("trimmed.obj", &trimmed).unwrap();
    assert!(warnings[0].contains("2 trimming loops"), "{warnings:?}");
    let both = format!("{PATCH}f 1 2 3\n");
    let loaded = read_bytes(both.as_bytes(), None, &ReadOptions::default()).unwrap();
    assert!(
        loaded.report.warnings.iter().any(|w| w.contains("1 free-form curves and surfaces beside polygons"))
    );
    let other = PATCH.replace("bspline", "bmatrix");
    let loaded = read_bytes(other.as_bytes(), None, &ReadOptions::default()).unwrap();
    assert!(
        loaded.report.warnings.iter().any(|w| w.contains("neither bspline nor bezier")),
        "{}",
        loaded.report
    );
    for (text, message) in [
        (
            PATCH.replace("parm u 0 0 0 0 1 1 1 1\n", ""),
            "line 20: a line \"parm u\" with the knots is missing",
        ),
        (PATCH.replace("parm u 0 0 0 0 1", "parm u 0 0 0 0 2"), "line 20: parm u: "),
        (PATCH.replace(" 12 16", " 12"), "line 20: 15 control points do not fit 4 × 4"),
        (PATCH.replace(" 12 16", " 12 17"), "line 20: vertex 17 does not exist"),
        (PATCH.replace("cstype bspline\n", ""), "line 19: no line \"cstype\""),
        (PATCH.replace("deg 3 3", "deg 1000000000000 3"), "the degree is 1000000000000"),
        (PATCH.replace("deg 3 3\n", ""), "no line \"deg\""),
        (PATCH.replace("surf 0 1 0 1 1", "surf 0 2 0 1 1"), "line 20: "),
        (PATCH.replace("parm v 0 0", "parm v 0 x"), "line 23: "),
    ] {
        let found = load("bad.obj", &text).unwrap_err();
        assert!(found.contains(message), "{message}: {found}");
    }
}

/// Written by geomdl 5.4 from a surface whose points its own evaluation gives.
const SURFACE: &str = r#"{"shape": {"type": "surface", "count": 1, "data": [{"type": "spline", "rational": true,
"dimension": 3, "degree_u": 2, "degree_v": 1, "knotvector_u": [0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0],
"knotvector_v": [0.0, 0.0, 0.5, 1.0, 1.0], "size_u": 4, "size_v": 3, "control_points": {"points": [[0.0, 0.0, 0.5],
[0.0, 2.0, 0.0], [0.0, 4.0, -0.5], [1.5, 0.0, 0.25], [1.5, 2.0, 0.25], [1.5, 4.0, 0.25], [3.0, 0.0, 0.5],
[3.0, 2.0, 1.0], [3.0, 4.0, 1.5], [4.5, 0.0, 1.25], [4.5, 2.0, 2.25], [4.5, 4.0, 3.25]], "weights": [1.0, 1.25, 1.5,
1.75, 1.0, 1.25, 1.5, 1.75, 1.0, 1.25, 1.5, 1.75]}, "delta": [0.05, 0.05]}]}}"#;
const CURVES: &str = r#"{"shape": {"type": "curve", "count": 2, "data": [{"type": "spline", "rational": false,
"dimension": 3, "degree": 3, "knotvector": [0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0], "control_points":
{"points": [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [3.0, 2.0, 1.0], [4.0, 0.0, 0.0], [5.0, 1.0, 2.0]]}, "delta": 0.01},
{"type": "spline", "rational": true, "dimension": 3, "degree": 2, "knotvector": [0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
"control_points": {"points": [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], "weights": [1.0,
0.7071067811865476, 1.0]}, "delta": 0.01, "name": "arc"}]}}"#;

#[test]
fn json_of_geomdl_is_read_as_geomdl_evaluates_it() {
    let (model, warnings) = load("surface.json", SURFACE).unwrap();
    assert!(warnings.is_empty());
    for (at, right) in [
        ([0.0, 0.0], [0.0, 0.0, 0.5]),
        ([0.25, 0.3], [1.6080843585237259, 1.0369068541300528, 0.3506151142355009]),
        ([0.4, 0.5], [2.3076923076923075, 2.0, 0.6538461538461539]),
        ([0.9, 0.75], [4.077787769784173, 2.987410071942446, 2.3444244604316546]),
        ([1.0, 1.0], [4.5, 4.0, 3.25]),
    ] {
        assert_near(&point(&model.shapes()[0], at), &right);
    }
    let (model, _) = load("curves.json", CURVES).unwrap();
    assert_eq!((model.shapes().len(), model.name(0), model.name(1)), (2, None, Some("arc")));
    assert_near(
        &point(&model.shapes()[0], [0.3, 0.0]),
        &[1.7459999999999998, 1.7639999999999998, 0.32399999999999995],
    );
    assert_near(&point(&model.shapes()[1], [0.3, 0.0]), &[0.8973756499953727, 0.4412674277525846, 0.0]);
    // The quarter circle in the plane, alone instead of in a list.
    let circle = r#"{"shape":{"type":"curve","data":{"degree":2,"knotvector":[0,0,0,1,1,1],
        "control_points":{"points":[[1,0],[1,1],[0,1]],"weights":[1,0.7071067811865476,1]}}}}"#;
    let (model, _) = load("circle.json", circle).unwrap();
    let p = point(&model.shapes()[0], [0.5, 0.0]);
    assert!(p.len() == 2 && (p[0].hypot(p[1]) - 1.0).abs() < 1e-15);
    let trimmed = SURFACE.replace(
        "\"delta\"",
        "\"reversed\": 1, \"trims\": {\"count\": 1, \"data\": [{\"type\": \"spline\"}]}, \"delta\"",
    );
    let (_, warnings) = load("trimmed.json", &trimmed).unwrap();
    assert!(
        warnings[0].contains("trimming curves of 1 surfaces")
            && warnings[1].contains("1 shapes are reversed"),
        "{warnings:?}"
    );
}

#[test]
fn json_of_geomdl_that_is_no_curve_or_surface_is_refused() {
    for (text, message) in [
        (SURFACE.replace("\"surface\"", "\"volume\""), "volume"),
        (SURFACE.replace("\"size_u\": 4", "\"size_u\": 5"), "size_u is 5, but degree and knots need 4"),
        (SURFACE.replace("\"degree_v\": 1", "\"degree_w\": 1"), "volume"),
        (SURFACE.replace("\"knotvector_v\"", "\"knots\""), "shape 0: the field \"knotvector_v\" is missing"),
        (SURFACE.replace("[0.0, 4.0, -0.5]", "[0.0, 4.0]"), "control point 2 has 2 coordinates, not 3"),
        (CURVES.replace("0.5, 1.0, 1.0, 1.0, 1.0]", "0.5, 1.0]"), "shape 0: "),
        (CURVES.replacen("\"spline\"", "\"freeform\"", 1), "freeform"),
        ("{\"shape\": 5}".to_owned(), "neither a field \"kind\""),
        ("{\"degree\": 3}".to_owned(), "neither a field \"kind\""),
        (
            "{\"kind\": \"model\", \"shapes\": [{\"degree\": 1}]}".to_owned(),
            "shape 0: the field \"kind\" is missing",
        ),
    ] {
        let found = load("bad.json", &text).unwrap_err();
        assert!(found.contains(message), "{message}: {found}");
    }
}
