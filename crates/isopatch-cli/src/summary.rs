//! A report as a few lines for people.

use crate::outputs::Written;
use isopatch::base::Repair;
use isopatch::report::{
    APatchReport, ElementCounts, IntersectionReport, RationalReport, Report, SingularReport,
};
use std::fmt::Write;

/// Most characters of the input that are shown.
const MAX_TITLE: usize = 100;

/// The report in lines, then the files if it is of a run that could write some.
pub fn summary(report: &Report, files: Option<&[Written]>) -> String {
    let mut lines = Lines(format!("{}\n", title(&report.input)));
    shape(report, &mut lines);
    accuracy(report, &mut lines);
    for (Repair { what, place, why }, times) in without_repetition(&report.repairs) {
        let times = if times == 1 { String::new() } else { format!(" (the last of {times} times)") };
        lines.add("note", format!("{what} at {place}: {why}{times}"));
    }
    lines.add("time", times(report));
    if let Some([]) = files {
        lines.add("files", "none: nothing was written; -o NAME.step and the like write".to_owned());
    }
    for (i, file) in files.unwrap_or_default().iter().enumerate() {
        let label = if i == 0 { "files" } else { "" };
        lines.add(label, format!("{}, {}", file.path.display(), size(file.bytes)));
    }
    lines.0
}

/// Repairs that differ in their numbers only, such as those of one round after another: the last of them, and how many they are.
fn without_repetition(repairs: &[Repair]) -> Vec<(&Repair, usize)> {
    let kind =
        |r: &Repair| (r.what.replace(|c: char| c.is_ascii_digit(), ""), r.place.clone(), r.why.clone());
    let mut found: Vec<(&Repair, usize)> = Vec::new();
    for repair in repairs {
        match found.iter_mut().find(|(known, _)| kind(known) == kind(repair)) {
            Some((last, times)) => (*last, *times) = (repair, *times + 1),
            None => found.push((repair, 1)),
        }
    }
    found
}

/// A number of things, in words: `1 patch`, `2 patches`.
pub fn counted(n: usize, noun: &str) -> String {
    match (n, noun) {
        (1, _) => format!("1 {noun}"),
        (_, "vertex") => format!("{n} vertices"),
        _ if noun.ends_with("ch") || noun.ends_with('x') => format!("{n} {noun}es"),
        _ => format!("{n} {noun}s"),
    }
}

/// Lines of a label and a text.
struct Lines(String);

impl Lines {
    fn add(&mut self, label: &str, text: String) {
        // Writing to a string does not fail.
        let _ = writeln!(self.0, "  {label:<10}{text}");
    }
}

fn title(input: &str) -> String {
    match input.char_indices().nth(MAX_TITLE) {
        Some((end, _)) => format!("{}…", &input[..end]),
        None => input.to_owned(),
    }
}

fn shape(report: &Report, lines: &mut Lines) {
    let base = &report.base;
    let surface = &report.surface;
    match (&report.apatch, &report.rational, &report.singular) {
        (Some(apatch), ..) => a_patches(report, apatch, lines),
        (None, Some(rational), _) => rational_patches(report, rational, lines),
        (None, None, Some(singular)) => triangles(report, singular, lines),
        (None, None, None) => lines.add(
            "patches",
            format!(
                "{} of degree 7, {}, {}",
                surface.patches,
                counted(base.vertices, "vertex"),
                counted(base.edges, "seam")
            ),
        ),
    }
    let open = match base.boundary_loops {
        0 => "closed".to_owned(),
        n => format!("open, {}", counted(n, "boundary loop")),
    };
    let components = counted(base.components, "component");
    let genus = match &report.singular {
        Some(_) => String::new(),
        None => format!(", genus {}", base.genus),
    };
    lines.add("topology", format!("{open}, {components}, Euler number {}{genus}", base.euler));
    let unit = &report.unit;
    let volume = surface.volume.map_or_else(String::new, |v| format!(", volume {} {unit}³", digits(v)));
    lines.add(
        "size",
        format!("diagonal {} {unit}, area {} {unit}²{volume}", digits(report.diagonal), digits(surface.area)),
    );
}

