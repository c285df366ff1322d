//! The colour of a point of the surface: paint, light and reflection. All directions are in the axes of the camera: to the
//! right, up, and towards the eye.

use super::skylight::Light;
use super::{Color, ColorScale, Metal, Paint};
use crate::geom::Vec3;
use std::f64::consts::{PI, TAU};

/// Direction to the main light: from above, on the left, in front.
const KEY: Vec3 = Vec3::new(-0.46, 0.62, 0.636);
/// Direction to the second light, which brightens the shadows: from the right.
const FILL: Vec3 = Vec3::new(0.83, 0.06, 0.55);
/// Direction to the third light, which parts the model from the background: from behind, above.
const RIM: Vec3 = Vec3::new(0.35, 0.62, -0.7);

/// Exponent of the highlight.
const GLOSS: f64 = 46.0;
/// Reflection of light that comes in head-on, of a varnish (Schlick 1994).
const VARNISH: f64 = 0.035;
/// Reflection of gold, linear light.
const GOLD: Color = Color([1.0, 0.7, 0.27]);
/// How much of the form light and shadow show on painted stripes; the rest is paint alone.
const STRIPE_SHADING: f32 = 0.42;

/// Strips are parallel to an axis that is tilted a little to the right, so that they do not follow the symmetries of most models;
/// this direction is across them.
const ACROSS_STRIPS: Vec3 = Vec3::new(-0.34, 0.940425, 0.0);

/// The studio: lights with their colours.
#[derive(Clone, Debug)]
pub(super) struct Studio {
    pub key: Vec3,
    fill: Vec3,
    rim: Vec3,
    /// Half-way between the key light and an eye straight ahead is found for each point; these are colours.
    key_color: Color,
    fill_color: Color,
    rim_color: Color,
    sky: Color,
    ground: Color,
    black: Color,
    white: Color,
    /// Colours of the scale of [`Paint::Values`].
    table: [Color; 5],
}

/// A point to be shaded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    /// Unit normal, towards the eye.
    pub normal: Vec3,
    /// Unit direction to the eye.
    pub eye: Vec3,
    /// Is it the outside that is seen?
    pub is_front: bool,
    /// Is it on a bright stripe?
    pub is_bright: bool,
    /// Light from all around and from the main light.
    pub light: [f32; 2],
}

impl Studio {
    pub fn new(paint: &Paint) -> Self {
        let scale = match paint {
            Paint::Values { scale, .. } => *scale,
            _ => ColorScale::Sequential,
        };
        Self {
            key: KEY.normalize(),
            fill: FILL.normalize(),
            rim: RIM.normalize(),
            key_color: Color([0.78, 0.745, 0.70]),
            fill_color: Color([0.13, 0.15, 0.18]),
            rim_color: Color([0.16, 0.17, 0.19]),
            sky: Color([0.38, 0.40, 0.43]),
            ground: Color([0.16, 0.15, 0.14]),
            black: Color::srgb(0x23262b),
            white: Color::srgb(0xf4f4f1),
            table: scale.table(),
        }
    }

    /// Which stripe of a striped paint a point is on: a bright one? None of other paints.
    pub fn stripe(paint: &Paint, normal: &Vec3, eye: &Vec3) -> Option<bool> {
        let turns = match paint {
            Paint::Isophotes { bands } => normal.y.clamp(-1.0, 1.0).acos() / PI * bands,
            Paint::Reflection { bands, .. } => {
                let r = 2.0 * normal.dot(eye) * normal - eye;
                r.dot(&ACROSS_STRIPS).atan2(r.z) / TAU * bands
            }
            Paint::Plain { .. } | Paint::Patches(_) | Paint::Values { .. } => return None,
        };
        Some(turns.rem_euclid(1.0) >= 0.5)
    }

    /// The colour of a point of a triangle.
    pub fn shade(
        &self,
        paint: &Paint,
        patch: usize,
        triangle: usize,
        weights: [f64; 3],
        point: &Point,
    ) -> Color {
        let stripe = if point.is_bright { self.white } else { self.black };
        let color = match paint {
            Paint::Plain { outside, inside } => {
                if point.is_front {
                    *outside
                } else {
                    *inside
                }
            }
            Paint::Patches(colors) => colors.get(patch).copied().unwrap_or(self.white),
            Paint::Values { corners, range: [low, high], .. } => {
                let Some(values) = corners.get(triangle) else { return self.white };
                let value: f64 = (0..3).map(|k| weights[k] * f64::from(values[k])).sum();
                ColorScale::at(&self.table, ((value - low) / (high - low)) as f32)
            }
            Paint::Isophotes { .. } => return stripe.mix(self.lit(stripe, point), STRIPE_SHADING),
            Paint::Reflection { metal: Metal::Chrome, .. } => {
                return stripe
                    .mix(self.lit(stripe, point), STRIPE_SHADING)
                    .scaled(0.4 + 0.6 * point.openness());
            }
            Paint::Reflection { metal: Metal::Gold, .. } => return self.gold(point),
        };
        self.lit(color, point)
    }

