//! Working memory that single queries share, so that they need not allocate.

use std::sync::Mutex;

/// Buffers that are not in use.
#[derive(Debug, Default)]
pub(crate) struct Pool<T>(Mutex<Vec<T>>);

impl<T> Clone for Pool<T> {
    /// Buffers hold nothing between queries: the copy starts without any.
    fn clone(&self) -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

impl<T: Default> Pool<T> {
    /// Runs `f` with a buffer of its own.
    #[inline]
    pub(crate) fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        let mut buffer = self.0.lock().ok().and_then(|mut free| free.pop()).unwrap_or_default();
        let result = f(&mut buffer);
        if let Ok(mut free) = self.0.lock() {
            free.push(buffer);
        }
        result
    }
}
