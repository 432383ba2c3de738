//! No circle of files: inside a crate, files that use each other in a ring cannot be read one after the other.

use super::finding::Finding;
use crate::workspace::{File, Package};
use std::collections::{BTreeMap, BTreeSet};

/// Circles that stay, by crate and first file, each with its reason.
const ALLOWED: &[(&str, &str, &str)] = &[
    ("cad-io", "iges::conic", "a conic is a curve, and the curves are read by kind"),
    ("cad-io", "iges::directory", "an error of any layer names the entry of the directory"),
    ("cad-io", "iges::revolution", "a surface of revolution is a surface, and the surfaces are read by kind"),
    (
        "footpoint",
        "global::proof::hulls::tiles::build",
        "a tile that is too steep is built anew of lower degree",
    ),
    (
        "footpoint",
        "global::surface::cells",
        "the grid of patches is part of the geometry that it is made from",
    ),
    ("footpoint", "global::surface::landing_lanes", "the end of a walk is part of the walk"),
    (
        "indgeo",
        "commands::demo::job::alignment",
        "both parts of the demonstration write their files in one way",
    ),
    ("indgeo", "commands::fit_surface::conclusion", "a fit that is concluded may be begun anew"),
    ("indgeo", "commands::project::job", "the same job in one piece or in many"),
    ("pc-io", "shape", "names are written as they are read"),
    ("sdm-fit", "curve::parts", "a path through points may end in several parts"),
    ("sdm-fit", "primitive::flat", "the start of one kind is made of starts of others"),
    ("segmentation", "describe", "a region describes itself by what the segmentation found"),
];

/// Finds files of one crate that use each other in a circle. That a file uses what the `mod.rs` of its own folder holds does not count.
pub(crate) fn check(packages: &[Package], files: &[File]) -> Vec<Finding> {
    packages.iter().flat_map(|package| in_package(package, files)).collect()
}

fn in_package(package: &Package, files: &[File]) -> Vec<Finding> {
    let folder = format!("{}/src/", package.folder());
    let mut sources = BTreeMap::new();
    for file in files {
        let Some(inside) = file.path.strip_prefix(&folder).and_then(|path| path.strip_suffix(".rs")) else {
            continue;
        };
        let module = inside.strip_suffix("/mod").unwrap_or(inside).replace('/', "::");
        if inside != "lib" && inside != "main" && !inside.starts_with("bin/") {
            sources.insert(module, file);
        }
    }
    let names: BTreeSet<&str> = sources.keys().map(String::as_str).collect();
    let graph: BTreeMap<&str, BTreeSet<&str>> =
        sources.iter().map(|(module, file)| (module.as_str(), uses(module, file, &names))).collect();
    let reaches: BTreeMap<&str, BTreeSet<&str>> =
        names.iter().map(|module| (*module, reachable(module, &graph))).collect();
    let mut findings = Vec::new();
    let mut seen = BTreeSet::new();
    for module in &names {
        let circle: Vec<&str> =
            reaches[module].iter().copied().filter(|other| reaches[other].contains(module)).collect();
        if circle.len() < 2 || !seen.insert(circle.clone()) {
            continue;
        }
        let is_allowed =
            ALLOWED.iter().any(|(crate_name, first, _)| *crate_name == package.name && *first == circle[0]);
        if !is_allowed {
            findings.push(Finding::error(
                &sources[*module].path,
                0,
                format!("these files of {} use each other in a circle: {}", package.name, circle.join(", ")),
                "move what both sides need into a file below them",
            ));
        }
    }
    findings
}

/// All modules that a module leads to, itself included if it is in a circle.
fn reachable<'a>(from: &str, graph: &BTreeMap<&'a str, BTreeSet<&'a str>>) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    let mut left: Vec<&str> = graph[from].iter().copied().collect();
    while let Some(module) = left.pop() {
        if found.insert(module) {
            left.extend(graph[module].iter().copied());
        }
    }
    found
}

