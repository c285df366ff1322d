//! What can be typed.

use crate::outputs::{OutputFile, VtkCells};
use crate::values;
use clap::{Args, Parser, Subcommand, ValueEnum};
use isopatch::base::BaseMethod;
use isopatch::geom::Aabb;
use isopatch::io::Unit;
use isopatch::recipes::apatch::{GradientLengths, NormalSource};
use isopatch::recipes::hybrid::{Polygons, TriangleElement};
use isopatch::recipes::spline::Effort;
use isopatch::render::View;
use std::path::PathBuf;

/// Turn a formula into a smooth solid made of few Bézier patches, for CAD, or a mesh into a smooth surface through it.
#[derive(Debug, Parser)]
#[command(name = "isopatch", version, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Fit(Box<Fit>),
    Inspect(Inspect),
    Convert(Convert),
    Render(Render),
    Singular(Singular),
    Gallery(Gallery),
}

/// Make a smooth surface from a formula or a mesh and write it
#[derive(Debug, Args)]
#[command(after_help = FIT_EXAMPLES)]
pub struct Fit {
    /// A formula, such as "x^2+y^2+z^2-1" or "x^4+y^4+z^4 = 1+4xyz", the name of a surface of `isopatch gallery`, or a
    /// mesh file (.obj .off .ply .stl)
    #[arg(allow_hyphen_values = true, value_parser = values::input)]
    pub input: String,

    #[command(flatten)]
    pub options: FitOptions,

    /// Take options from a TOML file, by their long names; what is typed wins
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
}

const FIT_EXAMPLES: &str = "\
Examples:
  isopatch fit decocube -o decocube.step -o decocube.glb --report decocube.json
  isopatch fit \"x^4+y^4+z^4 = 1\" --tol 1e-4 -o cube.step
  isopatch fit torus --base models/torus-20x10.off -o torus.step
  isopatch fit bunny.obj --method apatch -o bunny.glb
  isopatch fit part.stl --crease-angle 40 -o part.glb -o part.isopatch

Exit status: 0 done; 1 the input can't be handled; 2 the command line is wrong; 3 made, but --tol was not reached
(no file is written); 130 interrupted.";

/// The options of `fit`, from the command line or a file.
#[derive(Clone, Debug, Default, Args)]
pub struct FitOptions {
    /// Output file, as often as wanted; its ending is the format: .step .stp .vtu .msh .glb .3mf .obj .off .ply .stl
    /// .png .isopatch
    #[arg(short, long, value_name = "OUT", value_parser = values::output)]
    pub output: Vec<OutputFile>,

    /// How the surface is made; auto: formula → spline, but flat triangles where it is
    /// singular; mesh → apatch
    #[arg(long, value_name = "METHOD")]
    pub method: Option<Method>,

