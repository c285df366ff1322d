//! Makes the surfaces in the figures of Xu, Huang & Bajaj 2001 as meshes and pictures, and a table of their numbers.
//!
//! `cargo run --release --example paper_000_figures -- OUT [MESHES]` writes PLY and PNG files and `table.txt` into the folder OUT. The
//! heads (Figs. 14 and 15) and the teapot (Figs. 16 and 17) are made from `cgal_head.off` and `npm_teapot.off` in the folder
//! MESHES, and left out without it. Figs. 1, 4, 5, 8, 11 and 12 show no surface.
//!
//! Each PLY file has the patch of every triangle; patches over faces come first. Figs. 14 and 17 show the two kinds apart and are two
//! files each.

use isopatch::apatch::{self, APatchFunction, APatchOptions, APatchSurface, Free, FreeRule, Layer2Rule};
use isopatch::bernstein::{cubic, triangle};
use isopatch::geom::{Point3, Vec3};
use isopatch::hull::{self, ApexRule, Class, HermiteMesh, HullOptions, Margin, Side};
use isopatch::inspect::{APatchInspectOptions, inspect_a_patches};
use isopatch::io::ply::write_ply;
use isopatch::io::png::write_png;
use isopatch::io::read::read_mesh;
use isopatch::mesh::{EdgeId, FaceId, HalfEdgeMesh};
use isopatch::recipes::apatch::{APatchRecipe, fit};
use isopatch::render::{Color, Paint, RenderOptions, Scene, Style, Subject, Up, View, draw, scene};
use isopatch::surface::{PatchId, Surface};
use isopatch::tessellate::{APatchResolution, Tessellation, tessellate_a_patches};
use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// The vertices p_1 … p_4 of section 6, and the faces [p_1 p_2 p_3] and [p_1 p_2 p_4].
const VERTICES: [[f64; 3]; 4] = [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 4.0, -1.0], [0.0, -4.0, -1.0]];
const FACES: [[u32; 3]; 2] = [[2, 0, 1], [3, 1, 0]];
/// Normals of Fig. 6 and of Fig. 9.
const CONVEX: [[f64; 3]; 4] = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]];
const NONCONVEX: [[f64; 3]; 4] = [[1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, -1.0, 1.5], [0.0, 1.0, 1.5]];
/// How far apexes stay above what bounds them, which the paper leaves open.
const MARGIN: f64 = 0.05;
/// Free parameters of Fig. 2. The bound of the faces is −1; the edge between them raises it to −0.8741.
const FAMILY: [f64; 6] = [-0.874, 0.0, 1.0, 4.0, 16.0, 64.0];
/// Intervals of the lattices on which lower bounds are sampled.
const BOUND_LATTICE: usize = 40;
/// What Fig. 3 is above its bound.
const NEAR: f64 = 1e-9;
const FINE: APatchResolution = APatchResolution { along: 40, across: 20 };
const COARSE: APatchResolution = APatchResolution { along: 8, across: 3 };
/// Width and height of the pictures.
const SIZE: [usize; 2] = [360, 270];
/// One colour behind them, which takes fewer bytes than two.
const BACKGROUND: u32 = 0xf4f6f8;
/// From where the joins of two faces are seen: along their common edge, and from above.
const ALONG_EDGE: View = View { azimuth: -25.0, elevation: 22.0 };
/// Colours of the surfaces of Fig. 2, and of patches over faces and over edges in Figs. 14 and 17.
const SHADES: [u32; 6] = [0x264e86, 0x3f7cac, 0x74a9cf, 0xa6bddb, 0xe0a458, 0xc0622b];
const FACES_AND_EDGES: [u32; 2] = [0xa9c1dc, 0xd9874a];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("usage: paper_000_figures OUT [MESHES]")?);
    fs::create_dir_all(&folder)?;
    let mut figures = Figures { folder, up: Up::Z, table: String::new() };
    figures.section_6()?;
    figures.sphere()?;
    if let Some(meshes) = arguments.next().map(PathBuf::from) {
        figures.up = Up::Y;
        figures.mesh("fig14_15_head", &meshes.join("cgal_head.off"))?;
        figures.mesh("fig16_17_teapot", &meshes.join("npm_teapot.off"))?;
    }
    fs::write(figures.folder.join("table.txt"), &figures.table)?;
    print!("{}", figures.table);
    Ok(())
}

/// Where the figures go, which axis points up in pictures, and what is said about them.
struct Figures {
    folder: PathBuf,
    up: Up,
    table: String,
}

