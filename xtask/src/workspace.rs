//! The files and the packages of the workspace.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// One file, named by its path from the workspace root with `/` between the parts.
#[derive(Clone, Debug)]
pub(crate) struct File {
    pub(crate) path: String,
    /// Size in bytes.
    pub(crate) size: u64,
    /// The contents, read only for files that are text of ours (see [`is_our_text`]).
    pub(crate) text: Option<String>,
}

impl File {
    /// A text file held in memory.
    #[cfg(test)]
    pub(crate) fn in_memory(path: &str, text: &str) -> Self {
        Self { path: path.into(), size: text.len() as u64, text: Some(text.into()) }
    }

    /// The lines with their numbers from 1; nothing for files that are not text of ours.
    pub(crate) fn numbered_lines(&self) -> impl Iterator<Item = (usize, &str)> {
        self.text.iter().flat_map(|text| text.lines()).enumerate().map(|(index, line)| (index + 1, line))
    }

    pub(crate) fn has_extension(&self, extension: &str) -> bool {
        Path::new(&self.path).extension().is_some_and(|found| found == extension)
    }
}

/// One package of the workspace as `cargo metadata` tells it.
#[derive(Clone, Debug)]
pub(crate) struct Package {
    pub(crate) name: String,
    pub(crate) description: String,
    /// Path of its `Cargo.toml` from the workspace root.
    pub(crate) manifest: String,
    /// Names of all direct dependencies of any kind, without itself, which tests name to turn features on.
    pub(crate) dependencies: Vec<String>,
}

impl Package {
    /// The package's folder from the workspace root.
    pub(crate) fn folder(&self) -> &str {
        self.manifest.strip_suffix("/Cargo.toml").unwrap_or("")
    }
}

/// The workspace root: the parent of this crate's folder.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

/// All files below `root` except build output and version control, ordered by path.
pub(crate) fn files(root: &Path) -> Result<Vec<File>, String> {
    let mut found = Vec::new();
    collect(root, root, &mut found)?;
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

fn collect(root: &Path, folder: &Path, found: &mut Vec<File>) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let path = entry.path();
        let relative = relative(root, &path);
        let kind = entry.file_type().map_err(failed)?;
        if kind.is_dir() {
            if !is_left_out(&relative) {
                collect(root, &path, found)?;
            }
        } else {
            let size = entry.metadata().map_err(failed)?.len();
            let text = if is_our_text(&relative) {
                Some(fs::read_to_string(&path).map_err(|error| format!("{relative}: {error}"))?)
            } else {
                None
            };
            found.push(File { path: relative, size, text });
        }
    }
    Ok(())
}

/// Folders that hold nothing of ours: build output, version control, fuzzing leftovers (the list of `.gitignore`).
fn is_left_out(folder: &str) -> bool {
    let name = folder.rsplit('/').next().unwrap_or(folder);
    name == "target" || name == ".git" || matches!(folder, "fuzz/corpus" | "fuzz/artifacts")
}

/// Whether the project wrote this file as text. Fixtures are data, even where they look like text, and `docs/katex` is not ours.
fn is_our_text(path: &str) -> bool {
    if path.starts_with("docs/katex/") {
        return false;
    }
    if path.starts_with("fixtures/") {
        return path == "fixtures/PROVENANCE.md";
    }
    let extension = Path::new(path).extension().and_then(|extension| extension.to_str());
    path == ".ci/run" || matches!(extension, Some("rs" | "md" | "toml" | "sh" | "py" | "snap" | "yml"))
}

fn relative(root: &Path, path: &Path) -> String {
    let parts = path.strip_prefix(root).unwrap_or(path).components();
    parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// The packages of the workspace at `root`, ordered by name, from `cargo metadata` (needs no network).
pub(crate) fn packages(root: &Path) -> Result<Vec<Package>, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--no-deps", "--format-version", "1", "--locked"])
        .current_dir(root)
        .output()
        .map_err(|error| format!("cargo metadata did not start: {error}"))?;
    if !output.status.success() {
        return Err(format!("cargo metadata failed: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    let metadata = serde_json::from_slice(&output.stdout)
        .map_err(|error| format!("cargo metadata printed something that is not JSON: {error}"))?;
    Ok(read_packages(&metadata, root))
}

fn read_packages(metadata: &serde_json::Value, root: &Path) -> Vec<Package> {
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let empty = Vec::new();
    let mut packages: Vec<Package> = metadata["packages"]
        .as_array()
        .unwrap_or(&empty)
        .iter()
        .map(|package| Package {
            name: text(&package["name"]),
            description: text(&package["description"]),
            manifest: relative(root, Path::new(&text(&package["manifest_path"]))),
            dependencies: package["dependencies"]
                .as_array()
                .unwrap_or(&empty)
                .iter()
                .map(|dependency| text(&dependency["name"]))
                .filter(|name| *name != text(&package["name"]))
                .collect(),
        })
        .collect();
    packages.sort_by(|a, b| a.name.cmp(&b.name));
    packages
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_read_from_metadata() {
        let metadata = serde_json::json!({ "packages": [
            { "name": "b", "description": null, "manifest_path": "/r/crates/b/Cargo.toml", "dependencies": [{ "name": "a" }, { "name": "b" }] },
            { "name": "a", "description": "First.", "manifest_path": "/r/crates/a/Cargo.toml", "dependencies": [] },
        ]});
        let packages = read_packages(&metadata, Path::new("/r"));
        assert_eq!(packages[0].name, "a");
        assert_eq!(packages[0].folder(), "crates/a");
        assert_eq!(packages[1].description, "");
        assert_eq!(packages[1].dependencies, ["a"]);
    }

    #[test]
    fn this_very_file_is_found_and_build_output_is_not() {
        let files = files(&root()).unwrap();
        assert!(files.iter().any(|file| file.path == "xtask/src/workspace.rs" && file.text.is_some()));
        assert!(!files.iter().any(|file| file.path.starts_with("target/") || file.path.starts_with(".git/")));
    }
}
