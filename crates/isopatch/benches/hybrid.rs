//! Nanoseconds for a surface point with its normal, over each kind of face and over edges, on one thread; beside them those of the
//! triangle method over as many triangles.
//!
//! `cargo bench -p isopatch --bench hybrid`

use cpu_time::ProcessTime;
use isopatch::apatch::grid::{EdgeTable, FaceTable, GridOut};
use isopatch::apatch::{self, APatchOptions};
use isopatch::bernstein::triangle;
use isopatch::geom::Points;
use isopatch::hull::{self, HullOptions};
use isopatch::hybrid::grid::{PyramidTable, SectorTable, TriangleTable};
use isopatch::hybrid::{FaceCells, HybridFunction};
use std::hint::black_box;

#[path = "../tests/support/mod.rs"]
mod support;

use support::{meshes, polyhedra};

const RUNS: usize = 7;
/// Passes over all faces in a run: the bodies have few faces.
const PASSES: usize = 2000;
/// Intervals along an edge, and across the patch over it.
const ALONG: usize = 10;
const ACROSS: usize = 4;

/// Least processor time of several runs.
fn seconds(mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let start = ProcessTime::now();
        for _ in 0..PASSES {
            run();
        }
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(once).fold(f64::INFINITY, f64::min)
}

fn report(name: &str, points: usize, seconds: f64) {
    println!("{name:>40} {:8.2} ns a point", 1e9 * seconds / (points * PASSES) as f64);
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
    let hybrid = TriangleTable::new(&in_triangle);
    let (pyramids, sectors) = (PyramidTable::new(&square), SectorTable::new(&in_triangle));
    let size = square.len().max(faces.len()).max(edges.len());
    let (mut p, mut n) = (Points::zeros(size), Points::zeros(size));
    let mut out = GridOut { points: p.view_mut(), normals: Some(n.view_mut()) };

    let triangles = meshes::perturbed(0.05, 0.1);
    let f = apatch::build(hull::build(triangles, &HullOptions::default()), &APatchOptions::default());
    let mesh = f.hull().data().mesh();
    let time = seconds(|| mesh.faces().for_each(|face| faces.evaluate(&f, black_box(face), &mut out)));
    report("triangle method, faces", mesh.face_count() * faces.len(), time);
    let time = seconds(|| mesh.edges().for_each(|e| edges.evaluate(&f, black_box(e), &mut out)));
    report("triangle method, edges", mesh.edge_count() * edges.len(), time);
    let single = seconds(|| {
        for face in mesh.faces().take(2) {
            in_triangle.iter().for_each(|x| _ = black_box(f.shoot_face(face, *x)));
        }
    });
    report("triangle method, single rays", 2 * in_triangle.len(), single);

    for (name, body, gradient) in [
        ("cube", polyhedra::rhombicuboctahedron(), 0.02),
        ("dodecahedron", polyhedra::dodecahedron(), 0.02),
        ("icosidodecahedron, two-sided", polyhedra::icosidodecahedron(), 0.2),
    ] {
        let f = polyhedra::random(body, polyhedra::sectors, [0.02, gradient], 1);
        bench(name, &f, &in_triangle, &over_edge, (&hybrid, &edges, &pyramids, &sectors), &mut out);
    }
}

fn bench(
    name: &str,
    f: &HybridFunction,
    in_triangle: &[[f64; 3]],
    over_edge: &[[f64; 3]],
    (faces, edges, pyramids, sectors): (&TriangleTable, &EdgeTable, &PyramidTable, &SectorTable),
    out: &mut GridOut<'_>,
) {
    let mesh = f.hull().data.mesh();
    let of = |wanted: fn(&FaceCells) -> bool| -> Vec<_> {
        mesh.faces().filter(|face| wanted(&f.faces()[face.index()])).collect()
    };
    let triangles = of(|cells| matches!(cells, FaceCells::Triangle { .. }));
    let of_pyramids = of(|cells| matches!(cells, FaceCells::Pyramid(_)));
    let of_sectors = of(|cells| matches!(cells, FaceCells::Sectors(_)));
    let split: Vec<_> = of_sectors.iter().copied().filter(|face| f.corners(*face).len() == 3).collect();
    if !split.is_empty() {
        let time = seconds(|| split.iter().for_each(|face| faces.evaluate(f, black_box(*face), out)));
        report(&format!("{name}, triangles in sectors"), split.len() * faces.len(), time);
    }
    if !triangles.is_empty() {
        let time = seconds(|| {
            triangles.iter().for_each(|face| faces.evaluate(f, black_box(*face), out));
        });
        report(&format!("{name}, triangles"), triangles.len() * faces.len(), time);
    }
    if !of_pyramids.is_empty() {
        let time =
            seconds(|| of_pyramids.iter().for_each(|face| pyramids.evaluate(f, black_box(*face), out)));
        report(&format!("{name}, pyramids"), of_pyramids.len() * pyramids.len(), time);
    }
    if !of_sectors.is_empty() {
        let time = seconds(|| {
            of_sectors.iter().for_each(|face| sectors.evaluate(f, black_box(*face), 0, out));
        });
        report(&format!("{name}, sectors"), of_sectors.len() * sectors.len(), time);
        let single = seconds(|| {
            for x in in_triangle {
                let foot = isopatch::hybrid::Foot::Sector(0, *x);
                _ = black_box(f.shoot_from(of_sectors[0], foot, [[0.0; 3]; 2]));
            }
        });
        report(&format!("{name}, sectors, single rays"), in_triangle.len(), single);
    }
    let curved: Vec<_> = mesh.edges().filter(|e| f.has_edge_patch(*e)).collect();
    let time = seconds(|| curved.iter().for_each(|e| f.evaluate_edge(edges, over_edge, black_box(*e), out)));
    report(&format!("{name}, edges"), curved.len() * edges.len(), time);
}