/// The paper's options: apexes of §3.1, layer 2 by least squares (step 5), and the default of step 8.
fn paper(data: HermiteMesh, free: Free) -> APatchFunction {
    let hull = HullOptions { rule: ApexRule::Paper, margin: Margin::Absolute(MARGIN) };
    let options = APatchOptions { layer2: Layer2Rule::LeastSquares, rule: FreeRule::Linear, free };
    apatch::build(hull::build(data, &hull), &options)
}

fn two_faces(vertices: [[f64; 3]; 4], normals: [[f64; 3]; 4]) -> Result<HermiteMesh, Box<dyn Error>> {
    let mesh = HalfEdgeMesh::from_faces(4, &FACES)?;
    Ok(HermiteMesh::new(mesh, vertices.map(Point3::from).to_vec(), &normals.map(Vec3::from))?)
}

impl Figures {
    fn section_6(&mut self) -> Result<(), Box<dyn Error>> {
        let mut mixed = CONVEX;
        (mixed[2], mixed[3]) = ([0.0, 1.0, 1.5], [0.0, 1.0, 1.5]);
        let mut flat = VERTICES;
        flat[3] = [0.0, -4.0, 0.0];
        let up = [0.0, 0.0, 1.0];
        let joins = [
            ("fig6", VERTICES, CONVEX),
            ("fig7", VERTICES, mixed),
            ("fig9", VERTICES, NONCONVEX),
            ("fig10", flat, [up, up, [0.0, -1.0, 1.5], up]),
        ];
        for (name, vertices, normals) in joins {
            self.figure(name, paper(two_faces(vertices, normals)?, Free::Default))?;
        }
        let mut family = Vec::new();
        for b in FAMILY {
            let function = paper(two_faces(VERTICES, CONVEX)?, Free::Global(b));
            family.push(tessellate_a_patches(&APatchSurface::new(function.clone()), FINE)?);
            self.numbers(&format!("fig2_b={b}"), function)?;
        }
        let family = stacked(&family);
        self.picture("fig2_family", &Scene::new(&family, shades(&SHADES)), Some(ALONG_EDGE))?;
        let near = paper(two_faces(VERTICES, NONCONVEX)?, Free::Default);
        let bounds = lower_bounds(&near).into_iter().map(|sides| sides.map(|b| b + NEAR)).collect();
        let near = near.with_free(&Free::PerFace(bounds));
        let mesh = tessellate_a_patches(&APatchSurface::new(near.clone()), FINE)?;
        self.picture(
            "fig3_near_bound",
            &scene(&mesh, &Subject::default(), Style::Shaded)?,
            Some(ALONG_EDGE),
        )?;
        self.numbers("fig3_near_bound", near)
    }

    /// The icosahedron of Fig. 12 gives the sphere of Fig. 13 with the neighbour rule, and something else with step 8.
    fn sphere(&mut self) -> Result<(), Box<dyn Error>> {
        for (name, rule) in [("fig13_sphere", FreeRule::Neighbour), ("fig13_with_step_8", FreeRule::Linear)] {
            let hull = HullOptions { rule: ApexRule::Paper, margin: Margin::Relative(MARGIN) };
            let layer2 = Layer2Rule::LeastSquares;
            let options = APatchOptions { layer2, rule, ..APatchOptions::default() };
            let function = apatch::build(hull::build(icosahedron()?, &hull), &options);
            let surface = APatchSurface::new(function);
            let mesh = tessellate_a_patches(&surface, FINE)?;
            let worst = mesh.positions.iter().map(|p| (p.norm() - 1.0).abs()).fold(0.0, f64::max);
            self.write(name, &mesh)?;
            self.picture(name, &scene(&mesh, &Subject::default(), Style::Isophotes)?, None)?;
            if rule == FreeRule::Neighbour {
                self.picture(
                    "fig12_icosahedron",
                    &scene(&flat(&surface), &Subject::default(), Style::Mesh)?,
                    None,
                )?;
            }
            self.describe(name, &surface);
            writeln!(self.table, "  largest distance from the unit sphere {worst:.2e}")?;
        }
        Ok(())
    }

