//! The tables as Markdown.

use super::compute::{Block, Row, Table};
use super::digits::{Relation, decimals, four_digits, of_decimals, of_step, two_digits};
use std::fmt::Write as _;

const HEAD: &str = "\
# Tables 1 to 6 of [HW05]

Written by `cargo xtask paper-tables`, which computes every number with the `footpoint` crate, and Table 6 with
`sdm-register`.

Under each printed number stands the computed one:

- `=`: the printed number is the computed value rounded to its digits, or rounded to 10 decimals and
  then to its digits;
- `cut off`: it is the computed value cut off after its digits;
- `misprint`: it is neither, so the iteration described by the table cannot have produced it.

Where they differ, the computed value is given with more digits.

- Tables 1 to 3 are reproduced by [HW05, eq. (5)] in closed form (`second_order_taylor_curve`), Tables 4 and 5
  by [HW05, eqs. (12)-(15)] with eq. (7) (`second_order_surface`). Nothing is clamped or damped.
- Example 2 is a cubic curve; in Table 1 the initial parameters 0.898 and 1.795 are meant literally.
- In Example 3 seven groups of four control points run in u¹, the points of a group in u².
";

/// The whole document.
pub(crate) fn document(tables: &[Table]) -> String {
    let mut text = String::from(HEAD);
    let (mut equal, mut others) = (0, [Vec::new(), Vec::new()]);
    for table in tables {
        for block in &table.blocks {
            for row in &block.rows {
                for (i, printed) in row.printed.iter().enumerate() {
                    let computed = row.computed[i];
                    let relation = of_step(computed, printed.text);
                    if relation == Relation::Equal {
                        equal += 1;
                        continue;
                    }
                    others[usize::from(relation == Relation::Misprint)].push(format!(
                        "| {} | {} | {} | {} | {} | {} | {} |",
                        table.number,
                        block.title,
                        row.label,
                        block.steps[i],
                        printed.text,
                        four_digits(computed),
                        relation.mark()
                    ));
                }
            }
        }
    }
    let [cut, misprints] = others.each_ref().map(Vec::len);
    let _ = write!(
        text,
        "\n{equal} of the {} printed steps are reproduced, {cut} are cut off, and {misprints} are misprints:\n\n\
         | table | point | row | step | printed | computed | |\n|---|---|---|---|---|---|---|\n{}\n",
        equal + cut + misprints,
        others.concat().join("\n")
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
            let relation = of_decimals(solution.computed, printed.text);
            let _ = write!(text, ", printed {} {}", printed.text, relation.mark());
            if relation != Relation::Equal {
                let _ = write!(text, " [{:.*}]", decimals(printed.text), solution.computed);
            }
            text.push_str(unlisted(relation, printed.relation));
        }
        text.push_str(if solution.name == "u¹" { "; " } else { "\n" });
    }
    text
}

/// The computed step, and how the printed one relates to it.
fn mark(row: &Row, i: usize) -> String {
    let (computed, printed) = (row.computed[i], row.printed[i]);
    let relation = of_step(computed, printed.text);
    let unlisted = unlisted(relation, printed.relation);
    match relation {
        Relation::Equal => format!("{} ={unlisted}", printed.text),
        other => format!("{} {} [{}]{unlisted}", two_digits(computed), other.mark(), four_digits(computed)),
    }
}

/// Says when a number does not relate to the printed one as is listed.
fn unlisted(found: Relation, listed: Relation) -> &'static str {
    if found == listed { "" } else { " (not listed so)" }
}

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}
