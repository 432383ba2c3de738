//! `cargo xtask measure`: runs the programs that measure the goals of the project and writes `docs/measurements.md`.
//!
//! What each program prints is quoted as it is, below the command that prints it. Numbers of time depend on the machine, so that
//! this document is written on demand and not compared by anything.

use crate::{Failure, workspace};
use std::fmt::Write as _;
use std::process::Command;

/// Where the report goes, from the workspace root.
const REPORT: &str = "docs/measurements.md";

/// One program to run: what it is about, and how it is called.
struct Measurement {
    /// For `cargo xtask measure NAME`.
    name: &'static str,
    title: &'static str,
    about: &'static str,
    program: &'static str,
    arguments: &'static [&'static str],
    /// Whether one thread is to do the work, where CPU time is measured.
    one_thread: bool,
}

/// Programs that run `indgeo`, which has to be built before.
const RUN_INDGEO: &[&str] = &["thin_parts", "two_sided_surfaces"];

/// All measurements, in the order of the report.
const MEASUREMENTS: &[Measurement] = &[
    Measurement {
        name: "projection",
        title: "Certified projection",
        about: "Nine kinds of shape, six sets of queries each, against closed forms or refined dense samples. Wanted: no wrong \
                answer; curves below 1 us, surfaces below 5 us (10 us on 50 x 50 control points) on a processor that takes 20 to 25 ns for a \
                jet, that is 40 and 200 (400) jets; no query above 1 ms.",
        program: "kinds",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "projection-constructed",
        title: "Certified projection of constructed shapes",
        about: "Steep patches, high degrees, unequal weights, creases, collapsed edges, floating knots, large and small scales, shapes \
                with axes and centres; queries on them, near, far and where they focus, against dense samples that are refined, and against \
                the fast mode. Wanted: no wrong answer, no open certificate, no query above 1 ms.",
        program: "constructed",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "registration",
        title: "Registration from many starts",
        about: "All starts of the cases in `fixtures/register-cases`, up to 60 degrees away; errors against the certified optimum, \
                or that of the inliers alone, as shares of the diameter.",
        program: "register_cases",
        arguments: &[
            "fixtures/register-cases/cad_zero",
            "fixtures/register-cases/cad_noise1e-3",
            "fixtures/register-cases/cad_offset_pos",
            "fixtures/register-cases/cad_warp_in",
            "fixtures/register-cases/cad_out20",
        ],
        one_thread: true,
    },
    Measurement {
        name: "registration-time",
        title: "Time of registrations",
        about: "CPU seconds of field and registration, against the goals of the project.",
        program: "cpu_goals",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "registration-robust",
        title: "Registration with outliers and missing parts",
        about: "Default settings, 104 starts of 5 to 60 degrees each.",
        program: "robust_cases",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "registration-verdicts",
        title: "Verdicts on registrations of thin parts",
        about: "Plates, shells, brackets and blades of 0.3 to 3 % of their size, scanned from one side, from starts 90 to 180 degrees off; and badly \
                made ones, near and from anywhere. Wanted: no wrong pose with exit status 0, and no doubt of a badly made part in its place.",
        program: "thin_parts",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "start",
        title: "Registration without a start",
        about: "From random positions, by all methods: how often the first candidate, and any, leads to the true pose.",
        program: "coarse_start",
        arguments: &[],
        one_thread: false,
    },
    Measurement {
        name: "registration-features",
        title: "Registration after matching by position and normal",
        about: "From random starts of 15 to 180 degrees: by nearest points alone, and after matching in R6 (`register --feature-weight`) with \
                several lengths of the normal; 600 points with noise of a thousandth of the diagonal.",
        program: "feature_matching",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "views",
        title: "Many views at once",
        about: "Six views of one body without common points. Wanted without noise: 5e-6 of the diameter.",
        program: "many_views",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "rivals",
        title: "Fits of curves: methods side by side",
        about: "From the same start, with the same control points, in one run: point, tangent and squared distance minimisation, and \
                control points and parameters together by L-BFGS.",
        program: "rivals",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "fitting",
        title: "Fits beside their goals",
        about: "Curves and surfaces by point, tangent and squared distance minimisation, which share all other code; distances to shapes \
                that are known, crossings, folds, seams, seconds per iteration, and quadratic convergence.",
        program: "fitting_goals",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "two-sided",
        title: "Fits of curves judged from both sides",
        about: "Waves, roses, limacons, spirals, outlines with corners, two outlines: random points in no order, noise of 0 to 1 % of the \
                diagonal, 0 to 5 % outliers, 150 and 600 points, by code that shares nothing with the fit. Wanted: curve and truth within \
                three spacings or standard deviations of each other everywhere in 99 % of the runs; no run that claims what is not so.",
        program: "two_sided_curves",
        arguments: &["2", "600"],
        one_thread: false,
    },
    Measurement {
        name: "two-sided-surfaces",
        title: "Fits of surfaces judged from both sides",
        about: "Height fields, a roof, discs, L-shapes, triangles, tubes, cones, domes: random points in no order, noise of 0 to 1 % of the \
                diagonal, 0 to 5 % outliers, 500 and 2000 points, fitted by the program itself and judged by code that shares nothing with \
                it. Wanted: surface and truth within three spacings or standard deviations of each other everywhere in 99 % of the runs; no \
                run that ends with 0 and is wrong.",
        program: "two_sided_surfaces",
        arguments: &["2", "2000"],
        one_thread: false,
    },
    Measurement {
        name: "primitives",
        title: "Primitives against a minimiser with many starts",
        about: "Pieces of 10 to 360 degrees in both directions, noise up to a hundredth of the radius, up to 45 % outliers, clouds that \
                leave a shape open. Wanted: no fit that says converged above the lowest known root mean square by more than a part in 1e9.",
        program: "primitive_fits",
        arguments: &["2"],
        one_thread: true,
    },
    Measurement {
        name: "real-fits",
        title: "Fits of real data",
        about: "Sections of an airfoil and of a scanned blade, the outline of a horse in an image, a side of the blade: as the data ask for, and \
                to a tolerance. Wanted: closed curves that do not cross themselves, and the tolerance.",
        program: "real_fits",
        arguments: &[],
        one_thread: false,
    },
    Measurement {
        name: "surfaces",
        title: "Large fits of surfaces",
        about: "From a cloud without parameters to the surface, on all threads. Wanted on two cores: 64,000 points and 55 x 55 control \
                points in 3 s; a million points and 100 x 100 control points in 60 s and 4 GB.",
        program: "large_surfaces",
        arguments: &[],
        one_thread: false,
    },
    Measurement {
        name: "clouds",
        title: "Clouds without parameters: time",
        about: "On one thread. Wanted: a height field of a million points in 1 s, hidden points of a million in 4 s, a cost per point of \
                the whole way that does not grow.",
        program: "scaling",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "scans",
        title: "Clouds without parameters to surfaces",
        about: "From the cloud alone, with nets of the sizes of [MPK, Figs. 7-9] for clouds of that kind. Wanted: no loops, no crossovers and no \
                folds, the finish below the least squares surface, at most .11 for the trunk of the bunny; 64,000 points in 10 s. The \
                blade stands on its platform, which no surface around its axis follows: its base surface is no success, and said so.",
        program: "scans",
        arguments: &[],
        one_thread: false,
    },
    Measurement {
        name: "hidden-points",
        title: "Hidden points against rays",
        about: "On samples of a mesh, seen from three directions and three places; the default is Automatic(0.72). Wanted: at 35,000 and \
                1,000,000 points at most 2 % falsely visible and 2 % falsely hidden.",
        program: "visibility",
        arguments: &["fixtures/mesh/bunny.obj"],
        one_thread: false,
    },
    Measurement {
        name: "inspection-memory",
        title: "Memory of an inspection",
        about: "The largest resident memory of `indgeo inspect` on ten million generated points, in binary PLY with three doubles a point and in \
                LAS, which are read in pieces; the points that the report accounts for are all. Wanted: at most 500 MB, also for a hundred \
                million points.",
        program: "inspection_memory",
        arguments: &["10000000"],
        one_thread: false,
    },
    Measurement {
        name: "contours",
        title: "Level sets",
        about: "Contours of grids and images as B-splines, distances from level functions, adaptively sampled distances, against closed \
                forms. Wanted: 36 control points within 1e-4 of the size of a star, within 0.05 pixel in an image; distances of order 3.5 \
                or more; a tenth of the leaves of trilinear ones.",
        program: "contours",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "fields",
        title: "Distances on grids and on meshes",
        about: "Errors and orders of distances on grids, time of each method, obstacles, signs, geodesic distances and closed forms of the \
                feature sensitive metric. Wanted: marching of its order, Tsai's sweeping exact for one source, redistancing of order 3.5 or \
                more in 1.5 us per node, obstacles without a wrong node in 7 times the time of sweeping; signed distances of a mesh in 1.1 us \
                per node without a wrong sign; geodesic distances in .45 us per vertex, exact ones in 20.",
        program: "fields",
        arguments: &[],
        one_thread: true,
    },
    Measurement {
        name: "cad",
        title: "Trimmed faces of CAD files",
        about: "Counts of faces, largest edge tolerances, areas of every face, distances and sides of points against tables that were made \
                with OpenCASCADE and an independent search (`fixtures/cad`); folders with more files and tables can be given. Wanted: no \
                wrong distance, side or area; .3 ms a point, 1 ms on the screw.",
        program: "trimmed_faces",
        arguments: &["fixtures/cad"],
        one_thread: true,
    },
    Measurement {
        name: "subdivision",
        title: "Fits of Loop subdivision surfaces",
        about: "A body from a coarse control mesh: point, tangent and squared distance minimisation, distances after each iteration as \
                shares of the diagonal.",
        program: "subdivision_cases",
        arguments: &[],
        one_thread: true,
    },
];

