//! Draws Figs. 1.1, 6.1, 6.2 and 6.3 of Xu, Bajaj & Evans over meshes with the same kinds of faces.
//!
//! `cargo run --release --example paper_001_figures -- OUT` writes PNG pictures and `table.txt` into the folder OUT. The meshes of
//! the paper are not published; those here are a bent rhombicosidodecahedron (triangles, quadrilaterals, pentagons), a tube
//! around a trefoil knot (quadrilaterals), a bent icosidodecahedron (triangles, pentagons) and a vase (triangles, quadrilaterals).
//! The other figures show no surface.

use isopatch::apatch::Over;
use isopatch::geom::{Point3, Vec3};
use isopatch::hybrid::HybridSurface;
use isopatch::io::png::write_png;
use isopatch::io::read::PolygonMesh;
use isopatch::mesh::FaceId;
use isopatch::recipes::hybrid::{Fitted, FittedPolygons, HybridRecipe, fit};
use isopatch::render::{RenderOptions, Style, Subject, View, draw, of_polygons, scene};
use isopatch::surface::{PatchId, Surface};
use isopatch::tessellate::{APatchResolution, Tessellation, tessellate_hybrid};
use std::collections::BTreeSet;
use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::PathBuf;

#[path = "../tests/support/bodies.rs"]
mod bodies;

/// Pixels of a picture.
const SIZE: [usize; 2] = [600, 450];
/// Intervals along and across the patches.
const FINE: APatchResolution = APatchResolution { along: 14, across: 6 };

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: paper_001_figures OUT")?);
    fs::create_dir_all(&folder)?;
    let mut figures = Figures { folder, table: String::new() };
    figures.figure_1()?;
    figures.figure_6("fig6.1", &knot(), None)?;
    figures.figure_6("fig6.2", &bent(&icosidodecahedron()), None)?;
    figures.figure_6("fig6.3", &vase(), Some("b_hull"))?;
    fs::write(figures.folder.join("table.txt"), &figures.table)?;
    print!("{}", figures.table);
    Ok(())
}

/// Where the figures go, and what is said about them.
struct Figures {
    folder: PathBuf,
    table: String,
}

impl Figures {
    /// (a) the mesh, (b) the hull, (c) and (d) a patch over four and over five sides with those around it, (e) and (f) all patches.
    fn figure_1(&mut self) -> Result<(), Box<dyn Error>> {
        let mesh = bent(&rhombicosidodecahedron());
        let made = self.made("fig1.1", &mesh)?;
        self.mesh("fig1.1a_mesh", &mesh)?;
        let drawn = tessellate_hybrid(&made.surface, FINE)?.mesh;
        self.hull("fig1.1b_hull", &made.surface, &drawn)?;
        for (name, corners) in [("fig1.1c_four_sides", 4), ("fig1.1d_five_sides", 5)] {
            let f = mesh.faces.iter().position(|f| f.len() == corners).ok_or("no such polygon")?;
            let (part, normal) = around(&made.surface, &drawn, FaceId::from(f));
            let azimuth = normal.y.atan2(normal.x).to_degrees();
            let view = View { azimuth, elevation: normal.z.asin().to_degrees() };
            self.picture(name, &part, &Subject::default(), Style::Patches, Some(view))?;
        }
        self.picture("fig1.1e_patches", &drawn, &Subject::default(), Style::Patches, None)?;
        self.picture("fig1.1f_surface", &drawn, &Subject::default(), Style::Reflection, None)
    }

    /// The mesh, the hull if it is asked for, the patches, and the surface.
    fn figure_6(&mut self, name: &str, mesh: &PolygonMesh, hull: Option<&str>) -> Result<(), Box<dyn Error>> {
        let made = self.made(name, mesh)?;
        self.mesh(&format!("{name}a_mesh"), mesh)?;
        let drawn = tessellate_hybrid(&made.surface, FINE)?.mesh;
        if let Some(hull) = hull {
            self.hull(&format!("{name}{hull}"), &made.surface, &drawn)?;
        }
        let letters = if hull.is_some() { ["c", "d"] } else { ["b", "c"] };
        let [patches, surface] = letters;
        let nothing = Subject::default();
        self.picture(&format!("{name}{patches}_patches"), &drawn, &nothing, Style::Patches, None)?;
        self.picture(&format!("{name}{surface}_surface"), &drawn, &nothing, Style::Reflection, None)
    }

