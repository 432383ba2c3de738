//! All feet of a point: every local minimum of the distance within a factor of the least one.

use crate::global::curve::all_feet_line::{APART, Harvest};
use crate::global::curve::piece::PieceSet;
use crate::global::gap::Gap;
use crate::global::surface::patch::PatchSet;
use crate::global::tree::Bounds;
use crate::{CurveFootpoint, Error, Multiplicity, ProjectionOptions, SurfaceFootpoint};
use nalgebra::{SVector, Vector3};

/// Share of the diagonal of a box around sampled points that the shape may bulge beyond.
const BULGE: f64 = 0.1;

/// Local minima of the distance of a point from one or several surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceFeet {
    /// The feet by growing distance, each place once. `lower_bound` is for all of them the one of the least distance;
    /// `multiplicity` tells whether another foot is as near as this one.
    pub feet: Vec<SurfaceFootpoint>,
    /// Whether it is proven that there are no more feet, but for those closer than 1e-7 of the size of the model to
    /// another point where the distance is stationary.
    pub complete: bool,
    /// Whether feet form whole curves or areas, as for centres and points on axes: each has one representative.
    pub continuum: bool,
    /// Boxes of the parameter domain that were examined.
    pub boxes: u32,
}

/// Local minima of the distance of a point from one or several curves.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveFeet<const D: usize> {
    /// The feet by growing distance, each place once. `lower_bound` is for all of them the one of the least distance;
    /// `multiplicity` tells whether another foot is as near as this one.
    pub feet: Vec<CurveFootpoint<D>>,
    /// Whether it is proven that there are no more feet, but for those closer than 1e-7 of the size of the model to
    /// another point where the distance is stationary.
    pub complete: bool,
    /// Whether feet form whole arcs, as for the centre of a circle: each has one representative.
    pub continuum: bool,
    /// Intervals of the parameter domain that were examined.
    pub boxes: u32,
}

/// What the two kinds of footpoint have in common.
trait Footpoint<const D: usize>: Copy {
    fn point(&self) -> SVector<f64, D>;
    fn distance(&self) -> f64;
    fn converged(&self) -> bool;
    /// A total order for equal distances.
    fn rank(&self) -> (usize, [f64; 2]);
    fn multiplicity(&mut self) -> &mut Multiplicity;
}

impl Footpoint<3> for SurfaceFootpoint {
    fn point(&self) -> Vector3<f64> {
        self.point
    }
    fn distance(&self) -> f64 {
        self.distance
    }
    fn converged(&self) -> bool {
        self.status.is_converged()
    }
    fn rank(&self) -> (usize, [f64; 2]) {
        (self.shape, self.parameter)
    }
    fn multiplicity(&mut self) -> &mut Multiplicity {
        &mut self.multiplicity
    }
}

impl<const D: usize> Footpoint<D> for CurveFootpoint<D> {
    fn point(&self) -> SVector<f64, D> {
        self.point
    }
    fn distance(&self) -> f64 {
        self.distance
    }
    fn converged(&self) -> bool {
        self.status.is_converged()
    }
    fn rank(&self) -> (usize, [f64; 2]) {
        (self.shape, [self.parameter, 0.0])
    }
    fn multiplicity(&mut self) -> &mut Multiplicity {
        &mut self.multiplicity
    }
}

/// How the candidates of one kind of shape are examined.
struct Examine<'a, F, P> {
    /// The public result of a place.
    finish: &'a dyn Fn(&F) -> P,
    is_minimum: &'a dyn Fn(&F) -> bool,
    /// Whether a minimum is one of a continuum.
    continues: &'a dyn Fn(&F, &P) -> bool,
}

/// The feet that are kept.
struct Gathered<P> {
    feet: Vec<P>,
    complete: bool,
    continuum: bool,
}

