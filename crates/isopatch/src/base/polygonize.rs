//! A first, fine triangle mesh of the surface in a box, with its topology settled.
//!
//! Cells in which interval bounds exclude zeros of f are dropped, the others halved until each has the certificate of
//! [`super::certificate`]; the mesh is the zero set of the piecewise linear function between their nodes.

use super::cover::{Cover, CoverOptions, Leaf, Nodes, center};
use super::error::BaseError;
use super::marching::march;
use super::octree::{DEEPEST, Lattice};
use super::singular::{median, singular_near};
use super::triangle_mesh::TriangleMesh;
use crate::field::Field;
use crate::geom::{Aabb, Point3};
use crate::parallel::Evenly;
use rayon::prelude::*;

/// Settings of [`polygonize`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolygonizeOptions {
    /// Largest change of ∇f, to first order, across a cell that meets the surface, as a share of |∇f|. Default 2.0: the
    /// topology mostly asks for finer cells by itself.
    pub turn: f64,
    /// Least number of triangles, as far as it can be foreseen. Default 0: as many as the topology needs.
    pub triangles: usize,
    /// Most cells. Default 2²⁰, which take some 400 MB.
    pub most_cells: usize,
}

impl Default for PolygonizeOptions {
    fn default() -> Self {
        Self { turn: 2.0, triangles: 0, most_cells: 1 << 20 }
    }
}

/// A mesh near f = 0.
#[derive(Clone, Debug)]
pub struct Polygonization {
    /// Closed, or with its boundary in the sides of the box; a manifold without self-intersections. Vertices are near the
    /// surface, not on it.
    pub mesh: TriangleMesh,
    /// Is the mesh shown to be isotopic to f = 0 in the box?
    pub certified: bool,
    /// Number of cells that may meet the surface.
    pub cells: usize,
    /// Longest edge of a cell that the mesh passes through.
    pub step: f64,
}

/// Leaves that one task looks at.
const TASK: usize = 128;

/// Triangles of a cell that the surface passes through, on average: foresees their number.
const TRIANGLES_OF_CELL: usize = 6;

/// Polygonises f = 0 in `region`, a part of the box `bounds` outside of which there is no surface.
///
/// Where no certificate can be had (kinks, contacts with the sides of the box, bounds that are too wide) the mesh is made
/// all the same if one more halving of these cells does not change its Euler number and its number of components.
/// Fails if there is no surface, if a singular point is found, or if the topology is not settled.
pub fn polygonize(
    field: &dyn Field,
    region: &Aabb,
    bounds: &Aabb,
    options: &PolygonizeOptions,
) -> Result<Polygonization, BaseError> {
    let cover_options = CoverOptions { turn: options.turn, most_leaves: options.most_cells };
    let look = |lattice: &Lattice, open: &[Leaf]| refuse_singular(field, lattice, open);
    let mut cover = Cover::new(field, Lattice::over(region), cover_options, look)?;
    let mut nodes = cover.certify();
    while too_few_triangles(&cover, &nodes, options) {
        cover.split_coarsest(&nodes);
        nodes = cover.certify();
    }
    // What one thread does alone goes beside what all of them share.
    let (mesh, (is_certain, step)) =
        rayon::join(|| march(&cover, &nodes, bounds), || (is_certain(&cover, &nodes), step(&cover, &nodes)));
    let mesh = mesh?;
    if mesh.faces.is_empty() && is_certain {
        return Err(no_surface(field, region, true));
    }
    let mut done = Polygonization { mesh, certified: is_certain, cells: cover.leaves.len(), step };
    if !is_certain {
        refuse_unresolved(&cover, &nodes)?;
        settle(&mut cover, &mut done, bounds)?;
        if done.mesh.faces.is_empty() {
            return Err(no_surface(field, region, false));
        }
    }
    Ok(done)
}

fn no_surface(field: &dyn Field, region: &Aabb, proven: bool) -> BaseError {
    BaseError::NoSurface { negative: field.value(region.center()) < 0.0, proven }
}

/// The leaves that the surface passes through.
fn crossed<'a>(cover: &'a Cover<'_>, nodes: &'a Nodes) -> impl ParallelIterator<Item = &'a Leaf> {
    let leaves = cover.leaves.par_iter().enumerate().evenly_by(TASK);
    leaves.filter(|(i, leaf)| nodes.is_crossed(*i, &leaf.cell)).map(|(_, leaf)| leaf)
}

/// Has every leaf its certificate, and so what is between them?
fn is_certain(cover: &Cover<'_>, nodes: &Nodes) -> bool {
    !cover.leaves.iter().any(|leaf| leaf.uncertain) && cover.borders_are_certain(nodes)
}

