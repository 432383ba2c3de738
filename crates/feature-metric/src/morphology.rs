//! Morphology of regions on meshes by geodesic balls (\[P05, sec. 6\]).

use crate::{Error, MetricMesh};

/// What is done to a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// All vertices within the radius of the region.
    Dilate,
    /// All vertices farther than the radius from everything outside of the region.
    Erode,
    /// Erosion, then dilation: what is thinner than the ball goes.
    Open,
    /// Dilation, then erosion: holes and gaps narrower than the ball go.
    Close,
}

impl MetricMesh {
    /// The region, by one flag per vertex, after an operation with balls of this radius. In the feature sensitive metric a ball
    /// hardly crosses features, and so do not the regions.
    ///
    /// # Errors
    /// [`Error::Labels`] unless there is one flag per vertex; [`Error::Option`] for a radius that is negative or not finite.
    pub fn morphology(&self, region: &[bool], operation: Operation, radius: f64) -> Result<Vec<bool>, Error> {
        if region.len() != self.vertex_count() {
            return Err(Error::Labels { found: region.len(), expected: self.vertex_count() });
        }
        if !(radius.is_finite() && radius >= 0.0) {
            return Err(Error::Option {
                name: "radius",
                value: radius,
                allowed: "a length that is not negative",
            });
        }
        match operation {
            Operation::Dilate => self.dilated(region, radius),
            Operation::Erode => self.eroded(region, radius),
            Operation::Open => self.dilated(&self.eroded(region, radius)?, radius),
            Operation::Close => self.eroded(&self.dilated(region, radius)?, radius),
        }
    }

    fn dilated(&self, region: &[bool], radius: f64) -> Result<Vec<bool>, Error> {
        let sources: Vec<usize> =
            (0..region.len()).filter(|&v| region[v] && self.places(v).is_ok()).collect();
        if sources.is_empty() {
            return Ok(region.to_vec());
        }
        let distances = self.distances_from_region(&sources)?;
        Ok(region.iter().zip(&distances.values).map(|(inside, d)| *inside || *d <= radius).collect())
    }

    fn eroded(&self, region: &[bool], radius: f64) -> Result<Vec<bool>, Error> {
        let outside: Vec<bool> = region.iter().map(|inside| !inside).collect();
        Ok(self.dilated(&outside, radius)?.into_iter().map(|outside| !outside).collect())
    }
}
