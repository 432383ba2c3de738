//! Areas of faces.
//!
//! Green's theorem: with `G` the integral of the element of area along the second parameter, the area inside the loops
//! is the integral of `−G du` along them. Where the end of the second parameter belongs to the face, `G` there is added
//! over the whole period of the first.

use crate::carrier::Surface;
use crate::face::Face;
use crate::part::Part;
use crate::trace::Chord;
use nalgebra::Vector2;
use nurbs_core::{ParametricSurface, gauss_legendre};

/// Places of a chord at which the integrand is evaluated.
const ALONG: usize = 6;

/// Places of a span of a B-spline at which the element of area is evaluated.
const ACROSS: usize = 10;

/// Pieces of a chord on a B-spline between knots, where edges may turn fast.
const SPLINE_PIECES: usize = 4;

/// Nodes and weights on `[0, 1]` of a rule that is applied to equal pieces.
fn composite(count: usize, pieces: usize) -> Vec<(f64, f64)> {
    let (rule, n) = (gauss_legendre(count), pieces as f64);
    let piece = |k: usize| rule.iter().map(move |(s, w)| ((k as f64 + s) / n, w / n)).collect::<Vec<_>>();
    (0..pieces).flat_map(piece).collect()
}

/// The integral of the element of area along the second parameter.
struct Primitive<'a> {
    surface: &'a Surface,
    swap: bool,
    /// Where it is 0.
    start: f64,
    rule: Vec<(f64, f64)>,
}

impl Primitive<'_> {
    /// Element of area at a place in the plane of the chords.
    fn element(&self, p: Vector2<f64>) -> f64 {
        let uv = if self.swap { Vector2::new(p.y, p.x) } else { p };
        self.surface.jet(&uv).normal_direction().norm()
    }

    fn at(&self, p: &Vector2<f64>) -> f64 {
        if let Some(value) = self.surface.area_primitive(p.y) {
            return value;
        }
        let Some(spline) = self.surface.spline() else {
            // The element of area does not change along the second parameter.
            return self.element(*p) * (p.y - self.start);
        };
        let breaks = &spline.surface.breaks()[usize::from(!self.swap)];
        let (low, high, sign) =
            if p.y >= self.start { (self.start, p.y, 1.0) } else { (p.y, self.start, -1.0) };
        let mut ends = vec![low];
        ends.extend(breaks.iter().copied().filter(|b| *b > low && *b < high));
        ends.push(high);
        let mut sum = 0.0;
        for pair in ends.windows(2) {
            let width = pair[1] - pair[0];
            for (node, weight) in &self.rule {
                sum += weight * width * self.element(Vector2::new(p.x, pair[0] + width * node));
            }
        }
        sign * sum
    }
}

impl Part {
    /// Area of a face.
    ///
    /// Exact up to rounding and the accuracy with which the edges lie on the surface; loops have to be oriented as STEP
    /// and IGES demand.
    #[must_use]
    pub fn area(&self, face: usize) -> f64 {
        let f = &self.faces[face];
        let boundary = &f.boundary;
        let swap = boundary.swap;
        let along = usize::from(!swap);
        let start = match f.surface.spline() {
            Some(spline) => spline.surface.domain()[along].start(),
            None => 0.0,
        };
        let primitive = Primitive { surface: &f.surface, swap, start, rule: gauss_legendre(ACROSS) };
        let rule = composite(ALONG, if f.surface.spline().is_some() { SPLINE_PIECES } else { 1 });
        let sign = if f.same_sense == swap { 1.0 } else { -1.0 };
        let integral: f64 =
            boundary.chords.iter().map(|c| self.chord_integral(f, c, &primitive, &rule)).sum();
        let own = sign * integral;
        let full = || self.full_area(f, &primitive);
        if boundary.chords.is_empty() {
            return full();
        }
        if f.surface.period.iter().all(Option::is_some) {
            // Loops around the tube start anywhere: the area is known up to that of the whole carrier.
            return own.rem_euclid(full());
        }
        let [_, top] = boundary.ends_inside();
        if top && !f.surface.unbounded() { own + full() } else { own.abs() }
    }

