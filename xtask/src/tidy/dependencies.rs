//! The direction in which crates may depend on each other, and which crate may use which heavy dependency.

use super::finding::Finding;
use crate::workspace::{File, Package};

/// For every crate the workspace crates it may name in its `Cargo.toml`, tests included. A crate that is not listed fails the check.
const ALLOWED: &[(&str, &[&str])] = &[
    ("lanes", &[]),
    ("nurbs-core", &[]),
    ("mesh-core", &["lanes"]),
    ("pc-io", &["nurbs-core", "mesh-core"]),
    ("footpoint", &["lanes", "nurbs-core", "mesh-core"]),
    ("brep-core", &["lanes", "nurbs-core", "footpoint"]),
    ("cad-io", &["nurbs-core", "brep-core"]),
    ("distance-field", &["lanes", "nurbs-core", "mesh-core", "footpoint", "brep-core"]),
    ("sdm-core", &["distance-field"]),
    (
        "sdm-fit",
        &["sdm-core", "lanes", "nurbs-core", "mesh-core", "footpoint", "brep-core", "distance-field"],
    ),
    (
        "sdm-register",
        &["sdm-core", "lanes", "nurbs-core", "mesh-core", "footpoint", "brep-core", "distance-field"],
    ),
    ("inspection", &["lanes", "nurbs-core", "mesh-core", "footpoint", "brep-core", "distance-field"]),
    ("cloud-param", &["lanes", "nurbs-core", "mesh-core", "footpoint", "sdm-fit"]),
    ("feature-metric", &["nurbs-core", "mesh-core", "distance-field"]),
    ("segmentation", &["lanes", "mesh-core"]),
    ("picture", &["lanes", "mesh-core"]),
    ("level-set", &["lanes", "nurbs-core", "mesh-core", "footpoint", "distance-field", "sdm-fit"]),
    (
        "industrial-geometry",
        &[
            "nurbs-core",
            "mesh-core",
            "pc-io",
            "cad-io",
            "footpoint",
            "brep-core",
            "distance-field",
            "sdm-fit",
            "sdm-register",
            "inspection",
            "cloud-param",
            "feature-metric",
            "segmentation",
            "level-set",
            "picture",
        ],
    ),
    ("indgeo", &["lanes", "industrial-geometry"]),
    ("indgeo-python", &["indgeo", "industrial-geometry"]),
    (
        "measurements",
        &[
            "nurbs-core",
            "mesh-core",
            "footpoint",
            "distance-field",
            "level-set",
            "sdm-fit",
            "sdm-register",
            "cloud-param",
            "industrial-geometry",
        ],
    ),
    ("fuzz-targets", &["footpoint", "pc-io", "cad-io"]),
    (
        "xtask",
        &[
            "nurbs-core",
            "mesh-core",
            "footpoint",
            "pc-io",
            "cad-io",
            "distance-field",
            "sdm-fit",
            "cloud-param",
            "sdm-register",
            "industrial-geometry",
        ],
    ),
];

/// Outside crates that only the named crates may use.
const RESERVED: &[(&str, &[&str])] = &[("clap", &["indgeo"]), ("indicatif", &["indgeo"]), ("anyhow", &[])];

/// Checks every dependency of every workspace package against the tables above.
pub(crate) fn check(packages: &[Package], files: &[File]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for package in packages {
        let Some((_, allowed)) = ALLOWED.iter().find(|(name, _)| *name == package.name) else {
            findings.push(Finding::error(
                &package.manifest,
                0,
                format!("`{}` has no place in the dependency table", package.name),
                "add a row to ALLOWED in xtask/src/tidy/dependencies.rs",
            ));
            continue;
        };
        for dependency in &package.dependencies {
            let line = line_of(files, &package.manifest, dependency);
            let inside = packages.iter().any(|other| other.name == *dependency);
            if inside && !allowed.contains(&dependency.as_str()) {
                let choice = if allowed.is_empty() { "none".to_owned() } else { allowed.join(", ") };
                findings.push(Finding::error(
                    &package.manifest,
                    line,
                    format!("`{}` must not depend on `{dependency}` (allowed: {choice})", package.name),
                    "move the code to the crate where it belongs",
                ));
            }
            let reserved = RESERVED.iter().find(|(name, _)| name == dependency);
            if let Some((_, users)) = reserved.filter(|(_, users)| !users.contains(&package.name.as_str())) {
                let choice = if users.is_empty() { "no crate".to_owned() } else { users.join(", ") };
                findings.push(Finding::error(
                    &package.manifest,
                    line,
                    format!("`{}` must not use `{dependency}` (reserved to {choice})", package.name),
                    "remove it",
                ));
            }
        }
    }
    findings
}

/// The line of a manifest that names `dependency`, 0 when there is none.
fn line_of(files: &[File], manifest: &str, dependency: &str) -> usize {
    let names_it = |line: &str| {
        line.trim_start().strip_prefix(dependency).is_some_and(|rest| rest.starts_with(['.', ' ', '=']))
    };
    let file = files.iter().find(|file| file.path == manifest);
    file.and_then(|file| file.numbered_lines().find(|(_, line)| names_it(line)))
        .map_or(0, |(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, dependencies: &[&str]) -> Package {
        Package {
            name: name.into(),
            description: "Something.".into(),
            manifest: format!("crates/{name}/Cargo.toml"),
            dependencies: dependencies.iter().map(|&name| name.into()).collect(),
        }
    }

    #[test]
    fn the_right_direction_passes() {
        let packages = [
            package("nurbs-core", &["nalgebra"]),
            package("footpoint", &["nurbs-core", "rayon"]),
            package("indgeo", &["clap"]),
        ];
        assert!(check(&packages, &[]).is_empty());
    }

    #[test]
    fn the_wrong_direction_fails_at_its_line() {
        let packages = [package("nurbs-core", &["footpoint"]), package("footpoint", &[])];
        let manifest = File::in_memory(
            "crates/nurbs-core/Cargo.toml",
            "[dependencies]\nfootpoint-x = \"1\"\nfootpoint.workspace = true\n",
        );
        let findings = check(&packages, &[manifest]);
        assert_eq!(findings.len(), 1);
        assert_eq!(findings[0].line, 3);
        assert!(
            findings[0].what.contains("must not depend on `footpoint` (allowed: none)"),
            "{}",
            findings[0]
        );
    }

    #[test]
    fn unknown_crates_and_reserved_dependencies_fail() {
        let findings = check(&[package("new-crate", &[]), package("pc-io", &["clap"])], &[]);
        assert!(findings[0].what.contains("no place"), "{}", findings[0]);
        assert!(findings[1].what.contains("reserved to indgeo"), "{}", findings[1]);
    }

    #[test]
    fn the_table_itself_has_no_cycle() {
        let direct =
            |name: &str| ALLOWED.iter().find(|(row, _)| *row == name).map_or(&[][..], |(_, names)| names);
        for (start, _) in ALLOWED {
            let mut reached: Vec<&str> = direct(start).to_vec();
            let mut next = 0;
            while next < reached.len() {
                for name in direct(reached[next]) {
                    if !reached.contains(name) {
                        reached.push(name);
                    }
                }
                next += 1;
            }
            assert!(!reached.contains(start), "{start} depends on itself");
        }
    }
}
