//! The run of a command: session, threads, progress, interrupts, and files in memory.

pub(crate) mod call;
pub(crate) mod interrupt;
pub(crate) mod memory;
pub(crate) mod progress;
pub(crate) mod session;
pub(crate) mod threads;
pub(crate) mod watch;
