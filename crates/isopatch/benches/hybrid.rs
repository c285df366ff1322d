//! Nanoseconds for a surface point over each kind of cells and over edges, on one thread, without and with its normal; beside them
//! how many times those of the triangle method that is.
//!
//! `cargo bench -p isopatch --bench hybrid`

use cpu_time::ProcessTime;
use isopatch::apatch::grid::{EdgeTable, FaceTable, GridOut};
use isopatch::apatch::{self, APatchOptions};
use isopatch::bernstein::triangle;
use isopatch::geom::{Point3, Points, Vec3};
use isopatch::hull::{self, HullOptions, Side};
use isopatch::hybrid::grid::{PyramidTable, SectorTable, TriangleTable};
use isopatch::hybrid::hull::{HybridOptions, Sheets, build};
use isopatch::hybrid::{FaceCells, HermitePolygons, HybridFunction, mended};
use isopatch::mesh::{EdgeId, FaceId, HalfEdgeMesh};
use std::hint::black_box;

#[path = "../tests/support/mod.rs"]
mod support;

use support::bodies::{Body, bodies, quadrics};
use support::meshes::{self, noise3};

const RUNS: usize = 7;
/// Passes over all faces in a run: the bodies have few faces.
const PASSES: usize = 1000;
/// Intervals along an edge, and across the patch over it.
const ALONG: usize = 10;
const ACROSS: usize = 4;

/// Normals of the bodies are off by this.
const NOISE: f64 = 0.25;

