//! Options of the search for footpoints.

use crate::commands::numbers;
use crate::error::Error;
use clap::ValueEnum;
use industrial_geometry::footpoint::{Mode, ProjectionOptions};

/// How footpoints are searched.
#[derive(Debug, clap::Args)]
pub(crate) struct Search {
    /// How hard to search
    #[arg(long, value_enum, default_value_t = SearchMode::Certified)]
    pub(crate) mode: SearchMode,
    /// Allowed gap between a distance and its proven lower bound, as a share of the distance
    #[arg(long, value_name = "GAP", default_value_t = 1e-7, value_parser = numbers::signed)]
    pub(crate) relative_gap: f64,
    /// Leave out points with a coordinate that is NaN or infinite; by default they keep their row, with the status
    /// `invalid_point` and no values, so that row i of the result belongs to point i
    #[arg(long)]
    pub(crate) drop_non_finite: bool,
    /// The scan to read of a file of several (E57, PTX): its name, its number from 0 on, or `all`, which moves them by their poses
    /// and puts them together
    #[arg(long, value_name = "SCAN", default_value = "all")]
    pub(crate) scan: String,
}

/// How hard to search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SearchMode {
    /// Global search with a proof that no point is nearer
    Certified,
    /// Local iterations from the most promising pieces; no proof, and no lower bound
    Fast,
    /// One local iteration from the nearest of a few samples: a local foot only, wrong where the model comes near the point
    /// twice; no proof, and no lower bound; for points close to the model
    Local,
}

impl Search {
    /// The options of the library, checked.
    pub(crate) fn options(&self) -> Result<ProjectionOptions, Error> {
        let mode = match self.mode {
            SearchMode::Certified => Mode::Certified,
            SearchMode::Fast => Mode::Fast,
            SearchMode::Local => Mode::Local,
        };
        if !(1e-15..1.0).contains(&self.relative_gap) {
            let what =
                format!("--relative-gap is {}, it must be at least 1e-15 and below 1", self.relative_gap);
            return Err(Error::usage(what, "leave it out for 1e-7"));
        }
        Ok(ProjectionOptions::default().with_mode(mode).with_relative_gap(self.relative_gap))
    }
}

impl SearchMode {
    /// The name in the report.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Certified => "certified",
            Self::Fast => "fast",
            Self::Local => "local",
        }
    }
}