fn check(x: &[f64], factor: f64, options: &ProjectionOptions) -> Result<(), Error> {
    if !x.iter().all(|c| c.is_finite()) {
        return Err(Error::NonFinitePoint { index: 0 });
    }
    if !(factor >= 1.0 && factor.is_finite()) {
        return Err(Error::Option {
            option: "factor",
            value: factor,
            what: "it must be finite and at least 1",
        });
    }
    options.validate()
}

/// The largest distance of a foot that is wanted, ties included.
fn limit(distance: f64, factor: f64, gap: &Gap, x: &[f64]) -> f64 {
    let rounding = 8.0 * f64::EPSILON * x.iter().fold(0.0f64, |a, c| a.max(c.abs()));
    distance * factor * (1.0 + gap.tie) + 1e-3 * gap.absolute + rounding
}

pub(super) fn surface_feet<const K: usize>(
    set: &PatchSet<K>,
    x: &Vector3<f64>,
    factor: f64,
    options: &ProjectionOptions,
) -> Result<SurfaceFeet, Error> {
    check(x.as_slice(), factor, options)?;
    let gap = Gap::new(options, set.size);
    let found = set.scratch.with(|scratch| {
        let mut found = set.search(x, true, &gap, scratch);
        set.improve_open(x, &mut found, &gap, scratch);
        found
    });
    let limit = limit(found.foot.distance_sq.sqrt(), factor, &gap, x.as_slice());
    let apart = APART * set.size;
    let harvest = set.minima(x, limit * limit, &gap);
    let boxes = harvest.boxes;
    let bound = found.bound_sq.sqrt();
    let finish = |foot: &_| {
        let out = set.finish(x, foot);
        SurfaceFootpoint { lower_bound: bound.min(out.distance), ..out }
    };
    let examine = Examine {
        finish: &finish,
        is_minimum: &|foot| set.is_minimum(x, foot),
        continues: &|foot, out: &SurfaceFootpoint| {
            out.distance > gap.absolute && set.continues(x, foot, out, &gap)
        },
    };
    let Gathered { feet, complete, continuum } = gather(&found.foot, harvest, &examine, limit, apart, &gap);
    Ok(SurfaceFeet { feet, complete, continuum, boxes })
}

pub(super) fn curve_feet<const D: usize, const K: usize>(
    set: &PieceSet<D, K>,
    x: &SVector<f64, D>,
    factor: f64,
    options: &ProjectionOptions,
) -> Result<CurveFeet<D>, Error> {
    check(x.as_slice(), factor, options)?;
    let gap = Gap::new(options, set.size);
    let (nearest, bound_sq) = set.scratch.with(|scratch| set.search(x, true, &gap, scratch));
    let limit = limit(nearest.distance_sq.sqrt(), factor, &gap, x.as_slice());
    let apart = APART * set.size;
    let harvest = set.minima(x, limit * limit, &gap);
    let boxes = harvest.boxes;
    let bound = bound_sq.sqrt();
    let finish = |foot: &_| {
        let out = set.finish(x, foot);
        CurveFootpoint { lower_bound: bound.min(out.distance), ..out }
    };
    let examine = Examine {
        finish: &finish,
        is_minimum: &|foot| set.is_minimum(x, foot),
        continues: &|foot, out: &CurveFootpoint<D>| {
            out.distance > gap.absolute && set.continues(x, foot, out, &gap)
        },
    };
    let Gathered { feet, complete, continuum } = gather(&nearest, harvest, &examine, limit, apart, &gap);
    Ok(CurveFeet { feet, complete, continuum, boxes })
}

