//! The direction in which a cloud is seen as a height field.

use crate::{AxisFrame, Error, MultilevelOptions, Weighting, multilevel, parallel};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use sdm_fit::tight_axes;
use std::f64::consts::PI;

/// Least variance, as a share of the next larger one, from which on the principal plane may not be the one to see a cloud from.
const DOUBTFUL: f64 = 0.25;
/// Points that choose a direction; directions tried in half a turn; how often the angle between them is halved around the best.
const CHOOSERS: usize = 3000;
const DIRECTIONS: usize = 12;
const HALVINGS: usize = 4;
/// How much larger what a height field leaves may be than in the best direction.
const AS_FLAT: f64 = 1.5;
/// Cells in each direction of a rectangle, for fewer points accordingly fewer, in which points are looked for.
const CELLS: f64 = 24.0;
const PER_CELL: f64 = 6.0;
/// What a height field leaves, as a share of the size, that does not matter.
const NOTHING: f64 = 1e-9;

/// The frame whose third axis is the direction in which the cloud is a height field: the one in which it extends least, unless it extends
/// about as little in others. Then it is, of those over which a height field leaves about the least, the one in which points fill the
/// rectangle around them best: a roof is seen from above, not from the side. The other axes are along the sides of the smallest
/// rectangle.
pub(crate) fn plane_frame(points: &[Vector3<f64>]) -> Result<AxisFrame, Error> {
    let centre = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let size = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let scatter: Matrix3<f64> = points.iter().map(|p| (p - centre) / size).map(|d| d * d.transpose()).sum();
    if size == 0.0 || !scatter.iter().all(|v| v.is_finite()) {
        return Err(Error::Shape { wanted: "a surface", why: "all of its points coincide".into() });
    }
    let eigen = SymmetricEigen::new(scatter);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let [thin, middle, _] = order.map(|k| eigen.eigenvectors.column(k).into_owned());
    let [least, next, _] = order.map(|k| eigen.eigenvalues[k]);
    let normal =
        if least > DOUBTFUL * next { best_direction(points, &centre, [&thin, &middle], size)? } else { thin };
    tight_frame(points, centre, normal)
}

/// The frame of a normal, of either sense, along the sides of the smallest rectangle.
fn tight_frame(
    points: &[Vector3<f64>],
    centre: Vector3<f64>,
    normal: Vector3<f64>,
) -> Result<AxisFrame, Error> {
    let normal = if normal[normal.iamax()] < 0.0 { -normal } else { normal };
    let frame = AxisFrame::new(centre, &normal)?;
    let [x, y] = tight_axes(points, &frame.axes[2], &frame.axes[0]);
    Ok(AxisFrame { axes: [x, y, frame.axes[2]], ..frame })
}

/// Of the directions in a plane, and those of the coordinate axes.
fn best_direction(
    points: &[Vector3<f64>],
    centre: &Vector3<f64>,
    [a, b]: [&Vector3<f64>; 2],
    size: f64,
) -> Result<Vector3<f64>, Error> {
    let thin: Vec<Vector3<f64>> =
        points.iter().copied().step_by(points.len().div_ceil(CHOOSERS).max(1)).collect();
    let at = |angle: f64| a * angle.cos() + b * angle.sin();
    let step = PI / DIRECTIONS as f64;
    let mut candidates: Vec<(Option<f64>, Vector3<f64>)> =
        (0..DIRECTIONS).map(|k| (Some(k as f64 * step), at(k as f64 * step))).collect();
    candidates.extend((0..3).map(|c| (None, Vector3::ith(c, 1.0))));
    let rate = |normal: &Vector3<f64>| -> Result<Rating, Error> { Rating::of(&thin, centre, normal) };
    let rated = parallel::tasks(candidates.len(), |k| rate(&candidates[k].1));
    let rated: Vec<Rating> = rated.into_iter().collect::<Result<_, _>>()?;
    let flattest = rated.iter().map(|r| r.left).fold(f64::INFINITY, f64::min).max(NOTHING * size);
    let fits = |r: &Rating| r.left <= AS_FLAT * flattest;
    // The first of those that are filled equally well: the principal plane is the first of all.
    let mut best = 0;
    for k in 1..rated.len() {
        let better = !fits(&rated[best]) && fits(&rated[k]);
        let fuller = fits(&rated[best]) == fits(&rated[k]) && rated[k].filled > rated[best].filled + 1e-9;
        if better || fuller {
            best = k;
        }
    }
    let (angle, mut normal) = candidates[best];
    let Some(mut angle) = angle else { return Ok(normal) };
    let (mut filled, mut half) = (rated[best].filled, 0.5 * step);
    for _ in 0..HALVINGS {
        for next in [angle - half, angle + half] {
            let rating = rate(&at(next))?;
            if fits(&rating) && rating.filled > filled {
                (angle, filled, normal) = (next, rating.filled, at(next));
            }
        }
        half *= 0.5;
    }
    Ok(normal)
}

/// What speaks for a direction.
#[derive(Clone, Copy, Debug)]
struct Rating {
    /// Root mean square distance that a height field leaves.
    left: f64,
    /// Share of the cells of the rectangle with points.
    filled: f64,
}

impl Rating {
    fn of(points: &[Vector3<f64>], centre: &Vector3<f64>, normal: &Vector3<f64>) -> Result<Self, Error> {
        let frame = tight_frame(points, *centre, *normal)?;
        let local: Vec<Vector3<f64>> = points.iter().map(|p| frame.to_local(p)).collect();
        let options =
            MultilevelOptions::default().with_weighting(Weighting::Squared).with_data_per_piece(6.0);
        let left = multilevel(&local, None, &options).map_or(f64::INFINITY, |(_, report)| report.rms);
        let (low, high) = local.iter().fold((local[0], local[0]), |(l, h), p| (l.inf(p), h.sup(p)));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let cells = (points.len() as f64 / PER_CELL).sqrt().clamp(2.0, CELLS) as usize;
        let place = |p: &Vector3<f64>, c: usize| {
            let share = (p[c] - low[c]) / (high[c] - low[c]).max(f64::MIN_POSITIVE);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share")]
            let k = (share.clamp(0.0, 1.0) * cells as f64) as usize;
            k.min(cells - 1)
        };
        let mut met = vec![false; cells * cells];
        local.iter().for_each(|p| met[place(p, 0) * cells + place(p, 1)] = true);
        Ok(Self { left, filled: met.iter().filter(|m| **m).count() as f64 / met.len() as f64 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roof_is_seen_from_above() {
        // As wide as it is high: the variances along y and z are the same.
        let at = |k: usize| {
            let (x, y) = (2.0 * (k as f64 * 0.618_034).fract() - 1.0, (k as f64 * 0.754_878).fract());
            Vector3::new(x, y, -x.abs())
        };
        let points: Vec<_> = (0..3000).map(at).collect();
        let frame = plane_frame(&points).unwrap();
        assert!(frame.axes[2].z.abs() > 0.999, "{}", frame.axes[2]);
        assert!(frame.axes[0].x.abs() > 0.999, "{}", frame.axes[0]);
    }

    #[test]
    fn a_sheet_is_seen_across_its_least_extent() {
        let at = |k: usize| {
            let (x, y) = ((k as f64 * 0.618_034).fract(), (k as f64 * 0.754_878).fract());
            Vector3::new(0.1 * (3.0 * x).sin(), 2.0 * y, x)
        };
        let points: Vec<_> = (0..1000).map(at).collect();
        assert!(plane_frame(&points).unwrap().axes[2].x.abs() > 0.95);
    }
}