    /// Matt paint under a thin varnish.
    fn lit(&self, color: Color, point: &Point) -> Color {
        let n = &point.normal;
        let [sky, key] = point.light;
        let ambient = self.ground.mix(self.sky, (0.5 + 0.5 * n.y) as f32).scaled(sky);
        let cosine = |light: &Vec3| n.dot(light).max(0.0) as f32;
        let light = ambient
            .plus(self.key_color.scaled(cosine(&self.key) * key))
            .plus(self.fill_color.scaled(cosine(&self.fill) * (0.35 + 0.65 * sky)))
            .plus(self.rim_color.scaled(cosine(&self.rim) * sky));
        let half = (self.key + point.eye).normalize();
        let highlight = 0.34 * n.dot(&half).max(0.0).powf(GLOSS) as f32 * key;
        let glance = schlick(VARNISH, n.dot(&point.eye)) as f32;
        let gloss = self.key_color.scaled(highlight).plus(self.sky.scaled(0.75 * glance * sky));
        color.times(light).plus(gloss)
    }

    /// Strips around the model, seen in gold.
    fn gold(&self, point: &Point) -> Color {
        let strip = if point.is_bright { 0.95 } else { 0.025 };
        // A metal reflects everything at a glance, without its own tint.
        let tint = GOLD.mix(Color([1.0; 3]), schlick(0.0, point.normal.dot(&point.eye)) as f32);
        // A little light from everywhere, as the metal is not quite polished.
        let [sky, key] = point.light;
        let n = &point.normal;
        let soft =
            0.05 + 0.10 * (0.5 + 0.5 * n.y as f32) * sky + 0.12 * n.dot(&self.key).max(0.0) as f32 * key;
        let half = (self.key + point.eye).normalize();
        let highlight = 0.5 * n.dot(&half).max(0.0).powf(GLOSS) as f32 * key;
        tint.scaled(0.8 * strip + soft + highlight).scaled(point.openness())
    }
}

/// Part of the light that is reflected, by the cosine to the normal.
fn schlick(head_on: f64, cosine: f64) -> f64 {
    head_on + (1.0 - head_on) * (1.0 - cosine.clamp(0.0, 1.0)).powi(5)
}

impl Point {
    /// How much of the surroundings is reflected: deep inside, a metal sees itself.
    fn openness(&self) -> f32 {
        0.25 + 0.75 * self.light[0]
    }

    /// Light on the side that is seen.
    pub fn lit_by(lights: [&Light; 3], weights: [f64; 3], is_front: bool) -> [f32; 2] {
        let side = usize::from(!is_front);
        let mean = |of: fn(&Light) -> [f32; 2]| (0..3).map(|k| weights[k] as f32 * of(lights[k])[side]).sum();
        [mean(|light| light.sky), mean(|light| light.key)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(normal: Vec3, light: f32) -> Point {
        let normal = normal.normalize();
        Point { normal, eye: Vec3::z(), is_front: true, is_bright: false, light: [light; 2] }
    }

    #[test]
    fn light_comes_from_above_and_shadows_are_dark() {
        let paint = Paint::Plain { outside: Color([0.5; 3]), inside: Color([0.2; 3]) };
        let studio = Studio::new(&paint);
        let seen = |normal: Vec3, light: f32| {
            studio.shade(&paint, 0, 0, [1.0, 0.0, 0.0], &point(normal, light)).0[1]
        };
        let up = seen(Vec3::new(-0.3, 0.6, 0.7), 1.0);
        assert!(up > 2.0 * seen(Vec3::new(0.2, -0.7, 0.7), 1.0) && up < 0.8, "{up}");
        assert!(seen(Vec3::z(), 1.0) > 2.0 * seen(Vec3::z(), 0.0));
    }

    #[test]
    fn stripes_follow_the_normal() {
        let isophotes = Paint::Isophotes { bands: 10.0 };
        let reflection = Paint::Reflection { bands: 10.0, metal: Metal::Gold };
        let stripe = |paint: &Paint, elevation: f64| {
            let (s, c) = elevation.to_radians().sin_cos();
            Studio::stripe(paint, &(c * Vec3::z() + s * ACROSS_STRIPS), &Vec3::z()).unwrap()
        };
        // Bands of 9 degrees; y is 0.94 of the direction across the strips, so isophotes are asked near the horizon.
        assert_ne!(stripe(&isophotes, 2.0), stripe(&isophotes, -2.0));
        assert_eq!(stripe(&isophotes, 2.0), stripe(&isophotes, 6.0));
        // Bands of 18 degrees of the reflected ray, which turns twice as fast as the normal.
        for (a, b) in [(1.0, 8.0), (10.0, 17.0), (19.0, 26.0)] {
            assert_eq!(stripe(&reflection, a), stripe(&reflection, b));
        }
        assert_ne!(stripe(&reflection, 8.0), stripe(&reflection, 10.0));
        assert_eq!(Studio::stripe(&Paint::Patches(vec![]), &Vec3::z(), &Vec3::z()), None);
    }
}
