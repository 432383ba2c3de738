//! Where the parameters of a surface cannot move freely: its ends, its kinks and its poles.

use crate::local_geometry::{LocalGeometry, of_curve, of_point, of_surface};
use crate::pole::Pole;
use nalgebra::Vector3;
use nurbs_core::{CurveJet, Interval, ParametricSurface, SurfaceJet};

/// Share of a domain within which a parameter is at its end.
const AT_END: f64 = 1e-12;
/// Share of the size within which points are the same.
const SAME_POINT: f64 = 1e-9;
/// Sine of the angle between residual and normal above which a kink holds the foot.
const HELD: f64 = 1e-6;
/// Distance from a pole, as a share of the size, within which second derivatives are rounding errors.
const BESIDE_POLE: f64 = 1e-5;
/// Share of a domain by which the other side of a kink is looked at.
const BESIDE_KINK: f64 = 1e-7;
/// Samples of an edge per stretch between two breaks.
const SAMPLES: usize = 4;

/// What lies at an end of a parameter.
#[derive(Clone, Debug)]
enum End {
    /// The surface ends.
    Open,
    /// It goes on at the other end.
    Closed,
    /// All points of the edge are one.
    Collapsed(Box<Pole>),
}

/// What is known about the parameter domain of one surface.
#[derive(Clone, Debug)]
pub(crate) struct Borders {
    domain: [Interval; 2],
    ends: [[End; 2]; 2],
    /// Parameters inside the domain where first derivatives jump.
    kinks: [Vec<f64>; 2],
    /// Largest coordinate of the surface relative to its centre.
    size: f64,
}

impl Borders {
    /// Examines a surface of about the given size.
    pub(crate) fn new<S: ParametricSurface>(surface: &S, size: f64) -> Self {
        let domain = surface.domain();
        let breaks = surface.breaks();
        let same = SAME_POINT * size;
        let ends = [0, 1].map(|k| {
            let edges = [domain[k].start(), domain[k].end()].map(|at| {
                let place = |t: f64| if k == 0 { surface.point(at, t) } else { surface.point(t, at) };
                samples(domain[1 - k], &breaks[1 - k]).into_iter().map(place).collect::<Vec<_>>()
            });
            let close = |(p, q): (&Vector3<f64>, &Vector3<f64>)| (p - q).norm() <= same;
            let closed = surface.period()[k].is_some() || edges[0].iter().zip(&edges[1]).all(close);
            [0, 1].map(|end| {
                if edges[end].iter().all(|p| (p - edges[end][0]).norm() <= same) {
                    End::Collapsed(Box::new(Pole::new(surface, k, end)))
                } else if closed {
                    End::Closed
                } else {
                    End::Open
                }
            })
        });
        let kinks = surface
            .derivative_breaks()
            .map(|breaks| breaks.iter().filter(|b| b.continuity == 0).map(|b| b.parameter).collect());
        Self { domain, ends, kinks, size }
    }

    /// The end at which a parameter lies, if at any, and how far it is away from the nearest in any case.
    #[inline]
    fn nearest_end(&self, k: usize, parameter: f64) -> (usize, f64) {
        let (below, above) = (parameter - self.domain[k].start(), self.domain[k].end() - parameter);
        if below <= above { (0, below) } else { (1, above) }
    }

    /// The local geometry at a foot with the given residual, and whether the surface ends there.
    #[inline]
    pub(crate) fn geometry<S: ParametricSurface>(
        &self,
        surface: &S,
        parameter: [f64; 2],
        jet: &SurfaceJet,
        residual: &Vector3<f64>,
    ) -> (LocalGeometry<3>, bool) {
        let mut free = [true; 2];
        let mut held = [false; 2];
        let mut on_boundary = false;
        for k in 0..2 {
            let tangent = if k == 0 { &jet.du } else { &jet.dv };
            let (end, gap) = self.nearest_end(k, parameter[k]);
            let at_end = gap <= AT_END * self.domain[k].length();
            match &self.ends[k][end] {
                End::Collapsed(pole) => {
                    let away = gap * tangent.norm();
                    if away <= SAME_POINT * self.size {
                        return (pole.geometry(residual), !pole.inner);
                    }
                    if away <= BESIDE_POLE * self.size
                        && let Some(geometry) = pole.geometry_beside(jet, residual)
                    {
                        return (geometry, false);
                    }
                }
                End::Open if at_end => {
                    free[k] = false;
                    on_boundary = true;
                }
                End::Closed if at_end => held[k] = !self.slides(tangent, residual),
                End::Open | End::Closed => {}
            }
            let tolerance = AT_END * self.domain[k].length();
            if self.kinks[k].iter().any(|kink| (kink - parameter[k]).abs() <= tolerance) {
                held[k] = !self.slides(tangent, residual);
            }
            free[k] &= !held[k];
        }
        if free == [true; 2]
            && let Some(geometry) = of_surface(jet, residual)
        {
            return (geometry, on_boundary);
        }
        (geometry_along(free, jet, residual, self.side(surface, parameter, jet, held)), on_boundary)
    }

