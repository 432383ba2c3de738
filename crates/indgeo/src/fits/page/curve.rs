//! Pictures of fitted curves: with the points by their distance, and with a curvature comb.

use super::bands::{Shown, hex, picked};
use crate::output::html::{note, section};
use industrial_geometry::nurbs::nalgebra::SVector;
use industrial_geometry::nurbs::{BsplineCurve, ParametricCurve};
use std::fmt::Write as _;

/// Width of a picture of a plane curve, and of one of three views of a space curve; the margin.
const WIDE: f64 = 640.0;
const NARROW: f64 = 310.0;
const MARGIN: f64 = 14.0;
/// Samples of a span of a curve, and every which one has a tooth of the comb.
const PER_SPAN: usize = 24;
const TOOTH: usize = 2;
/// Length of the long teeth as a share of the size, and the share of the teeth that are no longer.
const LONG: f64 = 0.14;
const USUAL: f64 = 0.95;

/// What is drawn.
pub(crate) struct CurveSections<'a, const D: usize> {
    pub(crate) curves: Vec<&'a BsplineCurve<D>>,
    pub(crate) points: &'a [SVector<f64, D>],
    /// Of each point; NaN of what is none.
    pub(crate) distances: &'a [f64],
    pub(crate) tolerance: Option<f64>,
    /// The largest distance of a point that counts.
    pub(crate) max: f64,
}

/// A place of a curve with its curvature vector.
struct Place<const D: usize> {
    point: SVector<f64, D>,
    curvature: SVector<f64, D>,
}

/// The sections of a page, as markup.
pub(crate) fn curve_sections<const D: usize>(scene: &CurveSections<'_, D>) -> String {
    let curves: Vec<Vec<Place<D>>> = scene.curves.iter().map(|curve| places(curve)).collect();
    let knots: Vec<SVector<f64, D>> = scene.curves.iter().flat_map(|curve| ends_of_spans(curve)).collect();
    let finite = |&i: &usize| scene.points[i].iter().all(|c| c.is_finite());
    let distance = |i: usize| scene.distances.get(i).copied().unwrap_or(f64::NAN);
    let points = picked(scene.points.len()).filter(finite).map(|i| (scene.points[i], distance(i))).collect();
    let shown = Shown::new(points, scene.points.len(), scene.tolerance, scene.max);
    let Some(frame) = Frame::around(&curves) else { return note("The curve has no extent.") };
    let with_points = frame.views(|svg, flat| {
        for (p, distance) in &shown.points {
            let [x, y] = flat(p);
            let colour = hex(shown.colour(*distance));
            let _ = write!(svg, "<path d=\"M{x:.1} {y:.1}h0\" stroke=\"{colour}\" stroke-width=\"4\" stroke-linecap=\"round\"/>");
        }
        curves.iter().for_each(|curve| line(svg, curve.iter().map(|place| flat(&place.point))));
        for knot in &knots {
            let [x, y] = flat(knot);
            let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.2\" fill=\"#fff\" stroke=\"#1d2733\"/>");
        }
    });
    let scale = comb_scale(&curves, frame.size);
    let comb = frame.views(|svg, flat| {
        for curve in &curves {
            let tip = |place: &Place<D>| flat(&(place.point - place.curvature * scale));
            for place in curve.iter().step_by(TOOTH) {
                let ([ax, ay], [bx, by]) = (flat(&place.point), tip(place));
                let _ = write!(
                    svg,
                    "<path d=\"M{ax:.1} {ay:.1}L{bx:.1} {by:.1}\" stroke=\"#3f6fb5\" stroke-width=\".5\"/>"
                );
            }
            line(svg, curve.iter().map(|place| flat(&place.point)));
            let tips: Vec<String> = curve.iter().map(tip).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
            let _ = write!(svg, "<polyline fill=\"none\" stroke=\"#c8422b\" points=\"{}\"/>", tips.join(" "));
        }
    });
    let first = with_points + &shown.legend() + &note("Circles: the ends of the spans of the curve.");
    section("The curve, and the points by their distance", &first)
        + &section(
            "Curvature comb",
            &(comb
                + &note(
                    "Teeth point away from the centre of curvature, their length is the curvature; a step of the red line is a jump of it.",
                )),
        )
}

