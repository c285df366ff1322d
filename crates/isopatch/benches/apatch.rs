//! Surface points a second of A-patches, and the seconds of what comes before, on one thread.
//!
//! `cargo bench -p isopatch --bench apatch` uses a torus of 98,304 faces; its faces are of all classes. For a mesh file, name a
//! triangle mesh as OFF: `-- bunny.off`. Points are computed in the widest vectors of the machine, and then in those that a machine
//! without AVX2 would get. Beside them stands how fast memory can be filled with as many bytes.

use isopatch::apatch::grid::{EdgeTable, FaceTable, GridOut, Vectors};
use isopatch::apatch::{self, APatchFunction, APatchOptions, APatchSurface};
use isopatch::bernstein::triangle;
use isopatch::geom::Points;
use isopatch::hull::{self, HermiteMesh, HullOptions};
use isopatch::tessellate::{APatchResolution, tessellate_a_patches};
use std::hint::black_box;

mod clock;

#[path = "../tests/support/meshes.rs"]
mod meshes;

use clock::{rate, seconds};

/// Intervals along an edge, and across the patch over it.
const ALONG: usize = 10;
const ACROSS: usize = 4;

fn points(function: &APatchFunction, vectors: Vectors) {
    let mesh = function.hull().data().mesh();
    let faces = FaceTable::new(&triangle::lattice(ALONG)).with_vectors(vectors);
    let over_edge: Vec<[f64; 3]> = (0..=ALONG)
        .flat_map(|i| (0..=ACROSS).map(move |j| (i as f64 / ALONG as f64, j as f64 / ACROSS as f64)))
        .map(|(x, y)| [x, 1.0 - x, y])
        .collect();
    let edges = EdgeTable::new(&over_edge).with_vectors(vectors);
    let curved: Vec<_> =
        mesh.edges().filter(|e| function.edges()[e.index()].iter().any(Option::is_some)).collect();
    for with_normals in [false, true] {
        let size = faces.len().max(edges.len());
        let (mut p, mut n) = (Points::zeros(size), Points::zeros(size));
        let mut out = GridOut { points: p.view_mut(), normals: with_normals.then(|| n.view_mut()) };
        let bytes = if with_normals { 48 } else { 24 };
        let what = if with_normals { "and normals" } else { "positions" };
        let time = seconds(|| mesh.faces().for_each(|f| faces.evaluate(function, f, &mut out)));
        rate(&format!("faces, {what}"), mesh.face_count() * faces.len(), time, bytes);
        let time = seconds(|| curved.iter().for_each(|e| edges.evaluate(function, *e, &mut out)));
        rate(&format!("edges, {what}"), curved.len() * edges.len(), time, bytes);
    }
}

fn memory(count: usize) {
    let mut memory = vec![0.0f64; 3 * count];
    let mut value = 0.0;
    let time = seconds(|| {
        value += 1.0;
        memory.fill(black_box(value));
    });
    rate("memory filled", count, time, 24);
}

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool was made before");
    let file = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let data: HermiteMesh = match &file {
        Some(path) => meshes::read_off(path.as_ref()).expect("a triangle mesh"),
        None => meshes::torus([256, 192]),
    };
    println!("{} faces, one thread", data.mesh().face_count());
    let time = seconds(|| hull::build(data.clone(), &HullOptions::default()));
    println!("{:>30} {time:8.4} s", "hull");
    let hull = hull::build(data, &HullOptions::default());
    let time = seconds(|| apatch::build(hull.clone(), &APatchOptions::default()));
    println!("{:>30} {time:8.4} s", "function");
    let function = apatch::build(hull, &APatchOptions::default());
    let surface = APatchSurface::new(function.clone());
    let time = seconds(|| tessellate_a_patches(&surface, APatchResolution::default()));
    println!("{:>30} {time:8.4} s", "tessellation at 8 × 2");
    for (vectors, what) in [(Vectors::Widest, "widest vectors"), (Vectors::Baseline, "baseline")] {
        println!("{what:>30}");
        points(&function, vectors);
    }
    memory(function.hull().data().mesh().face_count() * triangle::lattice(ALONG).len());
}
