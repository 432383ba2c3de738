//! `cargo xtask paper-figures`: the figures of \[MPK\] and \[P05\], of data of our own, as drawings in `docs/figures`.

mod distances;
mod drawing;
mod fitting;
mod metric;
mod registered;
mod ruled;
mod shading;
mod surfaces;
mod turntable;
mod weights;

use crate::paper_tables::directed::{bolt, vase};
use crate::{Failure, workspace};

/// Where the drawings go, from the workspace root.
const FOLDER: &str = "docs/figures";

/// Runs the command.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    if let Some(argument) = arguments.first() {
        return Err(Failure::Usage(format!("`{argument}` is not understood")));
    }
    let failed = |error: Box<dyn std::error::Error>| Failure::Failed(error.to_string());
    let (vase, bolt) = (vase(), bolt().map_err(failed)?);
    let drawings = [
        ("views.svg", turntable::views(&vase).map_err(failed)?),
        ("layers.svg", turntable::layers(&vase).map_err(failed)?),
        (
            "vase.svg",
            surfaces::steps("Lobed vase, 16,000 points with noise", &vase, [30, 30]).map_err(failed)?,
        ),
        ("bolt.svg", surfaces::steps("Stud bolt, scan of 8,565 points", &bolt, [30, 60]).map_err(failed)?),
        ("fit-step.svg", fitting::step().map_err(failed)?),
        ("fit-armijo.svg", fitting::armijo().map_err(failed)?),
        ("fit-evolution.svg", fitting::evolution().map_err(failed)?),
        ("fit-rectangle.svg", fitting::rectangle().map_err(failed)?),
        ("fit-noisy.svg", fitting::noisy().map_err(failed)?),
        ("obstacles.svg", distances::obstacles().map_err(failed)?),
        ("approximant.svg", distances::approximant().map_err(failed)?),
        ("ruled.svg", ruled::one().map_err(failed)?),
        ("ruled-layers.svg", ruled::layers(&vase).map_err(failed)?),
        ("registration.svg", registered::cloud().map_err(failed)?),
        ("geodesic-circles.svg", metric::circles().map_err(failed)?),
        ("geodesic-curves.svg", metric::curves().map_err(failed)?),
        ("feature-parameters.svg", metric::parameters().map_err(failed)?),
        ("dilation.svg", metric::dilation().map_err(failed)?),
        ("weights.svg", weights::one_projection(&vase).map_err(failed)?),
    ];
    let folder = workspace::root().join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(|e| Failure::Failed(format!("{FOLDER}: {e}")))?;
    for (name, text) in drawings {
        std::fs::write(folder.join(name), &text)
            .map_err(|e| Failure::Failed(format!("{FOLDER}/{name}: {e}")))?;
        println!("{FOLDER}/{name}: {} kB", text.len() / 1000);
    }
    Ok(())
}