    fn mesh(&mut self, name: &str, path: &Path) -> Result<(), Box<dyn Error>> {
        let given = read_mesh(path)?;
        let fitted = fit(&given, &APatchRecipe::default(), &|_| ())?;
        let surface = &fitted.surface;
        let mesh = tessellate_a_patches(surface, COARSE)?;
        let faces = surface.function().faces().len();
        self.write(&format!("{name}_face_patches"), &part(&mesh, |patch| patch < faces))?;
        self.write(&format!("{name}_edge_patches"), &part(&mesh, |patch| patch >= faces))?;
        self.write(name, &mesh)?;
        let input = flat(surface);
        self.write(&format!("{name}_input"), &input)?;
        let mut edges = scene(&input, &Subject::default(), Style::Mesh)?;
        // Open meshes may face either way.
        let grey = Color::srgb(FACES_AND_EDGES[0]);
        edges.paint = Paint::Plain { outside: grey, inside: grey };
        self.picture(&format!("{name}_input"), &edges, None)?;
        let smooth = Scene::new(&mesh, edges.paint.clone());
        self.picture(&format!("{name}_surface"), &smooth, None)?;
        let mut apart = mesh.clone();
        apart.patches.iter_mut().for_each(|p| *p = PatchId(u32::from(p.index() >= faces)));
        self.picture(&format!("{name}_patches"), &Scene::new(&apart, shades(&FACES_AND_EDGES)), None)?;
        self.describe(name, surface);
        for repair in &fitted.repairs {
            writeln!(self.table, "  {} ({})", repair.what, repair.why)?;
        }
        Ok(())
    }

    /// Hull and surface of two faces, and their numbers.
    fn figure(&mut self, name: &str, function: APatchFunction) -> Result<(), Box<dyn Error>> {
        let surface = APatchSurface::new(function.clone());
        let mesh = tessellate_a_patches(&surface, FINE)?;
        let subject = Subject { hull: Some(function.hull()), ..Subject::default() };
        self.picture(&format!("{name}_hull"), &scene(&mesh, &subject, Style::Hull)?, Some(ALONG_EDGE))?;
        self.picture(&format!("{name}_patches"), &scene(&mesh, &subject, Style::Patches)?, Some(ALONG_EDGE))?;
        self.numbers(name, function)
    }

    fn numbers(&mut self, name: &str, function: APatchFunction) -> Result<(), Box<dyn Error>> {
        let surface = APatchSurface::new(function);
        self.write(name, &tessellate_a_patches(&surface, FINE)?)?;
        self.describe(name, &surface);
        let function = surface.function();
        let bounds = lower_bounds(function);
        for (face, (free, bounds)) in function.hull().faces().iter().zip(function.free().iter().zip(bounds)) {
            for side in Side::BOTH.into_iter().filter(|side| face.class.reaches(*side)) {
                let s = side.index();
                writeln!(
                    self.table,
                    "  {side:?} cell of a {:?} face: apex at height {:.5}, free parameter {:.5}, lower bound {:.5}",
                    face.class, face.heights[s], free[s], bounds[s]
                )?;
            }
        }
        Ok(())
    }

    fn write(&self, name: &str, mesh: &Tessellation) -> Result<(), Box<dyn Error>> {
        let mut out = BufWriter::new(File::create(self.folder.join(format!("{name}.ply")))?);
        write_ply(mesh, &mut out)?;
        Ok(())
    }

    fn picture(&self, name: &str, scene: &Scene<'_>, view: Option<View>) -> Result<(), Box<dyn Error>> {
        let background = [Color::srgb(BACKGROUND); 2];
        let options = RenderOptions { size: SIZE, view, up: self.up, background };
        let image = draw(scene, &options)?;
        write_png(&image, &mut BufWriter::new(File::create(self.folder.join(format!("{name}.png")))?))?;
        Ok(())
    }

    fn describe(&mut self, name: &str, surface: &APatchSurface) {
        let found = inspect_a_patches(surface, &APatchInspectOptions::default());
        let hull = surface.function().hull();
        let count = |class| hull.faces().iter().filter(|face| face.class == class).count();
        let seams = &found.common.seams;
        // Writing to a string does not fail.
        let _ = writeln!(
            self.table,
            "{name}: {} faces ({} convex, {} nonconvex, {} flat), {} patches, {} undefined, {} folded; seams: gap {:.1e}, normal jump {:.1e} rad",
            hull.faces().len(),
            count(Class::Positive) + count(Class::Negative),
            count(Class::Nonconvex),
            count(Class::Zero),
            surface.patch_count(),
            found.undefined.len(),
            found.folded.len(),
            seams.max_gap,
            seams.max_normal_jump,
        );
    }
}

/// Lower bounds of the free parameters (step 6), sampled: of the faces, raised by what the rays over the edges ask for.
fn lower_bounds(function: &APatchFunction) -> Vec<[f64; 2]> {
    let mesh = function.hull().data().mesh();
    let faces: Vec<[f64; 2]> =
        mesh.faces().map(|f| Side::BOTH.map(|side| face_bound(function, f, side))).collect();
    let at_bound = function.clone().with_free(&Free::PerFace(faces.clone()));
    let mut bounds = faces.clone();
    for e in mesh.edges() {
        for side in Side::BOTH {
            let Some(lift) = edge_lift(&at_bound, e, side) else { continue };
            for f in function.hull().data().joint(e).into_iter().flatten().map(|h| mesh.face(h).index()) {
                let bound = &mut bounds[f][side.index()];
                *bound = bound.max(faces[f][side.index()] + lift);
            }
        }
    }
    bounds
}

