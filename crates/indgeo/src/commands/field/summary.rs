//! The summary of a field.

use super::job::FieldResults;
use crate::report::wording::counted;
use crate::report::{Report, Results};

impl Results for FieldResults {
    fn summarise(&self, text: &mut String, _: &Report) -> std::fmt::Result {
        let grid: Vec<String> = self.grid.iter().map(ToString::to_string).collect();
        *text += &format!("distances at {} nodes ({})", grid.join(" x "), self.method);
        if let (Some(min), Some(max)) = (self.min, self.max) {
            *text += &format!("\n  distance  min {min:.6}  max {max:.6}");
        }
        for (count, what) in [(self.blocked, "inside of obstacles"), (self.unreachable, "not reached")] {
            if count > 0 {
                *text += &format!("\n  {}, {what}", counted(count, "node"));
            }
        }
        for path in &self.paths {
            let [x, y] = path.target;
            *text += &match path.length {
                Some(length) => format!(
                    "\n  way to    ({x}, {y}): {length:.9}, {}",
                    counted(path.points.len().saturating_sub(2), "bend")
                ),
                None => format!("\n  way to    ({x}, {y}): none"),
            };
        }
        Ok(())
    }
}