    /// Box that holds the surface [default: that of the gallery, or found if the surface is bounded]
    #[arg(
        long = "box",
        value_name = "XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX",
        allow_hyphen_values = true,
        value_parser = values::bounds
    )]
    pub bounds: Option<Aabb>,

    /// Make the surface f = LEVEL instead of f = 0
    #[arg(long, allow_hyphen_values = true, value_parser = values::finite)]
    pub level: Option<f64>,

    /// Number of patches [default: that of the gallery, or as many as the curvature asks for]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::faces, conflicts_with = "tol")]
    pub faces: Option<usize>,

    /// Largest distance between surface and formula, relative to the diagonal
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = values::tolerance)]
    pub tol: Option<f64>,

    /// What a formula's spline costs: quick (up to three times faster, with about twice the patches) or full (the fewest
    /// patches, the least error) [default: full]
    #[arg(long, value_name = "EFFORT", conflicts_with = "base")]
    pub effort: Option<EffortChoice>,

    /// Value of a name in the formula, as often as wanted
    #[arg(long, value_name = "NAME=VALUE", value_parser = values::assignment)]
    pub set: Vec<String>,

    /// Take the base mesh from a file (.obj .off .ply .stl); its vertices are projected onto the surface
    #[arg(long, value_name = "MESH", conflicts_with = "faces")]
    pub base: Option<PathBuf>,

    /// How the base mesh is made: remesh (edge lengths follow curvature and error) or qem (decimation and flips only)
    /// [default: remesh]
    #[arg(long, value_name = "METHOD", conflicts_with = "base")]
    pub base_method: Option<MeshMethod>,

    /// Make flat triangles that conform to singular points and curves; edge and vertex are the paper's ways to do so, which
    /// may leave gaps and then say so [default: conforming, where there are singularities]
    #[arg(long, value_name = "HOW")]
    pub triangulate: Option<Triangulation>,

    /// How a surface is made: default, or paper (as the method's paper has it, to compare with; what that breaks is reported)
    /// [default: default]
    #[arg(long, value_name = "RECIPE", conflicts_with_all = ["tol", "base", "base_method", "effort"])]
    pub recipe: Option<Recipe>,

    /// Where the normals of a mesh come from [default: the file if it has any, else loop; over
    /// polygons angle]
    #[arg(long, value_name = "SOURCE", help_heading = MESHES)]
    pub normals: Option<Normals>,

    /// How long the gradients at the vertices of a mesh are [default: given]
    #[arg(long, value_name = "LENGTHS", help_heading = MESHES)]
    pub gradient_lengths: Option<Lengths>,

    /// Edges of a mesh whose faces are at more than this angle, in degrees, are sharp [default: none]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = values::angle, help_heading = MESHES)]
    pub crease_angle: Option<f64>,

    /// What becomes of the quadrilaterals, pentagons and so on of a mesh: keep (patches over them as they are) or split (into
    /// triangles) [default: keep]
    #[arg(long, value_name = "HOW", help_heading = MESHES)]
    pub polygons: Option<PolygonChoice>,

    /// The cells over the triangles of a mesh: triangle (the triangle method's, in a mesh of triangles alone) or hybrid (the
    /// polygon method's in any mesh) [default: triangle]
    #[arg(long, value_name = "ELEMENT", help_heading = MESHES)]
    pub triangle_element: Option<TriangleChoice>,

    /// Shape of A-patches: a number, larger for flatter patches, or a file with a line for each face of the mesh: the
    /// numbers of its outer and its inner side, - for the default [default: from the neighbours]
    #[arg(long, value_name = "VALUE|FILE", allow_hyphen_values = true, value_parser = values::free, help_heading = MESHES)]
    pub free: Option<FreeValues>,

    /// Intervals along the edge of a patch, where flat triangles are written: .glb .3mf .obj .off .ply .stl, and .vtu
    /// with linear cells, and .vtu and .msh of A-patches [default: 8, or less where A-patches would become more than 10 million triangles]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::resolution)]
    pub resolution: Option<usize>,

    /// Instead of that, the largest height of the surface over its flat triangles, as a share of the diagonal (measured)
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = values::positive, conflicts_with = "resolution")]
    pub chord: Option<f64>,

    /// What the cells of a .vtu are [default: bezier; linear for A-patches, which have no other]
    #[arg(long)]
    pub cells: Option<VtkCells>,

    /// What one unit of the formula or mesh is: mm, cm, m or in [default: mm]
    #[arg(long)]
    pub unit: Option<Unit>,

    /// Write what is known about the result as JSON
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,

    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,

    /// Number of threads [default: one a processor]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::threads)]
    pub threads: Option<usize>,
}

/// How a surface with singularities is triangulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Triangulation {
    /// Cones at singular points and along curves, bounds elsewhere
    Conforming,
    /// Expansion over edges from seeds (Bajaj & Xu 1997, Algorithm 1): checked, not certain
    Edge,
    /// Expansion around vertices (Algorithm 2): checked, not certain
    Vertex,
}

/// What the spline of a formula costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EffortChoice {
    /// Time: no evening, no thinning
    Quick,
    /// Few patches and small errors
    Full,
}

impl From<EffortChoice> for Effort {
    fn from(choice: EffortChoice) -> Self {
        match choice {
            EffortChoice::Quick => Self::Quick,
            EffortChoice::Full => Self::Full,
        }
    }
}

/// How a base mesh is made from a fine one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MeshMethod {
    /// Edge lengths follow curvature and error
    Remesh,
    /// Decimation by quadric errors, and flips
    Qem,
}

