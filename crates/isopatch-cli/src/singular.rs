//! `isopatch singular`: where a surface is singular, and how many parts it has.

use crate::arguments::Singular;
use crate::failure::{Failure, print};
use crate::input::Input;
use crate::summary::counted;
use crate::threads;
use isopatch::geom::Point3;
use isopatch::report;
use isopatch::singular::{
    Analysis, CurveKind, LowerDimensional, PointKind, SingularOptions, SpecialKind, Status, analyse,
};
use std::fmt::Write;
use std::time::Instant;

/// What is printed with `--json`.
#[derive(serde::Serialize)]
struct Report {
    points: Vec<Point>,
    curves: Vec<Curve>,
    components: Option<usize>,
    seeds: Vec<[f64; 3]>,
    lower_dimensional: Vec<Lower>,
    /// Boxes, smallest and largest coordinates.
    undecided: Vec<[[f64; 3]; 2]>,
    tau: f64,
    seconds: f64,
}

/// An isolated singular point.
#[derive(serde::Serialize)]
struct Point {
    at: [f64; 3],
    kind: PointKind,
    multiplicity: Option<usize>,
    radius: f64,
    status: Status,
}

/// An arc of the singular set with the special points at its ends.
#[derive(serde::Serialize)]
struct Curve {
    kind: CurveKind,
    closed: bool,
    status: Status,
    samples: Vec<[f64; 3]>,
    special: Vec<Special>,
}

#[derive(serde::Serialize)]
struct Special {
    at: [f64; 3],
    kind: SpecialKind,
    status: Status,
}

/// A part of the real surface of dimension less than 2: a number in the list of points or of curves.
#[derive(serde::Serialize)]
struct Lower {
    dimension: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    point: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    curve: Option<usize>,
}

pub fn run(arguments: &Singular) -> Result<(), Failure> {
    threads::start(None)?;
    let input = Input::new(&arguments.input, &arguments.set)?;
    let bounds = arguments
        .bounds
        .or(input.bounds)
        .ok_or_else(|| Failure::Unfit("singular points are found in a box: give one with --box".into()))?;
    let formula = match arguments.level {
        Some(level) => input.formula.minus(level),
        None => input.formula,
    };
    let clock = Instant::now();
    let analysis = analyse(&formula, &bounds, &SingularOptions::default())?;
    let report = Report::new(&analysis, clock.elapsed().as_secs_f64());
    let text = if arguments.json { serde_json::to_string_pretty(&report)? + "\n" } else { report.table() };
    print(&text);
    Ok(())
}

fn coordinates(p: Point3) -> [f64; 3] {
    // Adding zero turns −0 into 0.
    [p.x + 0.0, p.y + 0.0, p.z + 0.0]
}

impl Report {
    fn new(analysis: &Analysis, seconds: f64) -> Self {
        let set = &analysis.singular;
        let points = set.points.iter().map(|p| Point {
            at: coordinates(p.at),
            kind: p.kind,
            multiplicity: p.multiplicity,
            radius: p.radius,
            status: p.status,
        });
        let curves = set.curves.iter().map(|curve| Curve {
            kind: curve.kind,
            closed: curve.closed,
            status: curve.status,
            samples: curve.samples.iter().map(|s| coordinates(s.at)).collect(),
            special: curve
                .ends
                .iter()
                .flatten()
                .map(|i| &set.special[*i])
                .map(|s| Special { at: coordinates(s.at), kind: s.kind, status: s.status })
                .collect(),
        });
        let lower = set.lower_dimensional.iter().map(|part| match *part {
            LowerDimensional::Point(i) => Lower { dimension: part.dimension(), point: Some(i), curve: None },
            LowerDimensional::Curve(i) => Lower { dimension: part.dimension(), point: None, curve: Some(i) },
        });
        let seeds = analysis.components.as_ref().map(|c| c.seeds.as_slice());
        Self {
            points: points.collect(),
            curves: curves.collect(),
            components: seeds.map(<[Point3]>::len),
            seeds: seeds.unwrap_or_default().iter().copied().map(coordinates).collect(),
            lower_dimensional: lower.collect(),
            undecided: set.undecided.iter().map(report::corners).collect(),
            tau: set.tau,
            seconds,
        }
    }

    fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string does not fail.
        let mut line = |row: std::fmt::Arguments<'_>| {
            let _ = text.write_fmt(row);
            text.push('\n');
        };
        if self.points.is_empty() && self.curves.is_empty() && self.undecided.is_empty() {
            line(format_args!("No singular point in the box."));
        }
        if !self.points.is_empty() {
            line(format_args!("{}", counted(self.points.len(), "isolated singular point")));
            for p in &self.points {
                let multiplicity = p.multiplicity.map_or("-".to_owned(), |m| m.to_string());
                line(format_args!(
                    "  {}  {:<10}  multiplicity {multiplicity:<3}  {}",
                    place(&p.at),
                    word(&p.kind),
                    sureness(&p.status, p.radius)
                ));
            }
        }
        if !self.curves.is_empty() {
            line(format_args!("{}", counted(self.curves.len(), "singular arc")));
            for c in &self.curves {
                let ends: Vec<String> =
                    c.special.iter().map(|s| format!("{} ({})", place(&s.at), word(&s.kind))).collect();
                let ends = if c.closed { "closed".to_owned() } else { ends.join(" to ") };
                line(format_args!("  {:<10}  {} samples  {ends}", word(&c.kind), c.samples.len()));
            }
        }
        if !self.undecided.is_empty() {
            line(format_args!("undecided, may hold more: {}", counted(self.undecided.len(), "small box")));
            for [least, largest] in &self.undecided {
                line(format_args!("  {} to {}", place(least), place(largest)));
            }
        }
        match self.components {
            Some(count) => {
                line(format_args!("{}; a point on each:", counted(count, "connected component")));
                self.seeds.iter().for_each(|p| line(format_args!("  {}", place(p))));
            }
            None => line(format_args!("The connected components are too fine to be counted.")),
        }
        line(format_args!(
            "{:.2} s; numerical means |f| within {:.0e} of zero, relative",
            self.seconds, self.tau
        ));
        text
    }
}

fn place(p: &[f64; 3]) -> String {
    format!("{:>12.8} {:>12.8} {:>12.8}", p[0], p[1], p[2])
}

/// The word for a kind, as in JSON.
fn word(kind: &impl serde::Serialize) -> String {
    serde_json::to_value(kind).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}

fn sureness(status: &Status, radius: f64) -> String {
    match status {
        Status::Exact => "exact".to_owned(),
        Status::Certified => format!("certified within {radius:.0e}"),
        Status::Numerical => format!("numerical, within {radius:.0e}"),
    }
}