    fn made(&mut self, name: &str, mesh: &PolygonMesh) -> Result<FittedPolygons, Box<dyn Error>> {
        let Fitted::Polygons(made) = fit(mesh, &HybridRecipe::default(), &|_| ())? else {
            return Err(format!("{name}: made over triangles").into());
        };
        let sides = |n: usize| mesh.faces.iter().filter(|f| f.len() == n).count();
        let [three, four, five] = [3, 4, 5].map(sides);
        let [of_faces, of_edges] = made.surface.function().cell_counts();
        writeln!(
            self.table,
            "{name}: {three} triangles, {four} quadrilaterals, {five} pentagons; {} patches, {of_faces} + {of_edges} cells",
            made.surface.patch_count()
        )?;
        Ok(*made)
    }

    fn mesh(&self, name: &str, mesh: &PolygonMesh) -> Result<(), Box<dyn Error>> {
        // Every polygon is flat to look at: each has its own corners.
        let corners = mesh.faces.iter().flatten().map(|v| mesh.positions[*v as usize]);
        let mut next = 0..;
        let faces: Vec<Vec<u32>> = mesh.faces.iter().map(|f| next.by_ref().take(f.len()).collect()).collect();
        let drawn = of_polygons(&corners.collect::<Vec<_>>(), &faces, None);
        self.picture(name, &drawn, &Subject::default(), Style::Patches, None)
    }

    fn hull(&self, name: &str, surface: &HybridSurface, drawn: &Tessellation) -> Result<(), Box<dyn Error>> {
        let subject = Subject { polygons: Some(surface.function().hull()), ..Subject::default() };
        self.picture(name, drawn, &subject, Style::Hull, None)
    }

    fn picture(
        &self,
        name: &str,
        mesh: &Tessellation,
        subject: &Subject<'_>,
        style: Style,
        view: Option<View>,
    ) -> Result<(), Box<dyn Error>> {
        let options = RenderOptions { size: SIZE, view, ..RenderOptions::default() };
        let image = draw(&scene(mesh, subject, style)?, &options)?;
        Ok(write_png(&image, &mut BufWriter::new(File::create(self.folder.join(format!("{name}.png")))?))?)
    }
}

/// The patches over a face, over its edges and over the faces beside it; and the normal of the face.
fn around(surface: &HybridSurface, drawn: &Tessellation, f: FaceId) -> (Tessellation, Vec3) {
    let hull = surface.function().hull();
    let mesh = hull.data.mesh();
    let edges: BTreeSet<_> = mesh.face_half_edges(f).map(|h| mesh.edge(h)).collect();
    let beside: BTreeSet<_> =
        mesh.face_half_edges(f).filter_map(|h| mesh.twin(h)).map(|h| mesh.face(h)).collect();
    let near = |patch: PatchId| match surface.over(patch) {
        Over::Face(g) => g == f || beside.contains(&g),
        Over::Edge(e) => edges.contains(&e),
    };
    let kept: Vec<usize> = (0..drawn.triangles.len()).filter(|t| near(drawn.patches[*t])).collect();
    let part = Tessellation {
        positions: drawn.positions.clone(),
        normals: drawn.normals.clone(),
        triangles: kept.iter().map(|t| drawn.triangles[*t]).collect(),
        corner_normals: Vec::new(),
        patches: kept.iter().map(|t| drawn.patches[*t]).collect(),
    };
    (compact(part), hull.faces[f.index()].normal)
}

/// Without the points that no triangle has, so that the picture is of what is left.
fn compact(mesh: Tessellation) -> Tessellation {
    let used: BTreeSet<u32> = mesh.triangles.iter().flatten().copied().collect();
    let mut number = vec![0; mesh.positions.len()];
    used.iter().zip(0..).for_each(|(v, n)| number[*v as usize] = n);
    Tessellation {
        positions: used.iter().map(|v| mesh.positions[*v as usize]).collect(),
        normals: used.iter().map(|v| mesh.normals[*v as usize]).collect(),
        triangles: mesh.triangles.iter().map(|t| t.map(|v| number[v as usize])).collect(),
        ..mesh
    }
}

/// A body of triangles and pentagons, and one of quadrilaterals too.
fn icosidodecahedron() -> Vec<Point3> {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    signed(&[[0.0, 0.0, g], [0.5, 0.5 * g, 0.5 * g * g]])
}

fn rhombicosidodecahedron() -> Vec<Point3> {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    signed(&[[1.0, 1.0, g * g * g], [g * g, g, 2.0 * g], [2.0 + g, 0.0, g * g]])
}

