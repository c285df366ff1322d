//! A-patches over an algebraic surface with singularities: the data of Bajaj & Xu 1997, the patches of Xu, Huang & Bajaj 2001.
//!
//! ```text
//! conforming mesh ──► limit normals per sheet ──► solids f < 0: pairs of triangles along singular edges ──► hull ──► function
//! ```
//!
//! A-patches need an oriented manifold. The triangles around a singular edge are joined in pairs, each pair the border of a wedge in
//! which f < 0: so the whole is the border of solids that touch each other in singular points and curves, where vertices are there
//! once for each. Singular edges are creases: both patches of a pair end in one curve, and the curves of all pairs have the same
//! ends and tangents, unless the hull makes a corner there. Where a vertex has no normal in a sheet, as at the tip of a cone, it is a corner.

use crate::apatch::{self, APatchOptions, APatchSurface};
use crate::base::Repair;
use crate::field::Formula;
use crate::geom::{Aabb, Point3, Vec3};
use crate::hull::{self, HermiteError, HermiteMesh, HullOptions};
use crate::mesh::{HalfEdgeMesh, MeshError};
use crate::rational::Frame;
use crate::report::{APatchReport, Seconds};
use crate::singular::mesh::{EdgeTag, SingularMesh};
use crate::surface::{PatchId, Surface};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A finished surface.
#[derive(Debug)]
pub struct SingularAPatches {
    /// The surface.
    pub surface: APatchSurface,
    /// What the method did.
    pub figures: APatchReport,
    /// The vertex of the conforming mesh that each vertex of the surface is.
    pub vertices: Vec<u32>,
    /// The largest distance between the curves of the pairs of triangles along one singular edge, a length.
    pub gap: f64,
    /// What was changed, and what does not fit.
    pub repairs: Vec<Repair>,
    /// Time of each stage.
    pub seconds: Seconds,
}