fn too_few_triangles(cover: &Cover<'_>, nodes: &Nodes, options: &PolygonizeOptions) -> bool {
    // Half of the room is left for what the certificates may ask for.
    let fits = 16 * cover.leaves.len() < options.most_cells;
    let can_be_split = cover.leaves.iter().any(|leaf| leaf.cell.level < DEEPEST);
    if !fits || !can_be_split {
        return false;
    }
    let count = crossed(cover, nodes).count();
    count > 0 && TRIANGLES_OF_CELL * count < options.triangles
}

fn step(cover: &Cover<'_>, nodes: &Nodes) -> f64 {
    let edge = |leaf: &Leaf| cover.lattice.cell_box(&leaf.cell).size().max();
    crossed(cover, nodes).map(edge).reduce(|| 0.0, f64::max)
}

/// Level from which cells are so small that a singular point is looked for in those that may have one.
const SINGULAR_LEVEL: u32 = 6;

/// Searches at each level.
const SEARCHES: usize = 8;

/// Fails if a singular point of the surface is found from the centres of these cells.
fn refuse_singular(field: &dyn Field, lattice: &Lattice, open: &[Leaf]) -> Result<(), BaseError> {
    let suspects: Vec<&Leaf> =
        open.iter().filter(|leaf| leaf.cell.level >= SINGULAR_LEVEL && leaf.may_be_singular()).collect();
    if suspects.is_empty() {
        return Ok(());
    }
    let stride = suspects.len().div_ceil(SEARCHES);
    let starts: Vec<Point3> = suspects.iter().step_by(stride).map(|leaf| center(lattice, leaf)).collect();
    let typical = median(starts.iter().map(|p| field.gradient(*p).1.norm()).collect());
    let reach = lattice.cell_box(&suspects[0].cell).diagonal();
    let find = |start: &Point3| singular_near(field, *start, reach, typical, lattice.bounds.diagonal());
    match starts.iter().filter_map(find).find(|at| lattice.bounds.contains(at)) {
        Some(at) => Err(BaseError::Singular { at }),
        None => Ok(()),
    }
}

/// How many unresolved cells an error shows.
const SHOWN: usize = 4;

/// |∇f| below this share of its usual size on the surface says that a singular point may be near; on a kink it is larger.
const FLAT: f64 = 1e-2;

/// Fails if there are cells as small as can be in which the surface may be singular.
fn refuse_unresolved(cover: &Cover<'_>, nodes: &Nodes) -> Result<(), BaseError> {
    let slope = |leaf: &Leaf| cover.field().gradient(center(&cover.lattice, leaf)).1.norm();
    let typical = median(crossed(cover, nodes).map(slope).collect());
    let unresolved: Vec<&Leaf> = (cover.leaves.iter())
        .filter(|leaf| leaf.uncertain && leaf.cell.level == DEEPEST && leaf.may_be_singular())
        .filter(|leaf| slope(leaf) <= FLAT * typical)
        .collect();
    if unresolved.is_empty() {
        return Ok(());
    }
    refuse_singular(
        cover.field(),
        &cover.lattice,
        &unresolved.iter().map(|leaf| **leaf).collect::<Vec<_>>(),
    )?;
    Err(unresolved_cells(cover, &unresolved))
}

fn unresolved_cells(cover: &Cover<'_>, unresolved: &[&Leaf]) -> BaseError {
    let at = unresolved.iter().take(SHOWN).map(|leaf| center(&cover.lattice, leaf)).collect();
    let edge = |leaf: &&Leaf| cover.lattice.cell_box(&leaf.cell).size().max();
    let size = unresolved.iter().map(edge).fold(0.0, f64::max);
    BaseError::UnresolvedCells { count: unresolved.len(), at, size }
}

/// Halves the cells without a certificate once more, and fails if that changes the topology.
fn settle(cover: &mut Cover<'_>, done: &mut Polygonization, bounds: &Aabb) -> Result<(), BaseError> {
    if !cover.split_uncertain() {
        let uncertain: Vec<&Leaf> = cover.leaves.iter().filter(|leaf| leaf.uncertain).collect();
        return Err(unresolved_cells(cover, &uncertain));
    }
    let nodes = cover.certify();
    let finer = march(cover, &nodes, bounds)?;
    let topology = |mesh: &TriangleMesh| (mesh.euler_number(), mesh.component_count());
    if topology(&finer) != topology(&done.mesh) {
        let euler = [done.mesh.euler_number(), finer.euler_number()];
        return Err(BaseError::Unresolved { cells: cover.leaves.len(), euler });
    }
    Ok(())
}
