//! Level sets in the plane become B-spline curves (\[P05, sec. 4.6\]).

use crate::contour::signed_area;
use crate::correct::in_order;
use crate::measure::{Gap, Sample, along, denser, gap};
use crate::{Error, parallel};
use distance_field::{ErrorTerm, LevelSetField};
use mesh_core::Polyline;
use nalgebra::Vector2;
use nurbs_core::{BsplineCurve, CurveFitOptions, KnotVector};
use sdm_fit::curve::self_crossings;
use sdm_fit::{ActiveCurve, Constraints, Smoothing, Target, fit};

/// Sensor points on each span of a curve.
const SENSORS: usize = 6;
/// Iterations of squared distance minimisation in each round.
const ITERATIONS: usize = 30;
/// Rounds of inserted knots at most.
const ROUNDS: usize = 24;
/// Rounds of parameter correction before a curve is drawn to the level set.
const CORRECTIONS: usize = 3;
/// Points of a contour on each span at least: fewer do not determine a curve.
const PER_SPAN: usize = 3;
/// Share of the length of a contour that becomes the first spans, and their number at least and at most.
const FIRST: [usize; 2] = [6, 24];
/// Cells of the grid for each of the first spans.
const CELLS: f64 = 24.0;
/// Factor of the bending energy in least squares starts, of curves of one span: enough for spans without points, too little to be seen. It
/// falls with the fourth power of the number of spans, as the energy of a wiggle of the size of a span grows.
const BENDING: f64 = 1e-10;

/// What a curve for a contour shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Degree; default 3.
    pub degree: usize,
    /// Number of control points of every curve, with even knots; by default as many as the tolerance asks for.
    pub controls: Option<usize>,
    /// Largest distance between curve and level set, in both directions, in the unit of the grid; default 0.1.
    pub abs_tolerance: f64,
    /// Most control points of a curve; default 1000.
    pub max_controls: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { degree: 3, controls: None, abs_tolerance: 0.1, max_controls: 1000 }
    }
}

impl FitOptions {
    /// The same options with another degree.
    #[must_use]
    pub fn with_degree(self, degree: usize) -> Self {
        Self { degree, ..self }
    }

    /// The same options with a number of control points.
    #[must_use]
    pub fn with_controls(self, controls: Option<usize>) -> Self {
        Self { controls, ..self }
    }

    /// The same options with another largest distance.
    #[must_use]
    pub fn with_abs_tolerance(self, abs_tolerance: f64) -> Self {
        Self { abs_tolerance, ..self }
    }

    /// The same options with another limit on the control points.
    #[must_use]
    pub fn with_max_controls(self, max_controls: usize) -> Self {
        Self { max_controls, ..self }
    }

    fn check(&self) -> Result<(), Error> {
        let refuse = |option, value, what| Err(Error::Option { option, value, what });
        if !(2..=10).contains(&self.degree) {
            return refuse("degree", self.degree as f64, "it must be between 2 and 10");
        }
        if !(self.abs_tolerance > 0.0 && self.abs_tolerance.is_finite()) {
            return refuse("tolerance", self.abs_tolerance, "it must be a positive length");
        }
        let least = 2 * self.degree;
        if let Some(controls) = self.controls.filter(|&controls| controls < least || controls > 100_000) {
            return refuse(
                "controls",
                controls as f64,
                "it must be at least twice the degree, and at most 100000",
            );
        }
        if self.max_controls < least {
            return refuse("max_controls", self.max_controls as f64, "it must be at least twice the degree");
        }
        Ok(())
    }
}

/// A curve for a contour.
#[derive(Clone, Debug)]
pub struct FittedContour {
    /// The curve: periodic for a closed contour, clamped for an open one. The inside is on its left.
    pub curve: BsplineCurve<2>,
    /// Whether it is closed. Contours that are not end at the border of the grid.
    pub is_closed: bool,
    /// Whether it is closed and bounds a hole.
    pub is_hole: bool,
    /// The area within, of the contour; never negative.
    pub area: f64,
    /// The length of the contour.
    pub length: f64,
    /// Number of control points, those that repeat counted once.
    pub controls: usize,
    /// Largest distance of points of the curve from the level set, sixteen on each span.
    pub forth: f64,
    /// Largest distance of points of the contour from the curve, four or more in each cell.
    pub back: f64,
    /// How often the curve crosses itself.
    pub crossings: usize,
    /// Whether both distances are within the tolerance and the curve does not cross itself.
    pub is_within: bool,
}