/// Why there is no surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SingularAPatchError {
    /// The solids do not come apart into manifolds.
    #[error("the sheets can't be cut apart: {0}")]
    Sheets(#[from] MeshError),
    /// The mesh can't be interpolated.
    #[error(transparent)]
    Data(#[from] HermiteError),
}

/// The A-patch surface over a conforming mesh; `progress` is told the name of each stage as it starts.
///
/// # Errors
/// [`SingularAPatchError`] if the mesh does not come apart into oriented manifolds, or has triangles without area.
pub fn over_conforming(
    formula: &Formula,
    mesh: &SingularMesh,
    hull_options: &HullOptions,
    patch_options: &APatchOptions,
    progress: &dyn Fn(&str),
) -> Result<SingularAPatches, SingularAPatchError> {
    let mut seconds = Seconds::default();
    progress("sheets");
    let solids = seconds.measure("sheets", || Solids::new(mesh))?;
    let data = solids.hermite(formula, mesh)?;
    progress("hull");
    let hull = seconds.measure("hull", || hull::build(data, hull_options));
    progress("patches");
    let function = seconds.measure("patches", || apatch::build(hull, patch_options));
    let mut repairs = repairs(&solids, &function);
    let figures = APatchReport { normals: Some("field".to_owned()), ..APatchReport::new(&function) };
    let surface = APatchSurface::new(function);
    let (gap, parted) = gap(mesh, &solids, &surface);
    if parted > 0 {
        repairs.push(Repair {
            what: format!("sheets part on singular edges: {parted}"),
            place: format!("by up to {gap:.2e}"),
            why: "corners were made at their ends, and sheets leave a corner in different directions"
                .to_owned(),
        });
    }
    Ok(SingularAPatches { surface, figures, vertices: solids.vertices, gap, repairs, seconds })
}

/// A conforming mesh cut apart.
struct Solids {
    mesh: HalfEdgeMesh,
    /// The vertex of the whole mesh that each vertex is.
    vertices: Vec<u32>,
    /// Edges of the whole mesh at which triangles found no partner.
    unpaired: usize,
}

/// A triangle and its edge k, from corner k to k + 1.
type Side = (u32, usize);

impl Solids {
    fn new(mesh: &SingularMesh) -> Result<Self, MeshError> {
        let (pairs, unpaired) = pairs(mesh);
        let mut parents: Vec<usize> = (0..3 * mesh.triangles.len()).collect();
        for [(s, i), (t, j)] in pairs {
            let corner = |t: u32, k: usize| 3 * t as usize + k % 3;
            join(&mut parents, corner(s, i), corner(t, j + 1));
            join(&mut parents, corner(s, i + 1), corner(t, j));
        }
        let mut numbers = HashMap::new();
        let mut vertices = Vec::new();
        let mut faces = Vec::with_capacity(mesh.triangles.len());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            faces.push([0, 1, 2].map(|k| {
                *numbers.entry(root(&mut parents, 3 * t + k)).or_insert_with(|| {
                    vertices.push(corners[k]);
                    vertices.len() as u32 - 1
                })
            }));
        }
        Ok(Self { mesh: HalfEdgeMesh::from_faces(vertices.len(), &faces)?, vertices, unpaired })
    }

    /// Gradients and creases.
    fn hermite(&self, formula: &Formula, whole: &SingularMesh) -> Result<HermiteMesh, HermiteError> {
        use crate::field::Field;
        let is_singular: Vec<bool> = whole.vertices.iter().map(|kind| kind.is_singular()).collect();
        let frame = Frame::over_sheets(
            whole.positions.clone(),
            whole.triangles.clone(),
            &whole.normals,
            &whole.singular_edges,
            &is_singular,
        );
        let positions: Vec<Point3> = self.vertices.iter().map(|v| whole.positions[*v as usize]).collect();
        let singular: BTreeSet<[u32; 2]> = whole.singular_edges.iter().copied().collect();
        let tips: BTreeSet<u32> = self
            .mesh
            .half_edges()
            .filter(|h| frame.normals[self.mesh.face(*h).index()][self.mesh.side(*h)].is_none())
            .map(|h| self.mesh.origin(h).0)
            .collect();
        let gradients = self.mesh.half_edges().map(|h| {
            let (f, k) = (self.mesh.face(h).index(), self.mesh.side(h));
            let v = self.vertices[self.mesh.origin(h).index()] as usize;
            let is_tip = tips.contains(&self.mesh.origin(h).0);
            match frame.normals[f][k].filter(|_| !is_tip) {
                // A gradient with its length makes quadrics exact; on a singular vertex there is only a direction.
                Some(_) if !is_singular[v] => formula.gradient(whole.positions[v]).1,
                Some(n) => n,
                None => whole.normals[f][k],
            }
        });
        let gradients: Vec<Vec3> = gradients.collect();
        let sharp = self.mesh.edges().map(|e| {
            let h = self.mesh.edge_half_edge(e);
            let ends = [self.mesh.origin(h), self.mesh.origin(self.mesh.next(h))];
            let of_whole = ends.map(|v| self.vertices[v.index()]);
            let [a, b] = of_whole;
            ends.iter().any(|v| tips.contains(&v.0)) || singular.contains(&[a.min(b), a.max(b)])
        });
        let sharp = sharp.collect();
        HermiteMesh::with_creases(self.mesh.clone(), positions, gradients, sharp)
    }
}

/// The sides of triangles that belong together, and the number of sides at singular edges without a partner.
fn pairs(mesh: &SingularMesh) -> (Vec<[Side; 2]>, usize) {
    let mut edges: BTreeMap<[u32; 2], Vec<Side>> = BTreeMap::new();
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.entry([a.min(b), a.max(b)]).or_default().push((t as u32, k));
        }
    }
    let (mut pairs, mut unpaired) = (Vec::new(), 0);
    for (ends, sides) in edges {
        match mesh.tag(ends, sides.len()) {
            EdgeTag::Boundary => {}
            EdgeTag::Smooth => pairs.extend(sides.first_chunk::<2>()),
            EdgeTag::Singular => {
                let found = wedges(mesh, ends, &sides);
                unpaired += sides.len() - 2 * found.len();
                pairs.extend(found);
            }
        }
    }
    (pairs, unpaired)
}

