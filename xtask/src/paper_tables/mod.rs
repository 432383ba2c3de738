//! `cargo xtask paper-tables`: Tables 1 to 6 of \[HW05\] and Tables 1 and 2 of \[MPK\], computed and compared with what is printed.

mod compute;
mod digits;
pub(crate) mod directed;
mod printed;
mod render;
mod table_6;
#[cfg(test)]
mod tests;

use crate::{Failure, generated};
use compute::Table;

/// Where the tables are written.
const DOCUMENT: &str = "docs/paper-tables.md";

/// Prints the tables and writes [`DOCUMENT`]; with `--check` fails if it is out of date. Fails in any case
/// if a printed number does not relate to the computed one as is listed: equal, cut off, or a misprint.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let check = generated::is_check(arguments)?;
    let tables =
        compute::tables().map_err(|error| Failure::Failed(format!("an example is invalid: {error}")))?;
    for table in &tables {
        println!("{}", render::table(table));
    }
    let registrations = table_6::compute()
        .map_err(|error| Failure::Failed(format!("a registration of Table 6 is invalid: {error}")))?;
    println!("{}", table_6::render(&registrations));
    let comparisons = directed::compute().map_err(|error| {
        Failure::Failed(format!("a comparison of directed projections is invalid: {error}"))
    })?;
    println!("{}", directed::render(&comparisons));
    let mut wrong = disagreements(&tables);
    wrong.extend(directed::disagreements(&comparisons));
    wrong.extend(table_6::disagreements(&registrations));
    if !wrong.is_empty() {
        return Err(Failure::Failed(format!("not as printed, nor as listed:\n{}", wrong.join("\n"))));
    }
    generated::write_or_check(
        DOCUMENT,
        &format!(
            "{}\n{}\n{}",
            render::document(&tables),
            table_6::render(&registrations),
            directed::render(&comparisons)
        ),
        check,
        "paper-tables",
        generated::identical,
    )
}

/// Every number whose agreement with the paper is not what [`printed`] says of it.
fn disagreements(tables: &[Table]) -> Vec<String> {
    let mut found = Vec::new();
    for table in tables {
        for block in &table.blocks {
            for row in &block.rows {
                for (i, (&step, printed)) in row.computed.iter().zip(row.printed).enumerate() {
                    if digits::of_step(step, printed.text) != printed.relation {
                        let (label, k) = (&row.label, block.steps[i]);
                        found.push(format!(
                            "Table {}, {}, {label}, step {k}: printed {} (listed as `{}`), computed {}",
                            table.number,
                            block.title,
                            printed.text,
                            printed.relation.mark(),
                            digits::four_digits(step)
                        ));
                    }
                }
            }
            for solution in &block.solutions {
                let Some(printed) = solution.printed else { continue };
                if digits::of_decimals(solution.computed, printed.text) != printed.relation {
                    let (number, title, name) = (table.number, &block.title, solution.name);
                    let (text, mark) = (printed.text, printed.relation.mark());
                    let computed = solution.computed;
                    found.push(format!(
                        "Table {number}, {title}, {name}: printed {text} (listed as `{mark}`), computed {computed}"
                    ));
                }
            }
        }
    }
    found
}
