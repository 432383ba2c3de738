//! The positions beside a pose that a near symmetry of the model leads to, and what the points say about them.

use crate::commands::register::field::RegistrationField;
use crate::commands::register::near::Positions;
use crate::commands::register::request::{Cloud, Job};
use crate::commands::register::runs::{register_all, register_few};
use crate::commands::register::starts::is_same;
use crate::error::Error;
use crate::runtime::progress::Progress;
use industrial_geometry::register::start::OrientedPoints;
use industrial_geometry::register::{Comparison, Pose, RegisterOptions, RegisterReport};

/// Steps of a first look: where a turn is hardly fixed there would be many.
const MOST_STEPS: usize = 30;

/// A registration whose model may have near symmetries.
pub(crate) struct Beside<'a> {
    pub(crate) job: &'a Job<'a>,
    pub(crate) field: &'a RegistrationField,
    pub(crate) cloud: &'a Cloud<'a>,
    pub(crate) progress: &'a Progress,
    /// Points spread over the model.
    pub(crate) samples: &'a OrientedPoints,
    /// Motions that lay most of the model on itself.
    pub(crate) near: &'a [Pose<3>],
    /// Distance that counts as none.
    pub(crate) tolerance: f64,
}

impl Positions for Beside<'_> {
    fn beside(&self, pose: &Pose<3>) -> Vec<Pose<3>> {
        let turned = self.field.rivals(self.samples, &self.cloud.positions, pose);
        self.near.iter().map(|motion| pose.followed_by(motion)).chain(turned).collect()
    }

    fn score(&self, pose: &Pose<3>) -> f64 {
        self.field.compare(&self.cloud.positions, pose, self.job.options.scale).score
    }

    fn comparison(&self, poses: [&Pose<3>; 2]) -> Comparison {
        self.field.comparison(&self.cloud.positions, poses)
    }

    fn is_same(&self, one: &Pose<3>, other: &Pose<3>) -> bool {
        is_same(self.field, &self.cloud.positions, one, other)
    }

    fn are_equivalent(&self, one: &Pose<3>, other: &Pose<3>) -> bool {
        let motion = one.inverse().followed_by(other);
        self.field.is_symmetry(self.samples, &motion, self.tolerance)
    }

    fn few(&self, start: &Pose<3>) -> Result<RegisterReport<3>, Error> {
        let most = self.job.options.max_iterations.min(MOST_STEPS);
        let job = Job { options: RegisterOptions { max_iterations: most, ..self.job.options }, ..*self.job };
        register_few(&job, self.field, self.cloud, start, self.progress)
    }

    fn all(&self, start: &Pose<3>) -> Result<RegisterReport<3>, Error> {
        register_all(self.job, self.field, self.cloud, start, self.progress)
    }
}