/// What conforms to what.
fn triangles(report: &Report, singular: &SingularReport, lines: &mut Lines) {
    let base = &report.base;
    lines.add(
        "triangles",
        format!(
            "{}, flat (G0), {}, {} with normals of their own",
            base.faces,
            counted(base.vertices, "vertex"),
            counted(singular.sheets, "sheet")
        ),
    );
    let edges: usize = singular.edges_by_valence.values().sum();
    let valences: Vec<String> = singular
        .edges_by_valence
        .iter()
        .map(|(valence, count)| format!("{count} with {}", counted(*valence, "triangle")))
        .collect();
    let edges =
        if edges == 0 { String::new() } else { format!("; edges along them: {}", valences.join(", ")) };
    let SingularReport { points, arcs, special, lower_dimensional: [isolated, sticks], .. } = singular;
    lines.add(
        "singular",
        format!(
            "{}, {} between {}{edges}",
            counted(*points, "point"),
            counted(*arcs, "arc"),
            counted(*special, "special point")
        ),
    );
    if isolated + sticks > 0 {
        lines.add(
            "",
            format!(
                "{} and {} without sheets, beside the triangles",
                counted(*isolated, "isolated point"),
                counted(*sticks, "curve")
            ),
        );
    }
    let SingularReport { cells, cells_uncertain, doubtful_at, folded, .. } = singular;
    lines.add(
        "certainty",
        format!("{cells_uncertain} of {cells} cells, beside singularities, rest on numbers alone"),
    );
    if let [x, y, z] = doubtful_at.first().copied().unwrap_or([f64::NAN; 3])
        && x.is_finite()
    {
        lines.add("look at", format!("the surface near ({x:.4}, {y:.4}, {z:.4}) is not as expected"));
    }
    if *folded > 0 {
        lines.add("look at", format!("{} turned over", counted(*folded, "triangle")));
    }
}

/// Rational patches, what they meet in, and where they are not what they should be.
fn rational_patches(report: &Report, rational: &RationalReport, lines: &mut Lines) {
    let base = &report.base;
    lines.add(
        "patches",
        format!(
            "{} rational, {}, {}",
            report.surface.patches,
            counted(base.vertices, "vertex"),
            counted(base.edges, "curve")
        ),
    );
    for (label, count, noun, what) in [
        ("creases", rational.sharp_edges, "curve", "across which the surface is not G1"),
        ("crossings", rational.crossings, "curve", "on which more than two patches meet"),
        ("tips", rational.singular_vertices, "vertex", "without a tangent plane"),
    ] {
        if count > 0 {
            lines.add(label, format!("{} {what}", counted(count, noun)));
        }
    }
    if rational.folded > 0 {
        let names: Vec<String> = rational.folded_at.iter().map(u32::to_string).collect();
        let more = if rational.folded > names.len() { ", …" } else { "" };
        lines.add(
            "look at",
            format!("{} folded: {}{more}", counted(rational.folded, "patch"), names.join(", ")),
        );
    }
}

/// What A-patches are over, and where they are not what they should be.
fn a_patches(report: &Report, apatch: &APatchReport, lines: &mut Lines) {
    let base = &report.base;
    let over_edges = report.surface.patches - base.faces;
    lines.add(
        "patches",
        format!("{} over faces, {over_edges} over edges, {}", base.faces, counted(base.vertices, "vertex")),
    );
    if let Some(elements) = &apatch.elements {
        let ElementCounts { flat, triangles, pyramids, fans, sectors, cut, measured } = *elements;
        let kinds = [
            (triangles, "tetrahedra"),
            (pyramids, "pyramids"),
            (fans, "fans"),
            (sectors, "in sectors"),
            (flat, "flat"),
        ];
        let kinds = kinds.iter().filter(|(count, _)| *count > 0);
        let kinds: Vec<String> = kinds.map(|(count, name)| format!("{count} {name}")).collect();
        let cut =
            if cut > 0 { format!("; {} cut into triangles", counted(cut, "polygon")) } else { String::new() };
        let measured = if measured > 0 {
            format!("; {} measured, all others certain", counted(measured, "single sheet"))
        } else {
            String::new()
        };
        lines.add("faces", format!("{}{cut}{measured}", kinds.join(", ")));
    }
    let word = |word: &Option<String>| word.clone().unwrap_or_else(|| "not known".to_owned());
    lines.add(
        "gradients",
        format!("normals {}, lengths {}", word(&apatch.normals), word(&apatch.gradient_lengths)),
    );
    let creases = apatch.creases_straight + apatch.creases_curved;
    if creases > 0 {
        let APatchReport { creases_curved, creases_added, corners, .. } = apatch;
        lines.add(
            "creases",
            format!(
                "{creases}, {creases_curved} of them curved; {creases_added} added, with {}",
                counted(*corners, "corner")
            ),
        );
    }
    for (what, count, first) in [
        ("not defined everywhere", apatch.undefined, &apatch.undefined_at),
        ("folded", apatch.folded, &apatch.folded_at),
        ("bent hard, which flat triangles show", apatch.steep, &apatch.steep_at),
    ] {
        if let Some(count) = count.filter(|count| *count > 0) {
            let names: Vec<String> = first.iter().map(u32::to_string).collect();
            let more = if count > first.len() { ", …" } else { "" };
            lines.add("look at", format!("{} {what}: {}{more}", counted(count, "patch"), names.join(", ")));
        }
    }
}

