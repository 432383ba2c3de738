//! The approach to a model by points matched with position and normal.

use crate::commands::register::model::RegistrationModel;
use crate::commands::register::request::{Cloud, Job};
use crate::error::Error;
use industrial_geometry::register::start::OrientedPoints;
use industrial_geometry::register::{Error as RegisterError, FeatureMatching, Pose};
use std::path::PathBuf;

/// What is matched.
pub(crate) struct Approach {
    matching: FeatureMatching,
    points: OrientedPoints,
    file: PathBuf,
}

impl Approach {
    /// `None` where it is not asked for.
    pub(crate) fn of(
        job: &Job<'_>,
        model: &RegistrationModel,
        cloud: &Cloud<'_>,
    ) -> Result<Option<Self>, Error> {
        let Some(width) = job.feature_weight else { return Ok(None) };
        if model.is_planar() || matches!(model, RegistrationModel::Curves(_)) {
            let what = "--feature-weight matches the normals of surfaces, and this model has none";
            return Err(Error::usage(what, "leave it out"));
        }
        let failed = |error| failed(error, job.points);
        let points = match cloud.normals {
            Some(normals) => OrientedPoints::new(&cloud.positions, normals),
            None => OrientedPoints::without_normals(&cloud.positions),
        };
        // The sides of normals count where both are known to point out of the material.
        let oriented = cloud.normals.is_some() && job.max_angle.is_some();
        let matching = FeatureMatching::new(&model.samples(job.model)?, width, oriented).map_err(failed)?;
        Ok(Some(Self { matching, points: points.map_err(failed)?, file: job.points.to_path_buf() }))
    }

    /// Where matching leads from a start.
    pub(crate) fn from(&self, start: &Pose<3>) -> Result<Pose<3>, Error> {
        let found = self.matching.approach(&self.points, start);
        Ok(found.map_err(|error| failed(error, &self.file))?.pose)
    }
}

fn failed(error: RegisterError, file: &std::path::Path) -> Error {
    match error {
        RegisterError::Option { value, allowed, .. } => {
            Error::option("feature_weight", value, allowed, "see `indgeo register --help`")
        }
        other => Error::content(file, other.to_string(), "check it with `indgeo info`"),
    }
}
