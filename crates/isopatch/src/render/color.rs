//! Colours, in which light adds up, and scales of them.

/// A colour in linear light: red, green and blue, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Color(pub [f32; 3]);

impl Color {
    /// The colour of a web page: 0xRRGGBB.
    pub fn srgb(code: u32) -> Self {
        Self([16, 8, 0].map(|shift| linear((code >> shift & 0xff) as f32 / 255.0)))
    }

    /// The colour as three bytes of sRGB.
    pub fn to_srgb(self) -> [u8; 3] {
        // The cast saturates.
        self.0.map(|c| (255.0 * encoded(c.clamp(0.0, 1.0))).round() as u8)
    }

    /// This colour at t = 0, the other at t = 1.
    pub fn mix(self, other: Self, t: f32) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + t * (other.0[i] - self.0[i])))
    }

    /// Every channel times a number.
    pub fn scaled(self, by: f32) -> Self {
        Self(self.0.map(|c| by * c))
    }

    /// Channel times channel: light on paint.
    pub fn times(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * other.0[i]))
    }

    /// Light and light.
    pub fn plus(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

/// sRGB (IEC 61966-2-1) to linear light.
fn linear(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Linear light to sRGB.
fn encoded(c: f32) -> f32 {
    if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// A scale from numbers in [0, 1] to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorScale {
    /// Blue over grey to red, for numbers of both signs: the middle is zero.
    Diverging,
    /// Dark to bright, for numbers of one sign.
    Sequential,
}

impl ColorScale {
    /// Colours at equal steps, sRGB. Lightness falls off evenly from the middle, or rises evenly from the start.
    fn stops(self) -> [u32; 5] {
        match self {
            Self::Diverging => [0x27488f, 0x6d9bd2, 0xebe9e4, 0xe39468, 0x9c2236],
            Self::Sequential => [0x2f2a63, 0x2e6a90, 0x3aa68c, 0xa5d16d, 0xf6e97c],
        }
    }

    /// The colours at equal steps, in which [`Self::at`] interpolates.
    pub fn table(self) -> [Color; 5] {
        self.stops().map(Color::srgb)
    }

    /// The colour of a number; numbers outside of [0, 1] have that of the end.
    pub fn at(table: &[Color; 5], t: f32) -> Color {
        let x = if t.is_finite() { t.clamp(0.0, 1.0) * 4.0 } else { 2.0 };
        let step = (x as usize).min(3);
        table[step].mix(table[step + 1], x - step as f32)
    }
}

/// Colours that are told apart when they lie side by side, of the same lightness so that shading is still seen.
pub(super) const PATCH_COLORS: [u32; 7] =
    [0x8fb4d9, 0xe8b27d, 0x96c79a, 0xd99aa5, 0xb7a6d6, 0xd9cb86, 0x88c6c3];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_linear_light() {
        for byte in 0..=255u32 {
            let code = byte << 16 | (255 - byte) << 8 | byte;
            let bytes = Color::srgb(code).to_srgb();
            assert_eq!(bytes, [byte as u8, (255 - byte) as u8, byte as u8]);
        }
    }

    #[test]
    fn scales_end_in_their_ends() {
        for scale in [ColorScale::Diverging, ColorScale::Sequential] {
            let table = scale.table();
            for (t, stop) in [(-3.0, 0), (0.25, 1), (0.5, 2), (f32::NAN, 2), (1e30, 4)] {
                assert_eq!(ColorScale::at(&table, t).to_srgb(), table[stop].to_srgb());
            }
        }
    }
}