/// Nanoseconds of processor time a point for positions, and with normals: the least of several runs.
fn nanoseconds(points: usize, size: usize, mut run: impl FnMut(&mut GridOut<'_>)) -> [f64; 2] {
    let (mut p, mut n) = (Points::zeros(size), Points::zeros(size));
    [false, true].map(|normals| {
        let mut once = |_| {
            let mut out = GridOut { points: p.view_mut(), normals: normals.then(|| n.view_mut()) };
            let start = ProcessTime::now();
            (0..PASSES).for_each(|_| run(&mut out));
            start.elapsed().as_secs_f64()
        };
        let least = (0..RUNS).map(&mut once).fold(f64::INFINITY, f64::min);
        1e9 * least / (points * PASSES) as f64
    })
}

fn report(name: &str, [points, normals]: [f64; 2], beside: [f64; 2]) {
    let [p, n] = [points / beside[0], normals / beside[1]];
    println!("{name:>55} {points:7.2} ns ({p:4.2} ×), with normals {normals:7.2} ns ({n:4.2} ×)");
}

/// A body with normals that are off, as the recipe makes it.
fn made(body: Body, normal: impl Fn(&Point3) -> Vec3) -> Option<HybridFunction> {
    let noisy = |(v, p): (usize, &Vec3)| (normal(p) + NOISE * noise3(v)).normalize();
    let gradients: Vec<Vec3> = body.positions.iter().enumerate().map(noisy).collect();
    let mesh = HalfEdgeMesh::from_faces(body.positions.len(), &body.faces).ok()?;
    let data = HermitePolygons::new(mesh, body.positions, &gradients).ok()?;
    let built = build(data, &HybridOptions::default());
    Some(mended(HybridFunction::new(built.hull), Sheets::default()).0)
}

/// Bodies with triangles, pyramids and one-sided sectors over their faces; then a saddle, where sectors are two-sided.
fn functions() -> Vec<(&'static str, HybridFunction)> {
    let names = ["cube", "rhombicuboctahedron", "dodecahedron", "icosidodecahedron"];
    let chosen = bodies().into_iter().filter(|body| names.contains(&body.name));
    let saddle = quadrics().into_iter().filter(|(_, body)| body.name.starts_with("hyperbolic paraboloid"));
    let round = chosen.filter_map(|body| Some((body.name, made(body, |p| *p)?)));
    let curved = saddle.filter_map(|(q, body)| Some((body.name, made(body, |p| q.gradient(p).normalize())?)));
    round.chain(curved).collect()
}

fn main() {
    let part = |i: usize, n: usize| i as f64 / n as f64;
    let in_triangle = triangle::lattice(ALONG);
    let over_edge: Vec<[f64; 3]> = (0..=ALONG)
        .flat_map(|i| (0..=ACROSS).map(move |j| (i, j)))
        .map(|(i, j)| [part(ALONG - i, ALONG), part(i, ALONG), part(j, ACROSS)])
        .collect();
    let square: Vec<[f64; 2]> =
        (0..=ALONG).flat_map(|i| (0..=ALONG).map(move |j| [part(i, ALONG), part(j, ALONG)])).collect();
    let (faces, edges) = (FaceTable::new(&in_triangle), EdgeTable::new(&over_edge));
    let (triangles, pyramids) = (TriangleTable::new(&in_triangle), PyramidTable::new(&square));
    let sectors = SectorTable::new(&in_triangle);
    let size = square.len().max(faces.len()).max(edges.len());

    let data = meshes::perturbed(0.05, 0.1);
    let f = apatch::build(hull::build(data, &HullOptions::default()), &APatchOptions::default());
    let mesh = f.hull().data().mesh();
    let over_faces = nanoseconds(mesh.face_count() * faces.len(), size, |out| {
        mesh.faces().for_each(|face| faces.evaluate(&f, black_box(face), out));
    });
    let over_edges = nanoseconds(mesh.edge_count() * edges.len(), size, |out| {
        mesh.edges().for_each(|e| edges.evaluate(&f, black_box(e), out));
    });
    report("triangle method, faces", over_faces, over_faces);
    report("triangle method, edges", over_edges, over_edges);

    for (name, f) in functions() {
        let mesh = f.hull().data.mesh();
        let of = |wanted: &dyn Fn(FaceId, &FaceCells) -> bool| -> Vec<FaceId> {
            mesh.faces().filter(|face| wanted(*face, &f.faces()[face.index()])).collect()
        };
        let is_double = |cells: &FaceCells| cells.has(Side::Outer) && cells.has(Side::Inner);
        let whole = of(&|_, cells| matches!(cells, FaceCells::Triangle { .. }));
        let of_pyramids = of(&|_, cells| matches!(cells, FaceCells::Pyramid(_)));
        if !whole.is_empty() {
            let time = nanoseconds(whole.len() * triangles.len(), size, |out| {
                whole.iter().for_each(|face| triangles.evaluate(&f, black_box(*face), out));
            });
            report(&format!("{name}, triangles"), time, over_faces);
        }
        if !of_pyramids.is_empty() {
            let time = nanoseconds(of_pyramids.len() * pyramids.len(), size, |out| {
                of_pyramids.iter().for_each(|face| pyramids.evaluate(&f, black_box(*face), out));
            });
            report(&format!("{name}, pyramids"), time, over_faces);
        }
        for (kind, double) in [("one-sided", false), ("two-sided", true)] {
            let some = of(&|_, cells| matches!(cells, FaceCells::Sectors(_)) && is_double(cells) == double);
            let all: Vec<(FaceId, usize)> =
                some.iter().flat_map(|face| (0..f.corners(*face).len()).map(|k| (*face, k))).collect();
            if all.is_empty() {
                continue;
            }
            let time = nanoseconds(all.len() * sectors.len(), size, |out| {
                all.iter().for_each(|(face, k)| sectors.evaluate(&f, black_box(*face), *k, out));
            });
            report(&format!("{name}, {kind} sectors"), time, over_faces);
        }
        let curved: Vec<EdgeId> = mesh.edges().filter(|e| f.has_edge_patch(*e)).collect();
        let time = nanoseconds(curved.len() * edges.len(), size, |out| {
            curved.iter().for_each(|e| f.evaluate_edge(&edges, &over_edge, black_box(*e), out));
        });
        report(&format!("{name}, edges"), time, over_edges);
    }
}
