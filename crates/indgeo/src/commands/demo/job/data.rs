//! Where the data of the demonstration lie.

use crate::error::Error;
use std::path::{Path, PathBuf};

/// The files of the demonstration.
#[derive(Debug)]
pub(crate) struct Data {
    /// The scan.
    pub(crate) scan: PathBuf,
    /// The nominal model.
    pub(crate) model: PathBuf,
    /// Where the bolt lies in the scan.
    pub(crate) placement: PathBuf,
    /// The CAD part.
    #[cfg(feature = "step")]
    pub(crate) part: PathBuf,
}

const SCAN: &str = "scans/stud-bolt.ply";

impl Data {
    /// Looks in `fixtures` given, else below the working directory and its parents, else where the program was built.
    pub(crate) fn find(given: Option<&Path>) -> Result<Self, Error> {
        let mut places: Vec<PathBuf> = Vec::new();
        if let Some(given) = given {
            places.push(given.to_path_buf());
        } else {
            if let Ok(here) = std::env::current_dir() {
                places.extend(here.ancestors().map(|folder| folder.join("fixtures")));
            }
            // Of a program that was built from this repository.
            places.push(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures"));
        }
        let found = places.iter().find(|folder| folder.join(SCAN).is_file());
        let folder = found.ok_or_else(|| {
            let what = format!("the data of the demonstration ({SCAN}) are not in {}", places[0].display());
            Error::usage(
                what,
                "run this in a checkout of the repository, or name its folder with --data fixtures",
            )
        })?;
        Ok(Self {
            scan: folder.join(SCAN),
            model: folder.join("demo/stud-bolt-model.json"),
            placement: folder.join("demo/stud-bolt-placement.json"),
            #[cfg(feature = "step")]
            part: folder.join("cad/nema-17-bracket.step"),
        })
    }
}