/// Places along a curve, all of which are finite.
fn places<const D: usize>(curve: &BsplineCurve<D>) -> Vec<Place<D>> {
    let spans: Vec<usize> = curve.knots().spans().collect();
    let mut out = Vec::with_capacity(spans.len() * PER_SPAN + 1);
    for (k, &span) in spans.iter().enumerate() {
        let interval = curve.knots().span_interval(span);
        let last = usize::from(k + 1 == spans.len());
        for i in 0..PER_SPAN + last {
            let jet = curve.jet_in_span(span, interval.lerp(i as f64 / PER_SPAN as f64));
            let speed = jet.d1.norm_squared();
            let across = jet.d2 - jet.d1 * (jet.d1.dot(&jet.d2) / speed);
            let curvature = across / speed;
            let curvature =
                if curvature.iter().all(|c| c.is_finite()) { curvature } else { SVector::zeros() };
            out.push(Place { point: jet.point, curvature });
        }
    }
    out.retain(|place| place.point.iter().all(|c| c.is_finite()));
    out
}

fn ends_of_spans<const D: usize>(curve: &BsplineCurve<D>) -> Vec<SVector<f64, D>> {
    let knots = curve.knots();
    knots
        .spans()
        .map(|span| curve.point(knots.span_interval(span).start()))
        .chain([curve.point(curve.domain().end())])
        .collect()
}

/// By which length a curvature is drawn.
fn comb_scale<const D: usize>(curves: &[Vec<Place<D>>], size: f64) -> f64 {
    let mut all: Vec<f64> = curves.iter().flatten().map(|place| place.curvature.norm()).collect();
    all.sort_by(f64::total_cmp);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index among them")]
    let usual = all.get((USUAL * all.len().saturating_sub(1) as f64) as usize).copied().unwrap_or(0.0);
    if usual > 0.0 { LONG * size / usual } else { 0.0 }
}

fn line(svg: &mut String, places: impl Iterator<Item = [f64; 2]>) {
    let points: Vec<String> = places.map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = write!(
        svg,
        "<polyline fill=\"none\" stroke=\"#1d2733\" stroke-width=\"1.6\" points=\"{}\"/>",
        points.join(" ")
    );
}

/// How places become places in a picture.
struct Frame<const D: usize> {
    low: SVector<f64, D>,
    high: SVector<f64, D>,
    size: f64,
}

impl<const D: usize> Frame<D> {
    /// Around curves, with room for their combs.
    fn around(curves: &[Vec<Place<D>>]) -> Option<Self> {
        let mut low = SVector::<f64, D>::repeat(f64::INFINITY);
        let mut high = -low;
        for place in curves.iter().flatten() {
            (low, high) = (low.inf(&place.point), high.sup(&place.point));
        }
        let size = (high - low).amax();
        (size > 0.0 && size.is_finite()).then(|| {
            let room = SVector::repeat(LONG * size);
            Self { low: low - room, high: high + room, size }
        })
    }

    /// One picture in the plane, three in space, to the same scale.
    fn views(&self, draw: impl Fn(&mut String, &dyn Fn(&SVector<f64, D>) -> [f64; 2])) -> String {
        let sides = self.high - self.low;
        let views: &[([usize; 2], &str)] =
            if D == 2 { &[([0, 1], "")] } else { &[([0, 1], "x, y"), ([0, 2], "x, z"), ([1, 2], "y, z")] };
        let width = if D == 2 { WIDE } else { NARROW };
        let scale = (width - 2.0 * MARGIN) / sides.amax();
        let mut out = "<div class=\"views\">\n".to_owned();
        for ([a, b], name) in views {
            let height = sides[*b] * scale + 2.0 * MARGIN;
            let flat = |p: &SVector<f64, D>| {
                [MARGIN + (p[*a] - self.low[*a]) * scale, MARGIN + (self.high[*b] - p[*b]) * scale]
            };
            let across = sides[*a] * scale + 2.0 * MARGIN;
            let _ = write!(
                out,
                "<svg width=\"{across:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {across:.0} {height:.0}\" role=\"img\" \
                 aria-label=\"view {name}\">"
            );
            draw(&mut out, &flat);
            let _ = writeln!(out, "<text x=\"6\" y=\"{:.0}\">{name}</text></svg>", height - 6.0);
        }
        out.push_str("</div>\n");
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use industrial_geometry::nurbs::KnotVector;
    use industrial_geometry::nurbs::nalgebra::Vector2;

    #[test]
    fn curvature_of_a_parabola_is_what_it_is() {
        let net = [[-1.0, 1.0], [0.0, -1.0], [1.0, 1.0]].map(Vector2::from).to_vec();
        let curve = BsplineCurve::new(KnotVector::uniform_clamped(2, 3).unwrap(), net, None).unwrap();
        let middle = &places(&curve)[PER_SPAN / 2];
        // y = x² has the curvature 2 at its vertex, towards +y.
        assert!((middle.curvature - Vector2::new(0.0, 2.0)).norm() < 1e-12);
        let scene =
            CurveSections { curves: vec![&curve], points: &[], distances: &[], tolerance: None, max: 0.0 };
        let text = curve_sections(&scene);
        assert_eq!(text.matches("<section>").count(), 2);
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }
}
