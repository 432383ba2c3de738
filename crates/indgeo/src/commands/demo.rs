//! `indgeo demo`.
use super::Outcome;
use crate::args::Common;
use crate::error::Error;
use crate::report::Report;
/// Demo
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}
pub(crate) fn run(_: &Args, _: &Common, _: &mut Report) -> Result<Outcome, Error> {
    Ok(Outcome { summary: String::new(), converged: true })
}
