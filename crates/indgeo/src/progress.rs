//! Progress bars on the standard error stream, when it is a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::ops::ControlFlow;
use std::time::Duration;

/// A bar that is removed when it goes out of scope.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar that counts points, invisible when `quiet` or when nobody watches.
    pub(crate) fn new(what: &'static str, quiet: bool) -> Self {
        Self::with_template(what, quiet, "{msg} [{wide_bar}] {human_pos}/{human_len} points, {eta} left")
    }

    /// A bar that counts steps.
    pub(crate) fn steps(what: &'static str, quiet: bool) -> Self {
        Self::with_template(what, quiet, "{msg} [{wide_bar}] {human_pos}/{human_len}")
    }

    fn with_template(what: &'static str, quiet: bool, template: &str) -> Self {
        let bar = ProgressBar::with_draw_target(
            None,
            if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() },
        );
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what);
        bar.enable_steady_tick(Duration::from_millis(250));
        Self { bar }
    }

    /// Tells how far the work is; never asks to stop.
    pub(crate) fn report(&self, done: usize, total: usize) -> ControlFlow<()> {
        if self.bar.length() != Some(total as u64) {
            self.bar.set_length(total as u64);
        }
        // Threads report out of order; the bar only moves forward.
        if done as u64 > self.bar.position() {
            self.bar.set_position(done as u64);
        }
        ControlFlow::Continue(())
    }

    /// Shows that work goes on whose length is not known.
    pub(crate) fn tick(&self) -> ControlFlow<()> {
        self.bar.tick();
        ControlFlow::Continue(())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