/// The modules that a file uses, without those that hold it.
fn uses<'a>(module: &str, file: &File, names: &BTreeSet<&'a str>) -> BTreeSet<&'a str> {
    let code = code_of(file);
    let mut found = BTreeSet::new();
    for path in paths(&code) {
        let mut segments: Vec<&str> = path.split("::").collect();
        let mut base: Vec<&str> = module.split("::").collect();
        match segments[0] {
            "crate" => base.clear(),
            "self" => {}
            _ => {
                let ups = segments.iter().take_while(|segment| **segment == "super").count();
                base.truncate(base.len().saturating_sub(ups));
                segments.drain(..ups - 1);
            }
        }
        base.extend(&segments[1..]);
        let target = (1..=base.len()).rev().find_map(|count| names.get(base[..count].join("::").as_str()));
        if let Some(target) = target.filter(|target| **target != module && !holds(target, module)) {
            found.insert(*target);
        }
    }
    found
}

/// Whether a module is a folder in which another one lies.
fn holds(folder: &str, module: &str) -> bool {
    module.strip_prefix(folder).is_some_and(|rest| rest.starts_with("::"))
}

/// The source without comments and tests, on one line.
fn code_of(file: &File) -> String {
    let mut code = String::new();
    for (_, line) in file.numbered_lines() {
        if line.starts_with("#[cfg(test)]") {
            break;
        }
        code.push_str(line.split("//").next().unwrap_or_default());
        code.push(' ');
    }
    code
}

/// All paths of a source that begin in its crate, those of grouped imports one by one.
fn paths(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for root in ["crate::", "super::", "self::"] {
        for (place, _) in code.match_indices(root) {
            let is_word = code[..place]
                .chars()
                .next_back()
                .is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':');
            if !is_word {
                expand(&code[place..], String::new(), &mut found);
            }
        }
    }
    found
}

/// The paths at the beginning of a text: one, or several in braces. Returns how much of the text they take.
fn expand(text: &str, mut prefix: String, found: &mut Vec<String>) -> usize {
    let mut at = 0;
    loop {
        let rest = &text[at..];
        if let Some(inner) = rest.strip_prefix('{') {
            at += 1;
            let mut place = 0;
            while !inner[place..].starts_with('}') && place < inner.len() {
                let skipped = inner[place..].len() - inner[place..].trim_start_matches([' ', ',']).len();
                place += skipped;
                if inner[place..].starts_with('}') || place >= inner.len() {
                    break;
                }
                let used = expand(&inner[place..], prefix.clone(), found);
                place += used;
                // What follows ` as `, and anything that is no path.
                place += inner[place..].find([',', '}', '{']).unwrap_or(inner[place..].len());
                if used == 0 && inner[place..].starts_with('{') {
                    place += 1;
                }
            }
            return at + place + 1;
        }
        let word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        if word == 0 {
            return at;
        }
        if !prefix.is_empty() {
            prefix.push_str("::");
        }
        prefix.push_str(&rest[..word]);
        at += word;
        match text[at..].strip_prefix("::") {
            Some(_) => at += 2,
            None => {
                found.push(prefix.trim_end_matches("::self").to_owned());
                return at;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package() -> Package {
        Package {
            name: "a".into(),
            description: String::new(),
            manifest: "crates/a/Cargo.toml".into(),
            dependencies: Vec::new(),
        }
    }

    #[test]
    fn circles_are_found_through_groups_and_folders() {
        let files = [
            File::in_memory("crates/a/src/lib.rs", "mod b; mod c;"),
            File::in_memory("crates/a/src/b.rs", "use crate::{c::{d::Deep, Other as Mine}, Top};"),
            File::in_memory("crates/a/src/c/mod.rs", "pub mod d;"),
            File::in_memory("crates/a/src/c/d.rs", "use super::Shared;\nfn f() { super::super::b::g() }"),
        ];
        let findings = check(&[package()], &files);
        assert_eq!(findings.len(), 1, "{findings:?}");
        assert!(findings[0].what.ends_with("b, c::d"), "{}", findings[0]);
    }

    #[test]
    fn comments_tests_and_own_folders_do_not_count() {
        let files = [
            File::in_memory("crates/a/src/b.rs", "use crate::c::X; // crate::b\n#[cfg(test)]\nmod tests {}"),
            File::in_memory(
                "crates/a/src/c/mod.rs",
                "mod d;\nuse d::Y;\n#[cfg(test)]\nmod tests { use crate::b; }",
            ),
            File::in_memory("crates/a/src/c/d.rs", "use super::X;"),
        ];
        assert!(check(&[package()], &files).is_empty());
    }
}