/// How a surface is made by its method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Recipe {
    /// With rounds, as it is best
    Default,
    /// As printed
    Paper,
}

impl From<MeshMethod> for BaseMethod {
    fn from(method: MeshMethod) -> Self {
        match method {
            MeshMethod::Remesh => Self::Remesh,
            MeshMethod::Qem => Self::Decimate,
        }
    }
}

/// How a surface is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// The method that suits the input
    Auto,
    /// G1 spline of degree-7 Bézier triangles
    Spline,
    /// Rational patches over triangles, through the vertices of a mesh
    Rational,
    /// Rational A-patches through the vertices of a mesh
    Apatch,
}

/// Options that only a mesh takes.
const MESHES: &str = "Options for meshes";

/// Where normals come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Normals {
    /// The file, one a vertex; their lengths count, see --gradient-lengths
    File,
    /// The limit of Loop subdivision
    Loop,
    /// The faces around a vertex, weighted by their angles
    Angle,
    /// The faces around a vertex, weighted by their areas
    Area,
}

impl From<Normals> for NormalSource {
    fn from(normals: Normals) -> Self {
        match normals {
            Normals::File => Self::File,
            Normals::Loop => Self::Loop,
            Normals::Angle => Self::Angle,
            Normals::Area => Self::Area,
        }
    }
}

/// How long gradients are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Lengths {
    /// As long as the normals of the file; 1 for computed normals
    Given,
    /// 1
    Unit,
    /// Such that edges can be chords of a quadric: better where the curvature changes, exact for ellipsoids
    Recovered,
}

impl From<Lengths> for GradientLengths {
    fn from(lengths: Lengths) -> Self {
        match lengths {
            Lengths::Given => Self::Given,
            Lengths::Unit => Self::Unit,
            Lengths::Recovered => Self::Recovered,
        }
    }
}

/// What becomes of polygons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PolygonChoice {
    /// Patches over them as they are
    Keep,
    /// They are cut into triangles
    Split,
}

impl From<PolygonChoice> for Polygons {
    fn from(choice: PolygonChoice) -> Self {
        match choice {
            PolygonChoice::Keep => Self::Keep,
            PolygonChoice::Split => Self::Split,
        }
    }
}

/// Which cells stand over triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TriangleChoice {
    /// Those of the triangle method, in a mesh of triangles alone
    Triangle,
    /// Those of the polygon method, in any mesh
    Hybrid,
}

impl From<TriangleChoice> for TriangleElement {
    fn from(choice: TriangleChoice) -> Self {
        match choice {
            TriangleChoice::Triangle => Self::Triangle,
            TriangleChoice::Hybrid => Self::Hybrid,
        }
    }
}

/// Free parameters, or where they are.
#[derive(Clone, Debug, PartialEq)]
pub enum FreeValues {
    All(f64),
    File(PathBuf),
}

/// Measure a native file (.isopatch) on fresh samples
#[derive(Debug, Args)]
pub struct Inspect {
    /// A native file
    #[arg(value_name = "FILE.isopatch")]
    pub file: PathBuf,

    /// Formula or gallery name to measure against [default: the formula in the file]; not for A-patches
    #[arg(long, value_name = "FORMULA", allow_hyphen_values = true)]
    pub against: Option<String>,

    /// Value of a name in the formula of --against, as often as wanted
    #[arg(long, value_name = "NAME=VALUE", value_parser = values::assignment, requires = "against")]
    pub set: Vec<String>,

    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

/// Write a native file (.isopatch) in other formats
#[derive(Debug, Args)]
pub struct Convert {
    /// A native file
    #[arg(value_name = "IN.isopatch")]
    pub input: PathBuf,

    /// Output file; its ending is the format: .step .stp .vtu .msh .glb .3mf .obj .off .ply .stl .png .isopatch
    #[arg(value_name = "OUT", required = true, value_parser = values::output)]
    pub output: Vec<OutputFile>,

    /// Intervals along the edge of a patch, where flat triangles are written: .glb .3mf .obj .off .ply .stl, and .vtu
    /// with linear cells, and .vtu and .msh of A-patches [default: 8, or less where A-patches would become more than 10 million triangles]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::resolution)]
    pub resolution: Option<usize>,

