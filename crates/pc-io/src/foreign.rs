//! Calls into decoders and encoders of other crates, which may panic on damaged files.

use std::any::Any;
use std::cell::Cell;
use std::io::{Read, Seek};
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

use crate::{Error, Place};

/// What is read by the decoders of other crates: a file, or bytes in memory.
pub(crate) trait ReadSeek: Read + Seek + Send + Sync {}

impl<T: Read + Seek + Send + Sync> ReadSeek for T {}

/// A file, or bytes in memory, and its length in bytes.
pub(crate) struct Input {
    pub(crate) reader: Box<dyn ReadSeek>,
    pub(crate) length: u64,
}

impl Input {
    pub(crate) fn of_bytes(data: &[u8]) -> Self {
        Self { length: data.len() as u64, reader: Box::new(std::io::Cursor::new(data.to_vec())) }
    }

    /// An open file. Decoders that seek often get it without a buffer.
    pub(crate) fn of_file(file: std::fs::File) -> std::io::Result<Self> {
        Ok(Self { length: file.metadata()?.len(), reader: Box::new(file) })
    }
}

thread_local! {
    /// Guarded calls that this thread is in.
    static GUARDED: Cell<usize> = const { Cell::new(0) };
}

/// Keeps panics of guarded calls from being printed. The hook is put in place once for the process and looks at its own
/// thread only, so that the panics of other threads are told as before.
fn install_hook() {
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if GUARDED.get() == 0 {
                previous(info);
            }
        }));
    });
}

/// Runs `work`; a panic in it becomes an error of the file.
///
/// Whatever `work` was changing when it panicked must not be used again.
pub(crate) fn guarded<T>(decoder: &str, work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    install_hook();
    GUARDED.set(GUARDED.get() + 1);
    let ended = panic::catch_unwind(AssertUnwindSafe(work));
    GUARDED.set(GUARDED.get() - 1);
    ended.unwrap_or_else(|payload| {
        let what = format!("the {decoder} decoder broke off ({})", message(payload.as_ref()));
        Err(Error::malformed(Place::Whole, what, DAMAGED))
    })
}

/// Advice for content that the decoder of another crate refuses.
pub(crate) const DAMAGED: &str = "the file is damaged, export it again";

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_and_the_next_call_works() {
        for _ in 0..2 {
            let error =
                guarded("LAZ", || -> Result<(), Error> { panic!("index out of bounds") }).unwrap_err();
            assert!(error.to_string().contains("LAZ decoder broke off (index out of bounds)"), "{error}");
        }
        assert_eq!(guarded("LAZ", || Ok(7)).unwrap(), 7);
        assert_eq!(GUARDED.get(), 0);
    }
}
