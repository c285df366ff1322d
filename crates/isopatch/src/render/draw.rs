//! A scene to an image.

use super::legend::{self, Canvas};
use super::raster::{
    Bins, Flat, NOTHING, SAMPLES, Samples, Shapes, Span, Stroke, TILE, box_of, box_of_stroke, sample_at,
};
use super::shade::{Point, Studio};
use super::skylight::{Light, skylight};
use super::view::{Area, Camera, Pixel, Up, View};
use super::{Color, Paint, Scene};
use crate::geom::{Aabb, Vec3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// How a scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Width and height in pixels, 1 to [`MAX_SIZE`]; default 1200 × 900.
    pub size: [usize; 2],
    /// From where; none for a view from above and aside that shows the broader side.
    pub view: Option<View>,
    /// Which axis points up; default z.
    pub up: Up,
    /// Background at the top and at the bottom; default nearly white to a light grey.
    pub background: [Color; 2],
}

impl Default for RenderOptions {
    fn default() -> Self {
        let background = [Color::srgb(0xfbfbfc), Color::srgb(0xdfe3e8)];
        Self { size: [1200, 900], view: None, up: Up::Z, background }
    }
}

/// Largest width and height: an image of this size takes 3 GB while it is drawn.
pub const MAX_SIZE: usize = 16384;

/// Why a scene can't be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// The size is out of range.
    #[error("a picture of {width} by {height} pixels: width and height are from 1 to {MAX_SIZE}")]
    Size {
        /// Width.
        width: usize,
        /// Height.
        height: usize,
    },
}

/// An image, rows from top to bottom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue of each pixel, sRGB.
    pub rgb: Vec<u8>,
}

/// Room around the model, in parts of the width and the height.
const MARGIN: f64 = 0.055;
/// Height of the picture for which the thickness of lines is given.
const STANDARD_HEIGHT: f64 = 900.0;

/// Draws a scene: 16 samples a pixel, the nearest surface first. The same bytes whatever the number of threads.
///
/// # Errors
/// The size is out of range.
pub fn draw(scene: &Scene<'_>, options: &RenderOptions) -> Result<Image, RenderError> {
    let [width, height] = options.size;
    if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
        return Err(RenderError::Size { width, height });
    }
    let picture = Picture::new(scene, options);
    let tiles = [width.div_ceil(TILE), height.div_ceil(TILE)];
    let shapes = picture.shapes();
    let triangle = |t: &[u32; 3]| box_of(t.map(|v| picture.corners[v as usize]));
    let boxes = shapes.triangles.iter().map(triangle).chain(picture.strokes.iter().map(box_of_stroke));
    let (bins, veil_bins) =
        (Bins::new(tiles, boxes), Bins::new(tiles, picture.veils.iter().map(|v| box_of(v.corners))));
    let drawn: Vec<Vec<Color>> = (0..tiles[0] * tiles[1])
        .into_par_iter()
        .evenly()
        .map(|tile| {
            picture.tile(&shapes, tile_span(tile, tiles, options.size), bins.of(tile), veil_bins.of(tile))
        })
        .collect();
    let mut canvas = Canvas { width, height, colors: vec![Color::default(); width * height] };
    for (tile, colors) in drawn.iter().enumerate() {
        let span = tile_span(tile, tiles, options.size);
        let across = span.max[0] - span.min[0];
        for (row, colors) in colors.chunks(across).enumerate() {
            let start = (span.min[1] + row) * width + span.min[0];
            canvas.colors[start..start + across].copy_from_slice(colors);
        }
    }
    if let Some(legend) = &scene.legend {
        legend::draw(legend, &mut canvas);
    }
    let rgb = canvas.colors.par_iter().evenly().flat_map_iter(|c| c.to_srgb()).collect();
    Ok(Image { width, height, rgb })
}

fn tile_span(tile: usize, [across, _]: [usize; 2], size: [usize; 2]) -> Span {
    let min = [tile % across * TILE, tile / across * TILE];
    Span { min, max: std::array::from_fn(|c| (min[c] + TILE).min(size[c])) }
}

/// A translucent triangle in the picture.
struct FlatVeil {
    corners: [Pixel; 3],
    color: Color,
    opacity: f32,
}