    /// Instead of that, the largest height of the surface over its flat triangles, as a share of the diagonal (measured)
    #[arg(long, value_name = "T", allow_hyphen_values = true, value_parser = values::positive, conflicts_with = "resolution")]
    pub chord: Option<f64>,

    /// What the cells of a .vtu are [default: bezier; linear for A-patches, which have no other]
    #[arg(long)]
    pub cells: Option<VtkCells>,

    /// What one unit of the surface is: mm, cm, m or in; no coordinate changes [default: as the native file says]
    #[arg(long)]
    pub unit: Option<Unit>,
}

/// Draw a native file (.isopatch) or a mesh (.obj .off .ply .stl) as a picture
#[derive(Debug, Args)]
#[command(after_help = RENDER_EXAMPLES)]
pub struct Render {
    /// A native file or a mesh
    #[arg(value_name = "IN")]
    pub input: PathBuf,

    /// Picture to write
    #[arg(short, long, value_name = "OUT.png", value_parser = values::picture)]
    pub output: OutputFile,

    /// What is shown [default: shaded]
    #[arg(long, value_name = "STYLE")]
    pub style: Option<PictureStyle>,

    /// Width and height in pixels [default: 1200x900]
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    pub size: Option<[usize; 2]>,

    /// Where the eye is: front, back, left, right, top, bottom, or azimuth,elevation in degrees (front is -90,0)
    /// [default: aside and above, where the broader side is seen]
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true)]
    pub view: Option<View>,

    /// Axis that points up in the picture [default: z]
    #[arg(long, value_name = "AXIS")]
    pub up: Option<UpAxis>,

    /// Intervals along the edge of a patch [default: as many as are seen]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::resolution)]
    pub resolution: Option<usize>,

    /// Number of threads [default: one a processor]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = values::threads)]
    pub threads: Option<usize>,
}

const RENDER_EXAMPLES: &str = "\
Examples:
  isopatch render decocube.isopatch -o decocube.png
  isopatch render decocube.isopatch -o gold.png --style gold --size 1600x1200
  isopatch render part.isopatch -o top.png --style curvature --view top
  isopatch render bunny.obj -o bunny.png --style mesh --up y";

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PictureStyle {
    /// The surface in soft light
    #[default]
    Shaded,
    /// Every patch in a colour; of a mesh, every face
    Patches,
    /// Lines of equal angle to the vertical
    Isophotes,
    /// Black and white strips of light, reflected
    Reflection,
    /// The same in gold
    Gold,
    /// Gaussian curvature, with a scale
    Curvature,
    /// Mean curvature, with a scale
    MeanCurvature,
    /// Control net of a spline
    Net,
    /// Cells of the hull of A-patches
    Hull,
    /// Borders of the patches on the surface; of a mesh, its edges
    Mesh,
    /// Normals at the corners of patches
    Normals,
    /// Creases and boundary
    Singular,
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpAxis {
    /// As in some CAD programs
    X,
    /// As in many mesh files
    Y,
    /// As in most CAD programs
    Z,
}

/// Find the singular points and curves of an algebraic surface in a box, and its connected components
#[derive(Debug, Args)]
pub struct Singular {
    /// A polynomial, such as "x^2 = y z^2", with square roots of one kind, or the name of a surface of `isopatch gallery`
    #[arg(allow_hyphen_values = true, value_parser = values::input)]
    pub input: String,

    /// The box [default: that of the gallery]
    #[arg(
        long = "box",
        value_name = "XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX",
        allow_hyphen_values = true,
        value_parser = values::bounds
    )]
    pub bounds: Option<Aabb>,

    /// The surface f = LEVEL instead of f = 0
    #[arg(long, allow_hyphen_values = true, value_parser = values::finite)]
    pub level: Option<f64>,

    /// Value of a name in the formula, as often as wanted
    #[arg(long, value_name = "NAME=VALUE", value_parser = values::assignment)]
    pub set: Vec<String>,

    /// Print JSON: points, curves with samples, components with seeds
    #[arg(long)]
    pub json: bool,
}

/// List the surfaces that have a name
#[derive(Debug, Args)]
pub struct Gallery {
    /// Print a JSON array
    #[arg(long)]
    pub json: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
