//! The page of an inspection in a real browser: no error, a picture, and the numbers of the report.
//!
//! Uses Chromium, from the variable `CHROME` or from the path. Without one the test says so and passes, unless
//! `INDGEO_REQUIRE_BROWSER` is set, as `.ci/run` does.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::common::{Bench, fixture};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Looks at the page from inside, and leaves what it saw in the document.
const PROBE: &str = r##"<script>
addEventListener("load", () => setTimeout(() => {
  const seen = { ready: document.body.dataset.ready, errors: window.errors };
  const page = window.inspection;
  if (page) {
    const copy = document.createElement("canvas"), view = document.getElementById("view");
    page.drawNow();
    copy.width = 300; copy.height = 200;
    const context = copy.getContext("2d");
    context.drawImage(page.canvas, 0, 0, 300, 200);
    const pixels = context.getImageData(0, 0, 300, 200).data, colours = new Set();
    let filled = 0;
    for (let k = 0; k < pixels.length; k += 4) if (pixels[k + 3] > 0) { filled++; colours.add(pixels[k] >> 4 << 8 | pixels[k + 1] >> 4 << 4 | pixels[k + 2] >> 4); }
    Object.assign(seen, { filled, colours: colours.size, count: page.count });
    // Every hundredth point: what is picked where it is drawn lies as near, or it is hidden.
    let tried = 0, hit = 0;
    for (let i = 0; i < page.count; i += Math.ceil(page.count / 100)) {
      const [x, y] = page.project(i), found = page.pick(x, y);
      tried++;
      if (found >= 0) hit++;
      if (found === i) seen.described = page.describe(i), seen.picked = i;
    }
    Object.assign(seen, { tried, hit });
    document.querySelector("[data-worst]").click();
    page.drawNow();
    seen.ring = document.getElementById("ring").style.display;
    seen.wide = view.clientWidth;
  }
  seen.statistics = Object.fromEntries([...document.querySelectorAll("#statistics tr")].map((row) => [row.dataset.key, row.querySelector("[data-value]").dataset.value]));
  seen.worst = [...document.querySelectorAll("#worst tbody tr")].map((row) => row.querySelector("[data-value]").dataset.value);
  seen.bars = document.querySelectorAll("#histogram rect title").length;
  seen.asked = performance.getEntriesByType("resource").map((entry) => entry.name);
  const out = document.createElement("script");
  out.type = "application/json"; out.id = "seen"; out.textContent = JSON.stringify(seen).replaceAll("<", "\\u003c");
  document.body.append(out);
}, 300));
</script>"##;

const LISTEN: &str = r##"<script>
window.errors = [];
addEventListener("error", (event) => errors.push(String(event.message)));
addEventListener("securitypolicyviolation", (event) => errors.push("blocked: " + event.blockedURI));
for (const kind of ["error", "warn"]) { const old = console[kind]; console[kind] = (...texts) => { errors.push(kind + ": " + texts.join(" ")); old.apply(console, texts); }; }
</script>"##;

fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let path = std::env::var_os("PATH").unwrap_or_default();
    let on_path = std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name)));
    std::env::var_os("CHROME").map(PathBuf::from).into_iter().chain(on_path).find(|path| path.is_file())
}

fn dump(browser: &Path, page: &Path, profile: &Path) -> (String, String) {
    let mut command = Command::new(browser);
    command.args([
        "--headless",
        "--no-sandbox",
        "--disable-quic",
        "--no-first-run",
        "--disable-background-networking",
    ]);
    command.args([
        "--disable-component-update",
        "--disable-sync",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
    ]);
    command.args([
        "--window-size=1400,1000",
        "--virtual-time-budget=20000",
        "--enable-logging=stderr",
        "--timeout=60000",
    ]);
    command.arg(format!("--user-data-dir={}", profile.display())).arg("--dump-dom");
    let output = command.arg(format!("file://{}", page.display())).output().unwrap();
    (
        String::from_utf8_lossy(&output.stdout).into_owned(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

#[test]
fn the_page_works_and_shows_the_numbers_of_the_report() {
    let Some(browser) = browser() else {
        assert!(
            std::env::var_os("INDGEO_REQUIRE_BROWSER").is_none(),
            "no Chromium found; install it, or set CHROME"
        );
        eprintln!("skipped: no Chromium on this machine (install it, or name it in the variable CHROME)");
        return;
    };
    let bench = Bench::new();
    let (model, scan) = (fixture("demo/stud-bolt-model.json"), fixture("scans/stud-bolt.ply"));
    let run = bench.run(&format!(
        "inspect {model} {scan} -t 0.1 --drop-beyond-boundary --report page.html --json report.json"
    ));
    assert_eq!(run.code, 1, "{}", run.stderr);
    let page = bench.text("page.html");
    let probed = page.replacen("<meta name=\"generator\"", &format!("{LISTEN}<meta name=\"generator\""), 1);
    bench.put("probed.html", probed.replacen("</body>", &format!("{PROBE}</body>"), 1));
    let (document, log) = dump(&browser, &bench.path("probed.html"), &bench.path("profile"));

    let start = document.find("id=\"seen\">").unwrap_or_else(|| panic!("the page did not run: {log}")) + 10;
    let seen: Value =
        serde_json::from_str(&document[start..start + document[start..].find("</script>").unwrap()]).unwrap();
    assert_eq!(seen["ready"], "yes", "{seen} {log}");
    assert_eq!(seen["errors"], serde_json::json!([]), "{log}");
    assert_eq!(seen["asked"], serde_json::json!([]));
    assert!(!log.contains("CONSOLE") || !log.contains("Uncaught"), "{log}");
    let number = |name: &str| seen[name].as_f64().unwrap();
    assert!(number("filled") > 3000.0 && number("colours") > 12.0, "{seen}");
    assert!(number("count") > 6000.0 && number("bars") > 10.0, "{seen}");
    assert!(number("hit") >= 0.9 * number("tried"), "{seen}");
    assert_eq!(seen["ring"], "block");
    assert!(seen["described"].as_str().unwrap().contains(&format!("point {}", seen["picked"])), "{seen}");

    let report: Value = serde_json::from_str(&bench.text("report.json")).unwrap();
    let total = &report["results"]["total"];
    let shown = |key: &str| seen["statistics"][key].as_str().unwrap().parse::<f64>().unwrap();
    for key in ["count", "within", "over", "under"] {
        assert_eq!(Some(shown(key)), total[key].as_f64(), "{key}");
    }
    for key in
        ["min", "max", "mean", "mean_positive", "mean_negative", "rms", "standard_deviation", "variance"]
    {
        assert_eq!(Some(shown(key)), total["distance"][key].as_f64(), "{key}");
    }
    let worst: Vec<Option<f64>> =
        seen["worst"].as_array().unwrap().iter().map(|text| text.as_str().unwrap().parse().ok()).collect();
    let listed = report["results"]["worst"].as_array().unwrap();
    assert_eq!(worst, listed.iter().map(|point| point["distance"].as_f64()).collect::<Vec<_>>());
}
