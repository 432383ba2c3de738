//! How far a command is, and whether it shall go on, for who runs it without a terminal.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Seen from one thread while a command runs in another.
#[derive(Debug, Default)]
pub struct Watch {
    cancelled: AtomicBool,
    about: Mutex<String>,
    done: AtomicUsize,
    total: AtomicUsize,
}

impl Watch {
    /// Asks the command to stop; it does so at its next report of progress and writes nothing.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether the command was asked to stop.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// What the command does, how much of it is done, and of how much: 0 of 0 where that is not known.
    #[must_use]
    pub fn progress(&self) -> (String, usize, usize) {
        let about = self.about.lock().unwrap_or_else(PoisonError::into_inner).clone();
        (about, self.done.load(Ordering::Relaxed), self.total.load(Ordering::Relaxed))
    }

    /// Begins a piece of work with a name.
    pub(crate) fn begin(&self, about: &str) {
        self.say(about);
        self.done.store(0, Ordering::Relaxed);
        self.total.store(0, Ordering::Relaxed);
    }

    /// Tells what is done at present.
    pub(crate) fn say(&self, about: &str) {
        about.clone_into(&mut self.about.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Tells how much is done; threads report out of order.
    pub(crate) fn count(&self, done: usize, total: usize) {
        self.done.fetch_max(done, Ordering::Relaxed);
        self.total.store(total, Ordering::Relaxed);
    }

    /// Whether to go on.
    pub(crate) fn flow(&self) -> ControlFlow<()> {
        if self.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