fn accuracy(report: &Report, lines: &mut Lines) {
    let surface = &report.surface;
    if let (Some(max), Some(rms)) = (surface.max_distance, surface.rms_distance) {
        let back = surface.max_distance_back.map_or_else(String::new, |d| format!("; back, at most {d:.2e}"));
        let there = match max.is_finite() {
            true => format!("at most {max:.2e}, RMS {rms:.2e}"),
            false => "not known, as the gradient vanishes somewhere".to_owned(),
        };
        lines.add("distance", format!("{there}{back} (of the diagonal, measured)"));
    }
    let source = report.rational.as_ref().and_then(|rational| rational.normals.clone());
    let error = surface.max_normal_error_rad.map(|angle| {
        let bad = report.spline.map_or(0, |spline| spline.faces_over_20deg);
        let over = if bad == 0 { String::new() } else { format!(", {} over 20°", counted(bad, "patch")) };
        format!("off by at most {}°{over}", degrees(angle))
    });
    let normals: Vec<String> = source.into_iter().chain(error).collect();
    if !normals.is_empty() {
        lines.add("normals", normals.join("; "));
    }
    if let (Some(max), None) = (surface.max_distance_first_order, surface.max_distance) {
        let rms = surface.rms_distance_first_order.unwrap_or(f64::NAN);
        lines.add(
            "distance",
            format!("at most {max:.2e}, RMS {rms:.2e} (of the diagonal, |f|/|∇f|, measured)"),
        );
    }
    lines.add(
        "seams",
        format!(
            "largest gap {} of the diagonal, largest normal jump {} rad",
            small(surface.max_gap),
            small(surface.max_normal_jump_rad)
        ),
    );
    if let Some(count) = surface.self_intersections {
        lines.add("itself", intersections(count, surface.self_intersections_at.first()));
        let of_input = report.apatch.as_ref().and_then(|apatch| apatch.self_intersections_of_input);
        if let Some(count) = of_input.filter(|count| *count > 0) {
            lines.add("mesh", format!("intersects itself: {} of its triangles", counted(count, "pair")));
        }
    } else if report.apatch.is_some() {
        lines.add(
            "itself",
            "not checked for self-intersections; --report and isopatch inspect check".to_owned(),
        );
    }
}

fn intersections(count: usize, first: Option<&IntersectionReport>) -> String {
    let Some(IntersectionReport { at: [x, y, z], patches: [a, b] }) = first else {
        return "no self-intersections (measured)".to_owned();
    };
    format!(
        "intersects in {} of triangles, the first near ({x:.4}, {y:.4}, {z:.4}) in patches {a} and {b}",
        counted(count, "pair")
    )
}

fn times(report: &Report) -> String {
    let mut text = format!("{:.2} s", report.seconds.total());
    let stages: Vec<String> =
        report.seconds.stages().iter().map(|(stage, s)| format!("{stage} {s:.2}")).collect();
    if !stages.is_empty() {
        let _ = write!(text, ": {}", stages.join(", "));
    }
    text
}

/// A number with seven digits.
fn digits(x: f64) -> String {
    match x.abs() {
        a if (1e-3..1e6).contains(&a) => {
            let decimals = (6 - a.log10().floor() as i32).clamp(0, 9) as usize;
            format!("{x:.decimals$}")
        }
        _ => format!("{x:.6e}"),
    }
}

/// An angle in degrees.
fn degrees(radians: f64) -> String {
    match radians.to_degrees() {
        d if d < 0.01 => small(d),
        d => format!("{d:.3}"),
    }
}

/// A number of which the magnitude matters.
fn small(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") }
}

/// A number of bytes, in thousands that fit.
fn size(bytes: u64) -> String {
    let bytes = bytes as f64;
    match bytes {
        b if b < 1e3 => format!("{b:.0} bytes"),
        b if b < 1e6 => format!("{:.1} kB", b / 1e3),
        b if b < 1e9 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.1} GB", b / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_digits_at_every_scale() {
        let shown = [3.377682, 12345.678, 0.0012345678, 1.5e-18, 2e9].map(digits);
        assert_eq!(shown, ["3.377682", "12345.68", "0.001234568", "1.500000e-18", "2.000000e9"]);
        assert_eq!([0.0, 3.9e-15].map(small), ["0", "3.9e-15"]);
        assert_eq!([999, 1000, 1_310_000].map(size), ["999 bytes", "1.0 kB", "1.3 MB"]);
    }

    #[test]
    fn notes_that_differ_in_numbers_become_one() {
        let note =
            |what: &str, why: &str| Repair { what: what.into(), place: "whole mesh".into(), why: why.into() };
        let notes = [
            note("remade with 434 faces", "folds"),
            note("cut: 2", "flat"),
            note("remade with 80 faces", "folds"),
        ];
        assert_eq!(without_repetition(&notes), [(&notes[2], 2), (&notes[1], 1)]);
    }

    #[test]
    fn nouns_go_with_their_numbers() {
        let shown = [(1, "vertex"), (0, "vertex"), (2, "patch"), (2, "small box"), (3, "seam")];
        let shown = shown.map(|(n, noun)| counted(n, noun));
        assert_eq!(shown, ["1 vertex", "0 vertices", "2 patches", "2 small boxes", "3 seams"]);
    }

    #[test]
    fn long_inputs_are_cut() {
        assert_eq!(title("x^2"), "x^2");
        assert_eq!(title(&"π".repeat(200)).chars().count(), MAX_TITLE + 1);
    }
}
