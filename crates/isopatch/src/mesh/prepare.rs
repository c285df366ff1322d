//! From a mesh file's faces to an oriented manifold, or a reason why not.

use super::check::{MeshCheck, check};
use super::degenerate::{without_duplicates, without_flat_faces, without_repeated_corners};
use super::fans::{Fans, fans};
use super::half_edge::{HalfEdgeMesh, MeshError};
use super::orient::orient;
use super::pairing::pair;
use super::polygons::{Edges, Polygons};
use super::repairs::{Log, MeshRepair, Place, RepairKind};
use super::weld::weld;
use crate::geom::{Aabb, Point3};

/// How [`prepare`] treats a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PrepareOptions {
    /// Vertices on open edges that are no further apart than this fraction of the bounding box's diagonal become one.
    /// Default 0: their coordinates must be equal.
    pub weld_tolerance: f64,
}

/// Why a mesh can't be made an oriented manifold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// A face has a vertex whose coordinates are not finite.
    #[error("vertex {vertex} of face {face} has a coordinate that is not a finite number")]
    NotFinite {
        /// The vertex.
        vertex: u32,
        /// A face with it.
        face: u32,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, but there are only {count} vertices")]
    NoSuchVertex {
        /// The face.
        face: u32,
        /// The vertex.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// There are no faces, or none with an area.
    #[error("the mesh has no face with an area")]
    NoFaces,
    /// Vertices, faces or corners can't be numbered.
    #[error("the mesh is too large: it has {count} {what}, but at most {} are possible", u32::MAX - 1)]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How much.
        count: usize,
    },
    /// The tolerance for welding is no number from 0 to 1.
    #[error("the tolerance for welding must be from 0 to 1, not {tolerance}")]
    Tolerance {
        /// As it was given.
        tolerance: f64,
    },
    /// More than two faces meet in an edge and hang together around both ends, so that they can't be taken apart.
    #[error("the faces around edge {}–{} can't be taken apart (non-manifold)", edge[0], edge[1])]
    NonManifoldEdge {
        /// Ends of the edge.
        edge: [u32; 2],
    },
    /// The repaired faces are no manifold for another reason.
    #[error("the repaired mesh is no manifold: {0}")]
    NonManifold(MeshError),
}

/// An oriented manifold, and what became of the input on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The vertices; each has a face. Those that stay are in the order of the input, copies come last.
    pub positions: Vec<Point3>,
    /// The faces, polygons of any size, in the order of the input. [`HalfEdgeMesh::from_faces`] accepts them.
    pub faces: Vec<Vec<u32>>,
    /// The input's number of every vertex.
    pub vertex_source: Vec<u32>,
    /// The input's number of every face.
    pub face_source: Vec<u32>,
    /// All changes, in the numbers of the input; empty if there are none.
    pub repairs: Vec<MeshRepair>,
    /// What is left to say of the result: holes, components, faces without area.
    pub summary: MeshCheck,
}

/// Makes an oriented manifold, closed or with a boundary, of polygons as files have them.
///
/// In this order: equal vertices on open edges are welded; faces are reduced to simple loops; duplicates and faces
/// without area are dropped; where more than two faces meet in an edge, sheets are taken apart; faces are oriented alike
/// in each component, closed components outward (voids inward); every fan of faces gets its own vertex; vertices
/// without a face are dropped. Holes stay open, and nothing moves. The result depends on nothing but the input.
///
/// Time O(n log n). Does the surface go through itself? That is not looked for here.
///
/// # Errors
/// Numbers that are out of range or not finite, and a mesh that can't be repaired: see [`MeshFault`].
pub fn prepare<F: AsRef<[u32]>>(
    positions: &[Point3],
    faces: &[F],
    options: &PrepareOptions,
) -> Result<Prepared, MeshFault> {
    let mut log = Log::default();
    let polygons = accepted(positions, faces)?;
    let (scaled, _) = scaled(positions, &polygons);
    let kept = welds(&polygons, &scaled, options, &mut log)?;
    let polygons = polygons.renumbered(&kept);
    let polygons = without_repeated_corners(polygons, &mut log);
    let polygons = without_duplicates(polygons, &mut log);
    let polygons = without_flat_faces(polygons, &scaled, &mut log);
    if polygons.len() == 0 {
        return Err(MeshFault::NoFaces);
    }
    let edges = Edges::new(&polygons);
    let mut mate = pair(&polygons, &edges, &scaled, &mut log);
    let turned = orient(&polygons, &edges, &scaled, &mut mate, &mut log);
    let fans = fans(positions.len(), &edges, &mate);
    let names = fans.names(positions.len(), |corner, v| {
        let f = edges.face[corner] as usize;
        before_welding(
            faces[polygons.source(f) as usize].as_ref(),
            corner - polygons.range(f).start,
            v,
            &kept,
        )
    });
    let (faces, vertex_source) = compacted(&polygons, &fans, &turned, &names);
    note_vertices(&vertex_source, &kept, &mut log);
    let positions: Vec<Point3> = vertex_source.iter().map(|v| positions[*v as usize]).collect();
    let summary = check(&positions, &faces);
    if !summary.is_oriented_manifold() {
        let named = |error| in_numbers_of_the_input(error, &vertex_source);
        HalfEdgeMesh::from_faces(positions.len(), &faces).map_err(named)?;
    }
    let face_source = (0..polygons.len()).map(|f| polygons.source(f)).collect();
    Ok(Prepared { positions, faces, vertex_source, face_source, repairs: log.into_repairs(), summary })
}

