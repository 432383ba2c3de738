//! Chores of the workspace: `cargo xtask COMMAND`.
//!
//! One file per command, listed in [`COMMANDS`]; arguments are read by hand so that this crate builds quickly and pulls in nothing.

mod bench;
mod compare;
mod convergence;
mod examples;
mod generated;
mod measure;
mod paper_figures;
mod paper_tables;
mod tidy;
mod workspace;

use std::process::ExitCode;

/// One chore: what is typed, what it says of itself, and what it runs.
struct Command {
    name: &'static str,
    /// Arguments as shown in the help, empty when there are none.
    arguments: &'static str,
    about: &'static str,
    run: fn(&[String]) -> Result<(), Failure>,
}

/// Every chore, in the order of the help text.
const COMMANDS: &[Command] = &[
    Command {
        name: "bench",
        arguments: "[--quick] [--report-only]",
        about: "run all benchmarks and write docs/benchmarks.md; --report-only takes the results of the last run",
        run: bench::run,
    },
    Command {
        name: "measure",
        arguments: "[NAME…]",
        about: "run the programs that measure the goals of the project, all or those named, and write docs/measurements.md",
        run: measure::run,
    },
    Command {
        name: "compare",
        arguments: "",
        about: "fit the clouds of fixtures/fit-cases by FITPACK (scipy, to be installed) and by ours, with equal numbers of control points",
        run: compare::run,
    },
    Command {
        name: "tidy",
        arguments: "",
        about: "check what the compiler does not: dependency direction, file length, citations, snapshots, fixtures",
        run: tidy::run,
    },
    Command {
        name: "paper-tables",
        arguments: "[--check]",
        about: "compute the tables of the papers, compare with the printed numbers, write docs/paper-tables.md",
        run: paper_tables::run,
    },
    Command {
        name: "paper-figures",
        arguments: "",
        about: "draw the figures of the papers on parameters and fitting from data of our own into docs/figures",
        run: paper_figures::run,
    },
    Command {
        name: "convergence",
        arguments: "[--check]",
        about: "measure convergence orders and basins of the local methods, write docs/convergence.md",
        run: convergence::run,
    },
];

/// Why a chore did not succeed.
enum Failure {
    /// The command line makes no sense (exit code 2).
    Usage(String),
    /// The chore ran and the answer is "no", or it could not run (exit code 1).
    Failed(String),
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match dispatch(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Usage(message)) => {
            eprintln!("error: {message}\n\n{}", help());
            ExitCode::from(2)
        }
        Err(Failure::Failed(message)) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(arguments: &[String]) -> Result<(), Failure> {
    let Some((name, rest)) = arguments.split_first() else {
        return Err(Failure::Usage("no command given".into()));
    };
    if matches!(name.as_str(), "help" | "--help" | "-h") {
        println!("{}", help());
        return Ok(());
    }
    let Some(command) = COMMANDS.iter().find(|command| command.name == name) else {
        return Err(Failure::Usage(format!("there is no command `{name}`")));
    };
    if rest.iter().any(|argument| matches!(argument.as_str(), "--help" | "-h")) {
        println!("cargo xtask {}\n\n{}", usage(command), command.about);
        return Ok(());
    }
    (command.run)(rest)
}

fn usage(command: &Command) -> String {
    format!("{} {}", command.name, command.arguments).trim_end().to_owned()
}

fn help() -> String {
    let width = COMMANDS.iter().map(|command| usage(command).len()).max().unwrap_or(0);
    let mut text = String::from("Usage: cargo xtask COMMAND [ARGUMENT…]\n\nCommands:");
    for command in COMMANDS {
        text.push_str(&format!("\n  {:width$}  {}", usage(command), command.about));
    }
    text
}