    /// Integral of `G du` along a chord; where loops go around the tube of a torus, of `−F dv` instead.
    fn chord_integral(&self, f: &Face, c: &Chord, primitive: &Primitive<'_>, rule: &[(f64, f64)]) -> f64 {
        let boundary = &f.boundary;
        let around =
            f.surface.period.iter().all(Option::is_some) && boundary.windings.iter().any(|w| w[1] != 0);
        let value = |p: &Vector2<f64>, d: &Vector2<f64>| {
            if around {
                // The element of area of a torus does not depend on the first parameter.
                -p.x * primitive.element(*p) * d.y
            } else {
                primitive.at(p) * d.x
            }
        };
        let (mut sum, mut turned) = (0.0, 0.0);
        let cuts = self.knot_crossings(f, c);
        let pieces = cuts
            .windows(2)
            .flat_map(|w| rule.iter().map(move |(s, q)| (w[0] + s * (w[1] - w[0]), q * (w[1] - w[0]))));
        for (s, weight) in pieces {
            let chordwise = c.uv[0] * (1.0 - s) + c.uv[1] * s;
            let Some(owner) = c.owner.filter(|_| c.t[0] != c.t[1]) else {
                sum += weight * value(&chordwise, &(c.uv[1] - c.uv[0]));
                continue;
            };
            let edge = &self.edges[boundary.uses[owner].edge];
            let jet = edge.curve.jet((1.0 - s) * c.t[0] + s * c.t[1]);
            let flip = |p: Vector2<f64>| if boundary.swap { Vector2::new(p.y, p.x) } else { p };
            let uv = f.surface.invert(&jet.point, Some(&flip(chordwise))).at;
            let own = f.surface.jet(&uv);
            // Derivatives of the parameters of the foot of a moving point, which need not lie on the surface.
            let off = jet.point - own.point;
            let e = own.du.norm_squared() - off.dot(&own.duu);
            let g = own.dv.norm_squared() - off.dot(&own.dvv);
            let h = own.du.dot(&own.dv) - off.dot(&own.duv);
            let (a, b) = (own.du.dot(&jet.d1), own.dv.dot(&jet.d1));
            let det = e * g - h * h;
            let d = if det > 1e-20 * e * g {
                Vector2::new((g * a - h * b) / det, (e * b - h * a) / det)
            } else {
                Vector2::zeros()
            };
            let d = flip(d) * (c.t[1] - c.t[0]);
            turned += weight * d.x;
            sum += weight * value(&flip(uv), &d);
        }
        if around || c.owner.is_none() || c.t[0] == c.t[1] {
            return sum;
        }
        // Next to a pole the first parameter turns faster than the rule can follow: what it missed happened there.
        let turn_at = |p: &Vector2<f64>| {
            let jet = f.surface.jet(&if boundary.swap { Vector2::new(p.y, p.x) } else { *p });
            if boundary.swap { jet.dv.norm() } else { jet.du.norm() }
        };
        let places = [c.uv[0], c.uv[1], (c.uv[0] + c.uv[1]) * 0.5];
        let pole = places.iter().min_by(|a, b| turn_at(a).total_cmp(&turn_at(b)));
        sum + pole.map_or(0.0, |p| primitive.at(p) * (c.uv[1].x - c.uv[0].x - turned))
    }

    /// Where along a chord the edge crosses knots of a B-spline carrier, at which the element of area has kinks, with both
    /// ends.
    fn knot_crossings(&self, f: &Face, c: &Chord) -> Vec<f64> {
        let mut cuts = vec![0.0];
        if let (Some(spline), Some(owner)) = (f.surface.spline(), c.owner.filter(|_| c.t[0] != c.t[1])) {
            let flip = |p: Vector2<f64>| if f.boundary.swap { Vector2::new(p.y, p.x) } else { p };
            let ends = c.uv.map(flip);
            let edge = &self.edges[f.boundary.uses[owner].edge];
            for (i, knots) in spline.surface.breaks().iter().enumerate() {
                let shifts = f.surface.period[i].map_or(vec![0.0], |period| vec![-period, 0.0, period]);
                // The ends of the domain are crossed where the surface is closed.
                let domain = spline.surface.domain()[i];
                let knots = knots.iter().copied().chain([domain.start(), domain.end()]);
                let knots = knots.flat_map(|k| shifts.iter().map(move |shift| k + shift));
                for knot in knots {
                    if (ends[0][i] < knot) == (ends[1][i] < knot) {
                        continue;
                    }
                    let (mut low, mut high) = (0.0, 1.0);
                    for _ in 0..40 {
                        let s = 0.5 * (low + high);
                        let x = edge.curve.point((1.0 - s) * c.t[0] + s * c.t[1]);
                        let uv = f.surface.invert(&x, Some(&(ends[0] * (1.0 - s) + ends[1] * s))).at;
                        if (uv[i] < knot) == (ends[0][i] < knot) {
                            low = s;
                        } else {
                            high = s;
                        }
                    }
                    cuts.push(0.5 * (low + high));
                }
            }
        }
        cuts.push(1.0);
        cuts.sort_by(f64::total_cmp);
        cuts
    }

    /// Area of the whole carrier.
    fn full_area(&self, f: &Face, primitive: &Primitive<'_>) -> f64 {
        if let Some(area) = f.surface.whole_area() {
            return area;
        }
        let Some(spline) = f.surface.spline() else { return 0.0 };
        let (first, second) = (usize::from(f.boundary.swap), usize::from(!f.boundary.swap));
        let end = spline.surface.domain()[second].end();
        let breaks = &spline.surface.breaks()[first];
        let mut ends = vec![spline.surface.domain()[first].start()];
        let domain = spline.surface.domain()[first];
        ends.extend(breaks.iter().copied().filter(|b| *b > domain.start() && *b < domain.end()));
        ends.push(spline.surface.domain()[first].end());
        let mut sum = 0.0;
        for pair in ends.windows(2) {
            let width = pair[1] - pair[0];
            for (node, weight) in &primitive.rule {
                sum += weight * width * primitive.at(&Vector2::new(pair[0] + width * node, end));
            }
        }
        sum
    }
}