/// Fits a B-spline to each of the contours of a level set. Runs in parallel; results do not depend on the number of threads.
///
/// A curve starts as a least squares spline through points of the contour by their length, and is then drawn to the level set by squared
/// distance minimisation: sensor points on the curve, the distance field of the level set. Knots are inserted in the middle of spans
/// that are not within the tolerance.
///
/// # Errors
/// [`Error::Option`] for options that cannot be used.
pub fn fit_contours(
    field: &LevelSetField<2>,
    contours: &[Polyline<2>],
    options: &FitOptions,
) -> Result<Vec<FittedContour>, Error> {
    options.check()?;
    parallel::tasks(contours.len(), |k| fit_contour(field, &contours[k], options)).into_iter().collect()
}

/// A contour with its points.
struct Work<'a> {
    field: &'a LevelSetField<2>,
    samples: Vec<Sample>,
    length: f64,
    is_closed: bool,
    options: &'a FitOptions,
}

/// A curve that may be the one.
struct Candidate {
    curve: BsplineCurve<2>,
    gap: Gap,
    /// Parameters at which it crosses itself.
    crossings: Vec<[f64; 2]>,
}

impl Candidate {
    /// Whether it is to be preferred to another: one that does not cross itself, then the nearer one.
    fn is_better_than(&self, other: &Self) -> bool {
        let crosses = [self, other].map(|candidate| !candidate.crossings.is_empty());
        match crosses {
            [false, true] => true,
            [true, false] => false,
            _ => self.gap.largest() < other.gap.largest(),
        }
    }
}

/// The better one of what is known and what is new.
fn better(known: Option<Candidate>, new: Candidate) -> Candidate {
    match known {
        Some(known) if !new.is_better_than(&known) => known,
        _ => new,
    }
}

fn fit_contour(
    field: &LevelSetField<2>,
    contour: &Polyline<2>,
    options: &FitOptions,
) -> Result<FittedContour, Error> {
    let mut work = Work {
        field,
        samples: along(field, contour),
        length: contour.length(),
        is_closed: contour.is_closed(),
        options,
    };
    let found = work.best()?;
    let is_within = work.is_good(&found);
    let mut ring: Vec<_> = contour.vertices().to_vec();
    ring.extend(contour.vertices().first().copied());
    let area = signed_area(&Polyline::new(ring, false)?);
    Ok(FittedContour {
        is_within,
        is_closed: work.is_closed,
        is_hole: work.is_closed && area < 0.0,
        area: area.abs(),
        length: work.length,
        controls: found.curve.knots().distinct_count(),
        forth: found.gap.forth,
        back: found.gap.back,
        crossings: found.crossings.len(),
        curve: found.curve,
    })
}

