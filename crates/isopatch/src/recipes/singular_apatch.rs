//! A-patches over an algebraic surface with singularities: the data of Bajaj & Xu 1997, the patches of Xu, Huang & Bajaj 2001.
//!
//! ```text
//! conforming mesh ──► limit normals per sheet ──► solids f < 0: pairs of triangles along singular edges ──► hull ──► function
//! ```
//!
//! A-patches need an oriented manifold. The triangles around a singular edge are joined in pairs, each pair the border of a wedge in
//! which f < 0: so the whole is the border of solids that touch each other in singular points and curves, where vertices are there
//! once for each. Singular edges are creases: both patches of a pair end in one curve, and the curves of all pairs have the same
//! ends and tangents. Where a vertex has no normal in a sheet, as at the tip of a cone, it is a corner. If that is on a singular curve, or
//! the hull makes a corner there, the curve leaves the vertex along its chord in all solids: each triangle has its own normal there.

use crate::apatch::{self, APatchOptions, APatchSurface};
use crate::base::Repair;
use crate::field::Formula;
use crate::geom::{Point3, Vec3};
use crate::hull::{self, CreaseCurve, HermiteError, HermiteMesh, Hull, HullOptions};
use crate::mesh::{HalfEdgeId, HalfEdgeMesh, MeshError, VertexId, normals};
use crate::rational::Frame;
use crate::report::{APatchReport, Seconds};
use crate::singular::mesh::{EdgeTag, SingularMesh};
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
    // New vertices off the mesh would be off the zero set.
    let hull_options = hull_options.without_rounding();
    let mut seconds = Seconds::default();
    progress("sheets");
    let solids = seconds.measure("sheets", || Solids::new(formula, mesh))?;
    let mut straight = solids.tips_on_curves();
    let (function, gap, parted) = loop {
        progress("hull");
        let data = solids.hermite(&straight)?;
        let hull = seconds.measure("hull", || hull::build(data, &hull_options));
        progress("patches");
        let function = seconds.measure("patches", || apatch::build(hull, patch_options));
        let (gap, parted) = solids.gap(function.hull());
        let before = straight.len();
        straight.extend(parted.iter().flatten());
        if straight.len() == before {
            break (function, gap, parted.len());
        }
    };
    let mut repairs = repairs(&solids, &function);
    let figures = APatchReport { normals: Some("field".to_owned()), ..APatchReport::new(&function) };
    let surface = APatchSurface::new(function);
    if parted > 0 {
        repairs.push(Repair {
            what: format!("sheets part on singular edges: {parted}"),
            place: format!("by up to {gap:.2e}"),
            why: "the hull changed normals at their ends".to_owned(),
        });
    }
    Ok(SingularAPatches { surface, figures, vertices: solids.vertices, gap, repairs, seconds })
}

/// A conforming mesh cut apart.
struct Solids<'a> {
    formula: &'a Formula,
    whole: &'a SingularMesh,
    mesh: HalfEdgeMesh,
    /// The vertex of the whole mesh that each vertex is.
    vertices: Vec<u32>,
    /// Of each triangle: the normals of its sheet at its corners; none where the sheet has none.
    normals: Vec<[Option<Vec3>; 3]>,
    /// Edges of the whole mesh at which triangles found no partner.
    unpaired: usize,
}

/// A triangle and its edge k, from corner k to k + 1.
type Side = (u32, usize);

impl<'a> Solids<'a> {
    fn new(formula: &'a Formula, whole: &'a SingularMesh) -> Result<Self, MeshError> {
        let (pairs, unpaired) = pairs(whole);
        let mut parents: Vec<usize> = (0..3 * whole.triangles.len()).collect();
        for [(s, i), (t, j)] in pairs {
            let corner = |t: u32, k: usize| 3 * t as usize + k % 3;
            join(&mut parents, corner(s, i), corner(t, j + 1));
            join(&mut parents, corner(s, i + 1), corner(t, j));
        }
        let mut numbers = HashMap::new();
        let mut vertices = Vec::new();
        let mut faces = Vec::with_capacity(whole.triangles.len());
        for (t, corners) in whole.triangles.iter().enumerate() {
            faces.push([0, 1, 2].map(|k| {
                *numbers.entry(root(&mut parents, 3 * t + k)).or_insert_with(|| {
                    vertices.push(corners[k]);
                    vertices.len() as u32 - 1
                })
            }));
        }
        let is_singular: Vec<bool> = whole.vertices.iter().map(|kind| kind.is_singular()).collect();
        let SingularMesh { positions, triangles, normals, singular_edges, .. } = whole;
        let frame =
            Frame::over_sheets(positions.clone(), triangles.clone(), normals, singular_edges, &is_singular);
        let mesh = HalfEdgeMesh::from_faces(vertices.len(), &faces)?;
        Ok(Self { formula, whole, mesh, vertices, normals: frame.normals, unpaired })
    }

    /// The vertex of the whole mesh from which a half edge starts.
    fn origin(&self, h: HalfEdgeId) -> u32 {
        self.vertices[self.mesh.origin(h).index()]
    }

