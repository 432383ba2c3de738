//! The program `indgeo`.

use std::process::ExitCode;

fn main() -> ExitCode {
    indgeo::main()
}