/// Runs the command.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let chosen =
        |measurement: &&Measurement| arguments.is_empty() || arguments.iter().any(|a| a == measurement.name);
    if let Some(unknown) = arguments.iter().find(|a| MEASUREMENTS.iter().all(|m| m.name != a.as_str())) {
        let names: Vec<&str> = MEASUREMENTS.iter().map(|m| m.name).collect();
        return Err(Failure::Usage(format!(
            "measure does not know `{unknown}`; there are {}",
            names.join(", ")
        )));
    }
    let path = workspace::root().join(REPORT);
    let old = std::fs::read_to_string(&path).unwrap_or_default();
    let mut text = String::from(
        "# Measurements\n\nWritten by `cargo xtask measure`: the output of the programs that measure the goals of the project, on \
         the machine on which it was run last. Ratios of one run can be compared, times of different runs cannot.\n",
    );
    let mut unmet = Vec::new();
    for measurement in MEASUREMENTS {
        if chosen(&measurement) {
            println!("{}: {}", measurement.name, measurement.command_line());
            let (output, met) = measurement.output()?;
            text.push_str(&section(measurement, &output));
            if !met {
                unmet.push(measurement.name);
            }
        } else if let Some(kept) = section_of(&old, measurement.title) {
            // Measurements that are not asked for stay as they are.
            text.push_str(kept);
        }
    }
    for title in old.lines().filter_map(|line| line.strip_prefix("## ")) {
        // What is measured by hand, with its command, stays at the end.
        if MEASUREMENTS.iter().all(|measurement| measurement.title != title) {
            text.push_str(section_of(&old, title).unwrap_or_default());
        }
    }
    std::fs::write(&path, text)
        .map_err(|error| Failure::Failed(format!("{REPORT} cannot be written: {error}")))?;
    println!("written to {REPORT}");
    if unmet.is_empty() {
        return Ok(());
    }
    Err(Failure::Failed(format!("{REPORT} says what did not hold: {}", unmet.join(", "))))
}

