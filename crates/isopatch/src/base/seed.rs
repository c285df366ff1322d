//! A fine triangle mesh near the surface, with what the choice of the base mesh needs to know.

use super::bounds::{clipped_sides, side_beyond, tighten};
use super::clip::BoxSide;
use super::connectivity::Connectivity;
use super::corners::gather_at_corners;
use super::error::BaseError;
use super::jets::of_jets;
use super::polygonize::{Polygonization, PolygonizeOptions, polygonize};
use super::project::{ProjectOptions, project_positions};
use super::remesh::RemeshOptions;
use super::shape::{largest_curvature, unit_or_zero};
use super::singular::find_singular;
use super::sizing::automatic_count;
use super::triangle_mesh::TriangleMesh;
use crate::field::Field;
use crate::geom::{Aabb, Point3, Vec3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Faces that one task looks at.
const TASK: usize = 256;

/// Settings of [`seed_mesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeedOptions {
    /// Largest change of ∇f, to first order, across a cell that meets the surface, as a share of |∇f|. Default 2.0: the
    /// topology mostly asks for finer cells by itself; what decimation needs is in `least` and `surplus`.
    pub turn: f64,
    /// The mesh has about this many triangles, or more, for each face asked for. Default 3: decimation needs a choice.
    pub surplus: f64,
    /// Least number of triangles. Default 4000: a sphere then has some 20 cells along its diameter.
    pub least: usize,
    /// Most cells. Default 2²⁰, which take some 400 MB.
    pub most_cells: usize,
    /// May the box cut the surface? Default true; if false, that is an error.
    pub open: bool,
}

impl Default for SeedOptions {
    fn default() -> Self {
        Self { turn: 2.0, surplus: 3.0, least: 4000, most_cells: 1 << 20, open: true }
    }
}

/// A fine triangle mesh near the surface, from [`seed_mesh`].
#[derive(Clone, Debug)]
pub struct Seed {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// The field's unit normal at each vertex.
    pub normals: Vec<Vec3>,
    /// |k|max at each vertex.
    pub curvatures: Vec<f64>,
    /// Is f < 0 outside, so that the field is to be negated for the solid to be bounded?
    pub negative_outside: bool,
    /// Longest edge of a cell that the mesh passes through.
    pub step: f64,
    /// Diagonal of the bounding box.
    pub diagonal: f64,
    /// Is the mesh shown to be isotopic to the surface in the box?
    pub certified: bool,
    /// Number of cells that it was made from.
    pub cells: usize,
}

impl Seed {
    /// Edges, by their ends, at which the difference of the unit normals is longer than `turn`.
    pub fn sharp_edges(&self, turn: f64) -> impl Iterator<Item = [usize; 2]> + '_ {
        let sides = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
        let edges = self.mesh.faces.iter().flat_map(sides).filter(|[a, b]| a < b);
        let edges = edges.map(|ends| ends.map(|v| v as usize));
        edges.filter(move |[a, b]| (self.normals[*a] - self.normals[*b]).norm() > turn)
    }

    /// The number of faces that the curvature asks for.
    pub fn automatic_faces(&self, options: &RemeshOptions) -> usize {
        let x = &self.mesh.positions;
        Connectivity::from_faces(x.len(), &self.mesh.faces)
            .map_or(0, |c| automatic_count(&c, x, &self.curvatures, self.diagonal, &options.sizing))
    }
}

/// Polygonises the part of f = 0 that is in the box, see [`polygonize`].
///
/// `faces` is the number of faces wanted in the end, if known.
pub fn seed_mesh(
    field: &dyn Field,
    bounds: &Aabb,
    faces: Option<usize>,
    options: &SeedOptions,
) -> Result<Seed, BaseError> {
    let region = tighten(field, bounds)?;
    refuse_degenerate(field, &region)?;
    refuse_side(field, bounds, &region)?;
    let wanted = (options.surplus * faces.unwrap_or(0) as f64) as usize;
    let polygonize_options = PolygonizeOptions {
        turn: options.turn,
        triangles: wanted.max(options.least),
        most_cells: options.most_cells,
    };
    let made = polygonize(field, &region, bounds, &polygonize_options)?;
    if let (Some(clip), false) = (&made.mesh.clip, options.open)
        && let Some(v) = clip.sides.iter().position(|s| !s.is_empty())
        && let Some(side) = clip.sides[v].iter().next()
    {
        return Err(BaseError::SurfaceLeavesBox { side, at: made.mesh.positions[v] });
    }
    let mesh = gather_at_corners(field, made.mesh)?;
    let seed = describe(field, Polygonization { mesh, ..made });
    if !seed.certified {
        if let Some(at) = find_singular(field, &seed.mesh.positions, seed.step)
            && side_beyond(bounds, &at).is_none()
        {
            return Err(BaseError::Singular { at });
        }
        require_surface(field, &seed)?;
    }
    Ok(seed)
}

