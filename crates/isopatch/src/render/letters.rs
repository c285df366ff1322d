//! The letters of legends, as strokes: digits, and those of "Gaussian curvature" and "Mean curvature".

use std::f64::consts::PI;

/// A stroke in a grid in which digits are 7 high, small letters 5, and y points up from the line.
enum Part {
    Line([f64; 4]),
    /// Centre, radii, first and last angle in degrees, counter-clockwise if rising.
    Arc([f64; 6]),
}
use Part::{Arc, Line};

/// Height of digits and capitals.
pub(super) const HEIGHT: f64 = 7.0;
/// Room between letters.
const GAP: f64 = 1.7;
/// Width of a space, without the room around it.
const SPACE: f64 = 1.5;
/// Points on a full circle.
const ROUND: f64 = 40.0;

/// The strokes of a letter; none of one that is not here.
fn parts(letter: char) -> Vec<Part> {
    match letter {
        '0' => vec![Arc([2.0, 3.5, 2.0, 3.5, 0.0, 360.0])],
        '1' => vec![Line([0.5, 5.5, 2.1, 7.0]), Line([2.1, 7.0, 2.1, 0.0])],
        '2' => vec![
            Arc([2.0, 5.0, 2.0, 2.0, 165.0, -38.0]),
            Line([3.576, 3.769, 0.0, 0.0]),
            Line([0.0, 0.0, 4.0, 0.0]),
        ],
        '3' => vec![Arc([1.9, 5.3, 1.8, 1.7, 155.0, -90.0]), Arc([1.9, 1.8, 2.1, 1.8, 90.0, -155.0])],
        '4' => vec![Line([3.1, 0.0, 3.1, 7.0]), Line([3.1, 7.0, 0.0, 2.1]), Line([0.0, 2.1, 4.3, 2.1])],
        '5' => vec![
            Line([3.6, 7.0, 0.8, 7.0]),
            Line([0.8, 7.0, 0.415, 3.756]),
            Arc([1.9, 2.2, 2.1, 2.2, 135.0, -150.0]),
        ],
        '6' => vec![Arc([2.0, 2.1, 2.0, 2.1, 0.0, 360.0]), Arc([4.0, 2.1, 4.0, 4.9, 180.0, 100.0])],
        '7' => vec![Line([0.0, 7.0, 4.0, 7.0]), Line([4.0, 7.0, 1.3, 0.0])],
        '8' => vec![Arc([2.0, 5.3, 1.7, 1.7, 0.0, 360.0]), Arc([2.0, 1.8, 2.0, 1.8, 0.0, 360.0])],
        '9' => vec![Arc([2.0, 4.9, 2.0, 2.1, 0.0, 360.0]), Arc([0.0, 4.9, 4.0, 4.9, 0.0, -80.0])],
        '-' => vec![Line([0.3, 2.9, 3.3, 2.9])],
        '.' => vec![Line([0.2, 0.0, 0.2, 0.0])],
        'e' => vec![Line([0.05, 2.6, 3.95, 2.6]), Arc([2.0, 2.45, 2.0, 2.45, 4.0, 315.0])],
        'G' => vec![
            Arc([2.8, 3.5, 2.8, 3.5, 48.0, 350.0]),
            Line([5.56, 2.9, 5.56, 3.3]),
            Line([5.56, 3.3, 3.2, 3.3]),
        ],
        'M' => vec![
            Line([0.0, 0.0, 0.0, 7.0]),
            Line([0.0, 7.0, 2.8, 2.4]),
            Line([2.8, 2.4, 5.6, 7.0]),
            Line([5.6, 7.0, 5.6, 0.0]),
        ],
        'a' => vec![Arc([1.95, 2.45, 1.95, 2.45, 0.0, 360.0]), Line([3.9, 4.9, 3.9, 0.0])],
        'c' => vec![Arc([2.1, 2.45, 2.1, 2.45, 48.0, 312.0])],
        'i' => vec![Line([0.2, 0.0, 0.2, 4.9]), Line([0.2, 6.8, 0.2, 6.8])],
        'n' => vec![
            Line([0.0, 0.0, 0.0, 4.9]),
            Arc([1.8, 3.1, 1.8, 1.8, 180.0, 0.0]),
            Line([3.6, 3.1, 3.6, 0.0]),
        ],
        'r' => vec![Line([0.0, 0.0, 0.0, 4.9]), Arc([2.2, 2.7, 2.2, 2.2, 180.0, 75.0])],
        's' => vec![Arc([1.7, 3.7, 1.45, 1.2, 35.0, 270.0]), Arc([1.7, 1.25, 1.6, 1.25, 90.0, -145.0])],
        't' => vec![
            Line([1.1, 6.5, 1.1, 1.4]),
            Arc([2.5, 1.4, 1.4, 1.4, 180.0, 285.0]),
            Line([0.0, 4.9, 2.6, 4.9]),
        ],
        'u' => {
            vec![
                Line([0.0, 4.9, 0.0, 1.8]),
                Arc([1.8, 1.8, 1.8, 1.8, 180.0, 360.0]),
                Line([3.6, 4.9, 3.6, 0.0]),
            ]
        }
        'v' => vec![Line([0.0, 4.9, 1.9, 0.0]), Line([1.9, 0.0, 3.8, 4.9])],
        _ => Vec::new(),
    }
}

/// Straight lines of a text that starts at (0, 0) on its line, and its width.
pub(super) fn text(text: &str) -> (Vec<[[f64; 2]; 2]>, f64) {
    let (mut lines, mut x): (Vec<[[f64; 2]; 2]>, f64) = (Vec::new(), 0.0);
    for letter in text.chars() {
        let mut width: f64 = if letter == ' ' { SPACE } else { 0.0 };
        let parts = parts(letter);
        if letter != ' ' && parts.is_empty() {
            continue;
        }
        for part in parts {
            let points = part.points();
            width = points.iter().map(|p| p[0]).fold(width, f64::max);
            let placed: Vec<[f64; 2]> = points.iter().map(|p| [p[0] + x, p[1]]).collect();
            lines.extend(placed.windows(2).map(|ends| [ends[0], ends[1]]));
        }
        x += width + GAP;
    }
    (lines, (x - GAP).max(0.0))
}

impl Part {
    fn points(&self) -> Vec<[f64; 2]> {
        match *self {
            Line([x0, y0, x1, y1]) => vec![[x0, y0], [x1, y1]],
            Arc([x, y, rx, ry, first, last]) => {
                let steps = (ROUND * f64::abs(last - first) / 360.0).ceil().max(1.0);
                let at = |i: usize| {
                    let (s, c) = ((first + (last - first) * i as f64 / steps) * PI / 180.0).sin_cos();
                    [x + rx * c, y + ry * s]
                };
                (0..=steps as usize).map(at).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_letters_of_legends_are_there() {
        for letter in "0123456789.-eGaussian curvatureMean".chars() {
            assert!(letter == ' ' || !parts(letter).is_empty(), "{letter}");
        }
        let (lines, width) = text("-1.5e-7");
        assert!(lines.iter().flatten().all(|p| (0.0..=width).contains(&p[0]) && p[1] <= HEIGHT));
        assert_eq!(text("§"), (vec![], 0.0));
    }
}