    /// The normal that tells the side of a foot: at a kink the sum of those around it.
    fn side<S: ParametricSurface>(
        &self,
        surface: &S,
        parameter: [f64; 2],
        jet: &SurfaceJet,
        held: [bool; 2],
    ) -> Option<Vector3<f64>> {
        if held == [false; 2] {
            return jet.unit_normal();
        }
        let around = |k: usize| {
            let step = if held[k] { BESIDE_KINK * self.domain[k].length() } else { 0.0 };
            [self.moved(k, parameter[k], -step), self.moved(k, parameter[k], step)]
        };
        let [us, vs] = [around(0), around(1)];
        let normals = us.into_iter().flat_map(|u| vs.map(|v| surface.jet(u, v).unit_normal()));
        Some(normals.flatten().sum())
    }

    /// Whether the foot is not held by a kink: the residual is normal to the tangent.
    fn slides(&self, tangent: &Vector3<f64>, residual: &Vector3<f64>) -> bool {
        let allowed = HELD * residual.norm() + AT_END * self.size;
        tangent.dot(residual).abs() <= tangent.norm() * allowed
    }

    /// A parameter moved by a step: wrapped where the surface closes, kept inside where it ends.
    #[inline]
    pub(crate) fn moved(&self, k: usize, parameter: f64, step: f64) -> f64 {
        let to = parameter + step;
        if self.domain[k].contains(to) {
            to
        } else if matches!(self.ends[k], [End::Closed, _]) {
            self.domain[k].wrap(to)
        } else {
            self.domain[k].clamp(to)
        }
    }

    /// Whether a step would leave the domain from its end.
    #[inline]
    pub(crate) fn blocks(&self, k: usize, parameter: f64, step: f64) -> bool {
        let (end, gap) = self.nearest_end(k, parameter);
        let outwards = if end == 0 { step < 0.0 } else { step > 0.0 };
        outwards && gap <= AT_END * self.domain[k].length() && !matches!(self.ends[k][end], End::Closed)
    }

    /// The middle of the domain, where the surface can be evaluated.
    pub(crate) fn centre(&self) -> [f64; 2] {
        self.domain.map(Interval::midpoint)
    }
}

/// The model of the parameters that are free: `Q = I − J M⁻¹ Jᵀ` over these (one: a curve; none: a point).
fn geometry_along(
    free: [bool; 2],
    jet: &SurfaceJet,
    residual: &Vector3<f64>,
    side: Option<Vector3<f64>>,
) -> LocalGeometry<3> {
    let direction = match free {
        [true, false] => Some(0),
        [false, true] => Some(1),
        [false, false] => None,
        // Not regular: the longer derivative alone has a direction.
        [true, true] => Some(usize::from(jet.du.norm_squared() < jet.dv.norm_squared())),
    };
    direction
        .and_then(|k| of_curve(&line(jet, k), residual, side.as_ref()))
        .unwrap_or_else(|| of_point(residual, side.as_ref()))
}

/// The jet of a parameter line.
pub(crate) fn line(jet: &SurfaceJet, k: usize) -> CurveJet<3> {
    let (d1, d2) = if k == 0 { (jet.du, jet.duu) } else { (jet.dv, jet.dvv) };
    CurveJet { point: jet.point, d1, d2 }
}

/// Parameters between and at the breaks.
fn samples(domain: Interval, breaks: &[f64]) -> Vec<f64> {
    let mut ends = vec![domain.start()];
    ends.extend(breaks.iter().copied().filter(|b| *b > domain.start() && *b < domain.end()));
    ends.push(domain.end());
    let mut out = vec![domain.start()];
    for pair in ends.windows(2) {
        out.extend((1..=SAMPLES).map(|i| pair[0] + (pair[1] - pair[0]) * i as f64 / SAMPLES as f64));
    }
    out
}
