//! Options of a segmentation.

use crate::Error;

/// How a cloud is segmented. The defaults hold for all parts: lengths are measured in the noise and the spacing of the cloud itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentationOptions {
    /// Standard deviation of the noise along the normal, a length; `None` (the default) finds it from the residuals of local quadrics.
    pub sigma: Option<f64>,
    /// Fewest points of a region, at least 8; default 10.
    pub min_points: usize,
}

impl Default for SegmentationOptions {
    fn default() -> Self {
        Self { sigma: None, min_points: 10 }
    }
}

impl SegmentationOptions {
    /// The same options with a known noise.
    #[must_use]
    pub fn with_sigma(self, sigma: Option<f64>) -> Self {
        Self { sigma, ..self }
    }

    /// The same options with another least number of points of a region.
    #[must_use]
    pub fn with_min_points(self, min_points: usize) -> Self {
        Self { min_points, ..self }
    }

    /// Checks every number.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if let Some(sigma) = self.sigma.filter(|s| !(*s > 0.0 && s.is_finite())) {
            return Err(Error::Option { name: "sigma", value: sigma, allowed: "a positive length" });
        }
        if self.min_points < 8 {
            let value = self.min_points as f64;
            return Err(Error::Option { name: "min_points", value, allowed: "at least 8" });
        }
        Ok(())
    }
}
