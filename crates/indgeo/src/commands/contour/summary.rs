//! The summary of contours.

use super::job::ContourResults;
use crate::report::wording::counted;
use crate::report::{Report, Results};

impl Results for ContourResults {
    fn summarise(&self, text: &mut String, _: &Report) -> std::fmt::Result {
        let size: Vec<String> = self.size.iter().map(ToString::to_string).collect();
        *text += &format!("contours of {} ({})", size.join(" x "), self.method);
        if let Some(level) = self.level {
            *text += &format!("\n  level      {level:.6}, {} inside", self.inside.unwrap_or("below"));
        }
        *text += &format!(
            "\n  region     {}, {}",
            counted(self.components, "component"),
            counted(self.holes, "hole")
        );
        if let Some(evolution) = &self.evolution {
            let rest = if evolution.settled { "at rest" } else { "still moving" };
            *text += &format!("\n  evolution  {}, {rest}", counted(evolution.steps, "step"));
        }
        if let Some(mesh) = &self.mesh {
            let open = if mesh.closed { "closed" } else { "open" };
            *text += &format!(
                "\n  mesh       {}, {}, {open}",
                counted(mesh.vertices, "vertex"),
                counted(mesh.triangles, "triangle")
            );
            if let Some(surface) = &self.surface {
                let [u, v] = surface.control_points;
                *text += &format!("\n  surface    {u} x {v} control points, like a {}", surface.kind.name());
            }
        } else {
            let controls: usize = self.contours.iter().map(|curve| curve.control_points).sum();
            let open = self.contours.iter().filter(|curve| !curve.closed).count();
            *text += &format!(
                "\n  curves     {}, {open} open, {}",
                counted(self.contours.len(), "curve"),
                counted(controls, "control point")
            );
            if self.left_out > 0 {
                *text += &format!("; {} left out as small", counted(self.left_out, "contour"));
            }
        }
        if let Some(max) = self.max {
            let verdict = if self.within_tolerance { "within" } else { "not within" };
            *text += &format!("\n  distance   max {max:.3e}, {verdict} the tolerance of {}", self.tolerance);
        }
        Ok(())
    }
}
