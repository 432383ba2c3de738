//! Sections across an axis that are long and thin, as those of blades: how to go around them.
//!
//! Directions from the middle of a crescent do not tell whether it closes: its middle lies outside. Straightened along its mean
//! line and widened to a circle it is like any other section.

use nalgebra::{Matrix2, Matrix3, SymmetricEigen, Vector2, Vector3};

/// Bins along the section.
const BINS: usize = 16;
/// Fewest points.
const FEWEST: usize = 120;
/// Length of a section over its thickness from which on it is thin.
const THIN: f64 = 2.5;
/// Share of the thickness, in the middle, that is empty between two sides, and the share of the points allowed in it.
const BETWEEN: f64 = 0.4;
const FEW: f64 = 0.12;
/// Share of the bins that must have two sides, of those without the ends that are at least this share of the thickest; and
/// how many must.
const TWO_SIDED: f64 = 0.75;
const TELLING: f64 = 0.35;
const FEWEST_BINS: usize = 5;

/// A section that is long, thin and closed, with its mean line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Section {
    middle: Vector2<f64>,
    along: Vector2<f64>,
    /// Mean line: across as a polynomial of the place along, which is from -1 to 1.
    line: Vector3<f64>,
    /// Half the length, and half the largest thickness.
    half: [f64; 2],
}

impl Section {
    /// `None` where points have no two sides along a mean line, or are not thin: as far as circles, and sheets that are open.
    pub(crate) fn of(points: &[Vector2<f64>]) -> Option<Self> {
        if points.len() < FEWEST {
            return None;
        }
        let mean = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
        let scatter: Matrix2<f64> = points.iter().map(|p| p - mean).map(|d| d * d.transpose()).sum();
        if !scatter.iter().all(|x| x.is_finite()) {
            return None;
        }
        let eigen = SymmetricEigen::new(scatter);
        let along = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
        let across = Vector2::new(-along.y, along.x);
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
        };
        let (low, high) = range(&mut points.iter().map(|p| (p - mean).dot(&along)));
        let half_length = (high - low) / 2.0;
        let middle = mean + along * ((low + high) / 2.0);
        let local: Vec<[f64; 2]> = points
            .iter()
            .map(|p| p - middle)
            .map(|d| [d.dot(&along) / half_length.max(f64::MIN_POSITIVE), d.dot(&across)])
            .collect();
        // The line between the two sides: through the middles of the bins.
        let mut bins: Vec<Vec<[f64; 2]>> = vec![Vec::new(); BINS];
        for &[x, y] in &local {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
            let bin = (((x + 1.0) / 2.0 * BINS as f64).max(0.0) as usize).min(BINS - 1);
            bins[bin].push([x, y]);
        }
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for bin in bins.iter().filter(|b| !b.is_empty()) {
            let (l, h) = range(&mut bin.iter().map(|p| p[1]));
            let x = bin.iter().map(|p| p[0]).sum::<f64>() / bin.len() as f64;
            let row = Vector3::new(1.0, x, x * x);
            normal += row * row.transpose();
            right += row * ((l + h) / 2.0);
        }
        let line = normal.try_inverse()? * right;
        let offset = |[x, y]: [f64; 2]| y - line.dot(&Vector3::new(1.0, x, x * x));
        let half_thickness = local.iter().map(|&p| offset(p).abs()).fold(0.0, f64::max);
        if !(half_thickness > 0.0 && half_length >= THIN * half_thickness) {
            return None;
        }
        let thickness = |bin: &Vec<[f64; 2]>| {
            let (l, h) = range(&mut bin.iter().map(|&p| offset(p)));
            (l, h)
        };
        // Thin ends, and bins with hardly a point, tell nothing.
        let thickest = bins.iter().map(thickness).map(|(l, h)| h - l).fold(0.0, f64::max);
        let telling: Vec<&Vec<[f64; 2]>> = bins[1..BINS - 1]
            .iter()
            .filter(|bin| bin.len() >= 4 && thickness(bin).1 - thickness(bin).0 >= TELLING * thickest)
            .collect();
        let two_sided = |bin: &&&Vec<[f64; 2]>| {
            let (l, h) = thickness(bin);
            let inner = |&&p: &&[f64; 2]| (offset(p) - (l + h) / 2.0).abs() < BETWEEN * (h - l) / 2.0;
            // Of a single side that is merely slanted within the bin, points lie everywhere in between.
            bin.iter().filter(inner).count() as f64 <= FEW * bin.len() as f64
        };
        let count = telling.iter().filter(two_sided).count();
        (count >= FEWEST_BINS && count as f64 >= TWO_SIDED * telling.len() as f64).then_some(Self {
            middle,
            along,
            line,
            half: [half_length, half_thickness],
        })
    }

    /// The place in the straight section, which is about a unit circle.
    pub(crate) fn straightened(&self, p: &Vector2<f64>) -> Vector2<f64> {
        let d = p - self.middle;
        let x = d.dot(&self.along) / self.half[0];
        let y = d.dot(&Vector2::new(-self.along.y, self.along.x)) - self.line_at(x);
        Vector2::new(x, y / self.half[1])
    }

    /// The inverse of [`straightened`](Self::straightened).
    pub(crate) fn bent(&self, q: &Vector2<f64>) -> Vector2<f64> {
        let across = Vector2::new(-self.along.y, self.along.x);
        self.middle + self.along * (q.x * self.half[0]) + across * (q.y * self.half[1] + self.line_at(q.x))
    }

    fn line_at(&self, x: f64) -> f64 {
        self.line.dot(&Vector3::new(1.0, x, x * x))
    }
}

/// Places of a section from its middle: straightened if it is thin and closed, otherwise from the middle of its box.
pub(crate) fn from_middle(points: &[Vector2<f64>]) -> (Vec<Vector2<f64>>, bool) {
    if let Some(section) = Section::of(points) {
        return (points.iter().map(|p| section.straightened(p)).collect(), true);
    }
    let Some(first) = points.first() else { return (Vec::new(), false) };
    let (low, high) = points.iter().fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
    let middle = (low + high) / 2.0;
    (points.iter().map(|p| p - middle).collect(), false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    fn crescent(count: usize, closed: bool) -> Vec<Vector2<f64>> {
        let at = |k: usize| {
            let t = TAU * k as f64 / count as f64;
            let (x, side) = (t.cos(), if closed { t.sin() } else { 0.0 });
            Vector2::new(7.0 + 10.0 * x, -2.0 + 5.0 * x * x + 1.2 * side)
        };
        (0..count).map(at).collect()
    }

    #[test]
    fn a_crescent_is_straightened_and_a_sheet_is_not() {
        let points = crescent(600, true);
        let section = Section::of(&points).unwrap();
        for p in &points {
            let q = section.straightened(p);
            assert!((0.6..1.3).contains(&q.norm()), "{q}");
            assert!((section.bent(&q) - p).norm() < 1e-12);
        }
        assert!(Section::of(&crescent(600, false)).is_none());
        // Half a circle with some noise, and a whole one.
        let arc = |turn: f64| -> Vec<Vector2<f64>> {
            (0..600)
                .map(|k| turn * f64::from(k) / 600.0)
                .map(|t| Vector2::new(t.cos(), t.sin()) * (1.0 + 0.01 * (977.0 * t).sin()))
                .collect()
        };
        assert!(Section::of(&arc(PI)).is_none() && Section::of(&arc(TAU)).is_none());
        assert!(Section::of(&[]).is_none() && Section::of(&[Vector2::zeros(); 500]).is_none());
        assert!(Section::of(&[Vector2::repeat(f64::NAN); 500]).is_none());
    }
}
