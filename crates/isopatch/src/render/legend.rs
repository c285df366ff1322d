//! A bar with colours and numbers, drawn on the finished picture.

use super::letters::{HEIGHT, text};
use super::{Color, ColorScale, Legend};

/// Numbers beside the bar.
const MARKS: usize = 5;
/// Part of the width of a picture that a legend takes.
pub(super) const SHARE: f64 = 0.15;
/// Colour of text and frame, sRGB.
const INK: u32 = 0x3a3f47;

/// A picture in linear light.
pub(super) struct Canvas {
    pub width: usize,
    pub height: usize,
    pub colors: Vec<Color>,
}

impl Canvas {
    fn blend(&mut self, x: usize, y: usize, color: Color, cover: f64) {
        if let Some(old) = self.colors.get_mut(y * self.width + x).filter(|_| x < self.width) {
            *old = old.mix(color, cover.clamp(0.0, 1.0) as f32);
        }
    }

    /// Draws a line of some thickness with round ends.
    fn line(&mut self, [a, b]: [[f64; 2]; 2], radius: f64, color: Color) {
        let pixels = |c: usize, size: usize| {
            let least = (a[c].min(b[c]) - radius - 1.0).max(0.0) as usize;
            least..((a[c].max(b[c]) + radius + 2.0).max(0.0) as usize).min(size)
        };
        for y in pixels(1, self.height) {
            for x in pixels(0, self.width) {
                let p = [x as f64 + 0.5 - a[0], y as f64 + 0.5 - a[1]];
                let d = [b[0] - a[0], b[1] - a[1]];
                let length = d[0] * d[0] + d[1] * d[1];
                let t =
                    if length > 0.0 { ((p[0] * d[0] + p[1] * d[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
                let distance = (p[0] - t * d[0]).hypot(p[1] - t * d[1]);
                self.blend(x, y, color, radius + 0.5 - distance);
            }
        }
    }

    /// Writes a text whose line starts at (x, y), with letters of this height.
    fn write(&mut self, words: &str, [x, y]: [f64; 2], height: f64, color: Color) {
        let scale = height / HEIGHT;
        for line in text(words).0 {
            self.line(line.map(|p| [x + scale * p[0], y - scale * p[1]]), 0.068 * height, color);
        }
    }
}

/// Draws a legend at the right side of a picture.
pub(super) fn draw(legend: &Legend, canvas: &mut Canvas) {
    let (width, height) = (canvas.width as f64, canvas.height as f64);
    let letters = (0.0165 * height).min(0.0125 * width);
    let ink = Color::srgb(INK);
    let table = legend.scale.table();
    let left = width * (1.0 - SHARE) + 0.5 * letters;
    let (top, bottom) = ((0.27 * height).round(), (0.73 * height).round());
    let right = left + 1.6 * letters;
    for y in top as usize..bottom as usize {
        let t = (bottom - y as f64 - 0.5) / (bottom - top);
        for x in left as usize..right as usize {
            canvas.blend(x, y, ColorScale::at(&table, t as f32), 1.0);
        }
    }
    for mark in 0..MARKS {
        let t = mark as f64 / (MARKS - 1) as f64;
        let value = legend.range[0] + t * (legend.range[1] - legend.range[0]);
        let y = bottom - t * (bottom - top);
        canvas.line([[right, y], [right + 0.4 * letters, y]], 0.05 * letters, ink);
        let largest = legend.range[0].abs().max(legend.range[1].abs());
        canvas.write(&number(value, largest), [right + 0.9 * letters, y + 0.5 * letters], letters, ink);
    }
    // One word a line, above the bar.
    let words: Vec<&str> = legend.title.split(' ').collect();
    for (i, word) in words.iter().rev().enumerate() {
        canvas.write(word, [left, top - (1.7 + 1.7 * i as f64) * letters], letters, ink);
    }
}

/// A number with three digits of the largest one on the scale.
fn number(value: f64, largest: f64) -> String {
    // Beyond these, zeros would say less than an exponent.
    if value == 0.0 || value.abs() < 1e-9 * largest {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&largest) {
        return format!("{value:.1e}");
    }
    let decimals = (2 - largest.log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.decimals$}");
    if decimals == 0 { text } else { text.trim_end_matches('0').trim_end_matches('.').to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let shown = |value, largest| number(value, largest);
        assert_eq!(shown(1.0, 1.5), "1");
        assert_eq!(shown(-0.1234, 1.5), "-0.12");
        assert_eq!(shown(12345.6, 20000.0), "12346");
        assert_eq!(shown(1.5e-7, 3e-7), "1.5e-7");
        assert_eq!(shown(1e-18, 2.0), "0");
        assert_eq!(shown(0.00123, 0.002), "0.00123");
    }

    #[test]
    fn the_bar_has_the_colors_of_the_scale() {
        let white = Color([1.0; 3]);
        let mut canvas = Canvas { width: 600, height: 400, colors: vec![white; 240_000] };
        let legend =
            Legend { title: "Mean curvature".into(), range: [-1.0, 1.0], scale: ColorScale::Diverging };
        draw(&legend, &mut canvas);
        let column = (600.0 * (1.0 - SHARE)) as usize + 8;
        let at = |y: usize| canvas.colors[y * 600 + column].to_srgb();
        assert!(at(115)[0] > at(115)[2] && at(285)[2] > at(285)[0], "red above, blue below");
        let ink = canvas.colors.iter().filter(|c| c.0[0] < 0.1).count();
        assert!(ink > 100, "{ink}");
        let left = canvas.colors.iter().enumerate().filter(|(i, _)| i % 600 < 500);
        assert!(left.into_iter().all(|(_, c)| *c == white), "the rest of the picture is as it was");
    }
}
