//! Multilevel B-splines: a smooth height field through or near scattered points.

mod height_field;
mod lattice;
mod options;

pub use height_field::HeightField;
pub use options::{LevelRecord, MultilevelOptions, MultilevelReport, MultilevelStatus, Trend, Weighting};

use crate::Error;
use lattice::Lattice;
use nalgebra::{Matrix3, Vector3};
use nurbs_core::Interval;

/// Coarse cells in each direction by which data are sorted, so that neighbours touch the same part of a lattice.
const SORTING_CELLS: usize = 256;
/// Fewest points for which sorting pays.
const SORTED: usize = 20_000;

/// The height field `z = f(x, y)` of scattered points by multilevel B-spline approximation ([MPK, eqs. (1)-(6)],
/// \[LWS97\]), as one uniform cubic spline.
///
/// Every level adds the approximation of what the coarser ones leave, on a lattice of half the spacing; the sum is refined
/// to the newest lattice at once, so that evaluation costs the same after any number of levels. `domain` is the
/// rectangle of the field, by default the bounding rectangle of the points; points outside it do not count.
///
/// The trend is taken off first and added to the coefficients at the end, exactly. Without this a constant does not
/// come back as a constant, because the approximation of eq. (5) is not a projection.
///
/// # Errors
/// [`Error::TooFewPoints`] without a finite point in the domain, [`Error::EmptyDomain`], [`Error::Option`].
///
/// ```
/// use cloud_param::{MultilevelOptions, multilevel};
/// use nalgebra::Vector3;
///
/// let wave = |x: f64, y: f64| (3.0 * x).sin() + y;
/// let points: Vec<_> = (0..2500).map(|i| (f64::from(i % 50) / 49.0, f64::from(i / 50) / 49.0))
///     .map(|(x, y)| Vector3::new(x, y, wave(x, y))).collect();
/// let (field, report) = multilevel(&points, None, &MultilevelOptions::default())?;
/// assert!(report.rms < 1e-2);
/// assert!((field.value(0.37, 0.71) - wave(0.37, 0.71)).abs() < 1e-2);
/// # Ok::<(), cloud_param::Error>(())
/// ```
pub fn multilevel(
    points: &[Vector3<f64>],
    domain: Option<[Interval; 2]>,
    options: &MultilevelOptions,
) -> Result<(HeightField, MultilevelReport), Error> {
    options.check()?;
    let finite = |p: &&Vector3<f64>| p.iter().all(|c| c.is_finite());
    let [x, y] = match domain {
        Some(domain) => domain,
        None => bounding_rectangle(points.iter().filter(finite))?,
    };
    let inside = |p: &&Vector3<f64>| x.contains(p.x) && y.contains(p.y);
    let used: Vec<&Vector3<f64>> = points.iter().filter(finite).filter(inside).collect();
    if used.is_empty() {
        return Err(Error::TooFewPoints { total: points.len(), usable: 0, needed: 1 });
    }
    let spans = options.spans.unwrap_or_else(|| first_spans(x.length(), y.length()));
    let trend = trend(&used, [x, y], spans, options.trend);
    // Places in units of the coarsest lattice, and what is left to be approximated.
    let scale = [spans[0] as f64 / x.length(), spans[1] as f64 / y.length()];
    let mut data: Vec<[f64; 3]> = used
        .iter()
        .map(|p| {
            let place = [(p.x - x.start()) * scale[0], (p.y - y.start()) * scale[1]];
            [place[0], place[1], p.z - trend[0] - trend[1] * place[0] - trend[2] * place[1]]
        })
        .collect();
    if data.len() >= SORTED {
        sort(&mut data, spans);
    }
    let (low, high) =
        used.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |r, p| (r.0.min(p.z), r.1.max(p.z)));
    let goal = options.tolerance * (high - low);

    let mut sum = Lattice::zeros(spans);
    let mut report = MultilevelReport::new(points.len(), data.len(), &data);
    let mut factor = 1.0;
    for level in 0..options.max_levels {
        if level > 0 {
            if !options.admits(sum.spans(), data.len()) {
                report.status = MultilevelStatus::Resolution;
                break;
            }
            sum = sum.refined();
            factor *= 2.0;
        }
        let correction = Lattice::approximate(sum.spans(), factor, &data, options.weighting);
        correction.subtract_from(&mut data, factor);
        sum.add(&correction);
        report.push(sum.spans(), &data);
        if report.rms <= goal {
            report.status = MultilevelStatus::Converged;
            break;
        }
    }
    sum.add_plane([trend[0], trend[1] / factor, trend[2] / factor]);
    Ok((HeightField::new([x, y], sum), report))
}

fn bounding_rectangle<'a>(points: impl Iterator<Item = &'a Vector3<f64>>) -> Result<[Interval; 2], Error> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        for axis in 0..2 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    let side = |axis: usize| {
        Interval::new(low[axis], high[axis])
            .map_err(|_| Error::EmptyDomain { low: low[axis], high: high[axis] })
    };
    Ok([side(0)?, side(1)?])
}

/// Nearly square cells, one along the shorter side.
fn first_spans(width: f64, height: f64) -> [usize; 2] {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and 64")]
    let spans = |side: f64, other: f64| (side / other).round().clamp(1.0, 64.0) as usize;
    [spans(width, height), spans(height, width)]
}

/// `a + b s + c t` in lattice coordinates.
fn trend(points: &[&Vector3<f64>], [x, y]: [Interval; 2], spans: [usize; 2], kind: Trend) -> [f64; 3] {
    let count = points.len() as f64;
    let mean = points.iter().map(|p| p.z).sum::<f64>() / count;
    if kind == Trend::Mean {
        return [mean, 0.0, 0.0];
    }
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for p in points {
        let row =
            Vector3::new(1.0, (p.x - x.start()) / x.length() - 0.5, (p.y - y.start()) / y.length() - 0.5);
        matrix += row * row.transpose() / count;
        right += row * ((p.z - mean) / count);
    }
    // The ridge decides for a level plane where the points lie on a line.
    matrix += Matrix3::from_diagonal(&Vector3::new(0.0, 1e-12, 1e-12));
    match matrix.cholesky() {
        Some(factor) => {
            let plane = factor.solve(&right);
            let at_start = mean + plane.x - 0.5 * (plane.y + plane.z);
            [at_start, plane.y / spans[0] as f64, plane.z / spans[1] as f64]
        }
        None => [mean, 0.0, 0.0],
    }
}

/// Counting sort by coarse cells.
fn sort(data: &mut Vec<[f64; 3]>, spans: [usize; 2]) {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "places are inside the lattice"
    )]
    let cell = |p: &[f64; 3]| {
        let along = |axis: usize| {
            ((p[axis] / spans[axis] as f64 * SORTING_CELLS as f64) as usize).min(SORTING_CELLS - 1)
        };
        along(0) * SORTING_CELLS + along(1)
    };
    let mut starts = vec![0usize; SORTING_CELLS * SORTING_CELLS + 1];
    for p in data.iter() {
        starts[cell(p) + 1] += 1;
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut sorted = vec![[0.0; 3]; data.len()];
    for p in data.iter() {
        let slot = &mut starts[cell(p)];
        sorted[*slot] = *p;
        *slot += 1;
    }
    *data = sorted;
}
