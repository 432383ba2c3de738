//! The tables as Markdown.

use super::compute::{Block, Row, Table};
use super::digits::{four_digits, two_digits};
use std::fmt::Write as _;

const HEAD: &str = "\
# Tables 1 to 6 of [HW05]

Written by `cargo xtask paper-tables`, which computes every number with the `footpoint` crate, and Table 6 with
`sdm-register`.

A step is rounded to 10 decimals and then to 2 significant digits, as in the paper. Under each printed
number stands the computed one, marked `=` where they agree. A number marked `misprint` is one that the
iteration described by the table cannot have produced; the value that it does produce is given with more
digits.

- Tables 1 to 3 are reproduced by [HW05, eq. (5)] in closed form (`second_order_taylor_curve`), Tables 4 and 5
  by [HW05, eqs. (12)-(15)] with eq. (7) (`second_order_surface`). Nothing is clamped or damped.
- Example 2 is a cubic curve; in Table 1 the initial parameters 0.898 and 1.795 are meant literally.
- In Example 3 seven groups of four control points run in u¹, the points of a group in u².
";

/// The whole document.
pub(crate) fn document(tables: &[Table]) -> String {
    let mut text = String::from(HEAD);
    let (mut agree, mut misprints) = (0, Vec::new());
    for table in tables {
        for block in &table.blocks {
            for row in &block.rows {
                for (i, printed) in row.printed.iter().enumerate() {
                    let computed = row.computed[i];
                    if two_digits(computed) == printed.text {
                        agree += 1;
                    } else {
                        misprints.push(format!(
                            "| {} | {} | {} | {} | {} | {} |",
                            table.number,
                            block.title,
                            row.label,
                            block.steps[i],
                            printed.text,
                            four_digits(computed)
                        ));
                    }
                }
            }
        }
    }
    let total = agree + misprints.len();
    let _ = write!(
        text,
        "\n{agree} of the {total} printed steps are reproduced. The other {}:\n\n| table | point | row | step | printed | computed |\n|---|---|---|---|---|---|\n{}\n",
        misprints.len(),
        misprints.join("\n")
    );
    for table in tables {
        text.push('\n');
        text.push_str(&self::table(table));
    }
    text
}

/// One table with its heading.
pub(crate) fn table(table: &Table) -> String {
    let mut text = format!("## Table {}\n\n{}.\n", table.number, capitalised(table.about));
    for block in &table.blocks {
        text.push('\n');
        text.push_str(&self::block(block));
    }
    text
}

fn block(block: &Block) -> String {
    let mut text = format!("{}\n\n| step |", block.title);
    for step in &block.steps {
        let _ = write!(text, " {step} |");
    }
    text.push_str("\n|---|");
    text.push_str(&"---|".repeat(block.steps.len()));
    text.push('\n');
    for row in &block.rows {
        let cells = |cell: &dyn Fn(usize) -> String| {
            let cell = |i| if i < row.printed.len() { format!(" {} |", cell(i)) } else { " |".into() };
            (0..block.steps.len()).map(cell).collect::<String>()
        };
        let _ = writeln!(text, "| {}, printed |{}", row.label, cells(&|i| row.printed[i].text.into()));
        let _ = writeln!(text, "| computed |{}", cells(&|i| mark(row, i)));
    }
    text.push('\n');
    for solution in &block.solutions {
        let _ = write!(text, "{} = {:.10}", solution.name, solution.computed);
        if let Some(printed) = solution.printed {
            let rounded = as_many_decimals(solution.computed, printed.text);
            let _ = write!(text, ", printed {} ", printed.text);
            match (rounded == printed.text, printed.misprint) {
                (true, _) => text.push('='),
                (false, true) => {
                    let _ = write!(text, "misprint (cut off) [{rounded}]");
                }
                (false, false) => text.push_str("differs"),
            }
        }
        text.push_str(if solution.name == "u¹" { "; " } else { "\n" });
    }
    text
}

fn mark(row: &Row, i: usize) -> String {
    let (computed, printed) = (two_digits(row.computed[i]), row.printed[i]);
    if computed != printed.text {
        let what = if printed.misprint { "misprint" } else { "differs" };
        format!("{computed} {what} [{}]", four_digits(row.computed[i]))
    } else {
        format!("{computed} =")
    }
}

/// A number with as many decimals as a printed one.
pub(crate) fn as_many_decimals(value: f64, printed: &str) -> String {
    let decimals = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    format!("{value:.decimals$}")
}

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}