/// A scene as the camera sees it.
struct Picture<'a> {
    scene: &'a Scene<'a>,
    options: &'a RenderOptions,
    camera: Camera,
    studio: Studio,
    corners: Vec<Pixel>,
    /// In the axes of the camera.
    normals: Vec<Vec3>,
    lights: Vec<Light>,
    strokes: Vec<Stroke>,
    /// From far to near.
    veils: Vec<FlatVeil>,
}

impl<'a> Picture<'a> {
    fn new(scene: &'a Scene<'a>, options: &'a RenderOptions) -> Self {
        let [width, height] = options.size.map(|n| n as f64);
        let extent = scene.extent();
        let view = options.view.unwrap_or_else(|| View::three_quarter(&Aabb::around(&extent), options.up));
        let legend = if scene.legend.is_some() { legend::SHARE } else { 0.0 };
        let margin = MARGIN * width.min(height);
        let area = Area { min: [margin; 2], max: [width * (1.0 - legend) - margin, height - margin] };
        let camera = Camera::around(&extent, view, options.up, area);
        let studio = Studio::new(&scene.paint);
        let mesh = scene.mesh;
        let stroke = |(set, ends): (usize, &[_; 2])| Stroke {
            ends: [camera.project(&ends[0]), camera.project(&ends[1])],
            radius: 0.5 * scene.lines[set].width * height / STANDARD_HEIGHT,
            set: set as u32,
        };
        let segments =
            scene.lines.iter().enumerate().flat_map(|(set, l)| l.segments.iter().map(move |s| (set, s)));
        Self {
            corners: mesh.positions.par_iter().evenly().map(|p| camera.project(p)).collect(),
            normals: mesh.normals.par_iter().evenly().map(|n| camera.direction(n)).collect(),
            lights: skylight(mesh, &camera, &studio.key),
            strokes: segments.map(stroke).collect(),
            veils: veils(scene, &camera),
            scene,
            options,
            camera,
            studio,
        }
    }

