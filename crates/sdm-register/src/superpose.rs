//! The rigid motion that takes points nearest to given places.

use crate::{Error, Pose, rotation};
use nalgebra::{Matrix4, SMatrix, SVector, SymmetricEigen, Vector3};

/// The rigid motion `T` that minimises `Σ wᵢ |T xᵢ − qᵢ|²` over pairs `(x, q, w)`, in closed form by the unit quaternion of the
/// largest eigenvalue (Horn, *Closed-form solution of absolute orientation using unit quaternions*, 1987).
///
/// Where the pairs leave the motion open (points on one line), one of the best motions is returned.
///
/// # Errors
/// [`Error::TooFewPoints`] without a pair of positive weight, [`Error::NotFinite`] for a pair that is not finite.
pub fn superpose<const D: usize>(
    pairs: &[(SVector<f64, D>, SVector<f64, D>, f64)],
) -> Result<Pose<D>, Error> {
    let is_finite = |(x, q, w): &(SVector<f64, D>, SVector<f64, D>, f64)| {
        x.iter().chain(q.iter()).chain([w]).all(|c| c.is_finite())
    };
    if let Some(index) = pairs.iter().position(|pair| !is_finite(pair)) {
        return Err(Error::NotFinite { index, count: pairs.iter().filter(|pair| !is_finite(pair)).count() });
    }
    let count = pairs.iter().filter(|pair| pair.2 > 0.0).count();
    let Some(&(x0, q0, _)) = pairs.iter().find(|pair| pair.2 > 0.0) else {
        return Err(Error::TooFewPoints { total: pairs.len(), finite: count, needed: 1 });
    };
    let heaviest = pairs.iter().map(|pair| pair.2).fold(0.0, f64::max);
    let weighted = || pairs.iter().map(|(x, q, w)| (x - x0, q - q0, w.max(0.0) / heaviest));
    let total: f64 = weighted().map(|(.., w)| w).sum();
    let source = weighted().map(|(x, _, w)| x * w).sum::<SVector<f64, D>>() / total;
    let target = weighted().map(|(_, q, w)| q * w).sum::<SVector<f64, D>>() / total;
    // Of unit size, so that products of coordinates neither vanish nor overflow.
    let size = weighted().map(|(x, q, _)| (x - source).amax().max((q - target).amax())).fold(0.0, f64::max);
    let scale = if size > 0.0 { size.recip() } else { 1.0 };
    let products: SMatrix<f64, D, D> = weighted()
        .map(|(x, q, w)| (x - source) * scale * ((q - target) * scale).transpose() * w)
        .fold(SMatrix::zeros(), |sum, product| sum + product);
    let pose = Pose::new(best_rotation(&products), SVector::zeros());
    Ok(Pose { source_origin: x0 + source, target_origin: q0 + target, ..pose })
}

/// The rotation `R` that maximises `Σ wᵢ ⟨R xᵢ, qᵢ⟩`, given `S = Σ wᵢ xᵢ qᵢᵀ`.
pub(crate) fn best_rotation<const D: usize>(s: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    if D == 2 {
        let angle = (s[(0, 1)] - s[(1, 0)]).atan2(s[(0, 0)] + s[(1, 1)]);
        return rotation::exponential::<D>(&Vector3::new(angle, 0.0, 0.0)).0;
    }
    let [xx, yy, zz] = [s[(0, 0)], s[(1, 1)], s[(2, 2)]];
    let [dx, dy, dz] = [s[(1, 2)] - s[(2, 1)], s[(2, 0)] - s[(0, 2)], s[(0, 1)] - s[(1, 0)]];
    let [sx, sy, sz] = [s[(1, 2)] + s[(2, 1)], s[(2, 0)] + s[(0, 2)], s[(0, 1)] + s[(1, 0)]];
    #[rustfmt::skip]
    let n = Matrix4::new(
        xx + yy + zz, dx,           dy,            dz,
        dx,           xx - yy - zz, sz,            sy,
        dy,           sz,           yy - xx - zz,  sx,
        dz,           sy,           sx,            zz - xx - yy,
    );
    let eigen = SymmetricEigen::new(n);
    let vector = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let quaternion = [vector[0], vector[1], vector[2], vector[3]];
    let rotation = rotation::from_quaternion(quaternion).unwrap_or_else(nalgebra::Matrix3::identity);
    SMatrix::from_fn(|i, j| rotation[(i, j)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, Vector3};

    #[test]
    fn motions_come_back_from_any_turn() {
        let points: Vec<Vector3<f64>> =
            (0..12).map(|i| Vector3::from_fn(|k, _| (1.7 * (3 * i + k) as f64).sin() * 5.0)).collect();
        for turn in [Vector3::new(3.1, 0.2, -0.1), Vector3::new(0.0, 0.0, 0.0), Vector3::new(-1.0, 2.0, 1.5)]
        {
            let motion = Pose::new(rotation::exponential::<3>(&turn).0, Vector3::new(1e3, -20.0, 7.0));
            let pairs: Vec<_> = points.iter().map(|x| (*x, motion.apply(x), 1.0)).collect();
            let found = superpose(&pairs).unwrap();
            assert!(pairs.iter().all(|(x, q, _)| (found.apply(x) - q).norm() < 1e-12 * 1e3));
        }
    }

    #[test]
    fn turns_in_the_plane_come_back() {
        let motion = Pose::new(rotation::exponential::<2>(&(Vector3::x() * 2.9)).0, Vector2::new(3.0, 4.0));
        let points = [[0.0, 0.0], [2.0, 0.1], [-1.0, 3.0]].map(Vector2::from);
        let found = superpose(&points.map(|x| (x, motion.apply(&x), 1.0))).unwrap();
        assert!((found.rotation - motion.rotation).norm() < 1e-14, "{found:?}");
    }

    #[test]
    fn a_pair_of_weight_zero_does_not_count() {
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let pairs = [(x, x, 1.0), (y, y, 1.0), (z, z, 1.0), (x + y, x * 100.0, 0.0)];
        let found = superpose(&pairs).unwrap();
        assert!((found.apply(&(x + z)) - (x + z)).norm() < 1e-14);
        assert_eq!(superpose(&pairs[3..]), Err(Error::TooFewPoints { total: 1, finite: 0, needed: 1 }));
        let bad = [(x, x * f64::NAN, 1.0)];
        assert_eq!(superpose(&bad), Err(Error::NotFinite { index: 0, count: 1 }));
    }
}