impl Work<'_> {
    fn is_good(&self, candidate: &Candidate) -> bool {
        candidate.gap.largest() <= self.options.abs_tolerance && candidate.crossings.is_empty()
    }

    fn candidate(&self, curve: BsplineCurve<2>) -> Result<Candidate, Error> {
        let gap = gap(self.field, &self.samples, &curve)?;
        let crossings = self_crossings(&curve);
        Ok(Candidate { curve, gap, crossings })
    }

    /// The curve that is asked for, or the nearest one that was found.
    fn best(&mut self) -> Result<Candidate, Error> {
        let even = |spans: usize| (0..=spans).map(|k| k as f64 / spans as f64).collect::<Vec<f64>>();
        let degree = self.options.degree;
        if let Some(controls) = self.options.controls {
            let spans = if self.is_closed { controls } else { controls - degree };
            return self.drawn(&even(spans));
        }
        let cells = self.length / self.field.grid().spacing().amax();
        let first = (cells / CELLS).ceil().clamp(FIRST[0] as f64, FIRST[1] as f64);
        let least = if self.is_closed { 2 * degree } else { 1 };
        let mut breaks = even(to_count(first).max(least));
        let mut best = self.drawn(&breaks)?;
        let mut latest: Option<Candidate> = None;
        for _ in 0..ROUNDS {
            if self.is_good(&best) {
                break;
            }
            let known = latest.as_ref().unwrap_or(&best);
            let mut split = self.split(&breaks, known);
            if split.len() == breaks.len() {
                // Too few points for more spans where these are wanted.
                let bad = self.bad(&breaks, known);
                self.samples =
                    denser(self.field, &self.samples, self.is_closed.then_some(self.length), |length| {
                        bad.iter()
                            .any(|pair| pair[0] <= length / self.length && length / self.length < pair[1])
                    });
                split = self.split(&breaks, known);
            }
            if split.len() == breaks.len() || split.len() + degree > self.options.max_controls {
                break;
            }
            breaks = split;
            let found = self.drawn(&breaks)?;
            if found.is_better_than(&best) {
                (best, latest) = (found, None);
            } else {
                latest = Some(found);
            }
        }
        Ok(best)
    }

    /// The breaks with the middle of each span that is not within the tolerance or in which the curve crosses itself, as long as there are
    /// points for it.
    fn split(&self, breaks: &[f64], candidate: &Candidate) -> Vec<f64> {
        let mut out = Vec::with_capacity(2 * breaks.len());
        let shares: Vec<f64> = self.samples.iter().map(|(length, _)| length / self.length).collect();
        let mut bad = self.bad(breaks, candidate).into_iter().peekable();
        for pair in breaks.windows(2) {
            out.push(pair[0]);
            let points = shares.iter().filter(|share| pair[0] <= **share && **share < pair[1]).count();
            if bad.next_if(|bad| bad[0] == pair[0]).is_some() && points >= 2 * PER_SPAN {
                out.push(0.5 * (pair[0] + pair[1]));
            }
        }
        out.extend(breaks.last());
        out
    }

    /// The spans that are not within the tolerance or in which the curve crosses itself.
    fn bad(&self, breaks: &[f64], candidate: &Candidate) -> Vec<[f64; 2]> {
        let pairs = breaks.windows(2).map(|pair| [pair[0], pair[1]]).zip(&candidate.gap.spans);
        let is_bad = |(pair, error): &([f64; 2], &f64)| {
            let within = |t: &f64| pair[0] <= *t && *t <= pair[1];
            let is_near = **error <= self.options.abs_tolerance;
            !is_near || candidate.crossings.iter().flatten().any(within)
        };
        pairs.filter(is_bad).map(|(pair, _)| pair).collect()
    }

    fn knots(&self, breaks: &[f64]) -> Result<KnotVector, Error> {
        let degree = self.options.degree;
        let spans = breaks.len() - 1;
        if !self.is_closed {
            let ends = |t: f64| std::iter::repeat_n(t, degree + 1);
            let inner = breaks[1..spans].iter().copied();
            return Ok(KnotVector::new(degree, ends(0.0).chain(inner).chain(ends(1.0)).collect())?);
        }
        // Breaks of the periods before and after.
        let at = |k: usize| breaks[k % spans] + (k / spans) as f64 - 1.0;
        Ok(KnotVector::periodic(degree, (spans - degree..=2 * spans + degree).map(at).collect())?)
    }

    /// The curve with knots at given breaks in `[0, 1]`, drawn to the level set.
    ///
    /// Of the least squares curves by length and by feet, and the one that is drawn, the best counts.
    fn drawn(&self, breaks: &[f64]) -> Result<Candidate, Error> {
        let points: Vec<Vector2<f64>> = self.samples.iter().map(|(_, point)| *point).collect();
        let mut parameters: Vec<f64> = self.samples.iter().map(|(length, _)| length / self.length).collect();
        let knots = self.knots(breaks)?;
        let spans = (breaks.len() - 1) as f64;
        let mut options = CurveFitOptions::default().with_regularization(BENDING / spans.powi(4));
        if !self.is_closed
            && let [first, .., last] = points.as_slice()
        {
            options = options.with_end_points(*first, *last);
        }
        let is_free = self.options.controls.is_none();
        let mut best: Option<Candidate> = None;
        for _ in 0..CORRECTIONS {
            let wrapped = |t: &f64| if self.is_closed { t.rem_euclid(1.0) } else { *t };
            let at: Vec<f64> = parameters.iter().map(wrapped).collect();
            let curve = BsplineCurve::approximate(knots.clone(), &at, &points, &options)?.shape;
            let found = self.candidate(curve)?;
            parameters = in_order(&found.curve, &parameters, &points);
            let found = better(best.take(), found);
            if is_free && self.is_good(&found) {
                return Ok(found);
            }
            best = Some(found);
        }
        let Some(start) = best else {
            return Err(Error::Empty { what: "a contour has no points".to_owned() });
        };
        let drawn = self.candidate(self.by_distance(&start.curve)?)?;
        Ok(better(Some(start), drawn))
    }

    /// Squared distance minimisation on the field of the level set.
    fn by_distance(&self, start: &BsplineCurve<2>) -> Result<BsplineCurve<2>, Error> {
        let target = Target::Model { field: self.field, sensors: SENSORS, boundary: true };
        let mut constraints = Constraints::none();
        if !self.is_closed {
            let net = start.control_points();
            let last = net.len() - 1;
            constraints = constraints.with_held(0, net[0]).with_held(last, net[last]);
        }
        let options = sdm_fit::FitOptions::default()
            .with_term(ErrorTerm::SquaredDistance)
            .with_smoothing(Smoothing::Continuation { start: 1e-6, factor: 0.25, floor: 0.0 })
            .with_max_iterations(ITERATIONS);
        let fitted = fit(ActiveCurve::new(start.clone())?, target, &constraints, &options)?;
        Ok(fitted.shape.into_curve())
    }
}

/// A small whole number.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a few dozen")]
fn to_count(value: f64) -> usize {
    value as usize
}
