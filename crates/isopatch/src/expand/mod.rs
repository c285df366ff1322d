//! Triangulation of a surface by expansion from seed points (Bajaj & Xu 1997, §4): Algorithm 1 over edges,
//! Algorithm 2 around vertices, both with the surface's power series over tangent planes.
//!
//! ```text
//! series   polynomials.rs, p_expression.rs   φ_k over the P-plane, the certified (p, k, ε)-radius
//! walls    walls.rs                          singular points and polylines, at which a front ends
//! front    front.rs, plane.rs                where a triangle fits
//! steps    steps.rs                          Algorithms 1 and 2: which triangle is wanted next
//! seeds    seeds.rs                          one on each sheet beside a wall
//! check    check.rs                          gaps, folds, what is missing
//! ```
//!
//! Where the paper stitches a finished triangulation to the singular set, here the front sees the singular segments as
//! edges that it has to end in, so that they are edges of the mesh.

mod check;
mod front;
mod options;
mod p_expression;
mod plane;
mod polynomials;
mod seeds;
mod sheet;
mod steps;
mod walls;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

pub use check::Check;
pub use options::{Approach, ExpandOptions};
pub use p_expression::{PExpression, p_frame};
pub use walls::Walls;

use crate::field::{Field, Polynomial};
use crate::geom::{Aabb, Point3, Vec3};
use front::{Front, Vertex};
use sheet::Sheet;
use steps::Expansion;

/// A surface as triangles, counter-clockwise seen from where f > 0.
#[derive(Clone, Debug)]
pub struct Expanded {
    /// Vertices, on the surface; those of the walls come first, with their numbers.
    pub positions: Vec<Point3>,
    /// Unit gradients; none at points of walls.
    pub normals: Vec<Option<Vec3>>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the vertex is on a side of the box.
    pub on_box: Vec<bool>,
    /// What came out.
    pub check: Check,
}

/// Why a surface is not expanded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExpandError {
    /// No seed is on the surface in the box.
    #[error("none of {given} seed points leads to a smooth point of the surface in the box")]
    NoSeed {
        /// How many seeds were tried.
        given: usize,
    },
    /// The degree of the power series is out of range.
    #[error("the degree of the power series is {degree}; it must be 1 to {most}", most = MOST_DEGREE)]
    Degree {
        /// What was asked for.
        degree: usize,
    },
}

/// Highest degree of a power series: beyond it they gain nothing on steps of this size.
pub const MOST_DEGREE: usize = 6;

/// Triangulates the sheets of a polynomial surface f = 0 in a box that the seeds lie on, and those beside the walls.
///
/// Every seed is moved to the surface; one on a part that is already triangulated is passed over. The result may have gaps or
/// miss sheets, which [`Expanded::check`] tells: unlike a certified triangulation, an expansion knows only what it meets.
pub fn expand(
    field: &dyn Field,
    polynomial: &Polynomial,
    bounds: &Aabb,
    walls: &Walls,
    seeds: &[Point3],
    options: &ExpandOptions,
) -> Result<Expanded, ExpandError> {
    if options.degree == 0 || options.degree > MOST_DEGREE {
        return Err(ExpandError::Degree { degree: options.degree });
    }
    let terms = polynomial.float_terms();
    let sheet = Sheet { field, terms: &terms, bounds: *bounds };
    let mut front = Front::new(&sheet, walls);
    seeds::strips(&mut front);
    seeds::fans(&mut front, options.segment * bounds.diagonal());
    Expansion::new(&mut front, options).run();
    for seed in seeds {
        if let Some(p) = seeds::start(&sheet, *seed)
            && !seeds::is_covered(&front, &p)
        {
            begin(&mut front, options, p);
            Expansion::new(&mut front, options).run();
        }
    }
    if front.triangles.is_empty() {
        return Err(ExpandError::NoSeed { given: seeds.len() });
    }
    let check = check::check(&front);
    let on_box = front.vertices.iter().map(|v| v.sides != 0).collect();
    let positions = front.vertices.iter().map(|v| v.at).collect();
    let normals = front.vertices.iter().map(|v| v.normal).collect();
    Ok(Expanded { positions, normals, triangles: front.triangles, on_box, check })
}

/// The initial step: three points on the circle of the seed, refined by Newton's method.
fn begin(front: &mut Front<'_>, options: &ExpandOptions, seed: Point3) {
    let Some((series, radius)) = Expansion::new(front, options).series_at(seed) else { return };
    let corners: Vec<Point3> = (0..3)
        .filter_map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 3.0;
            let p = steps::refined(front.sheet, &series, [angle.cos(), angle.sin()], radius)?;
            if front.sheet.is_outside(&p) { front.sheet.clip(&seed, &p, 0.0) } else { Some(p) }
        })
        .collect();
    let normals: Vec<Vec3> = corners.iter().filter_map(|p| front.sheet.normal(*p)).collect();
    if corners.len() < 3 || normals.len() < 3 {
        return;
    }
    let first = front.vertices.len() as u32;
    for (at, normal) in corners.into_iter().zip(normals) {
        front.vertices.push(Vertex { at, normal: Some(normal), sides: front.sheet.sides(&at) });
    }
    front.add_triangle([first, first + 1, first + 2], seed);
}
