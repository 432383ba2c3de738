//! Normals of meshes and clouds.

mod estimate;
mod mesh;
mod orient;
mod spanning_forest;
mod tangent_plane;

pub use estimate::{CloudNormals, NormalOptions, Orientation, estimate_normals};
pub use mesh::Normals;
pub use orient::{orient_consistently, orient_towards};

pub(crate) use estimate::GRAPH_DEGREE;
pub(crate) use orient::propagate;
pub(crate) use spanning_forest::links;
pub(crate) use tangent_plane::tangent_plane;

use nalgebra::Vector3;

/// The unit vector in the direction of `vector`; `None` where it has no direction or is not finite.
pub(crate) fn unit(vector: &Vector3<f64>) -> Option<Vector3<f64>> {
    let largest = vector.amax();
    if largest == 0.0 || !vector.iter().all(|value| value.is_finite()) {
        return None;
    }
    let scaled = vector / largest;
    Some(scaled / scaled.norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_survive_any_scale() {
        for scale in [1e-300, 1.0, 1e300] {
            let direction = unit(&(Vector3::new(3.0, 0.0, 4.0) * scale)).unwrap();
            assert!((direction - Vector3::new(0.6, 0.0, 0.8)).norm() < 1e-15);
        }
        for nothing in
            [Vector3::zeros(), Vector3::new(f64::NAN, 1.0, 0.0), Vector3::new(0.0, f64::INFINITY, 0.0)]
        {
            assert_eq!(unit(&nothing), None);
        }
    }
}
