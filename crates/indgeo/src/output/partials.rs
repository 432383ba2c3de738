//! Results of a part of the work in files, to be sent and merged: an envelope with a hash of what is in it.

use crate::error::Error;
use crate::files;
use crate::report::Output;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};
use std::io::{BufWriter, Write};
use std::path::Path;

/// What a part of the work was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Kind {
    /// The inspection of a tile.
    Inspection,
    /// The sums of one iteration of a registration over a tile.
    Registration,
}

/// Whether all points were measured by the same program decides whether their numbers are those of one run.
const PROGRAM: &str = concat!("indgeo ", env!("CARGO_PKG_VERSION"));

#[derive(Serialize, Deserialize)]
struct Envelope<C> {
    partial: Kind,
    program: String,
    /// Of the text of the content.
    sha256: String,
    content: C,
}

/// SHA-256 of bytes in hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    hex(Sha256::new_with_prefix(bytes))
}

/// The value of a hash in hexadecimal digits.
pub(crate) fn hex(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Writes a partial result; the file appears whole or not at all.
pub(crate) fn write<C: Serialize>(
    path: &Path,
    kind: Kind,
    content: &C,
    about: String,
) -> Result<Output, Error> {
    let failed = |error: serde_json::Error| Error::write(path, error.into());
    let content = serde_json::value::to_raw_value(content).map_err(failed)?;
    let sha256 = sha256(content.get().as_bytes());
    let envelope = Envelope { partial: kind, program: PROGRAM.to_owned(), sha256, content };
    let bytes = files::write(path, |out| {
        let mut out = BufWriter::new(out);
        serde_json::to_writer(&mut out, &envelope)?;
        out.write_all(b"\n")?;
        out.flush()
    })?;
    Ok(Output { path: path.to_path_buf(), bytes, content: about })
}

/// A partial result as read, its content still as text.
pub(crate) struct Opened {
    pub(crate) kind: Kind,
    content: Box<RawValue>,
}

impl Opened {
    /// Reads a partial result and checks that it is whole and of this version of the program.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let bytes = files::read_bytes(path)?;
        let envelope: Envelope<Box<RawValue>> = serde_json::from_slice(&bytes).map_err(|error| {
            let what = format!("this is no partial result, or it is damaged ({error})");
            Error::content(path, what, AGAIN)
        })?;
        if envelope.program != PROGRAM {
            let what = format!("the partial result was made by {}, this is {PROGRAM}", envelope.program);
            return Err(Error::content(
                path,
                what,
                "make all partial results with the program that merges them",
            ));
        }
        if envelope.sha256 != sha256(envelope.content.get().as_bytes()) {
            let what = "the partial result is damaged: its content does not fit its hash";
            return Err(Error::content(path, what, AGAIN));
        }
        Ok(Self { kind: envelope.partial, content: envelope.content })
    }

    /// The content, or a part of it.
    pub(crate) fn parse<C: DeserializeOwned>(&self, path: &Path) -> Result<C, Error> {
        serde_json::from_str(self.content.get())
            .map_err(|error| Error::content(path, format!("the partial result is damaged: {error}"), AGAIN))
    }
}

/// What to do about a partial result that cannot be used.
const AGAIN: &str = "make it again, by the command with --partial";