impl Measurement {
    fn cargo_arguments(&self) -> Vec<&str> {
        let mut all = vec!["run", "--release", "--quiet", "--package", "measurements", "--bin", self.program];
        if !self.arguments.is_empty() {
            all.push("--");
            all.extend(self.arguments);
        }
        all
    }

    fn command_line(&self) -> String {
        let threads = if self.one_thread { "RAYON_NUM_THREADS=1 " } else { "" };
        format!("{threads}cargo {}", self.cargo_arguments().join(" "))
    }

    /// What the program prints, and whether all that it measures is as it must be.
    fn output(&self) -> Result<(String, bool), Failure> {
        let cargo = || {
            let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
            command.current_dir(workspace::root());
            command
        };
        if RUN_INDGEO.contains(&self.program) {
            let built = cargo().args(["build", "--release", "--quiet", "--bin", "indgeo"]).status();
            if !built.is_ok_and(|status| status.success()) {
                return Err(Failure::Failed("`cargo build --release --bin indgeo` failed".to_owned()));
            }
        }
        let mut command = cargo();
        command.args(self.cargo_arguments());
        if self.one_thread {
            command.env("RAYON_NUM_THREADS", "1");
        }
        let failed = |what: &str| Failure::Failed(format!("`{}` {what}", self.command_line()));
        let output = command.output().map_err(|error| failed(&format!("did not start: {error}")))?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        // Programs that count wrong results print all of them and end with 1.
        let met = output.status.success();
        if !met && (output.status.code() != Some(1) || text.trim().is_empty()) {
            return Err(failed(&format!("failed: {}", String::from_utf8_lossy(&output.stderr).trim())));
        }
        Ok((text, met))
    }
}

fn section(measurement: &Measurement, output: &str) -> String {
    let mut text = format!("\n## {}\n\n{}\n\n", measurement.title, measurement.about);
    let _ = write!(text, "```text\n$ {}\n", measurement.command_line());
    for line in output.trim_end().lines() {
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text.push_str("```\n");
    text
}

/// The section with this title, from the empty line before it to the next.
fn section_of<'a>(text: &'a str, title: &str) -> Option<&'a str> {
    let start = text.find(&format!("\n## {title}\n"))?;
    let end = text[start + 1..].find("\n## ").map_or(text.len(), |next| start + 1 + next);
    Some(&text[start..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_are_found_again() {
        let text: String =
            MEASUREMENTS.iter().map(|measurement| section(measurement, "a line  \nanother\n")).collect();
        for measurement in MEASUREMENTS {
            let found = section_of(&text, measurement.title);
            assert_eq!(found, Some(section(measurement, "a line\nanother").as_str()));
        }
        assert_eq!(section_of(&text, "Nothing"), None);
    }

    #[test]
    fn names_are_different_and_unknown_ones_refused() {
        for (i, measurement) in MEASUREMENTS.iter().enumerate() {
            assert!(
                MEASUREMENTS[..i].iter().all(|m| m.name != measurement.name && m.title != measurement.title)
            );
        }
        assert!(matches!(run(&["nonsense".to_owned()]), Err(Failure::Usage(_))));
    }
}
