//! stub
use crate::Failure;
pub(crate) fn run(_: &[String]) -> Result<(), Failure> {
    Ok(())
}
