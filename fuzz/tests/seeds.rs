//! Every seed of every target, by the function itself and, where they are built, by the targets with libFuzzer.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use fuzz_targets::TARGETS;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

/// Beyond this a seed counts as endless; the slowest takes a small fraction of it.
const PATIENCE: Duration = Duration::from_secs(60);

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds")
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn every_target_has_seeds_and_every_folder_a_target() {
    let folders: Vec<String> =
        files(&folder()).iter().map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    let names: Vec<&str> = TARGETS.iter().map(|(name, _)| *name).collect();
    assert_eq!(folders, names);
    for name in names {
        assert!(files(&folder().join(name)).len() >= 3, "{name} has too few seeds");
        let target = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("fuzz_targets/{name}.rs"));
        assert!(std::fs::read_to_string(target).unwrap().contains(&format!("fuzz_targets::{name}(data)")));
    }
}

#[test]
fn every_seed_passes_its_target() {
    for (name, target) in TARGETS {
        for path in files(&folder().join(name)) {
            let data = std::fs::read(&path).unwrap();
            let (done, finished) = mpsc::channel();
            let worker = std::thread::spawn(move || {
                target(&data);
                // Nobody waits any more when it comes too late.
                let _ = done.send(());
            });
            match finished.recv_timeout(PATIENCE) {
                Err(mpsc::RecvTimeoutError::Timeout) => {
                    panic!("{} takes more than {PATIENCE:?}", path.display())
                }
                _ => assert!(worker.join().is_ok(), "{} fails", path.display()),
            }
        }
    }
}

#[cfg(feature = "libfuzzer")]
#[test]
fn every_seed_passes_its_target_with_libfuzzer() {
    let programs = [
        env!("CARGO_BIN_EXE_fuzz_any"),
        env!("CARGO_BIN_EXE_fuzz_json"),
        env!("CARGO_BIN_EXE_fuzz_obj"),
        env!("CARGO_BIN_EXE_fuzz_off"),
        env!("CARGO_BIN_EXE_fuzz_pcd"),
        env!("CARGO_BIN_EXE_fuzz_ply"),
        env!("CARGO_BIN_EXE_fuzz_project"),
        env!("CARGO_BIN_EXE_fuzz_stl"),
        env!("CARGO_BIN_EXE_fuzz_xyz"),
    ];
    assert_eq!(programs.len(), TARGETS.len());
    for (program, (name, _)) in programs.into_iter().zip(TARGETS) {
        let seeds = files(&folder().join(name));
        let output = std::process::Command::new(program)
            .args(["-timeout=60", "-rss_limit_mb=1500"])
            .args(&seeds)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {text}");
        assert_eq!(text.matches("Executed ").count(), seeds.len(), "{name}: {text}");
    }
}
