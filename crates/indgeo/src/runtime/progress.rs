//! Progress on the standard error stream, when it is a terminal.

use crate::runtime::memory;
use crate::runtime::watch::Watch;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Before it is known how much there is to do, and where that is never known.
const WAITING: &str = "{spinner} {msg}";

/// A line that is removed when it goes out of scope.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    what: &'static str,
    /// How a bar looks once it is known how much there is to do.
    template: &'static str,
    steps: AtomicUsize,
    /// Who watches without a terminal.
    watch: Option<Arc<Watch>>,
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

    /// A line about the present iteration.
    pub(crate) fn iterations(what: &'static str, quiet: bool) -> Self {
        Self::with_template(what, quiet, WAITING)
    }

    fn with_template(what: &'static str, quiet: bool, template: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(
            None,
            if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() },
        );
        if let Ok(style) = ProgressStyle::with_template(WAITING) {
            bar.set_style(style);
        }
        bar.set_message(what);
        let watch = memory::watch();
        match &watch {
            Some(watch) => watch.begin(what),
            None => bar.enable_steady_tick(Duration::from_millis(250)),
        }
        Self { bar, what, template, steps: AtomicUsize::new(0), watch }
    }

    /// Tells how far the work is; asks to stop where the one who watches does.
    pub(crate) fn report(&self, done: usize, total: usize) -> ControlFlow<()> {
        if total > 0 && self.bar.length() != Some(total as u64) {
            self.bar.set_length(total as u64);
            if let Ok(style) = ProgressStyle::with_template(self.template) {
                self.bar.set_style(style.progress_chars("=> "));
            }
        }
        // Threads report out of order; the bar only moves forward.
        if done as u64 > self.bar.position() {
            self.bar.set_position(done as u64);
        }
        self.flow(|watch| watch.count(done, total))
    }

    /// Tells which iteration of how many is done, and something about it; asks to stop where the one who watches does.
    pub(crate) fn iteration(&self, number: usize, most: usize, about: &str) -> ControlFlow<()> {
        self.tell(line(self.what, number, most, about))
    }

    /// The same for iterations that have no numbers: they are counted here, from [`Progress::begin`].
    pub(crate) fn next_iteration(&self, most: usize, about: &str) -> ControlFlow<()> {
        self.iteration(self.steps.fetch_add(1, Ordering::Relaxed) + 1, most, about)
    }

    /// Tells how far a part of the work is that has a name of its own; asks to stop where the one who watches does.
    pub(crate) fn part(&self, what: &str, done: usize, total: usize) -> ControlFlow<()> {
        let how_far = if total > 0 { format!(", {done} of {total}") } else { String::new() };
        self.tell(format!("{}: {what}{how_far}", self.what))
    }

    fn tell(&self, text: String) -> ControlFlow<()> {
        let flow = self.flow(|watch| watch.say(&text));
        self.bar.set_message(text);
        flow
    }

    /// Whether to go on, after the one who watches was told.
    fn flow(&self, tell: impl FnOnce(&Watch)) -> ControlFlow<()> {
        self.watch.as_ref().map_or(ControlFlow::Continue(()), |watch| {
            tell(watch);
            watch.flow()
        })
    }

    /// Iterations are counted from 1 again.
    pub(crate) fn begin(&self) {
        self.steps.store(0, Ordering::Relaxed);
    }
}

fn line(what: &str, number: usize, most: usize, about: &str) -> String {
    format!("{what}: iteration {number} of at most {most}, {about}")
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_iteration_is_one_of_so_many() {
        assert_eq!(line("fitting", 3, 30, "rms 1.5e-3"), "fitting: iteration 3 of at most 30, rms 1.5e-3");
        let progress = Progress::iterations("fitting", true);
        let _ = progress.next_iteration(30, "");
        let _ = progress.next_iteration(30, "");
        assert_eq!(progress.bar.message(), "fitting: iteration 2 of at most 30, ");
        progress.begin();
        let _ = progress.next_iteration(30, "");
        assert_eq!(progress.bar.message(), "fitting: iteration 1 of at most 30, ");
    }

    #[test]
    fn nothing_of_nothing_is_not_shown() {
        let progress = Progress::new("projecting", true);
        assert_eq!(progress.bar.length(), None);
        let _ = progress.report(0, 0);
        assert_eq!(progress.bar.length(), None);
        let _ = progress.report(5, 20);
        assert_eq!((progress.bar.position(), progress.bar.length()), (5, Some(20)));
    }
}