/// Samples along each side of the box when it is asked whether the field is anything at all.
const SAMPLES: usize = 9;

/// The samples of a box, or of a side of it.
fn samples(region: &Aabb) -> impl Iterator<Item = Point3> + '_ {
    let share = |i: usize| i as f64 / (SAMPLES - 1) as f64;
    (0..SAMPLES.pow(3)).map(move |n| {
        let t = Vec3::new(share(n % SAMPLES), share(n / SAMPLES % SAMPLES), share(n / SAMPLES / SAMPLES));
        region.min + region.size().component_mul(&t)
    })
}

/// Fails if the field has no value at all, or always the same.
fn refuse_degenerate(field: &dyn Field, region: &Aabb) -> Result<(), BaseError> {
    let mut values = samples(region).map(|p| field.value(p)).filter(|f| !f.is_nan());
    let Some(first) = values.next() else { return Err(BaseError::Undefined { share: 1.0, at: None }) };
    if values.all(|f| f == first) { Err(BaseError::ConstantField { value: first }) } else { Ok(()) }
}

/// Fails if the field vanishes on a side of the box.
fn refuse_side(field: &dyn Field, bounds: &Aabb, region: &Aabb) -> Result<(), BaseError> {
    let vanishes = |side: &BoxSide| {
        let mut flat = *region;
        flat.min[side.axis] = side.position(bounds);
        flat.max[side.axis] = side.position(bounds);
        samples(&flat).all(|p| field.value(p).abs() <= field.rounding_bound(p))
    };
    match clipped_sides(bounds, region).find(vanishes) {
        Some(side) => Err(BaseError::SurfaceInSide { side }),
        None => Ok(()),
    }
}

fn describe(field: &dyn Field, made: Polygonization) -> Seed {
    let Polygonization { mesh, certified, cells, step } = made;
    let (normals, curvatures): (Vec<Vec3>, Vec<f64>) = of_jets(field, &mesh.positions, |jet| {
        let k = largest_curvature(&jet.curvature_tensor());
        (unit_or_zero(&jet.gradient), if k.is_finite() { k } else { 0.0 })
    })
    .into_iter()
    .unzip();
    let diagonal = Aabb::around(&mesh.positions).diagonal();
    let curvatures = with_turns(&mesh, &normals, curvatures);
    let negative_outside = mesh.clip.is_none() && signed_volume(&mesh) < 0.0;
    Seed { mesh, normals, curvatures, negative_outside, step, diagonal, certified, cells }
}

/// The volume of {f < 0} if that is bounded; of {f > 0}, with a minus sign, if not: parts of the surface inside others only
/// take something away from it.
fn signed_volume(mesh: &TriangleMesh) -> f64 {
    let Some(origin) = mesh.positions.first() else { return 0.0 };
    let volume = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize] - origin);
        a.dot(&b.cross(&c))
    };
    mesh.faces.iter().map(volume).sum()
}

/// Curvatures that are at least the turn of the normal along the edges at a vertex: a sharp rim can pass between all
/// vertices of a coarse mesh.
fn with_turns(mesh: &TriangleMesh, normals: &[Vec3], mut curvatures: Vec<f64>) -> Vec<f64> {
    let turn = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|v| v as usize);
        let turn = (normals[a] - normals[b]).norm() / (mesh.positions[a] - mesh.positions[b]).norm();
        if turn.is_finite() { turn } else { 0.0 }
    };
    let of_face = |&[a, b, c]: &[u32; 3]| {
        let [ab, bc, ca] = [turn(a, b), turn(b, c), turn(c, a)];
        [ab.max(ca), ab.max(bc), bc.max(ca)]
    };
    let turns: Vec<[f64; 3]> = mesh.faces.par_iter().evenly_by(TASK).map(of_face).collect();
    for (v, turn) in mesh.faces.iter().flatten().zip(turns.iter().flatten()) {
        let curvature = &mut curvatures[*v as usize];
        *curvature = curvature.max(*turn);
    }
    curvatures
}

/// A sign change need not be a zero: if more vertices than this share cannot be projected, it is something else.
const STRAY_SHARE: f64 = 0.01;

/// Fails if the sign changes at a pole or a jump instead of a zero.
fn require_surface(field: &dyn Field, seed: &Seed) -> Result<(), BaseError> {
    let mut positions = seed.mesh.positions.clone();
    let sides = seed.mesh.clip.as_ref().map_or(&[][..], |c| &c.sides);
    let report = project_positions(field, &mut positions, sides, seed.diagonal, &ProjectOptions::default());
    match report.failures.first() {
        Some(i) if report.failures.len() as f64 > STRAY_SHARE * positions.len() as f64 => {
            Err(BaseError::NotOnSurface { at: seed.mesh.positions[*i] })
        }
        _ => Ok(()),
    }
}
