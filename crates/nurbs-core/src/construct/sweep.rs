//! Sections carried along a path.

use super::frames::{PathFrame, rotation_minimizing_frames};
use super::skin::skin_at;
use crate::{BsplineCurve, BsplineSurface, Error, ParametricCurve};
use nalgebra::Vector3;

/// Accuracy of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepOptions {
    /// Largest distance of the surface from the exact sweep, relative to the diagonal of the section's
    /// control points plus the length of the path's chord polygon (default 1e-6).
    pub relative_tolerance: f64,
    /// Most sections to interpolate (default 2049).
    pub max_sections: usize,
    /// Degree along the path (default 3).
    pub degree: usize,
}

impl Default for SweepOptions {
    fn default() -> Self {
        Self { relative_tolerance: 1e-6, max_sections: 2049, degree: 3 }
    }
}

impl SweepOptions {
    /// Sets the tolerance.
    #[must_use]
    pub fn with_relative_tolerance(self, relative_tolerance: f64) -> Self {
        Self { relative_tolerance, ..self }
    }

    /// Sets the most sections.
    #[must_use]
    pub fn with_max_sections(self, max_sections: usize) -> Self {
        Self { max_sections, ..self }
    }

    /// Sets the degree along the path.
    #[must_use]
    pub fn with_degree(self, degree: usize) -> Self {
        Self { degree, ..self }
    }
}

/// A swept surface and how good it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The surface: `u` along the section, `v` along the path, with the path's parameter.
    pub surface: BsplineSurface,
    /// Largest deviation of the control points of a section from where the frame carries them, measured
    /// half-way between the interpolated sections; a bound of the deviation there. A length.
    pub deviation: f64,
    /// Whether the deviation is within the tolerance; if not, the number of sections was the limit.
    pub within_tolerance: bool,
    /// Number of interpolated sections.
    pub sections: usize,
}

/// The surface swept by a section that moves along a path like a rigid body, turning as little as possible
/// about the path ([`rotation_minimizing_frames`]).
///
/// The section is given in place at the start of the path. The surface interpolates carried sections,
/// twice as many until what is in between is within the tolerance.
///
/// ```
/// # use nurbs_core::{construct, Circle, Frame, Helix};
/// # use nalgebra::Vector3;
/// # use construct::{SweepOptions, sweep};
/// let path = Helix::new(Frame::WORLD, 10.0, 4.0, 1.0)?;
/// let place = Frame::new(Vector3::new(10.0, 0.0, 0.0), Vector3::y(), Vector3::x())?;
/// let spring = sweep(&Circle::in_frame(&place, 1.0)?.to_nurbs()?, &path, &SweepOptions::default())?;
/// assert!(spring.within_tolerance);
/// # Ok::<(), nurbs_core::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when the path has no tangent somewhere, or a corner (split it there), or an option
/// is out of range.
pub fn sweep<C: ParametricCurve<3> + ?Sized>(
    section: &BsplineCurve<3>,
    path: &C,
    options: &SweepOptions,
) -> Result<Sweep, Error> {
    if options.max_sections <= options.degree || options.degree == 0 {
        return Err(Error::argument(format!(
            "a sweep of degree {} with at most {} sections is not possible; degree ≥ 1, more sections than that",
            options.degree, options.max_sections
        )));
    }
    check_corners(path)?;
    let mut stations = first_stations(path, options.degree);
    loop {
        // Frames also half-way, where the deviation is measured.
        let fine = halved(&stations);
        let frames = rotation_minimizing_frames(path, &fine, None)?;
        let sections = frames.iter().step_by(2).map(|f| carried(section, &frames[0], f));
        let sections = sections.collect::<Result<Vec<_>, Error>>()?;
        let surface = skin_at(&sections, &stations, options.degree)?;
        let deviation = deviation(section, &surface, &frames)?;
        let tolerance = options.relative_tolerance * size(section, &frames);
        let within_tolerance = deviation <= tolerance;
        if within_tolerance || fine.len() > options.max_sections {
            return Ok(Sweep { surface, deviation, within_tolerance, sections: stations.len() });
        }
        stations = fine;
    }
}

/// Ends and breaks of the path with enough parameters between them for the degree.
fn first_stations<C: ParametricCurve<3> + ?Sized>(path: &C, degree: usize) -> Vec<f64> {
    let domain = path.domain();
    let mut stations = vec![domain.start()];
    stations.extend(path.breaks());
    stations.push(domain.end());
    while stations.len() <= degree.max(4) {
        stations = halved(&stations);
    }
    stations
}

fn halved(stations: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(2 * stations.len());
    for pair in stations.windows(2) {
        out.extend([pair[0], 0.5 * (pair[0] + pair[1])]);
    }
    out.extend(stations.last());
    out
}

fn carried(section: &BsplineCurve<3>, from: &PathFrame, to: &PathFrame) -> Result<BsplineCurve<3>, Error> {
    let points = section.control_points().iter().map(|p| from.carry(to, p)).collect();
    BsplineCurve::new(section.knots().clone(), points, section.weights().map(<[f64]>::to_vec))
}

/// At the frames of odd index: distance of the surface's section from the carried one, by control points.
fn deviation(
    section: &BsplineCurve<3>,
    surface: &BsplineSurface,
    frames: &[PathFrame],
) -> Result<f64, Error> {
    let mut worst = 0.0_f64;
    let n_v = surface.n_v();
    for (i, point) in section.control_points().iter().enumerate() {
        // Weights do not change along v, so a row of control points is a polynomial curve of its own.
        let row = surface.control_points()[i * n_v..(i + 1) * n_v].to_vec();
        let track = BsplineCurve::new(surface.knots_v().clone(), row, None)?;
        for frame in frames.iter().skip(1).step_by(2) {
            let exact: Vector3<f64> = frames[0].carry(frame, point);
            worst = worst.max((track.point(frame.parameter) - exact).norm());
        }
    }
    Ok(worst)
}

fn size(section: &BsplineCurve<3>, frames: &[PathFrame]) -> f64 {
    let length: f64 = frames.windows(2).map(|w| (w[1].point - w[0].point).norm()).sum();
    section.control_box().diagonal() + length
}

/// An error where the tangent jumps at a break of the path.
fn check_corners<C: ParametricCurve<3> + ?Sized>(path: &C) -> Result<(), Error> {
    let near = 1e-9 * path.domain().length();
    for t in path.breaks() {
        let tangent = |t: f64| path.jet(t).unit_tangent();
        if let (Some(before), Some(after)) = (tangent(t - near), tangent(t + near))
            && (after - before).norm() > 1e-4
        {
            return Err(Error::argument(format!(
                "the path has a corner at parameter {t}; sweep along the parts before and after it"
            )));
        }
    }
    Ok(())
}