    /// Vertices at which a corner has no normal, those on singular curves by their numbers in the whole mesh.
    fn tips_on_curves(&self) -> BTreeSet<u32> {
        let on_curve: BTreeSet<u32> = self.whole.singular_edges.iter().flatten().copied().collect();
        let tips = self.mesh.half_edges().filter(|h| self.normal(*h).is_none()).map(|h| self.origin(h));
        tips.filter(|v| on_curve.contains(v)).collect()
    }

    /// The normal of the sheet at the corner where a half edge starts.
    fn normal(&self, h: HalfEdgeId) -> Option<Vec3> {
        self.normals[self.mesh.face(h).index()][self.mesh.side(h)]
    }

    /// Gradients and creases; singular curves leave the vertices `straight`, of the whole mesh, along their chords.
    fn hermite(&self, straight: &BTreeSet<u32>) -> Result<HermiteMesh, HermiteError> {
        use crate::field::Field;
        let Self { whole, mesh, .. } = self;
        let positions: Vec<Point3> = self.vertices.iter().map(|v| whole.positions[*v as usize]).collect();
        let is_straight = |v: VertexId| straight.contains(&self.vertices[v.index()]);
        let mut tips: BTreeSet<VertexId> = mesh.vertices().filter(|v| is_straight(*v)).collect();
        tips.extend(mesh.half_edges().filter(|h| self.normal(*h).is_none()).map(|h| mesh.origin(h)));
        let gradients = mesh.half_edges().map(|h| {
            let (f, v) = (mesh.face(h), mesh.origin(h));
            match self.normal(h).filter(|_| !tips.contains(&v)) {
                // A gradient with its length makes quadrics exact; on a singular vertex there is only a direction.
                Some(_) if !whole.vertices[self.origin(h) as usize].is_singular() => {
                    self.formula.gradient(positions[v.index()]).1
                }
                Some(n) => n,
                None if is_straight(v) => normals::of_face(mesh, &positions, f),
                None => whole.normals[f.index()][mesh.side(h)],
            }
        });
        let gradients: Vec<Vec3> = gradients.collect();
        let sharp = mesh.edges().map(|e| {
            let h = mesh.edge_half_edge(e);
            let ends = [mesh.origin(h), mesh.dest(h)];
            ends.iter().any(|v| tips.contains(v)) || self.singular_edge(ends).is_some()
        });
        let sharp = sharp.collect();
        HermiteMesh::with_creases(mesh.clone(), positions, gradients, sharp)
    }

    /// The singular edge between two vertices, by its ends in the whole mesh, the smaller first; none if there is none.
    fn singular_edge(&self, ends: [VertexId; 2]) -> Option<[u32; 2]> {
        let [a, b] = ends.map(|v| self.vertices[v.index()]);
        let sorted = [a.min(b), a.max(b)];
        self.whole.singular_edges.binary_search(&sorted).is_ok().then_some(sorted)
    }

    /// The largest distance between the curves over one singular edge, and the edges where they are not the same.
    fn gap(&self, hull: &Hull) -> (f64, Vec<[u32; 2]>) {
        let (data, mesh) = (hull.data(), hull.data().mesh());
        // Of each edge, and each edge of a solid that it is: the curves of its pieces.
        let mut curves: BTreeMap<[u32; 2], BTreeMap<[VertexId; 2], Vec<CreaseCurve>>> = BTreeMap::new();
        for e in mesh.edges() {
            let mut source = hull.source_edge(e);
            source.sort_by_key(|v| self.vertices[v.index()]);
            let Some((edge, mut curve)) = self.singular_edge(source).zip(data.crease_curve(e)) else {
                continue;
            };
            let start = self.whole.positions[edge[0] as usize];
            if (curve.net[3] - start).norm_squared() < (curve.net[0] - start).norm_squared() {
                curve.net.reverse();
            }
            curves.entry(edge).or_default().entry(source).or_default().push(curve);
        }
        let same = SAME * data.diagonal();
        let mut found = (0.0f64, Vec::new());
        for (edge, copies) in curves {
            let copies: Vec<Vec<CreaseCurve>> = copies.into_values().collect();
            let apart = copies.iter().map(|copy| apart(copy, &copies[0])).fold(0.0, f64::max);
            found.0 = found.0.max(apart);
            if apart > same {
                found.1.push(edge);
            }
        }
        found
    }
}

/// Curves that are no farther apart than this share of the diagonal are the same to rounding.
const SAME: f64 = 1e-12;

/// A bound of the distance between two curves, each in pieces: of control points, or of those from the chord where the pieces are not alike.
fn apart(a: &[CreaseCurve], b: &[CreaseCurve]) -> f64 {
    let off_chord = |curve: &CreaseCurve| {
        let [start, .., end] = curve.net;
        let chord = (end - start).normalize();
        curve.net.iter().map(|p| (p - start).cross(&chord).norm()).fold(0.0, f64::max)
    };
    match (a, b) {
        _ if a.iter().chain(b).all(|curve| curve.is_straight) => 0.0,
        ([a], [b]) => a.net.iter().zip(&b.net).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max),
        _ => a.iter().chain(b).map(off_chord).fold(0.0, f64::max),
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

fn repairs(solids: &Solids<'_>, function: &apatch::APatchFunction) -> Vec<Repair> {
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
