//! `isopatch render`, and the pictures among the outputs of `fit` and `convert`.

use crate::arguments::{PictureStyle, Render, UpAxis};
use crate::failure::Failure;
use crate::inspect::read;
use crate::interrupt::{Interruptible, Writing};
use crate::outputs::{self, flattened_for_picture};
use crate::threads;
use isopatch::geom::Point3;
use isopatch::io::atomic::Outputs;
use isopatch::io::native::{NativeModel, NativeSurface};
use isopatch::io::png::write_png;
use isopatch::io::read::read_mesh;
use isopatch::render::{Image, RenderOptions, Style, Subject, Up, View, draw, of_polygons, scene};
use isopatch::tessellate::Tessellation;
use std::path::Path;

/// What a picture shows, and how.
#[derive(Clone, Copy, Debug, Default)]
pub struct PictureOptions {
    pub style: PictureStyle,
    pub size: Option<[usize; 2]>,
    pub view: Option<View>,
    pub up: Up,
    /// Intervals along the edges of patches.
    pub resolution: Option<usize>,
}

pub fn run(arguments: &Render) -> Result<(), Failure> {
    threads::start(arguments.threads)?;
    let options = PictureOptions {
        style: arguments.style.unwrap_or_default(),
        size: arguments.size,
        view: arguments.view,
        up: arguments.up.map_or_else(Up::default, Into::into),
        resolution: arguments.resolution,
    };
    outputs::check(std::slice::from_ref(&arguments.output), None)?;
    let image = match is_native(&arguments.input) {
        true => of_model(&read(&arguments.input)?, &options)?,
        false => of_mesh(&arguments.input, &options)?,
    };
    let writing = Writing::begin();
    let mut files = Outputs::new();
    let path = &arguments.output.path;
    let result = files.write(path, |out| write_png(&image, &mut Interruptible(out)));
    if writing.interrupted() {
        return Err(Failure::Interrupted);
    }
    result?;
    outputs::commit(files, &writing, &[path])?;
    Ok(())
}

fn is_native(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("isopatch"))
}

/// Pieces of the polyline for a singular curve over one edge of the mesh.
const CURVE_PIECES: usize = 16;

/// The picture of a surface.
pub fn of_model(model: &NativeModel, options: &PictureOptions) -> Result<Image, Failure> {
    let mesh = flattened_for_picture(model, options.resolution)?;
    let hull = model.a_patches().map(|surface| surface.function().hull());
    let singular = model.rational().map_or_else(Vec::new, |surface| surface.singular_lines(CURVE_PIECES));
    let polygons = match &model.surface {
        NativeSurface::Hybrid(surface) => Some(surface.function().hull()),
        _ => None,
    };
    let surface = Some(model.as_surface());
    picture(&mesh, &Subject { surface, hull, polygons, singular: &singular }, options)
}

/// The picture of flat triangles with their singular set.
pub fn of_singular(mesh: &Tessellation, singular: &[Vec<Point3>]) -> Result<Image, Failure> {
    let options = PictureOptions { style: PictureStyle::Singular, ..PictureOptions::default() };
    picture(mesh, &Subject { singular, ..Subject::default() }, &options)
}

/// The picture of a mesh file as it is.
fn of_mesh(path: &Path, options: &PictureOptions) -> Result<Image, Failure> {
    if options.resolution.is_some() {
        return Err(Failure::Unfit(
            "--resolution is for the patches of a native file, not for a mesh".into(),
        ));
    }
    let mesh = read_mesh(path).map_err(|source| Failure::InputMesh { path: path.to_owned(), source })?;
    let mesh = of_polygons(&mesh.positions, &mesh.faces, mesh.normals.as_deref());
    picture(&mesh, &Subject::default(), options)
}

fn picture(mesh: &Tessellation, subject: &Subject<'_>, options: &PictureOptions) -> Result<Image, Failure> {
    let style = Style::from(options.style);
    let scene = scene(mesh, subject, style).map_err(|error| Failure::Unfit(format!("--style: {error}")))?;
    let standard = RenderOptions::default();
    let size = options.size.unwrap_or(standard.size);
    Ok(draw(&scene, &RenderOptions { size, view: options.view, up: options.up, ..standard })?)
}

impl From<PictureStyle> for Style {
    fn from(style: PictureStyle) -> Self {
        match style {
            PictureStyle::Shaded => Self::Shaded,
            PictureStyle::Patches => Self::Patches,
            PictureStyle::Isophotes => Self::Isophotes,
            PictureStyle::Reflection => Self::Reflection,
            PictureStyle::Gold => Self::Gold,
            PictureStyle::Curvature => Self::GaussianCurvature,
            PictureStyle::MeanCurvature => Self::MeanCurvature,
            PictureStyle::Net => Self::Net,
            PictureStyle::Hull => Self::Hull,
            PictureStyle::Mesh => Self::Mesh,
            PictureStyle::Normals => Self::Normals,
            PictureStyle::Singular => Self::Singular,
        }
    }
}

impl From<UpAxis> for Up {
    fn from(axis: UpAxis) -> Self {
        match axis {
            UpAxis::X => Self::X,
            UpAxis::Y => Self::Y,
            UpAxis::Z => Self::Z,
        }
    }
}
