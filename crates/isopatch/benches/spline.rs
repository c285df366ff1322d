//! Points with unit normals a second of a degree-7 spline, on one thread: at parameters that all patches share, and at any.
//!
//! `cargo bench -p isopatch --bench spline`. Beside them stands how fast memory can be filled with as many bytes; a point with its
//! derivatives takes 252 multiplications and as many additions.

use isopatch::bernstein::lanes::{TangentsMut, TriangleGrid};
use isopatch::bernstein::triangle;
use isopatch::gallery;
use isopatch::geom::{Point3, Points};
use isopatch::recipes::spline::{Effort, Size, SplineRecipe, fit};
use isopatch::spline::DEGREE;
use isopatch::surface::{PatchId, Sample, Surface};
use std::hint::black_box;

mod clock;

use clock::{rate, seconds};

const FACES: usize = 5_000;
/// Intervals along an edge.
const LATTICE: usize = 12;

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool was made before");
    let torus = gallery::surface("torus").expect("it is in the gallery");
    let formula = torus.field().expect("a formula");
    let recipe = SplineRecipe {
        bounds: torus.bounds,
        size: Size::Faces(FACES),
        effort: Effort::Quick,
        ..SplineRecipe::default()
    };
    let spline = fit(&formula, &recipe, &|_| ()).expect("it has a spline").surface;
    let parameters = triangle::lattice(LATTICE);
    let count = spline.nets.len() * parameters.len();
    println!("{} patches, {} points each, one thread", spline.nets.len(), parameters.len());

    let grid = TriangleGrid::new(DEGREE, &parameters);
    let (mut points, mut normals) = (Points::zeros(parameters.len()), Points::zeros(parameters.len()));
    let time = seconds(|| {
        for net in &spline.nets {
            let normals = Some(normals.view_mut());
            grid.evaluate(net, TangentsMut { points: points.view_mut(), derivatives: None, normals });
        }
    });
    rate("fixed grid, in cache", count, time, 48);

    let (mut points, mut normals) = (Points::zeros(count), Points::zeros(count));
    let time = seconds(|| {
        for (i, net) in spline.nets.iter().enumerate() {
            let range = i * parameters.len()..(i + 1) * parameters.len();
            let normals = Some(normals.slice_mut(range.clone()));
            grid.evaluate(net, TangentsMut { points: points.slice_mut(range), derivatives: None, normals });
        }
    });
    rate("fixed grid, all points kept", count, time, 48);

    let uv: Vec<[f64; 2]> = parameters.iter().map(|[u, v, _]| [*u, *v]).collect();
    let nothing = Point3::zeros();
    let mut samples = vec![Sample { point: nothing, normal: nothing, du: nothing, dv: nothing }; uv.len()];
    let all = 0..spline.nets.len() as u32;
    let time = seconds(|| all.clone().for_each(|p| spline.sample_batch(PatchId(p), &uv, &mut samples)));
    rate("any parameters, many a patch", count, time, 96);
    let time = seconds(|| {
        let mut sum = nothing;
        for p in all.clone() {
            uv.iter().for_each(|uv| sum += spline.sample(PatchId(p), *uv).normal);
        }
        sum
    });
    rate("any parameters, one by one", count, time, 96);

    let mut memory = vec![0.0f64; 6 * count];
    let mut value = 0.0;
    let time = seconds(|| {
        value += 1.0;
        memory.fill(black_box(value));
    });
    rate("memory filled", count, time, 48);
}
