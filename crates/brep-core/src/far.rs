//! Points so far away that the distances of all points of a model are the same number.

use crate::foot::Foot;
use crate::model::Model;
use nalgebra::Vector3;

/// Distance, in sizes of the model, from which a point is taken nearer. The nearest point to the point taken nearer is at most 5e-11 sizes
/// farther than the nearest one, which is far less than a distance of that length is rounded by.
const FAR: f64 = 1e10;

impl Model {
    /// The point on the way to the middle of the model from which a point that is far away is answered; `None` for all others.
    pub(crate) fn nearer(&self, x: &Vector3<f64>) -> Option<Vector3<f64>> {
        let middle = self.bounds().centre();
        let (away, size) = (x - middle, self.bounds().diagonal());
        let largest = away.amax();
        (size > 0.0 && largest > FAR * size).then(|| middle + away / largest * (FAR * size))
    }
}

impl Foot {
    /// The foot of a point taken nearer as that of the point itself, with the same gap; `None` where the distance is no number.
    pub(crate) fn of_far(self, x: &Vector3<f64>) -> Option<Self> {
        let offset = x - self.point;
        // The squares of such offsets may be too large.
        let largest = offset.amax();
        let distance = (offset / largest).norm() * largest;
        let lower_bound = distance - self.gap();
        distance.is_finite().then_some(Self { distance, lower_bound, ..self })
    }
}
