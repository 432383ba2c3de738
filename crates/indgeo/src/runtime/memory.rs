//! Files in memory: inputs and outputs of a command that is called from another language.
//!
//! A path that begins with a byte which no file name can hold stands for one of them, so that all checks of paths hold as they are.

use crate::runtime::watch::Watch;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// First byte of the name of a file in memory.
const MARK: char = '\0';

/// The path of the file in memory that is called `name`, to be given to a command. What is written to it comes back with
/// [`call`](crate::call()).
#[must_use]
pub fn memory_path(name: &str) -> String {
    format!("{MARK}{name}")
}

/// The bytes of an input, whoever owns them.
pub(crate) type Input = Box<dyn AsRef<[u8]> + Send + Sync>;

/// What belongs to a call: its files in memory, and who watches it.
pub(crate) struct Surroundings {
    inputs: BTreeMap<String, Input>,
    outputs: Mutex<BTreeMap<String, Vec<u8>>>,
    watch: Arc<Watch>,
}

thread_local! {
    /// Of the call that runs on this thread; commands read and write on the thread on which they begin.
    static PRESENT: RefCell<Option<Arc<Surroundings>>> = const { RefCell::new(None) };
}

impl Surroundings {
    /// A call with these inputs.
    pub(crate) fn new(inputs: BTreeMap<String, Input>, watch: Arc<Watch>) -> Arc<Self> {
        Arc::new(Self { inputs, outputs: Mutex::default(), watch })
    }

    /// Runs `work` in these surroundings.
    pub(crate) fn around<T>(self: &Arc<Self>, work: impl FnOnce() -> T) -> T {
        let before = PRESENT.with(|present| present.replace(Some(Arc::clone(self))));
        let done = work();
        PRESENT.with(|present| present.replace(before));
        done
    }

    /// What was written, by name.
    pub(crate) fn take_outputs(&self) -> BTreeMap<String, Vec<u8>> {
        std::mem::take(&mut *self.outputs.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

fn present() -> Option<Arc<Surroundings>> {
    PRESENT.with(|present| present.borrow().clone())
}

/// Who watches the present call.
pub(crate) fn watch() -> Option<Arc<Watch>> {
    present().map(|around| Arc::clone(&around.watch))
}

/// Whether the present call was asked to stop.
pub(crate) fn is_cancelled() -> bool {
    watch().is_some_and(|watch| watch.is_cancelled())
}

fn name(path: &Path) -> Option<&str> {
    path.to_str()?.strip_prefix(MARK)
}

/// Whether a path stands for a file in memory.
pub(crate) fn is_memory(path: &Path) -> bool {
    name(path).is_some()
}

/// Applies `read` to the bytes of a file in memory and to its name; `None` if there is none at this path.
pub(crate) fn read<T>(path: &Path, read: impl FnOnce(&[u8], &Path) -> T) -> Option<T> {
    let name = name(path)?;
    let present = present()?;
    present.inputs.get(name).map(|bytes| read((**bytes).as_ref(), Path::new(name)))
}

/// Keeps the bytes of an output.
pub(crate) fn keep(path: &Path, bytes: Vec<u8>) {
    if let Some((name, present)) = name(path).zip(present()) {
        let mut outputs = present.outputs.lock().unwrap_or_else(PoisonError::into_inner);
        outputs.insert(name.to_owned(), bytes);
    }
}

/// A message without the mark of files in memory.
pub(crate) fn without_mark(text: &str) -> String {
    text.replace(MARK, "")
}