/// Keeps the minima, each once, with one representative of each continuum.
fn gather<F: Copy, P: Footpoint<D>, const D: usize>(
    nearest: &F,
    harvest: Harvest<F, D>,
    examine: &Examine<'_, F, P>,
    limit: f64,
    apart: f64,
    gap: &Gap,
) -> Gathered<P> {
    let same = |a: &P, b: &P| (a.point() - b.point()).norm() <= apart;
    let mut kept = vec![(*nearest, (examine.finish)(nearest))];
    let mut rejected: Vec<P> = Vec::new();
    let accept = |kept: &mut Vec<(F, P)>, rejected: &mut Vec<P>, foot: &F| {
        let out = (examine.finish)(foot);
        if out.distance().is_nan() || out.distance() > limit || rejected.iter().any(|r| same(r, &out)) {
            return false;
        }
        if let Some(known) = kept.iter_mut().find(|k| same(&k.1, &out)) {
            if !known.1.converged() && out.converged() {
                *known = (*foot, out);
            }
            return true;
        }
        if (examine.is_minimum)(foot) {
            kept.push((*foot, out));
            return true;
        }
        rejected.push(out);
        false
    };
    for foot in &harvest.feet {
        accept(&mut kept, &mut rejected, foot);
    }
    // Of the feet on connected boxes of equal distance one is enough.
    let complete = !harvest.unresolved && harvest.flats.is_empty();
    for group in connected(&harvest.flats) {
        let members = group.iter().map(|&i| &harvest.flats[i]);
        let level = members.clone().map(|m| (examine.finish)(&m.0).distance()).fold(f64::INFINITY, f64::min);
        let mut represented = false;
        kept.retain(|(_, out)| {
            let inside = (out.distance() - level).abs() <= 8.0 * gap.tie * level + gap.absolute
                && members.clone().any(|m| touch(&m.1, &[out.point().into(); 2]));
            let keep = !inside || !represented;
            represented |= inside;
            keep
        });
        if !represented {
            members.into_iter().any(|m| accept(&mut kept, &mut rejected, &m.0));
        }
    }
    let mut continuum = false;
    for (foot, out) in &mut kept {
        let continues = (examine.continues)(foot, out);
        *out.multiplicity() = if continues { Multiplicity::Continuum } else { Multiplicity::Unique };
        continuum |= continues;
    }
    let mut feet: Vec<P> = kept.into_iter().map(|(_, out)| out).collect();
    feet.sort_by(|a, b| {
        let ((shape_a, [ua, va]), (shape_b, [ub, vb])) = (a.rank(), b.rank());
        let by_distance = a.distance().total_cmp(&b.distance());
        by_distance.then(shape_a.cmp(&shape_b)).then(ua.total_cmp(&ub)).then(va.total_cmp(&vb))
    });
    for i in 1..feet.len() {
        if gap.is_tie(feet[i - 1].distance().powi(2), feet[i].distance()) {
            for foot in &mut feet[i - 1..=i] {
                if *foot.multiplicity() == Multiplicity::Unique {
                    *foot.multiplicity() = Multiplicity::Tied;
                }
            }
        }
    }
    Gathered { feet, complete: complete && !continuum, continuum }
}

/// Whether two boxes meet, each made larger by what the shape may bulge beyond it.
fn touch<const D: usize>(a: &Bounds<D>, b: &Bounds<D>) -> bool {
    let diagonal = |c: &Bounds<D>| (SVector::<f64, D>::from(c[1]) - SVector::<f64, D>::from(c[0])).norm();
    let margin = BULGE * (diagonal(a) + diagonal(b));
    (0..D).all(|d| a[0][d] - margin <= b[1][d] && b[0][d] - margin <= a[1][d])
}

/// Indices of boxes, in groups that hang together.
fn connected<F, const D: usize>(flats: &[(F, Bounds<D>)]) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..flats.len()).collect();
    let mut groups = Vec::new();
    while let Some(first) = left.pop() {
        let mut group = vec![first];
        let mut next = 0;
        while next < group.len() {
            let here = group[next];
            next += 1;
            let (near, far) = left.into_iter().partition(|&i| touch(&flats[i].1, &flats[here].1));
            left = far;
            let near: Vec<usize> = near;
            group.extend(near);
        }
        groups.push(group);
    }
    groups
}