/// The points with these coordinates in cyclic order, up to signs, on the unit sphere.
fn signed(coordinates: &[[f64; 3]]) -> Vec<Point3> {
    let mut points: Vec<Point3> = Vec::new();
    for [x, y, z] in coordinates.iter().flat_map(|[x, y, z]| [[*x, *y, *z], [*y, *z, *x], [*z, *x, *y]]) {
        for signs in 0..8 {
            let sign = |bit: u32| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let p = Point3::new(sign(0) * x, sign(1) * y, sign(2) * z).normalize();
            if points.iter().all(|q| (q - p).norm() > SAME) {
                points.push(p);
            }
        }
    }
    points
}

/// Points on the unit sphere that are closer are one.
const SAME: f64 = 1e-9;

/// The convex body with these corners, drawn out along z and bent to a bean.
fn bent(corners: &[Point3]) -> PolygonMesh {
    let at = |p: &Point3| Point3::new(p.x + 0.45 * p.z * p.z, p.y * (1.0 + 0.25 * p.z), 1.5 * p.z);
    let faces = bodies::convex_faces(corners);
    PolygonMesh { positions: corners.iter().map(at).collect(), faces, normals: None }
}

/// A closed strip of quadrilaterals, `along` rings of `across` corners each.
fn rings(along: u32, across: u32, at: impl Fn(f64, f64) -> Point3) -> PolygonMesh {
    let number = |i: u32, j: u32| (i % along) * across + j % across;
    let all = || (0..along).flat_map(move |i| (0..across).map(move |j| (i, j)));
    let share = |i: u32, n: u32| f64::from(i) / f64::from(n);
    PolygonMesh {
        positions: all().map(|(i, j)| at(share(i, along), share(j, across))).collect(),
        faces: all()
            .map(|(i, j)| vec![number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)])
            .collect(),
        normals: None,
    }
}

/// A tube around a trefoil knot.
fn knot() -> PolygonMesh {
    const RADIUS: f64 = 0.55;
    let center = |t: f64| {
        let a = TAU * t;
        let r = 2.0 + (3.0 * a).cos();
        Point3::new(r * (2.0 * a).cos(), r * (2.0 * a).sin(), 1.2 * (3.0 * a).sin())
    };
    rings(54, 8, |t, s| {
        const STEP: f64 = 1e-4;
        let along = (center(t + STEP) - center(t - STEP)).normalize();
        // Away from the axis of the knot, so that the rings close.
        let c = center(t);
        let out = Vec3::new(c.x, c.y, 0.0);
        let side = (out - out.dot(&along) * along).normalize();
        let up = along.cross(&side);
        c + RADIUS * ((TAU * s).cos() * side + (TAU * s).sin() * up)
    })
}

/// Rings of quadrilaterals between two fans of triangles.
fn vase() -> PolygonMesh {
    const PROFILE: [[f64; 2]; 8] = [
        [0.5, -1.6],
        [0.95, -1.3],
        [1.1, -0.8],
        [0.9, -0.2],
        [0.55, 0.3],
        [0.5, 0.7],
        [0.7, 1.1],
        [0.55, 1.45],
    ];
    const AROUND: u32 = 10;
    let (first, last) = (PROFILE.len() as u32 * AROUND, PROFILE.len() as u32 * AROUND + 1);
    let number = |i: u32, j: u32| i * AROUND + j % AROUND;
    let ring = |[r, z]: [f64; 2]| {
        (0..AROUND).map(move |j| {
            let a = TAU * f64::from(j) / f64::from(AROUND);
            Point3::new(r * a.cos(), r * a.sin(), z)
        })
    };
    let mut positions: Vec<Point3> = PROFILE.into_iter().flat_map(ring).collect();
    positions.extend([Point3::new(0.0, 0.0, -1.75), Point3::new(0.0, 0.0, 1.6)]);
    let mut faces = Vec::new();
    for j in 0..AROUND {
        for i in 0..PROFILE.len() as u32 - 1 {
            faces.push(vec![number(i, j), number(i, j + 1), number(i + 1, j + 1), number(i + 1, j)]);
        }
        faces.push(vec![first, number(0, j + 1), number(0, j)]);
        let top = PROFILE.len() as u32 - 1;
        faces.push(vec![last, number(top, j), number(top, j + 1)]);
    }
    PolygonMesh { positions, faces, normals: None }
}
