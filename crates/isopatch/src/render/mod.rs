//! Pictures of surfaces, drawn on the CPU: antialiased, with soft light, and the same bytes every time.
//!
//! [`scene()`] makes a [`Scene`] of a [`Tessellation`](crate::tessellate::Tessellation) in some [`Style`], [`draw`] makes an
//! [`Image`] of it, and [`crate::io::png`] writes that. A scene can have lines and translucent faces of one's own as well.
//!
//! ```text
//! style.rs      what is painted and drawn;  borders.rs, wires.rs, curvature.rs find it in the surface
//! view.rs       the camera
//! skylight.rs   how much light reaches each vertex
//! raster.rs     triangles and lines to samples, 16 a pixel, in tiles
//! shade.rs      the colour of a sample
//! legend.rs     a bar of colours with numbers, in the strokes of letters.rs
//! draw.rs       all of it, tile by tile
//! ```

mod borders;
mod color;
mod curvature;
mod draw;
mod legend;
mod letters;
mod polygons;
mod raster;
mod scene;
mod shade;
mod skylight;
mod style;
mod view;
mod wires;

pub use borders::Borders;
pub use color::{Color, ColorScale};
pub use curvature::{Curvature, curvature};
pub use draw::{Image, MAX_SIZE, RenderError, RenderOptions, draw};
pub use polygons::of_polygons;
pub use scene::{Legend, LineSet, Metal, Paint, Scene, Veil};
pub use style::{Style, StyleError, Subject, scene};
pub use view::{UnknownView, Up, View};
