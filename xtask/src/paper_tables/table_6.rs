//! Table 6 of \[HW05\]: registration of a cloud to an object of 2.0 × 0.8 × 0.4.
//!
//! The paper does not give its object. Two that have the same size, and starts that have the same error, show the same
//! convergence; the numbers beside which ours are put were computed with 40 digits.

use distance_field::SurfaceField;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use nurbs_core::{BsplineSurface, Frame, KnotVector, ParametricSurface, Sphere};
use sdm_register::{FootpointPolicy, Method, Outliers, Pose, RegisterOptions, Source, StepControl, register};
use std::error::Error;
use std::f64::consts::PI;
use std::fmt::Write as _;

/// `E(0), …, E(8)` as printed.
const PRINTED: [&str; 9] =
    ["1.04", "3.5e-1", "2.1e-1", "1.1e-1", "6.0e-2", "1.3e-2", "4.3e-4", "1.7e-6", "2.3e-11"];

/// Errors of squared distance minimisation on the ellipsoid, and on the open surface.
const EXACT: [[f64; 9]; 2] = [
    [
        1.039995,
        0.3679804,
        0.1869796,
        0.08533404,
        0.03529336,
        0.008387198,
        4.632433e-4,
        1.639135e-6,
        2.435224e-11,
    ],
    [
        1.039952,
        0.4458137,
        0.1965949,
        0.06396490,
        0.02180781,
        0.005730328,
        4.302650e-4,
        2.023985e-6,
        9.642630e-11,
    ],
];

/// How far a computed error may be from the exact one: half a unit of its seventh digit, and what rounding of the
/// coordinates leaves.
const RELATIVE: f64 = 1e-6;
const ROUNDING: f64 = 2e-15;

/// One object with the errors of the methods.
#[derive(Debug)]
pub(crate) struct Registration {
    title: &'static str,
    pub(crate) rows: Vec<Row>,
    exact: &'static [f64; 9],
}

/// The errors of one method.
#[derive(Debug)]
pub(crate) struct Row {
    label: &'static str,
    pub(crate) errors: Vec<f64>,
}

/// Both objects.
pub(crate) fn compute() -> Result<Vec<Registration>, Box<dyn Error>> {
    let ellipsoid = ellipsoid()?;
    let cloud: Vec<_> = (0..240).map(on_ellipsoid).collect();
    let open = open_surface()?;
    let samples: Vec<_> = (0..240)
        .map(|i| open.point((f64::from(i / 12) + 0.5) / 20.0, (f64::from(i % 12) + 0.5) / 12.0))
        .collect();
    let mean = samples.iter().sum::<Vector3<f64>>() / samples.len() as f64;
    let closed = moved(
        &cloud,
        Vector3::zeros(),
        Vector3::new(0.0, 1.0, -1.0),
        70.0,
        Vector3::new(3.0, 3.0, -1.0),
        1.493,
    );
    let shifted =
        moved(&samples, mean, Vector3::new(1.0, -1.0, 0.0), 50.0, Vector3::new(2.0, 1.0, -3.0), 1.346);
    Ok(vec![
        registration("Ellipsoid with semi-axes 1, 0.4, 0.2, 240 points", &ellipsoid, &closed, &EXACT[0])?,
        registration("Open bicubic surface of 2.0 × 0.8 × 0.4, 240 points", &open, &shifted, &EXACT[1])?,
    ])
}

fn registration(
    title: &'static str,
    surface: &BsplineSurface,
    cloud: &[Vector3<f64>],
    exact: &'static [f64; 9],
) -> Result<Registration, Box<dyn Error>> {
    let field = SurfaceField::new(surface)?;
    let methods = [("SDM", Method::SDM), ("TDM", Method::TANGENT), ("ICP", Method::ICP)];
    let rows = methods.map(|(label, method)| {
        let options = RegisterOptions::default()
            .with_method(method)
            .with_control(StepControl::None)
            .with_footpoints(FootpointPolicy::Global)
            .with_outliers(Outliers::None)
            .with_tolerance(0.0)
            .with_max_iterations(exact.len() - 1);
        let report = register(&field, &Source::new(cloud), &Pose::identity(), &options)?;
        let errors =
            std::iter::once(report.initial_rms).chain(report.history.iter().map(|s| s.rms)).collect();
        Ok::<_, sdm_register::Error>(Row { label, errors })
    });
    Ok(Registration { title, rows: rows.into_iter().collect::<Result<_, _>>()?, exact })
}