fn face_bound(function: &APatchFunction, f: FaceId, side: Side) -> f64 {
    let face = &function.faces()[f.index()];
    let Some(cell) = &face.sides[side.index()] else { return f64::NAN };
    let bound = |x: [f64; 3]| {
        let [b_1, b_2, _] = cell.layers(x, 0.0);
        cubic::sharp_bound(&[side.sign() * face.base.value(x).0, b_1, b_2, 0.0]).0
    };
    triangle::lattice(BOUND_LATTICE).into_iter().map(bound).fold(f64::NEG_INFINITY, f64::max)
}

/// What the bounds of both faces have to be raised by together for the rays over an edge; none if they need not.
fn edge_lift(at_bound: &APatchFunction, e: EdgeId, side: Side) -> Option<f64> {
    let edge = at_bound.edge_function(e, side)?;
    let [mu, nu] = at_bound.edges()[e.index()][side.index()]?.reach;
    let share = |i: usize| i as f64 / BOUND_LATTICE as f64;
    let parameters = (0..=BOUND_LATTICE).flat_map(|i| (0..=BOUND_LATTICE).map(move |j| (share(i), share(j))));
    let lift = parameters.map(|(x, y)| {
        let r = 1.0 - y;
        let beta = y * y * (1.0 + 2.0 * mu * r) + r * r * (1.0 + 2.0 * nu * y);
        cubic::sharp_bound(&edge.layers(x, 1.0 - x, y)).0 / beta
    });
    Some(lift.fold(f64::NEG_INFINITY, f64::max)).filter(|lift| *lift > 0.0)
}

fn icosahedron() -> Result<HermiteMesh, Box<dyn Error>> {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let mut points = Vec::new();
    for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        points.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
    }
    let near = |a: &Vec3, b: &Vec3| (a - b).norm() < 2.0 + MARGIN;
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [a, b, c].map(|v| points[v]);
                if near(&p, &q) && near(&q, &r) && near(&r, &p) {
                    let outward = p.cross(&q).dot(&r) > 0.0;
                    faces.push(if outward { [a, b, c] } else { [a, c, b] }.map(|v| v as u32));
                }
            }
        }
    }
    let points: Vec<Vec3> = points.into_iter().map(|p| p.normalize()).collect();
    Ok(HermiteMesh::new(HalfEdgeMesh::from_faces(12, &faces)?, points.clone(), &points)?)
}

/// A colour for each patch.
fn shades(colors: &[u32]) -> Paint {
    Paint::Patches(colors.iter().map(|c| Color::srgb(*c)).collect())
}

/// Several meshes as one, each as one patch.
fn stacked(meshes: &[Tessellation]) -> Tessellation {
    let mut all = Tessellation {
        positions: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::new(),
        corner_normals: Vec::new(),
        patches: Vec::new(),
    };
    for (number, mesh) in (0..).zip(meshes) {
        let first = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.normals.extend(&mesh.normals);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
        all.patches.extend(vec![PatchId(number); mesh.triangles.len()]);
    }
    all
}

/// The triangles of some patches.
fn part(mesh: &Tessellation, keep: impl Fn(usize) -> bool) -> Tessellation {
    let mut part = mesh.with_split_creases().into_owned();
    let kept = |n: &usize| keep(mesh.patches[*n].index());
    let numbers: Vec<usize> = (0..mesh.triangles.len()).filter(kept).collect();
    part.triangles = numbers.iter().map(|n| part.triangles[*n]).collect();
    part.patches = numbers.iter().map(|n| mesh.patches[*n]).collect();
    part
}

/// The triangles of the mesh itself, as the recipe has prepared them, each with its own normal and a number.
fn flat(surface: &APatchSurface) -> Tessellation {
    let data = surface.function().hull().data();
    let corners: Vec<[Point3; 3]> = data.mesh().faces().map(|f| data.corners(f)).collect();
    let normal = |[a, b, c]: &[Point3; 3]| (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::z);
    Tessellation {
        positions: corners.iter().flatten().copied().collect(),
        normals: corners.iter().flat_map(|t| [normal(t); 3]).collect(),
        triangles: (0..corners.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        corner_normals: Vec::new(),
        patches: surface.patches().take(corners.len()).collect(),
    }
}
