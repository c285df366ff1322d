//! Kinds of pictures.

use super::borders::{Borders, segments};
use super::curvature::{Curvature, curvature, robust_range};
use super::{Color, ColorScale, Legend, LineSet, Metal, Paint, Scene, wires};
use crate::geom::Point3;
use crate::hull::Hull;
use crate::hybrid::HybridHull;
use crate::surface::Surface;
use crate::tessellate::Tessellation;

/// What a picture shows of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Style {
    /// The surface in one colour, its back in another one.
    #[default]
    Shaded,
    /// Every patch in a colour, with its border.
    Patches,
    /// Lines of equal angle between the normal and the vertical of the picture.
    Isophotes,
    /// Strips of light that are seen in the surface, black and white.
    Reflection,
    /// The same in gold.
    Gold,
    /// Gaussian curvature on a scale.
    GaussianCurvature,
    /// Mean curvature on a scale.
    MeanCurvature,
    /// Control points and the lines between them.
    Net,
    /// The cells of the hull of A-patches.
    Hull,
    /// The borders of the patches: the base mesh on the surface.
    Mesh,
    /// Normals at the corners of the patches.
    Normals,
    /// Singular points and curves, creases, and the boundary.
    Singular,
}

/// What a picture is made of.
#[derive(Clone, Copy, Default)]
pub struct Subject<'a> {
    /// The surface behind the triangles: for [`Style::Net`], and for normals at the corners of patches only.
    pub surface: Option<&'a dyn Surface>,
    /// The hull: for [`Style::Hull`].
    pub hull: Option<&'a Hull>,
    /// The hull over polygons: for [`Style::Hull`] as well.
    pub polygons: Option<&'a HybridHull>,
    /// Singular curves as polylines, and points as lines of one point: for [`Style::Singular`].
    pub singular: &'a [Vec<Point3>],
}

/// Why a surface can't be shown in a style.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StyleError {
    /// There are no control points.
    #[error("the surface has no control points to show")]
    NoNet,
    /// There is no hull.
    #[error("the surface has no hull to show; A-patches have one")]
    NoHull,
}

/// Colour of the outside, sRGB: a light blue grey.
const OUTSIDE: u32 = 0xa9c1dc;
/// Colour of the inside, sRGB: sand.
const INSIDE: u32 = 0xd9b384;
/// The outside where lines are to be seen on it.
const PALE: u32 = 0xd5dce4;
/// Lines of meshes.
const INK: u32 = 0x2c3640;
/// Singular curves and creases.
const RED: u32 = 0xc8202f;
/// Nets and cells outside of the surface.
const BLUE: u32 = 0x1f4e8c;
/// Cells inside.
const ORANGE: u32 = 0xd0741c;
/// Pairs of black and white, for a reading of the surface that is neither crowded nor coarse.
const ISOPHOTES: f64 = 18.0;
const STRIPS: f64 = 12.0;

/// The scene of a style.
pub fn scene<'a>(
    mesh: &'a Tessellation,
    subject: &Subject<'_>,
    style: Style,
) -> Result<Scene<'a>, StyleError> {
    let plain = |outside: u32| Paint::Plain { outside: Color::srgb(outside), inside: Color::srgb(INSIDE) };
    let lines = |segments, color: u32, width: f64, hidden: f32| LineSet {
        segments,
        color: Color::srgb(color),
        width,
        hidden,
    };
    let edges = |kind: &[&[[u32; 2]]]| kind.iter().flat_map(|edges| segments(mesh, edges)).collect();
    Ok(match style {
        Style::Shaded => Scene::new(mesh, plain(OUTSIDE)),
        Style::Patches => {
            let borders = Borders::new(mesh);
            let patches = mesh.patches.iter().map(|p| p.index() + 1).max().unwrap_or(0);
            let mut scene = Scene::new(mesh, Paint::Patches(borders.colors(patches)));
            scene.lines.push(lines(edges(&[&borders.seams]), INK, 0.8, 0.0));
            scene
        }
        Style::Isophotes => Scene::new(mesh, Paint::Isophotes { bands: ISOPHOTES }),
        Style::Reflection => Scene::new(mesh, Paint::Reflection { bands: STRIPS, metal: Metal::Chrome }),
        Style::Gold => Scene::new(mesh, Paint::Reflection { bands: STRIPS, metal: Metal::Gold }),
        Style::GaussianCurvature => of_curvature(mesh, Curvature::Gaussian, "Gaussian curvature"),
        Style::MeanCurvature => of_curvature(mesh, Curvature::Mean, "Mean curvature"),
        Style::Net => {
            let nets = subject.surface.and_then(wires::nets);
            let [net, points] = nets.ok_or(StyleError::NoNet)?;
            let borders = Borders::new(mesh);
            let mut scene = Scene::new(mesh, plain(PALE));
            scene.lines.push(lines(net, BLUE, 1.1, 0.25));
            scene.lines.push(lines(edges(&[&borders.seams, &borders.boundary]), INK, 1.6, 0.0));
            scene.lines.push(lines(points, ORANGE, 4.2, 0.0));
            scene
        }
        Style::Hull => {
            let colors = [BLUE, ORANGE].map(Color::srgb);
            let (veils, cells) = match (subject.hull, subject.polygons) {
                (Some(hull), _) => wires::cells(hull, colors),
                (None, Some(hull)) => wires::polygon_cells(hull, colors),
                (None, None) => return Err(StyleError::NoHull),
            };
            let mut scene = Scene::new(mesh, plain(PALE));
            scene.veils = veils;
            scene.lines.push(lines(cells, INK, 1.0, 0.0));
            scene
        }
        Style::Mesh => {
            let borders = Borders::new(mesh);
            let mut scene = Scene::new(mesh, plain(OUTSIDE));
            scene.lines.push(lines(edges(&[&borders.seams, &borders.boundary]), INK, 1.3, 0.0));
            scene
        }
        Style::Normals => {
            let normals = wires::normals(mesh, subject.surface);
            let feet = normals.iter().map(|[foot, _]| [*foot; 2]).collect();
            let mut scene = Scene::new(mesh, plain(PALE));
            scene.lines.push(lines(normals, BLUE, 1.4, 0.0));
            scene.lines.push(lines(feet, INK, 3.6, 0.0));
            scene
        }
        Style::Singular => {
            let borders = Borders::new(mesh);
            let pieces = |line: &Vec<Point3>| line.windows(2).map(|w| [w[0], w[1]]).collect::<Vec<_>>();
            let curves = subject.singular.iter().flat_map(pieces).collect();
            let points = subject.singular.iter().filter(|line| line.len() == 1).map(|line| [line[0]; 2]);
            let mut scene = Scene::new(mesh, plain(PALE));
            scene.lines.push(lines(edges(&[&borders.boundary]), INK, 1.6, 0.0));
            scene.lines.push(lines(edges(&[&borders.creases]), RED, 3.0, 0.3));
            scene.lines.push(lines(curves, RED, 4.0, 0.4));
            scene.lines.push(lines(points.collect(), RED, 11.0, 0.5));
            scene
        }
    })
}

fn of_curvature<'a>(mesh: &'a Tessellation, kind: Curvature, title: &str) -> Scene<'a> {
    let corners = curvature(mesh, kind);
    let (range, both_signs) = robust_range(mesh, &corners);
    let scale = if both_signs { ColorScale::Diverging } else { ColorScale::Sequential };
    let mut scene = Scene::new(mesh, Paint::Values { corners, range, scale });
    scene.legend = Some(Legend { title: title.to_owned(), range, scale });
    scene
}