/// Every error of squared distance minimisation that is not what it should be.
pub(crate) fn disagreements(registrations: &[Registration]) -> Vec<String> {
    let mut found = Vec::new();
    for registration in registrations {
        let errors = &registration.rows[0].errors;
        for (j, &exact) in registration.exact.iter().enumerate() {
            let computed = errors.get(j).copied().unwrap_or(f64::NAN);
            let allowed = RELATIVE * exact + ROUNDING;
            if computed.is_nan() || (computed - exact).abs() > allowed {
                found.push(format!(
                    "Table 6, {}, step {j}: exact {exact}, computed {computed}",
                    registration.title
                ));
            }
        }
    }
    found
}

/// The table as Markdown.
pub(crate) fn render(registrations: &[Registration]) -> String {
    let mut text = String::from(
        "## Table 6\n\nRoot mean square distance E(j) of the cloud after j steps. The object of the paper is not given; two of \
         its size take its place, with\nstarts of the same error. SDM is squared distance minimisation with nonnegative \
         models, TDM the tangent term, ICP the point term;\nno step is controlled.\n",
    );
    for registration in registrations {
        let _ = write!(text, "\n{}\n\n| j |", registration.title);
        for j in 0..PRINTED.len() {
            let _ = write!(text, " {j} |");
        }
        let _ = write!(text, "\n|---|{}\n| printed |", "---|".repeat(PRINTED.len()));
        for printed in PRINTED {
            let _ = write!(text, " {printed} |");
        }
        text.push('\n');
        for row in &registration.rows {
            let _ = write!(text, "| {} |", row.label);
            for error in &row.errors {
                // The last digits of errors near rounding depend on the order of sums.
                let digits = if *error < 1e-8 { 1 } else { 5 };
                if *error < 1e-12 {
                    text.push_str(" < 1e-12 |");
                } else {
                    let _ = write!(text, " {error:.digits$e} |");
                }
            }
            text.push('\n');
        }
    }
    text
}

/// `(x − c) Rᵀ + c + t · dir/|dir|`.
fn moved(
    cloud: &[Vector3<f64>],
    centre: Vector3<f64>,
    axis: Vector3<f64>,
    degrees: f64,
    direction: Vector3<f64>,
    distance: f64,
) -> Vec<Vector3<f64>> {
    let rotation = Rotation3::from_axis_angle(&Unit::new_normalize(axis), degrees.to_radians());
    let shift = direction.normalize() * distance;
    cloud.iter().map(|x| rotation * (x - centre) + centre + shift).collect()
}

fn ellipsoid() -> Result<BsplineSurface, nurbs_core::Error> {
    let axes = Matrix3::from_diagonal(&SEMI_AXES);
    Sphere::new(Frame::WORLD, 1.0)?.to_nurbs()?.transformed(&axes, &Vector3::zeros())
}

const SEMI_AXES: Vector3<f64> = Vector3::new(1.0, 0.4, 0.2);

/// The points of a spiral on the ellipsoid.
fn on_ellipsoid(i: u32) -> Vector3<f64> {
    let k = f64::from(i) + 0.5;
    let (polar, azimuth) = ((1.0 - 2.0 * k / 240.0).acos(), PI * (1.0 + 5f64.sqrt()) * k);
    Vector3::new(azimuth.cos() * polar.sin(), azimuth.sin() * polar.sin(), polar.cos())
        .component_mul(&SEMI_AXES)
}

/// Thousandths of the heights of the control points.
const HEIGHTS: [[i32; 6]; 8] = [
    [281, 274, 265, 278, 309, 330],
    [268, 274, 286, 305, 319, 325],
    [239, 269, 319, 346, 323, 300],
    [229, 280, 367, 414, 377, 340],
    [252, 291, 361, 420, 421, 412],
    [237, 227, 213, 222, 253, 275],
    [203, 160, 86, 44, 75, 106],
    [189, 135, 43, -16, 11, 43],
];

fn open_surface() -> Result<BsplineSurface, nurbs_core::Error> {
    let third = 1.0 / 3.0;
    let knots_u = KnotVector::new(3, vec![0.0, 0.0, 0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0, 1.0])?;
    let knots_v = KnotVector::new(3, vec![0.0, 0.0, 0.0, 0.0, third, 2.0 * third, 1.0, 1.0, 1.0, 1.0])?;
    let (u, v) = (knots_u.greville(), knots_v.greville());
    let points = HEIGHTS
        .iter()
        .zip(&u)
        .flat_map(|(row, u)| {
            row.iter()
                .zip(&v)
                .map(move |(&z, v)| Vector3::new(2.0 * u - 1.0, 0.8 * v - 0.4, f64::from(z) / 1e3))
        })
        .collect();
    BsplineSurface::new(knots_u, knots_v, points, None)
}