    fn shapes(&self) -> Shapes<'_> {
        Shapes { corners: &self.corners, triangles: &self.scene.mesh.triangles }
    }

    /// The colours of a tile's pixels.
    fn tile(&self, shapes: &Shapes<'_>, span: Span, numbers: &[u32], veils: &[u32]) -> Vec<Color> {
        let mut samples = Samples::new(span);
        let triangles = shapes.triangles.len() as u32;
        for number in numbers {
            match number.checked_sub(triangles) {
                None => {
                    if let Some(flat) = shapes.flat(*number as usize) {
                        samples.in_triangle(&flat, |samples, at, near| samples.keep(at, near, *number));
                    }
                }
                Some(stroke) => {
                    let stroke = &self.strokes[stroke as usize];
                    samples.in_stroke(stroke, |samples, at, near| samples.keep(at, near, *number));
                }
            }
        }
        let mut colors = self.shaded(shapes, &samples);
        let strokes = &numbers[numbers.partition_point(|n| *n < triangles)..];
        self.see_through(
            strokes.iter().map(|n| &self.strokes[(n - triangles) as usize]),
            &mut samples,
            &mut colors,
        );
        for veil in veils.iter().map(|v| &self.veils[*v as usize]) {
            if let Some(flat) = Flat::new(veil.corners) {
                samples.in_triangle(&flat, |samples, at, near| {
                    if near > samples.near[at] {
                        colors[at] = colors[at].mix(veil.color, veil.opacity);
                    }
                });
            }
        }
        let mean = |pixel: &[Color]| {
            pixel.iter().fold(Color::default(), |sum, c| sum.plus(*c)).scaled(1.0 / SAMPLES as f32)
        };
        colors.chunks(SAMPLES).map(mean).collect()
    }

    /// The colour of each sample.
    fn shaded(&self, shapes: &Shapes<'_>, samples: &Samples) -> Vec<Color> {
        let span = samples.span;
        let triangles = shapes.triangles.len() as u32;
        let mut colors = Vec::with_capacity(samples.shape.len());
        for y in span.min[1]..span.max[1] {
            let background = self.background(y);
            for x in span.min[0]..span.max[0] {
                let first = samples.first(x, y);
                // What the samples of the pixel have in common: the light on a triangle, by its stripes, is that of the first one.
                let mut seen = [(NOTHING, None, background); SAMPLES];
                let mut count = 0;
                for s in 0..SAMPLES {
                    let shape = samples.shape[first + s];
                    let at = sample_at(x, y, s);
                    let stroke = shape.checked_sub(triangles);
                    let stripe =
                        if stroke.is_none() { self.stripe(shapes, shape as usize, at) } else { None };
                    let known = seen[..count].iter().find(|known| (known.0, known.1) == (shape, stripe));
                    let color = match (known, shape, stroke) {
                        (Some(known), ..) => known.2,
                        (None, NOTHING, _) => background,
                        (None, _, Some(stroke)) => {
                            self.scene.lines[self.strokes[stroke as usize].set as usize].color
                        }
                        (None, _, None) => self.surface(shapes, shape as usize, at, stripe == Some(true)),
                    };
                    if known.is_none() {
                        seen[count] = (shape, stripe, color);
                        count += 1;
                    }
                    colors.push(color);
                }
            }
        }
        colors
    }

    /// Which stripe of a striped paint is at a point of the picture.
    fn stripe(&self, shapes: &Shapes<'_>, t: usize, at: [f64; 2]) -> Option<bool> {
        if !matches!(self.scene.paint, Paint::Isophotes { .. } | Paint::Reflection { .. }) {
            return None;
        }
        let flat = shapes.flat(t)?;
        let normal = self.normal(&flat, t, flat.weights(at));
        Studio::stripe(&self.scene.paint, &normal, &self.camera.eye_at(at))
    }

    /// The unit normal towards the eye.
    fn normal(&self, flat: &Flat, t: usize, weights: [f64; 3]) -> Vec3 {
        let numbers = self.scene.mesh.normal_numbers(t);
        let normal: Vec3 = (0..3).map(|k| weights[k] * self.normals[numbers[k] as usize]).sum();
        let normal = normal.try_normalize(0.0).unwrap_or_else(Vec3::z);
        if flat.is_front { normal } else { -normal }
    }

    fn background(&self, y: usize) -> Color {
        let [top, bottom] = self.options.background;
        top.mix(bottom, (y as f32 + 0.5) / self.options.size[1] as f32)
    }

    /// The colour of a triangle at a point of the picture.
    fn surface(&self, shapes: &Shapes<'_>, t: usize, at: [f64; 2], is_bright: bool) -> Color {
        let Some(flat) = shapes.flat(t) else { return Color::default() };
        let mesh = self.scene.mesh;
        let weights = flat.weights(at);
        let lights = mesh.normal_numbers(t).map(|n| &self.lights[n as usize]);
        let point = Point {
            normal: self.normal(&flat, t, weights),
            eye: self.camera.eye_at(at),
            is_front: flat.is_front,
            is_bright,
            light: Point::lit_by(lights, weights, flat.is_front),
        };
        self.studio.shade(&self.scene.paint, mesh.patches[t].index(), t, weights, &point)
    }

    /// Blends the hidden strokes, each kind once a sample.
    fn see_through<'s>(
        &self,
        strokes: impl Iterator<Item = &'s Stroke>,
        samples: &mut Samples,
        colors: &mut [Color],
    ) {
        let mut last_set = vec![u32::MAX; 0];
        for stroke in strokes {
            let set = &self.scene.lines[stroke.set as usize];
            if set.hidden <= 0.0 {
                continue;
            }
            last_set.resize(colors.len(), u32::MAX);
            samples.in_stroke(stroke, |samples, at, near| {
                if near <= samples.near[at] && last_set[at] != stroke.set {
                    last_set[at] = stroke.set;
                    // What is drawn itself needs no blending.
                    let is_line = samples.shape[at] as usize >= self.scene.mesh.triangles.len();
                    let part = if is_line { 0.0 } else { set.hidden };
                    colors[at] = colors[at].mix(set.color, part);
                }
            });
        }
    }
}

/// The veils of a scene from far to near.
fn veils(scene: &Scene<'_>, camera: &Camera) -> Vec<FlatVeil> {
    let mut veils: Vec<FlatVeil> = scene
        .veils
        .iter()
        .map(|veil| FlatVeil {
            corners: veil.corners.map(|p| camera.project(&p)),
            color: veil.color,
            opacity: veil.opacity,
        })
        .collect();
    let depth = |veil: &FlatVeil| veil.corners.iter().map(|p| p.near).sum::<f64>();
    veils.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    veils
}