/// The faces, if everything in them can be used.
fn accepted<F: AsRef<[u32]>>(positions: &[Point3], faces: &[F]) -> Result<Polygons, MeshFault> {
    let corners: usize = faces.iter().map(|f| f.as_ref().len()).sum();
    // Splitting makes at most one vertex a corner.
    for (what, count) in
        [("corners and vertices", corners.saturating_add(positions.len())), ("faces", faces.len())]
    {
        if count >= u32::MAX as usize {
            return Err(MeshFault::TooLarge { what, count });
        }
    }
    let mut polygons = Polygons::with_capacity(faces.len(), corners);
    for (f, corners) in faces.iter().enumerate() {
        let (face, corners) = (f as u32, corners.as_ref());
        for vertex in corners.iter().copied() {
            match positions.get(vertex as usize) {
                None => return Err(MeshFault::NoSuchVertex { face, vertex, count: positions.len() }),
                Some(p) if !p.iter().all(|x| x.is_finite()) => {
                    return Err(MeshFault::NotFinite { vertex, face });
                }
                Some(_) => {}
            }
        }
        polygons.push(face, corners.iter().copied());
    }
    Ok(polygons)
}

/// The positions relative to the centre of the box of all corners and to half its longest side, so that no product of
/// theirs overflows or vanishes; and that half. Vertices without a face are at the centre.
pub(super) fn scaled(positions: &[Point3], polygons: &Polygons) -> (Vec<Point3>, f64) {
    let mut is_used = vec![false; positions.len()];
    polygons.corners().iter().for_each(|v| is_used[*v as usize] = true);
    let used = || positions.iter().zip(&is_used).filter(|(_, used)| **used).map(|(p, _)| p);
    let bounds = Aabb::around(used());
    // Halves first: the difference of two finite coordinates may be infinite.
    let center = 0.5 * bounds.min + 0.5 * bounds.max;
    let half = (0.5 * bounds.max - 0.5 * bounds.min).max();
    let unit = if half > 0.0 { half } else { 1.0 };
    let scaled = |(p, used): (&Point3, &bool)| if *used { (p - center) / unit } else { Point3::zeros() };
    (positions.iter().zip(&is_used).map(scaled).collect(), unit)
}

/// For every vertex the one that takes its place.
fn welds(
    polygons: &Polygons,
    scaled: &[Point3],
    options: &PrepareOptions,
    log: &mut Log,
) -> Result<Vec<u32>, MeshFault> {
    let tolerance = options.weld_tolerance;
    if !(0.0..=1.0).contains(&tolerance) {
        return Err(MeshFault::Tolerance { tolerance });
    }
    let diagonal = Aabb::around(scaled).diagonal();
    let kept = weld(scaled, &Edges::new(polygons), tolerance * diagonal, diagonal);
    for (v, kept) in kept.iter().enumerate().filter(|(v, kept)| *v != **kept as usize) {
        log.note(RepairKind::WeldedVertex, Place::VertexInto(v as u32, *kept));
    }
    Ok(kept)
}

/// The corner of a face that became `v`; the one at `place`, unless the face has changed since.
fn before_welding(face: &[u32], place: usize, v: u32, kept: &[u32]) -> u32 {
    let was = |w: &&u32| kept[**w as usize] == v;
    face.get(place).filter(was).or_else(|| face.iter().find(was)).copied().unwrap_or(v)
}

/// The faces turned as they must be, with vertices numbered without gaps in the order of their names, copies last; and
/// those names.
fn compacted(polygons: &Polygons, fans: &Fans, turned: &[bool], names: &[u32]) -> (Vec<Vec<u32>>, Vec<u32>) {
    let mut is_used = vec![false; names.len()];
    fans.vertex.iter().for_each(|v| is_used[*v as usize] = true);
    let mut is_named = vec![false; names.len()];
    let mut order: Vec<(bool, u32, usize)> = Vec::new();
    for id in (0..names.len()).filter(|id| is_used[*id]) {
        let is_copy = std::mem::replace(&mut is_named[names[id] as usize], true);
        order.push((is_copy, names[id], id));
    }
    order.sort_unstable();
    let mut number = vec![0u32; names.len()];
    for (new, (_, _, id)) in order.iter().enumerate() {
        number[*id] = new as u32;
    }
    let faces = (0..polygons.len()).map(|f| {
        let corners = fans.vertex[polygons.range(f)].iter();
        let mut face: Vec<u32> = corners.map(|v| number[*v as usize]).collect();
        if turned[f] {
            face[1..].reverse();
        }
        face
    });
    (faces.collect(), order.iter().map(|(_, name, _)| *name).collect())
}

/// Notes vertices that are there more than once, and those that are neither there nor welded to another one; forgets
/// welds that fell apart into the same vertices again.
fn note_vertices(vertex_source: &[u32], kept: &[u32], log: &mut Log) {
    let mut times = vec![0u32; kept.len()];
    for v in vertex_source {
        times[*v as usize] += 1;
        if times[*v as usize] > 1 {
            log.note(RepairKind::SplitVertex, Place::Vertex(*v));
        }
    }
    let is_gone = |v: usize| times[v] == 0;
    log.retain(
        RepairKind::WeldedVertex,
        |place| !matches!(place, Place::VertexInto(v, _) if !is_gone(*v as usize)),
    );
    for v in (0..kept.len()).filter(|v| is_gone(*v) && kept[*v] as usize == *v) {
        log.note(RepairKind::UnusedVertex, Place::Vertex(v as u32));
    }
}

fn in_numbers_of_the_input(error: MeshError, vertex_source: &[u32]) -> MeshFault {
    match error {
        MeshError::NonManifoldEdge { from, to, .. } => {
            MeshFault::NonManifoldEdge { edge: [from, to].map(|v| vertex_source[v as usize]) }
        }
        other => MeshFault::NonManifold(other),
    }
}
