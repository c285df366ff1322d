//! Makes the surfaces in the figures of Xu, Huang & Bajaj 2001 as meshes, and a table of their numbers.
//!
//! `cargo run --release --example paper_000_figures -- OUT [MESHES]` writes PLY files and `table.txt` into the folder OUT. The
//! heads (Figs. 14 and 15) and the teapot (Figs. 16 and 17) are made from `cgal_head.off` and `npm_teapot.off` in the folder
//! MESHES, and left out without it. Figs. 1, 4, 5, 8, 11 and 12 show no surface.
//!
//! Each file has the patch of every triangle; patches over faces come first. Figs. 14 and 17 show the two kinds apart and are two
//! files each.

use isopatch::apatch::{self, APatchFunction, APatchOptions, APatchSurface, Free, FreeRule, Layer2Rule};
use isopatch::bernstein::{cubic, triangle};
use isopatch::geom::{Point3, Vec3};
use isopatch::hull::{self, ApexRule, Class, HermiteMesh, HullOptions, Margin, Side};
use isopatch::inspect::{APatchInspectOptions, inspect_a_patches};
use isopatch::io::ply::write_ply;
use isopatch::io::read::read_mesh;
use isopatch::mesh::{EdgeId, FaceId, HalfEdgeMesh};
use isopatch::recipes::apatch::{APatchRecipe, fit};
use isopatch::surface::Surface;
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

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("usage: paper_000_figures OUT [MESHES]")?);
    fs::create_dir_all(&folder)?;
    let mut figures = Figures { folder, table: String::new() };
    figures.section_6()?;
    figures.sphere()?;
    if let Some(meshes) = arguments.next().map(PathBuf::from) {
        figures.mesh("fig14_15_head", &meshes.join("cgal_head.off"))?;
        figures.mesh("fig16_17_teapot", &meshes.join("npm_teapot.off"))?;
    }
    fs::write(figures.folder.join("table.txt"), &figures.table)?;
    print!("{}", figures.table);
    Ok(())
}

/// Where the figures go, and what is said about them.
struct Figures {
    folder: PathBuf,
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
        for b in FAMILY {
            self.figure(&format!("fig2_b={b}"), paper(two_faces(VERTICES, CONVEX)?, Free::Global(b)))?;
        }
        let near = paper(two_faces(VERTICES, NONCONVEX)?, Free::Default);
        let bounds = lower_bounds(&near).into_iter().map(|sides| sides.map(|b| b + NEAR)).collect();
        self.figure("fig3_near_bound", near.with_free(&Free::PerFace(bounds)))
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
        self.write(&format!("{name}_input"), &flat(surface))?;
        self.describe(name, surface);
        for repair in &fitted.repairs {
            writeln!(self.table, "  {} ({})", repair.what, repair.why)?;
        }
        Ok(())
    }

    fn figure(&mut self, name: &str, function: APatchFunction) -> Result<(), Box<dyn Error>> {
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

/// The triangles of some patches.
fn part(mesh: &Tessellation, keep: impl Fn(usize) -> bool) -> Tessellation {
    let mut part = mesh.with_split_creases().into_owned();
    let kept = |n: &usize| keep(mesh.patches[*n].index());
    let numbers: Vec<usize> = (0..mesh.triangles.len()).filter(kept).collect();
    part.triangles = numbers.iter().map(|n| part.triangles[*n]).collect();
    part.patches = numbers.iter().map(|n| mesh.patches[*n]).collect();
    part
}

/// The triangles of the mesh itself, as the recipe has prepared them, with a number for each.
fn flat(surface: &APatchSurface) -> Tessellation {
    let data = surface.function().hull().data();
    let normal = |v| data.mesh().ring(v).next().map_or_else(Vec3::z, |h| data.gradient(h).normalize());
    Tessellation {
        positions: data.positions().to_vec(),
        normals: data.mesh().vertices().map(normal).collect(),
        triangles: data.mesh().faces().map(|f| data.mesh().triangle(f).map(|v| v.0)).collect(),
        corner_normals: Vec::new(),
        patches: surface.patches().take(data.mesh().face_count()).collect(),
    }
}
