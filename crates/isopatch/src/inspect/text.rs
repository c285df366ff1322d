//! An inspection as a table for the terminal; distances are parts of the diagonal.

use super::{Inspection, NORMAL_ERROR_LIMIT};
use std::fmt::{Display, Formatter, Result};

impl Display for Inspection {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let t = &self.topology;
        let line = |f: &mut Formatter<'_>, name: &str, value: String| writeln!(f, "{name:<22}{value}");
        let shell = match t.boundary_loops {
            0 => "closed".to_string(),
            n => format!("open, {n} boundary loop{}", plural(n)),
        };
        line(f, "patches", format!("{} on {} vertices, {} edges", self.patches, t.vertices, t.edges))?;
        let components = format!("{} component{}", t.components, plural(t.components));
        line(f, "topology", format!("{shell}, {components}, Euler number {}, genus {}", t.euler, t.genus))?;
        line(f, "diagonal", format!("{:.6}", self.diagonal))?;
        line(f, "area, volume", format!("{:.6}, {:.6}", self.extent.area, self.extent.volume))?;
        line(f, "largest gap", format!("{} of the diagonal", figure(self.seams.max_gap)))?;
        line(f, "largest normal jump", format!("{} rad", figure(self.seams.max_normal_jump)))?;
        let i = &self.interpolation;
        line(
            f,
            "at the vertices",
            format!(
                "position {}, normal {} rad, curvature {}",
                figure(i.max_position_error),
                figure(i.max_normal_error),
                figure(i.max_curvature_error)
            ),
        )?;
        if let Some(i) = &self.intersections {
            line(f, "self-intersections", format!("{} in {} triangles", i.count, i.triangles))?;
        }
        if let Some(d) = &self.deviation {
            line(
                f,
                "distance to field",
                format!("largest {:.2e}, RMS {:.2e}", d.max_distance, d.rms_distance),
            )?;
            let first_order = format!("largest {:.2e}, RMS {:.2e}", d.max_first_order, d.rms_first_order);
            line(f, "  first order", first_order)?;
            let limit = NORMAL_ERROR_LIMIT.to_degrees();
            let (over, folded) = (d.over_limit, d.folded);
            let degrees = d.max_normal_error.to_degrees();
            line(f, "normal error", format!("{degrees:.3}°; {over} over {limit:.0}°, {folded} folded"))?;
        }
        if let Some(c) = &self.coverage {
            let value = format!("largest {:.2e}, RMS {:.2e}", c.max_distance, c.rms_distance);
            line(f, "distance from field", format!("{value}, {} points", c.samples))?;
        }
        Ok(())
    }
}

/// An error with two digits.
fn figure(x: f64) -> String {
    if x == 0.0 { "0".to_string() } else { format!("{x:.1e}") }
}

/// The ending of a noun after the number `n`.
fn plural(n: usize) -> &'static str {
    if n == 1 { "" } else { "s" }
}