/// The pairs of triangles at an edge between which f < 0.
fn wedges(mesh: &SingularMesh, [a, b]: [u32; 2], sides: &[Side]) -> Vec<[Side; 2]> {
    let at = |v: u32| mesh.positions[v as usize];
    let Some(axis) = (at(b) - at(a)).try_normalize(0.0) else { return Vec::new() };
    let x = axis.cross(&Vec3::ith(axis.iamin(), 1.0)).normalize();
    let y = axis.cross(&x);
    let angle = |(t, k): &Side| {
        let d = at(mesh.triangles[*t as usize][(k + 2) % 3]) - at(a);
        d.dot(&y).atan2(d.dot(&x))
    };
    // Of a triangle that runs along the axis the normal points on, in the direction in which angles grow: f > 0 there.
    let runs_along = |(t, k): &Side| mesh.triangles[*t as usize][*k] == a;
    let mut around: Vec<Side> = sides.to_vec();
    around.sort_by(|s, t| angle(s).total_cmp(&angle(t)));
    let count = around.len();
    let next = (0..count).map(|i| [around[i], around[(i + 1) % count]]);
    next.filter(|[s, t]| count > 1 && !runs_along(s) && runs_along(t)).collect()
}

fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

fn join(parents: &mut [usize], a: usize, b: usize) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b)] = a.min(b);
}

/// Points along a singular edge at which the curves of its pairs are compared.
const ALONG: usize = 8;
/// Curves that are no farther apart than this share of the diagonal are the same to rounding.
const SAME: f64 = 1e-12;

/// The largest distance between the curves over one singular edge, and the number of edges where they are not the same.
fn gap(whole: &SingularMesh, solids: &Solids, surface: &APatchSurface) -> (f64, usize) {
    let mesh = &solids.mesh;
    let mut curves: BTreeMap<[u32; 2], Vec<[Point3; ALONG + 1]>> = BTreeMap::new();
    for e in mesh.edges() {
        let h = mesh.edge_half_edge(e);
        let ends = [mesh.origin(h), mesh.origin(mesh.next(h))].map(|v| solids.vertices[v.index()]);
        let sorted = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        if whole.singular_edges.binary_search(&sorted).is_ok() {
            let k = mesh.side(h);
            let mut points: [Point3; ALONG + 1] = std::array::from_fn(|i| {
                let t = i as f64 / ALONG as f64;
                let mut l = [0.0; 3];
                (l[k], l[(k + 1) % 3]) = (1.0 - t, t);
                surface.sample(PatchId(mesh.face(h).0), [l[0], l[1]]).point
            });
            if ends != sorted {
                points.reverse();
            }
            curves.entry(sorted).or_default().push(points);
        }
    }
    let same = SAME * Aabb::around(&whole.positions).diagonal();
    let mut found = (0.0f64, 0);
    for copies in curves.values() {
        let apart = copies.iter().flat_map(|c| c.iter().zip(&copies[0])).map(|(p, q)| (p - q).norm());
        let apart = apart.fold(0.0, f64::max);
        found = (found.0.max(apart), found.1 + usize::from(apart > same));
    }
    found
}

fn repairs(solids: &Solids, function: &apatch::APatchFunction) -> Vec<Repair> {
    let hull = function.hull();
    let copies = solids.vertices.len() - solids.vertices.iter().collect::<BTreeSet<_>>().len();
    let lines = [
        (copies, "vertices there more than once", "solids f < 0 touch each other there"),
        (solids.unpaired, "triangles that end alone in a singular edge", "f has the same sign on both sides"),
        (hull.moved_normals().len(), "normals moved", "they did not see the faces around them"),
        (hull.added_creases().len(), "creases added", "without them there is no valid surface"),
        (hull.corners().len(), "corners made", "no single normal sees all faces around them"),
        (hull.problems().len(), "places where the surface is not certain", "the hull has a fault there"),
    ];
    let word = |(count, what, why): (usize, &str, &str)| Repair {
        what: format!("{what}: {count}"),
        place: "whole surface".to_owned(),
        why: why.to_owned(),
    };
    lines.into_iter().filter(|(count, ..)| *count > 0).map(word).collect()
}
