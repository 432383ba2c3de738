//! The paths of a command taken together: no output takes the place of an input or of another output.

use crate::args::Command;
use crate::error::Error;
use crate::files::is_same;

/// Checks the files that the command line names, also through links and folders, before anything is read or written.
pub(crate) fn check(command: &Command) -> Result<(), Error> {
    let (inputs, outputs) = command.files();
    for (index, output) in outputs.iter().enumerate() {
        if inputs.iter().any(|input| is_same(output, input)) {
            let what = "this would overwrite an input";
            return Err(Error::content(output, what, "choose another name for the output"));
        }
        if let Some(other) = outputs[..index].iter().find(|other| is_same(output, other)) {
            let what =
                format!("two outputs would be written to this file (the other is {})", other.display());
            return Err(Error::content(output, what, "choose another name for one of them"));
        }
    }
    Ok(())
}
