//! `cargo xtask convergence`: orders and basins of the local methods on Examples 2 and 3 of \[HW05\].

mod measure;
mod random;
mod subject;

use crate::{Failure, examples, generated};
use footpoint::local::Method;
use measure::{Basin, Order, basin, order};
use std::fmt::Write as _;
use subject::{CurveSubject, Subject, SurfaceSubject};

/// Where the measurements are written.
const DOCUMENT: &str = "docs/convergence.md";

/// Largest distance of a test point from the shape, as a share of the shape's size.
const FAR: f64 = 0.25;

/// How the order is measured above the shape.
const ABOVE: Order = Order { distance: FAR, near: 3e-3, rounding: 1e-12 };

/// The same for points on it, where rounding is smaller and convergence faster.
const ON_SHAPE: Order = Order { distance: 0.0, near: 2e-2, rounding: 1e-14 };

/// Measures, prints, and writes [`DOCUMENT`]; with `--check` fails if it is out of date
/// by more than rounding can explain.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let check = generated::is_check(arguments)?;
    let text = document().map_err(|error| Failure::Failed(format!("an example is invalid: {error}")))?;
    println!("{text}");
    generated::write_or_check(DOCUMENT, &text, check, "convergence", generated::alike_as_measured)
}

const HEAD: &str = "\
# Convergence of the local methods

Written by `cargo xtask convergence`. Shapes are Examples 2 (cubic curve) and 3 (bicubic surface) of [HW05]; test
points and initial parameters are random with a fixed seed.

- *order*: median over 400 test points of log(e₂/e₁)/log(e₁/e₀), e the parameter error of successive steps close
  to the foot (before rounding sets in). 1 is linear, 2 quadratic convergence.
- *reached*: share of 4000 random starts from which the iteration ends at a point of the shape that satisfies the
  optimality (KKT) conditions, within 100 steps; *mean* and *most* count the steps of those that do.
- *bare*: the step repeated as it is, nothing clamped or damped (`iterate_curve`, `iterate_surface`), test points
  at most a quarter of the shape's size above or below an inner point.
- *safeguarded*: `project_curve`, `project_surface` on the same points.
- *beyond*: safeguarded, test points anywhere in the bounding box enlarged to twice its size, so that many feet
  lie on edges and corners.
";

/// The document; the sentences under the tables state what the tests below hold.
fn document() -> Result<String, nurbs_core::Error> {
    let (curve, surface) = (CurveSubject::new(examples::curve()?), SurfaceSubject::new(examples::surface()?));
    let mut text = String::from(HEAD);
    text.push_str("\n## Curve (Example 2)\n\n");
    table(&mut text, &curve);
    text.push_str(
        "\nAll second order methods are quadratic on curves. Eq. (5) gains an order for points on the curve, which is\n\
         why inversion tries it first; left to itself it loses some starts to its false fixed points. Eq. (7) takes the\n\
         fewest steps, the principal-circle step slightly more, Newton's method left to itself clearly more. With the\n\
         safeguards the second order methods end at a footpoint from every start; what the first order method\n\
         misses are feet near a centre of curvature, where its rate nears 1 and the steps run out.\n",
    );
    text.push_str("\n## Surface (Example 3)\n\n");
    table(&mut text, &surface);
    text.push_str(
        "\nOn surfaces the second order method of the paper is linear: one normal section does not tell the curvature\n\
         across it. The principal-circle step uses the same jet and is quadratic. Left to itself it reaches feet from\n\
         more starts than Newton's method and in fewer steps; with the safeguards both reach them from every start,\n\
         the principal-circle step still a little faster. That earns it the place of the default\n\
         (`Method::PrincipalCircle`).\n",
    );
    Ok(text)
}

fn table<S: Subject>(text: &mut String, subject: &S) {
    text.push_str(
        "| method | order | order, point on the shape | bare: reached | mean | most | safeguarded: reached | mean | most | beyond: reached | mean | most |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (method, name) in METHODS {
        let row = Measured::new(subject, method);
        let order = |o: Option<f64>| o.map_or_else(|| "–".into(), |o| format!("{o:.1}"));
        let _ = write!(text, "| {name} | {} | {} |", order(row.order), order(row.order_on_shape));
        for basin in [row.bare, row.safeguarded, row.beyond] {
            let _ = write!(text, " {:.1} % | {:.1} | {} |", 100.0 * basin.reached, basin.mean, basin.most);
        }
        text.push('\n');
    }
}

const METHODS: [(Method, &str); 5] = [
    (Method::FirstOrder, "first order"),
    (Method::SecondOrderTaylor, "second order, eq. (5)"),
    (Method::SecondOrder, "second order, eq. (7)"),
    (Method::PrincipalCircle, "principal circle"),
    (Method::Newton, "Newton"),
];

/// One row of a table.
struct Measured {
    order: Option<f64>,
    order_on_shape: Option<f64>,
    bare: Basin,
    safeguarded: Basin,
    beyond: Basin,
}

impl Measured {
    fn new<S: Subject>(subject: &S, method: Method) -> Self {
        Self {
            order: order(subject, method, &ABOVE),
            order_on_shape: order(subject, method, &ON_SHAPE),
            bare: basin(subject, method, FAR, S::bare),
            safeguarded: basin(subject, method, FAR, S::safeguarded),
            beyond: basin(subject, method, f64::INFINITY, S::safeguarded),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows<S: Subject>(subject: &S) -> [Measured; 5] {
        METHODS.map(|(method, _)| Measured::new(subject, method))
    }

    #[test]
    fn what_the_document_says_of_curves() {
        let [first, taylor, chord, circle, newton] = rows(&CurveSubject::new(examples::curve().unwrap()));
        assert!((first.order.unwrap() - 1.0).abs() < 0.1);
        for quadratic in [&taylor, &chord, &circle, &newton] {
            assert!((quadratic.order.unwrap() - 2.0).abs() < 0.2);
            assert!(quadratic.safeguarded.reached == 1.0 && quadratic.beyond.reached == 1.0);
        }
        assert!((taylor.order_on_shape.unwrap() - 3.0).abs() < 0.3);
        assert!(taylor.bare.reached < circle.bare.reached);
        assert!(first.safeguarded.reached < 0.95 && first.safeguarded.most == 100);
        assert!(chord.bare.mean < circle.bare.mean && circle.bare.mean < newton.bare.mean);
        assert!(chord.safeguarded.mean < circle.safeguarded.mean);
    }

    #[test]
    fn what_the_document_says_of_surfaces() {
        let [first, _, chord, circle, newton] = rows(&SurfaceSubject::new(examples::surface().unwrap()));
        assert!((first.order.unwrap() - 1.0).abs() < 0.15);
        assert!((chord.order.unwrap() - 1.0).abs() < 0.15);
        assert!((circle.order.unwrap() - 2.0).abs() < 0.2);
        assert!((newton.order.unwrap() - 2.0).abs() < 0.2);
        assert!(circle.bare.reached > newton.bare.reached && circle.bare.mean < newton.bare.mean);
        for quadratic in [&circle, &newton] {
            assert!(quadratic.safeguarded.reached == 1.0 && quadratic.beyond.reached == 1.0);
        }
        assert!(circle.safeguarded.mean < newton.safeguarded.mean);
        assert!(circle.safeguarded.mean < chord.safeguarded.mean);
    }
}
