//! The stages of a spline and of a hull, one by one: time an element, on one thread.
//!
//! `cargo bench -p isopatch --bench kernels`. Beside each time stands how many multiplications and additions, in registers, the same
//! processor does meanwhile with vectors of two numbers, which every x86-64 has: what the stage would take if it did nothing else
//! and needed so many of them.

use cpu_time::ProcessTime;
use isopatch::apatch::{self, APatchOptions};
use isopatch::base::{self, BaseOptions, FieldTarget};
use isopatch::bernstein::triangle;
use isopatch::field::{Field, Formula};
use isopatch::gallery;
use isopatch::geom::{Aabb, Point3};
use isopatch::hull::{self, HullOptions};
use isopatch::mesh::EdgeId;
use isopatch::network::{CurveOptions, fit_edges};
use isopatch::spline::{Construction, DEGREE, ShapeParameters, SplineOptions};
use std::hint::black_box;

#[path = "../tests/support/meshes.rs"]
mod meshes;

const RUNS: usize = 5;
const FACES: usize = 10_000;

/// Least processor time of several runs, each with what `prepare` makes.
fn seconds<S, T>(prepare: impl Fn() -> S, run: impl Fn(S) -> T) -> f64 {
    let once = |_| {
        let given = prepare();
        let start = ProcessTime::now();
        black_box(run(given));
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(once).fold(f64::INFINITY, f64::min)
}

/// Multiplications and additions a second that keep to registers.
fn arithmetic() -> f64 {
    /// Independent sums: enough to hide the latency of an addition.
    const SUMS: usize = 16;
    const STEPS: usize = 4_000_000;
    let time = seconds(
        || (black_box([1.0; SUMS]), black_box(1.0 - 1e-9), black_box(1e-9)),
        |(mut sums, factor, term)| {
            for _ in 0..STEPS {
                for sum in &mut sums {
                    *sum = *sum * factor + term;
                }
            }
            sums
        },
    );
    (2 * SUMS * STEPS) as f64 / time
}

struct Table {
    per_second: f64,
}

impl Table {
    fn row(&self, stage: &str, element: &str, count: usize, time: f64) {
        let each = time / count as f64;
        println!(
            "{stage:>28} {:9.3} µs a {element:<9} ({count:7}), {:9.0} operations",
            1e6 * each,
            each * self.per_second
        );
    }
}

fn formula() -> (Formula, Aabb) {
    let surface = gallery::surface("decocube").expect("it is in the gallery");
    (surface.field().expect("a formula"), surface.bounds.expect("a box"))
}

fn stages_of_splines(table: &Table) {
    let (formula, bounds) = formula();
    let options = BaseOptions { faces: Some(FACES), ..BaseOptions::default() };
    let seed = base::seed_mesh(&formula, &bounds, options.faces, &options.seed).expect("a surface");
    let time = seconds(|| (), |()| base::seed_mesh(&formula, &bounds, options.faces, &options.seed));
    table.row("polygonise, certified", "cell", seed.cells, time);
    let coarse = base::decimate(&seed.mesh, &seed.normals, FACES).expect("enough faces");
    let time = seconds(|| (), |()| base::decimate(&seed.mesh, &seed.normals, FACES));
    table.row("decimate", "triangle", seed.mesh.faces.len() - coarse.faces.len(), time);
    let fine = base::remesh(&formula, &coarse, FACES, seed.diagonal, &options.remesh).expect("a mesh");
    let time = seconds(|| (), |()| base::remesh(&formula, &coarse, FACES, seed.diagonal, &options.remesh));
    table.row("remesh", "face", FACES, time);
    let projection = &options.remesh.projection;
    let mesh = base::finish(&formula, fine.clone(), projection).expect("a base mesh");
    let time = seconds(|| fine.clone(), |fine| base::finish(&formula, fine, projection));
    table.row("project, curvatures", "vertex", mesh.positions.len(), time);

    let target = FieldTarget::new(&formula, mesh.diagonal());
    let edges: Vec<EdgeId> = mesh.mesh.edges().collect();
    let curve_options = CurveOptions::default();
    let curves = fit_edges(&mesh, &edges, &target, &curve_options).expect("curves");
    let time = seconds(|| (), |()| fit_edges(&mesh, &edges, &target, &curve_options));
    table.row("boundary curves, (8)", "edge", edges.len(), time);
    let (shape, spline) = (ShapeParameters::default(), SplineOptions::default());
    let fitted = || Construction::new(mesh.clone(), &curves, &target, spline.samples);
    let time = seconds(|| mesh.clone(), |mesh| Construction::new(mesh, &curves, &target, spline.samples));
    table.row("G0 patches, (13)", "patch", FACES, time);
    let time = seconds(fitted, |mut made| made.solve_vertices(&shape).map(|()| made));
    table.row("vertex systems, (19)", "vertex", mesh.positions.len(), time);
    let with_vertices = || {
        let mut made = fitted();
        made.solve_vertices(&shape).expect("solvable");
        made
    };
    let time = seconds(with_vertices, |mut made| made.solve_edges(&shape, &[]).map(|()| made));
    table.row("edge systems, (25)", "edge", edges.len(), time);
    let with_edges = || {
        let mut made = with_vertices();
        made.solve_edges(&shape, &[]).expect("solvable");
        made.refit_free_points();
        made
    };
    let once = SplineOptions { relaxation_steps: 1, ..spline };
    let time = seconds(with_edges, |mut made| made.relax(&once, &[]));
    table.row("a step of relaxation", "patch", FACES, time);
    let net = with_edges().finish().nets[0];
    let points = triangle::lattice(12);
    let time = seconds(
        || black_box(net),
        |net| points.iter().map(|[u, v, _]| triangle::evaluate(DEGREE, &net, [*u, *v]).point).sum::<Point3>(),
    );
    table.row("de Casteljau, degree 7", "point", points.len(), time);
}

fn stages_of_fields(table: &Table) {
    let (formula, bounds) = formula();
    let cells: Vec<Aabb> = triangle::lattice(40)
        .into_iter()
        .map(|t| {
            let corner = bounds.min + bounds.size().component_mul(&Point3::from(t));
            Aabb::new(corner, corner + 0.01 * bounds.size())
        })
        .collect();
    let time = seconds(|| (), |()| cells.iter().map(|c| formula.range(c).width()).sum::<f64>());
    table.row("interval of f", "cell", cells.len(), time);
    let slopes = |c: &Aabb| formula.linear_gradient_range(c).0.radius();
    let time = seconds(|| (), |()| cells.iter().map(slopes).sum::<f64>());
    table.row("linear bounds of ∇f", "cell", cells.len(), time);
}

fn stages_of_hulls(table: &Table) {
    let data = meshes::torus([128, 96]);
    let faces = data.mesh().face_count();
    let time = seconds(|| data.clone(), |data| hull::build(data, &HullOptions::default()));
    table.row("hull", "face", faces, time);
    let hull = hull::build(data, &HullOptions::default());
    let time = seconds(|| hull.clone(), |hull| apatch::build(hull, &APatchOptions::default()));
    table.row("A-patch function", "face", faces, time);
}

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool was made before");
    let table = Table { per_second: arithmetic() };
    println!("{:.2} thousand million operations a second in registers, one thread", table.per_second / 1e9);
    stages_of_fields(&table);
    stages_of_splines(&table);
    stages_of_hulls(&table);
}
